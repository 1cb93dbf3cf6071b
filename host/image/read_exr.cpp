// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMatrixAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "image/exr_file.h"
#include "image/image.h"

namespace eikon {
namespace {

using exr::Reader, exr::reading, exr::kMaxBytes;

Metadata metadata_of(const Imf::Header& header) {
  Metadata metadata;
  for (auto i = header.begin(); i != header.end(); ++i) {
    const std::string name = i.name();
    const bool ours = name.starts_with(exr::kPrefix);
    const std::string key = ours ? name.substr(std::string(exr::kPrefix).size()) : name;
    if (!ours && name != "worldToCamera" && name != "worldToNDC") continue;
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&i.attribute())) {
      metadata.strings[key] = text->value();
    } else if (const auto* number = dynamic_cast<const Imf::DoubleAttribute*>(&i.attribute())) {
      metadata.numbers[key] = number->value();
    } else if (const auto* matrix = dynamic_cast<const Imf::M44fAttribute*>(&i.attribute())) {
      std::vector<double>& values = metadata.matrices[key];
      for (int j = 0; j < 16; ++j) values.push_back(static_cast<double>(matrix->value()[j / 4][j % 4]));
    }
  }
  return metadata;
}

}  // namespace

const std::vector<float>* Image::plane(const std::string& channel) const {
  const auto found = std::find(channels.begin(), channels.end(), channel);
  return found == channels.end() ? nullptr : &planes[static_cast<std::size_t>(found - channels.begin())];
}

Metadata read_metadata(const std::filesystem::path& path) {
  return reading(path, [&] { return metadata_of(Reader(path).header(0)); });
}

Image read_exr(const std::filesystem::path& path) { return read_exr_within(path, kMaxBytes); }

Image read_exr_within(const std::filesystem::path& path, std::uint64_t max_bytes) {
  return reading(path, [&] {
    Reader reader(path);
    reader.check(0, max_bytes);
    const Imf::Header& header = reader.header(0);
    const Imath::Box2i& window = header.dataWindow();
    Image image;
    std::tie(image.width, image.height) = reader.size(0);
    Imf::FrameBuffer buffer;
    for (auto i = header.channels().begin(); i != header.channels().end(); ++i) {
      image.channels.emplace_back(i.name());
      image.planes.emplace_back(std::size_t{image.width} * image.height);
      buffer.insert(i.name(), Imf::Slice::Make(Imf::FLOAT, image.planes.back().data(), window, sizeof(float),
                                               sizeof(float) * image.width));
    }
    Imf::InputPart part(reader.file(), 0);
    part.setFrameBuffer(buffer);
    part.readPixels(window.min.y, window.max.y);
    const Metadata metadata = metadata_of(header);
    for (const auto& [key, value] : metadata.strings) image.metadata[key] = value;
    for (const auto& [key, value] : metadata.numbers) image.metadata[key] = fmt::format("{}", value);
    return image;
  });
}

}  // namespace eikon
