// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include <fmt/ranges.h>

#include "core/error.h"
#include "io/atomic_file.h"
#include "film/exr/layout.h"
#include "film/exr/mattes.h"
#include "film/exr/film_file.h"
#include "image/exr_file.h"
#include "film/layers.h"
#include "film/mattes.h"

namespace eikon {

namespace {

static_assert(std::endian::native == std::endian::little, "write_part keeps a half in the first bytes of a word");

/// One channel of a part and the function that computes its values: `real` for HALF and FLOAT
/// channels, `word` for UINT channels.
struct Source {
  std::string name;
  Imf::PixelType type = Imf::FLOAT;
  std::function<double(std::uint32_t x, std::uint32_t y)> real = {};
  std::function<std::uint32_t(std::uint32_t x, std::uint32_t y)> word = {};
  bool in_order = false;  // values must be asked for row by row, by one thread
};

class Stream : public Imf::OStream {
 public:
  Stream(AtomicFile& file, const std::string& name) : Imf::OStream(name.c_str()), file_(file) {}
  void write(const char bytes[], int size) override { file_.write(bytes, static_cast<std::size_t>(size)); }
  std::uint64_t tellp() override { return file_.position(); }
  void seekp(std::uint64_t position) override { file_.seek(position); }

 private:
  AtomicFile& file_;
};

Source source_of(const Film& film, const LayerChannel& channel, Imf::PixelType type) {
  const std::vector<std::uint32_t>& from = channel.film;
  switch (channel.rule) {
    case LayerRule::mean:
      return {.name = channel.name, .type = type, .real = [&film, from](auto x, auto y) {
                return film.mean(x, y, from);
              }};
    case LayerRule::mean_of_hit:
      return {.name = channel.name, .type = type, .real = [&film, from](auto x, auto y) {
                const double hits = to_double(film.total(x, y, from[1]));
                return hits > 0 ? to_double(film.total(x, y, from[0])) / hits : std::numeric_limits<double>::infinity();
              }};
    case LayerRule::word:
      return {.name = channel.name, .type = Imf::UINT, .word = [&film, from](auto x, auto y) {
                return static_cast<std::uint32_t>(film.total(x, y, from[0]) >> 64);
              }};
    case LayerRule::variance:
      return {.name = channel.name, .type = type, .real = [&film, from](auto x, auto y) {
                return film.variance_of_mean(x, y, from[0]);
              }};
    case LayerRule::samples:
      return {.name = channel.name, .type = Imf::UINT, .word = [&film](auto x, auto y) {
                return static_cast<std::uint32_t>(
                    std::min<std::uint64_t>(film.samples(x, y), std::numeric_limits<std::uint32_t>::max()));
              }};
  }
  throw InternalError("no such rule of a layer");
}

/// Adds a matte, always in full precision because rounding an id to half would change it.
void add_matte(const Film& film, const std::string& layer, std::vector<Source>& sources) {
  const auto& mattes = film.layout().mattes;
  const auto found = std::ranges::find(mattes, layer);
  if (found == mattes.end()) throw InternalError(fmt::format("the film does not have the matte {}", layer));
  const auto ranks = std::make_shared<exr::MatteRanks>(film, static_cast<std::size_t>(found - mattes.begin()));
  const std::vector<std::string> names = exr::matte_channels(layer);
  for (std::size_t c = 0; c < names.size(); ++c)
    sources.push_back({.name = names[c],
                       .real = [ranks, c](auto x, auto y) { return double(ranks->value(x, y, c)); },
                       .in_order = true});
}

std::vector<Source> image_sources(const Film& film, const ExrOptions& options) {
  const Imf::PixelType type = options.half ? Imf::HALF : Imf::FLOAT;
  std::vector<Source> sources;
  for (std::uint32_t c = 0; c < 3; ++c)
    sources.push_back(source_of(film, {film.layout().channels[c], LayerRule::mean, {c}}, type));
  if (const auto alpha = film.channel_index("A"))
    sources.push_back(source_of(film, {"A", LayerRule::mean, {*alpha}}, type));
  for (const std::string& layer : options.layers) {
    if (is_matte(layer)) {
      add_matte(film, layer, sources);
      continue;
    }
    for (const LayerChannel& channel : layer_channels(layer, film.layout()))
      sources.push_back(source_of(film, channel, type));
  }
  if (options.denoised != nullptr) {
    const Crop& crop = film.layout().crop;
    for (std::size_t c = 0; c < 3; ++c)
      sources.push_back({.name = "denoised." + options.denoised->channels[c],
                         .type = type,
                         .real = [&plane = options.denoised->planes[c], crop](auto x, auto y) {
                           return plane[std::size_t{y - crop.y0} * crop.width() + (x - crop.x0)];
                         }});
  }
  return sources;
}

Imf::Header make_header(const Film& film, const char* part, bool quick) {
  const FilmLayout& layout = film.layout();
  const auto corner = [](std::uint32_t x, std::uint32_t y) {
    return Imath::V2i(static_cast<int>(x), static_cast<int>(y));
  };
  const Imath::Box2i display(corner(0, 0), corner(layout.width - 1, layout.height - 1));
  const Imath::Box2i data(corner(layout.crop.x0, layout.crop.y0), corner(layout.crop.x1 - 1, layout.crop.y1 - 1));
  Imf::Header header(display, data);
  header.compression() = quick ? Imf::RLE_COMPRESSION : Imf::ZIP_COMPRESSION;
  header.setName(part);
  header.setType(Imf::SCANLINEIMAGE);
  Imf::addChromaticities(header,
                         // The default: Rec. 709 primaries, D65; the same in every part.
                         Imf::Chromaticities());
  return header;
}

Imf::Header sums_header(const Film& film, const ExrOptions& options) {
  const FilmLayout& layout = film.layout();
  if (options.record.size() > exr::kMaxRecordBytes)
    throw InputError(
        fmt::format("what the sums are of takes {} bytes, more than {}: merge fewer parts, or such as lie "
                    "beside each other",
                    options.record.size(), exr::kMaxRecordBytes));
  // Always quick: ZIP makes the sums a third smaller, and takes a core half a second longer for a megapixel, of each part
  // that is written and of each that is merged.
  Imf::Header header = make_header(film, exr::kSumsPart, true);
  for (const std::string& name : exr::sums_channels(layout)) header.channels().insert(name, Imf::Channel(Imf::UINT));
  header.insert(exr::kFormat, Imf::IntAttribute(exr::sums_format(layout)));
  header.insert(exr::kReplicates, Imf::IntAttribute(static_cast<int>(layout.replicates)));
  header.insert(exr::kChannels, Imf::StringAttribute(fmt::format("{}", fmt::join(layout.channels, ","))));
  if (!layout.mattes.empty())
    header.insert(exr::kMattes, Imf::StringAttribute(fmt::format("{}", fmt::join(layout.mattes, ","))));
  header.insert(exr::kRecord, Imf::StringAttribute(options.record));
  const std::string light_paths = exr::light_paths_text(film.light_paths());
  if (!light_paths.empty()) header.insert(exr::kLightPaths, Imf::StringAttribute(light_paths));
  exr::SumsHash hash(layout, options.record, light_paths);
  for (std::uint32_t y = layout.crop.y0; y < layout.crop.y1; ++y) hash.add_row(film.row_sums(y), film.row_counts(y));
  header.insert(exr::kSumsHash, Imf::StringAttribute(hash.text()));
  return header;
}

void add_metadata(Imf::Header& header, const Metadata& metadata) {
  for (const auto& [key, value] : metadata.strings) header.insert(exr::kPrefix + key, Imf::StringAttribute(value));
  for (const auto& [key, value] : metadata.numbers) header.insert(exr::kPrefix + key, Imf::DoubleAttribute(value));
  for (const auto& [key, values] : metadata.matrices) {
    if (values.size() != 16)
      throw InternalError(fmt::format("metadata {}: {} values are no 4x4 matrix", key, values.size()));
    Imath::M44f matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = static_cast<float>(values[static_cast<std::size_t>(i)]);
    const bool standard = key == "worldToCamera" || key == "worldToNDC";
    header.insert(standard ? key : exr::kPrefix + key, Imf::M44fAttribute(matrix));
  }
}

/// The number of OpenEXR's compressing threads: at most 8, and at most what host-side work may use
/// when the first image is written.
unsigned compressing_threads() {
  static const unsigned count = [] {
    const auto most = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    // Each thread needs memory for rows.
    const auto threads = static_cast<unsigned>(std::min<std::size_t>(most, 8));
    Imf::setGlobalThreadCount(static_cast<int>(threads));
    return threads;
  }();
  return count;
}

/// Throws if a value becomes infinite as half. 65520 (65504 plus half a step) is the least
/// magnitude that does.
void refuse_overflow(const Source& source, float value, std::uint32_t x, std::uint32_t y) {
  if (source.type == Imf::HALF && std::isfinite(value) && std::abs(value) >= 65520.0f)
    throw HalfOverflow(
        fmt::format("--half: {} at pixel {},{} in channel {} is beyond the range of half floats (65504): "
                    "leave --half out or scale the lights down",
                    value, x, y, source.name));
}

/// Converts and writes a few blocks of rows per thread at a time, so that memory does not grow with
/// the height of the image.
void write_part(Imf::OutputPart& part, const Crop& crop, const std::vector<Source>& sources) {
  const std::size_t width = crop.width();
  constexpr std::uint32_t kBlocks = 2;
  const bool in_order = std::ranges::any_of(sources, [](const Source& source) {
    // So that the error names the first overflow.
    return source.in_order || source.type == Imf::HALF;
  });
  const std::uint32_t most = std::min(exr::kRowsPerBlock * kBlocks * compressing_threads(), crop.height());
  const std::size_t plane = width * most;
  // Floats as their bits, halves in the low bytes.
  std::vector<std::uint32_t> words(plane * sources.size());
  for (std::uint32_t first = crop.y0; first < crop.y1; first += most) {
    const std::uint32_t last = std::min(first + most, crop.y1);
    const auto convert = [&](std::uint32_t y) {
      for (std::size_t s = 0; s < sources.size(); ++s) {
        const Source& source = sources[s];
        std::uint32_t* out = &words[s * plane + (y - first) * width];
        for (std::uint32_t x = crop.x0; x < crop.x1; ++x) {
          if (source.word) {
            *out++ = source.word(x, y);
          } else {
            const auto value = static_cast<float>(source.real(x, y));
            refuse_overflow(source, value, x, y);
            *out++ = source.type == Imf::HALF ? half(value).bits() : std::bit_cast<std::uint32_t>(value);
          }
        }
      }
    };
    if (in_order)
      for (std::uint32_t y = first; y < last; ++y) convert(y);
    else
      tbb::parallel_for(first, last, convert);
    Imf::FrameBuffer buffer;
    for (std::size_t s = 0; s < sources.size(); ++s) {
      // The base of a slice is the address of pixel (0, 0) of the full image.
      const Imath::Box2i window(Imath::V2i(static_cast<int>(crop.x0), static_cast<int>(first)),
                                Imath::V2i(static_cast<int>(crop.x1 - 1), static_cast<int>(last - 1)));
      buffer.insert(sources[s].name, Imf::Slice::Make(sources[s].type, &words[s * plane], window, sizeof(std::uint32_t),
                                                      sizeof(std::uint32_t) * width));
    }
    part.setFrameBuffer(buffer);
    part.writePixels(static_cast<int>(last - first));
  }
}

/// The frame buffer for rows [first, last), at most exr::kRowsPerBlock, of these channels:
/// words[channel][row - first][x - crop.x0], where each channel has crop.width() * exr::kRowsPerBlock
/// words.
Imf::FrameBuffer sums_buffer(const Crop& crop, std::uint32_t first, std::uint32_t last,
                             const std::vector<std::string>& names, std::vector<std::uint32_t>& words) {
  const Imath::Box2i window(Imath::V2i(static_cast<int>(crop.x0), static_cast<int>(first)),
                            Imath::V2i(static_cast<int>(crop.x1) - 1, static_cast<int>(last) - 1));
  const std::size_t plane = std::size_t{crop.width()} * exr::kRowsPerBlock;
  Imf::FrameBuffer buffer;
  for (std::size_t i = 0; i < names.size(); ++i)
    buffer.insert(names[i], Imf::Slice::Make(Imf::UINT, &words[i * plane], window, sizeof(std::uint32_t),
                                             sizeof(std::uint32_t) * crop.width()));
  return buffer;
}

/// Splits sums into words and writes them, 16 rows at a time.
void write_sums(Imf::OutputPart& part, const Film& film) {
  const FilmLayout& layout = film.layout();
  const Crop& crop = layout.crop;
  const std::vector<std::string> names = exr::sums_channels(layout);
  const std::size_t plane = std::size_t{crop.width()} * exr::kRowsPerBlock;
  const std::size_t channels = layout.channels.size();
  std::vector<std::uint32_t> words(plane * names.size());
  for (std::uint32_t first = crop.y0; first < crop.y1; first += exr::kRowsPerBlock) {
    const std::uint32_t last = std::min(first + exr::kRowsPerBlock, crop.y1);
    for (std::uint32_t y = first; y < last; ++y) {
      const int128* sum = film.row_sums(y).data();
      const std::uint64_t* count = film.row_counts(y).data();
      std::uint32_t* pixel = &words[std::size_t{y - first} * crop.width()];
      for (std::uint32_t x = 0; x < crop.width(); ++x, ++pixel) {
        std::uint32_t* out = pixel;
        const auto put = [&](auto value, std::uint32_t limbs) {
          for (std::uint32_t limb = 0; limb < limbs; ++limb, out += plane)
            *out = static_cast<std::uint32_t>(value >> (32 * limb));
        };
        for (std::uint32_t r = 0; r < layout.replicates; ++r) {
          for (std::size_t c = 0; c < channels; ++c) put(*sum++, exr::kSumLimbs);
          put(*count++, exr::kCountLimbs);
        }
      }
    }
    part.setFrameBuffer(sums_buffer(crop, first, last, names, words));
    part.writePixels(static_cast<int>(last - first));
  }
}

}  // namespace

void write_exr(const std::filesystem::path& path, const Film& film, const Metadata& metadata,
               const ExrOptions& options) {
  const std::vector<Source> sources = image_sources(film, options);
  std::vector<Imf::Header> headers{make_header(film, exr::kImagePart, options.quick)};
  for (const Source& source : sources) headers[0].channels().insert(source.name, Imf::Channel(source.type));
  add_metadata(headers[0], metadata);
  for (const std::string& layer : options.layers) {
    if (!is_matte(layer)) continue;
    const auto manifest = options.manifests.find(layer);
    for (const auto& [key, value] :
         exr::matte_attributes(layer, manifest == options.manifests.end() ? "{}" : manifest->second))
      headers[0].insert(key, Imf::StringAttribute(value));
  }
  if (options.exact_sums) headers.push_back(sums_header(film, options));
  const bool has_mattes = options.exact_sums && !film.layout().mattes.empty();
  if (has_mattes)
    headers.push_back(exr::mattes_header(film, make_header(film, "", options.quick),
                                         headers[1].typedAttribute<Imf::StringAttribute>(exr::kSumsHash).value()));

  AtomicFile file(path);
  try {
    Stream stream(file, path.string());
    Imf::MultiPartOutputFile output(stream, headers.data(), static_cast<int>(headers.size()), false,
                                    static_cast<int>(compressing_threads()));
    Imf::OutputPart image(output, 0);
    write_part(image, film.layout().crop, sources);
    if (options.exact_sums) {
      Imf::OutputPart sums(output, 1);
      write_sums(sums, film);
    }
    if (has_mattes) {
      Imf::OutputPart mattes(output, 2);
      exr::write_mattes(mattes, film);
    }
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(fmt::format("cannot write \"{}\": {}", path.string(), error.what()));
  }
  // After OpenEXR's destructor, which writes the chunk table and swallows what goes wrong.
  file.commit();
}

Image image_part(const Film& film, const ExrOptions& options) {
  const std::vector<Source> sources = image_sources(film, options);
  const Crop& crop = film.layout().crop;
  Image image{.width = crop.width(), .height = crop.height(), .channels = {}, .planes = {}, .metadata = {}};
  for (const Source& source : sources) {
    image.channels.push_back(source.name);
    image.planes.emplace_back(crop.pixel_count());
  }
  const auto convert = [&](std::uint32_t y) {
    for (std::size_t s = 0; s < sources.size(); ++s) {
      float* out = &image.planes[s][std::size_t{y - crop.y0} * crop.width()];
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
        *out++ = sources[s].word ? static_cast<float>(sources[s].word(x, y)) : static_cast<float>(sources[s].real(x, y));
    }
  };
  if (std::ranges::any_of(sources, &Source::in_order))
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y) convert(y);
  else
    tbb::parallel_for(crop.y0, crop.y1, convert);
  return image;
}

Image to_image(const Film& film, std::span<const std::string_view> further) {
  const Crop& crop = film.layout().crop;
  Image image{
      .width = crop.width(), .height = crop.height(), .channels = {"R", "G", "B"}, .planes = {}, .metadata = {}};
  if (film.channel_index("A")) image.channels.emplace_back("A");
  image.channels.insert(image.channels.end(), further.begin(), further.end());
  for (const std::string& channel : image.channels) {
    const auto found = film.channel_index(channel);
    if (!found) throw InternalError(fmt::format("the film has no channel {}", channel));
    std::vector<float>& plane = image.planes.emplace_back();
    plane.reserve(crop.pixel_count());
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x) plane.push_back(static_cast<float>(film.mean(x, y, *found)));
  }
  return image;
}

}  // namespace eikon
