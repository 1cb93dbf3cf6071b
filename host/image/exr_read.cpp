// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <bit>
#include <concepts>
#include <fstream>
#include <memory>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"
#include "image/exr_layout.h"
#include "image/image.h"

namespace eikon {
namespace {

constexpr int kMaxSide = 65536, kMaxTileSide = 8192, kMaxParts = 16, kMaxChannels = 4096;
constexpr std::uint64_t kMaxBytes = std::uint64_t{16} << 30;
// Deflate shrinks by 1032 at most and the other codecs by less; a file that claims far more than that lies about its size.
constexpr std::uint64_t kMaxExpansion = 4096, kAlwaysCredibleBytes = std::uint64_t{64} << 20;

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& why) {
  throw InputError(fmt::format("cannot read \"{}\": {}", path.string(), why));
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// An open EXR whose parts are known to be of bearable size.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) refuse(path, "no such file");
    if (!std::filesystem::is_regular_file(status)) refuse(path, "not a regular file");
    size_bytes_ = std::filesystem::file_size(path, error);
    std::ifstream file(path, std::ios::binary);
    char magic[4] = {};
    if (!file) refuse(path, "it cannot be opened: are you allowed to read it?");
    if (!file.read(magic, 4) || magic[0] != 0x76 || magic[1] != 0x2f || magic[2] != 0x31 || magic[3] != 0x01)
      refuse(path, "not an OpenEXR file (wrong magic number)");
    // Process-wide limits of OpenEXR, checked by it before it allocates anything for a header.
    Imf::Header::setMaxImageSize(kMaxSide, kMaxSide);
    Imf::Header::setMaxTileSize(kMaxTileSide, kMaxTileSide);
    // An incomplete chunk table is an error, not something to be guessed from the rest of the file.
    file_ = std::make_unique<Imf::MultiPartInputFile>(path.c_str(), 0, false);
    if (file_->parts() > kMaxParts)
      refuse(path, fmt::format("it has {} parts, more than {}", file_->parts(), kMaxParts));
  }

  [[nodiscard]] Imf::MultiPartInputFile& file() { return *file_; }
  [[nodiscard]] const Imf::Header& header(int part) const { return file_->header(part); }

  /// Checks what the part claims before anything is allocated for it.
  void check(int part, std::uint64_t max_bytes = kMaxBytes) const {
    const Imf::Header& head = header(part);
    if (head.hasType() && Imf::isDeepData(head.type())) refuse(path_, "deep images are not supported");
    std::uint64_t channel_count = 0;
    for (auto i = head.channels().begin(); i != head.channels().end(); ++i, ++channel_count)
      if (i.channel().xSampling != 1 || i.channel().ySampling != 1)
        refuse(path_, fmt::format("channel {} is subsampled, which is not supported", i.name()));
    if (channel_count == 0) refuse(path_, "it has no channels");
    if (channel_count > kMaxChannels)
      refuse(path_, fmt::format("it has {} channels, more than {}", channel_count, kMaxChannels));
    const auto [width, height] = size(part);
    const std::uint64_t bytes = std::uint64_t{width} * height * channel_count * sizeof(float);
    if (bytes > kMaxBytes || bytes > std::max(kAlwaysCredibleBytes, size_bytes_ * kMaxExpansion))
      refuse(path_, fmt::format("its header claims {}x{} pixels of {} channels, which {} bytes cannot hold", width,
                                height, channel_count, size_bytes_));
    if (bytes > max_bytes)
      refuse(path_, fmt::format("{}x{} pixels of {} channels need {} MB; at most {} MB are for it, scale it down",
                                width, height, channel_count, bytes >> 20U, max_bytes >> 20U));
  }

  /// Of the data window.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> size(int part) const {
    const Imath::Box2i& window = header(part).dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
      refuse(path_, fmt::format("a data window of {}x{} pixels", width, height));
    return {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
  }

 private:
  std::filesystem::path path_;
  std::uint64_t size_bytes_ = 0;
  std::unique_ptr<Imf::MultiPartInputFile> file_;
};

/// Whatever OpenEXR or the allocator throws becomes an InputError of one line.
template <std::invocable Body>
auto reading(const std::filesystem::path& path, Body body) {
  try {
    return body();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    refuse(path, "not enough memory for it");
  } catch (const std::exception& error) {
    refuse(path, one_line(error.what()));
  }
}

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

/// The layout that the sums part claims, each claim checked.
FilmLayout film_layout(const std::filesystem::path& path, const Reader& reader, int part) {
  const Imf::Header& header = reader.header(part);
  const auto* replicates = header.findTypedAttribute<Imf::IntAttribute>(exr::kReplicates);
  const auto* channels = header.findTypedAttribute<Imf::StringAttribute>(exr::kChannels);
  if (replicates == nullptr || channels == nullptr) refuse(path, "its part \"sums\" was not written by eikon");
  FilmLayout layout;
  if (replicates->value() < 1 || replicates->value() > 64 ||
      !std::has_single_bit(static_cast<unsigned>(replicates->value())))
    refuse(path, fmt::format("{} replicates", replicates->value()));
  layout.replicates = static_cast<std::uint32_t>(replicates->value());

  layout.channels.clear();
  const std::string& names = channels->value();
  for (std::size_t at = 0; at <= names.size();) {
    const std::size_t comma = std::min(names.find(',', at), names.size());
    layout.channels.push_back(names.substr(at, comma - at));
    at = comma + 1;
  }
  if (layout.channels.size() < 3 || layout.channels[0] != "R" || layout.channels[1] != "G" || layout.channels[2] != "B")
    refuse(path, "its sums are not of R, G, B");
  const auto need = [&](const std::string& name) {
    const Imf::Channel* channel = header.channels().findChannel(name);
    if (channel == nullptr || channel->type != Imf::UINT)
      refuse(path, fmt::format("the integer channel {} is missing", name));
  };
  for (std::uint32_t r = 0; r < layout.replicates; ++r) {
    for (const std::string& channel : layout.channels)
      for (std::uint32_t limb = 0; limb < exr::kSumLimbs; ++limb) need(exr::sum_name(r, channel, limb));
    for (std::uint32_t limb = 0; limb < exr::kCountLimbs; ++limb) need(exr::count_name(r, limb));
  }

  const Imath::Box2i &display = header.displayWindow(), &data = header.dataWindow();
  const bool inside = display.min == Imath::V2i(0, 0) && data.min.x >= 0 && data.min.y >= 0 &&
                      data.max.x <= display.max.x && data.max.y <= display.max.y && display.max.x < kMaxSide &&
                      display.max.y < kMaxSide;
  if (!inside) refuse(path, "its data window lies outside its display window");
  const auto end = [](int last) { return static_cast<std::uint32_t>(last) + 1; };
  layout.width = end(display.max.x);
  layout.height = end(display.max.y);
  layout.crop = {static_cast<std::uint32_t>(data.min.x), static_cast<std::uint32_t>(data.min.y), end(data.max.x),
                 end(data.max.y)};
  return layout;
}

void read_sums(const std::filesystem::path& path, Imf::InputPart& part, Film& film) {
  const FilmLayout& layout = film.layout();
  const Crop& crop = layout.crop;
  const std::size_t plane = std::size_t{crop.width()} * exr::kRowsPerBlock;
  const std::size_t words_per_replicate = layout.channels.size() * exr::kSumLimbs + exr::kCountLimbs;
  std::vector<std::uint32_t> words(plane * words_per_replicate * layout.replicates);
  for (std::uint32_t first = crop.y0; first < crop.y1; first += exr::kRowsPerBlock) {
    const std::uint32_t last = std::min(first + exr::kRowsPerBlock, crop.y1);
    const Imath::Box2i window(Imath::V2i(static_cast<int>(crop.x0), static_cast<int>(first)),
                              Imath::V2i(static_cast<int>(crop.x1 - 1), static_cast<int>(last - 1)));
    Imf::FrameBuffer buffer;
    std::size_t next = 0;
    const auto insert = [&](const std::string& name) {
      buffer.insert(name, Imf::Slice::Make(Imf::UINT, &words[next++ * plane], window, sizeof(std::uint32_t),
                                           sizeof(std::uint32_t) * crop.width()));
    };
    for (std::uint32_t r = 0; r < layout.replicates; ++r) {
      for (const std::string& channel : layout.channels)
        for (std::uint32_t limb = 0; limb < exr::kSumLimbs; ++limb) insert(exr::sum_name(r, channel, limb));
      for (std::uint32_t limb = 0; limb < exr::kCountLimbs; ++limb) insert(exr::count_name(r, limb));
    }
    part.setFrameBuffer(buffer);
    part.readPixels(static_cast<int>(first), static_cast<int>(last - 1));

    for (std::uint32_t y = first; y < last; ++y) {
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x) {
        const std::uint32_t* word = &words[std::size_t{y - first} * crop.width() + (x - crop.x0)];
        const auto take = [&] {
          const std::uint64_t value = *word;
          word += plane;
          return value;
        };
        for (std::uint32_t r = 0; r < layout.replicates; ++r) {
          for (std::uint32_t c = 0; c < layout.channels.size(); ++c) {
            const std::uint64_t w0 = take(), w1 = take(), w2 = take(), w3 = take();
            const int128 sum = static_cast<int128>(static_cast<std::int64_t>(w3 << 32 | w2)) << 64 | (w1 << 32 | w0);
            try {
              film.set(x, y, r, c, sum);
            } catch (const InputError&) {
              refuse(path, fmt::format("the sum of pixel {},{} is beyond the film's range: the file is damaged", x, y));
            }
          }
          const std::uint64_t low = take(), high = take();
          film.set_count(x, y, r, high << 32 | low);
        }
      }
    }
  }
}

}  // namespace

const std::vector<float>* Image::plane(const std::string& channel) const {
  const auto found = std::find(channels.begin(), channels.end(), channel);
  return found == channels.end() ? nullptr : &planes[static_cast<std::size_t>(found - channels.begin())];
}

Film read_film(const std::filesystem::path& path) {
  return reading(path, [&] {
    Reader reader(path);
    for (int i = 0; i < reader.file().parts(); ++i) {
      const Imf::Header& header = reader.header(i);
      if (!header.hasName() || header.name() != exr::kSumsPart) continue;
      reader.check(i);
      Film film(film_layout(path, reader, i));
      Imf::InputPart part(reader.file(), i);
      read_sums(path, part, film);
      return film;
    }
    refuse(path, "a plain picture without exact sums: render it with --samples or --crop");
  });
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
