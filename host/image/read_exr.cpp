// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMatrixAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "image/decode_hdr.h"
#include "image/exr_file.h"
#include "image/image.h"

namespace eikon {
namespace {

using exr::Reader, exr::reading;

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

bool has_color(const Imf::ChannelList& channels) {
  return channels.findChannel("R") != nullptr && channels.findChannel("G") != nullptr &&
         channels.findChannel("B") != nullptr;
}

/// The first part that has colours, or luminance. throws InputError
int part_to_show(Reader& reader) {
  for (int part = 0; part < reader.file().parts(); ++part) {
    const Imf::ChannelList& channels = reader.header(part).channels();
    if (has_color(channels) || channels.findChannel("Y") != nullptr) return part;
  }
  throw InputError("has neither channels R, G, B nor Y; save it as RGB");
}

}  // namespace

const std::vector<float>* Image::plane(const std::string& channel) const {
  const auto found = std::find(channels.begin(), channels.end(), channel);
  return found == channels.end() ? nullptr : &planes[static_cast<std::size_t>(found - channels.begin())];
}

Metadata read_metadata(const std::filesystem::path& path) {
  return reading(path, [&] { return metadata_of(Reader(path).header(0)); });
}

Image read_exr(const std::filesystem::path& path) {
  return reading(path, [&] {
    Reader reader(path);
    reader.check(0);
    const Imf::Header& header = reader.header(0);
    const Imath::Box2i& window = header.dataWindow();
    Image image;
    std::tie(image.width, image.height) = reader.size(0);
    image.x0 = std::int64_t{window.min.x} - header.displayWindow().min.x;
    image.y0 = std::int64_t{window.min.y} - header.displayWindow().min.y;
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

HdrImage read_exr_rgb(const std::filesystem::path& path, std::uint64_t max_bytes) {
  return reading(path, [&] {
    Reader reader(path);
    const int number = part_to_show(reader);
    reader.check(number);
    const Imf::Header& header = reader.header(number);
    const bool colored = has_color(header.channels());
    HdrImage image;
    std::tie(image.width, image.height) = reader.size(number);
    const std::uint64_t needed = std::uint64_t{image.width} * image.height * sizeof(glm::vec3);
    if (needed > max_bytes)
      throw InputError(fmt::format("has {} x {} pixels, which need {} MB; at most {} MB are for it, scale it down",
                                   image.width, image.height, needed >> 20U, max_bytes >> 20U));
    if (Imf::hasChromaticities(header)) {
      const Imf::Chromaticities& stated = Imf::chromaticities(header);
      const auto xy = [](const Imath::V2f& v) { return glm::dvec2(v.x, v.y); };
      image.primaries = {xy(stated.red), xy(stated.green), xy(stated.blue), xy(stated.white)};
    }
    image.is_cube = Imf::hasEnvmap(header) && Imf::envmap(header) == Imf::ENVMAP_CUBE;
    image.rgb.resize(std::size_t{image.width} * image.height);
    Imf::FrameBuffer buffer;
    const auto read_into = [&](const char* name, int c) {
      buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, &image.rgb[0][c], header.dataWindow(), sizeof(glm::vec3),
                                           sizeof(glm::vec3) * image.width));
    };
    if (colored) {
      for (int c = 0; c < 3; ++c) read_into(kRgb[static_cast<std::size_t>(c)], c);
    } else {
      read_into("Y", 0);
    }
    Imf::InputPart part(reader.file(), number);
    part.setFrameBuffer(buffer);
    part.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
    if (!colored)
      for (glm::vec3& texel : image.rgb) texel = glm::vec3(texel.x);
    return image;
  });
}

}  // namespace eikon
