// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfDoubleAttribute.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMatrixAttribute.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <type_traits>

#include <fmt/ranges.h>

#include "core/error.h"
#include "io/atomic_file.h"
#include "film/exr/layout.h"
#include "film/exr/mattes.h"
#include "film/exr/film_file.h"
#include "film/exr/scanlines.h"
#include "image/exr_file.h"
#include "film/layers.h"
#include "film/mattes.h"

namespace eikon {

namespace {

static_assert(std::endian::native == std::endian::little, "convert() keeps a half in the first bytes of a word");

/// One channel of a part, and the function that computes a row of its values: `reals` for HALF and
/// FLOAT channels, `words` for UINT channels.
struct Source {
  std::string name;
  Imf::PixelType type = Imf::FLOAT;
  std::function<void(std::uint32_t y, float* row)> reals = {};
  std::function<void(std::uint32_t y, std::uint32_t* row)> words = {};
  bool in_order = false;  // rows must be asked for in their order, by one thread
};

/// A row from a function of pixels.
template <class Value>
auto row_of(const Film& film, Value value) {
  return [&film, value](std::uint32_t y, auto* row) {
    const Crop& crop = film.layout().crop;
    for (std::uint32_t x = crop.x0; x < crop.x1; ++x)
      *row++ = static_cast<std::remove_reference_t<decltype(*row)>>(value(x, y));
  };
}

Source source_of(const Film& film, const LayerChannel& channel, Imf::PixelType type) {
  const std::vector<std::uint32_t>& from = channel.film;
  Source source{.name = channel.name, .type = type};
  switch (channel.rule) {
    case LayerRule::mean:
      if (from.size() == 1)
        source.reals = [&film, c = from[0]](std::uint32_t y, float* row) { film.row_means(y, c, row); };
      else
        source.reals = row_of(film, [&film, from](auto x, auto y) { return film.mean(x, y, from); });
      return source;
    case LayerRule::mean_of_hit:
      source.reals = row_of(film, [&film, from](auto x, auto y) {
        const double hits = to_double(film.total(x, y, from[1]));
        return hits > 0 ? to_double(film.total(x, y, from[0])) / hits : std::numeric_limits<double>::infinity();
      });
      return source;
    case LayerRule::word:
      source.type = Imf::UINT;
      source.words = row_of(film, [&film, from](auto x, auto y) { return film.total(x, y, from[0]) >> 64; });
      return source;
    case LayerRule::variance:
      source.reals = row_of(film, [&film, from](auto x, auto y) { return film.variance_of_mean(x, y, from[0]); });
      return source;
    case LayerRule::samples:
      source.type = Imf::UINT;
      source.words = row_of(film, [&film](auto x, auto y) {
        return std::min<std::uint64_t>(film.samples(x, y), std::numeric_limits<std::uint32_t>::max());
      });
      return source;
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
                       .reals = row_of(film, [ranks, c](auto x, auto y) { return ranks->value(x, y, c); }),
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
    for (std::size_t c = 0; c < 3; ++c)
      sources.push_back(
          {.name = "denoised." + options.denoised->channels[c],
           .type = type,
           .reals = [&plane = options.denoised->planes[c], crop = film.layout().crop](auto y, float* row) {
             std::copy_n(&plane[std::size_t{y - crop.y0} * crop.width()], crop.width(), row);
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
  // Always quick: ZIP makes the sums a third smaller, and takes a core half a second longer for a
  // megapixel, of each part that is written and of each that is merged.
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

/// Throws if a value becomes infinite as half. 65520 (65504 plus half a step) is the least
/// magnitude that does.
void refuse_overflow(const Source& source, float value, std::uint32_t x, std::uint32_t y) {
  if (source.type != Imf::HALF || !std::isfinite(value) || std::abs(value) < 65520.0f) return;
  const bool is_place = std::ranges::any_of(std::array{"depth", "position", "uv"},
                                            [&](const char* layer) { return source.name.starts_with(layer); });
  throw HalfOverflow(
      fmt::format("--half: {} at pixel {},{} in channel {} is beyond the range of half floats (65504): "
                  "leave --half out{}",
                  value, x, y, source.name, is_place ? "" : " or scale the lights down"));
}

/// Converts a row of a channel: floats to their bits, halves in the low bytes.
void convert(const Source& source, const Crop& crop, std::uint32_t y, std::uint32_t* out) {
  if (source.words) return source.words(y, out);
  std::vector<float> row(crop.width());
  source.reals(y, row.data());
  if (source.type == Imf::FLOAT) {
    std::memcpy(out, row.data(), row.size() * sizeof(float));
    return;
  }
  for (std::uint32_t x = crop.x0; x < crop.x1; ++x) {
    const float value = row[x - crop.x0];
    refuse_overflow(source, value, x, y);
    *out++ = half(value).bits();
  }
}

/// Converts and writes a few blocks of rows per thread at a time, so that memory does not grow with
/// the height of the image.
void write_image(exr::ScanlineFile& file, const Crop& crop, const std::vector<Source>& sources) {
  const std::size_t width = crop.width();
  constexpr std::uint32_t kBlocks = 2, kMaxThreads = 8;
  const bool in_order = std::ranges::any_of(sources, [](const Source& source) {
    // So that the error names the first overflow.
    return source.in_order || source.type == Imf::HALF;
  });
  const auto threads = static_cast<std::uint32_t>(tbb::this_task_arena::max_concurrency());
  const std::uint32_t most = std::min(exr::kRowsPerBlock * kBlocks * std::min(threads, kMaxThreads), crop.height());
  const std::size_t plane = width * most;
  std::vector<std::uint32_t> words(plane * sources.size());
  std::vector<std::string> names;
  for (const Source& source : sources) names.push_back(source.name);
  for (std::uint32_t first = crop.y0; first < crop.y1; first += most) {
    const std::uint32_t last = std::min(first + most, crop.y1);
    const auto convert_row = [&](std::uint32_t y) {
      for (std::size_t s = 0; s < sources.size(); ++s)
        convert(sources[s], crop, y, &words[s * plane + (y - first) * width]);
    };
    if (in_order)
      for (std::uint32_t y = first; y < last; ++y) convert_row(y);
    else
      tbb::parallel_for(first, last, convert_row);
    file.write(0, {.first = static_cast<int>(first),
                   .last = static_cast<int>(last),
                   .width = width,
                   .plane = plane,
                   .channels = names,
                   .words = words});
  }
}

/// Splits the sums and counts of a row into words, a plane for each, in the order of
/// exr::sums_channels().
void split_row(const Film& film, std::uint32_t y, std::uint32_t* words, std::size_t plane) {
  const FilmLayout& layout = film.layout();
  const std::size_t width = layout.crop.width(), channels = layout.channels.size(), replicates = layout.replicates;
  const std::span<const int128> sums = film.row_sums(y);
  const std::span<const std::uint64_t> counts = film.row_counts(y);
  // So few pixels at a time that they stay in the cache while one plane after the other is written,
  // which lie far apart.
  constexpr std::size_t kPixels = 64;
  for (std::size_t first = 0; first < width; first += kPixels) {
    const std::size_t last = std::min(first + kPixels, width);
    std::uint32_t* out = words;
    const auto put = [&](const auto* values, std::size_t each, std::uint32_t limbs) {
      for (std::uint32_t limb = 0; limb < limbs; ++limb, out += plane)
        for (std::size_t x = first; x < last; ++x) out[x] = static_cast<std::uint32_t>(values[x * each] >> (32 * limb));
    };
    for (std::size_t r = 0; r < replicates; ++r) {
      for (std::size_t c = 0; c < channels; ++c) put(&sums[r * channels + c], replicates * channels, exr::kSumLimbs);
      put(&counts[r], replicates, exr::kCountLimbs);
    }
  }
}

/// Writes the words of the sums, 16 rows at a time.
void write_sums(exr::ScanlineFile& file, const Film& film) {
  const Crop& crop = film.layout().crop;
  const std::vector<std::string> names = exr::sums_channels(film.layout());
  const std::size_t plane = std::size_t{crop.width()} * exr::kRowsPerBlock;
  std::vector<std::uint32_t> words(plane * names.size());
  for (std::uint32_t first = crop.y0; first < crop.y1; first += exr::kRowsPerBlock) {
    const std::uint32_t last = std::min(first + exr::kRowsPerBlock, crop.y1);
    for (std::uint32_t y = first; y < last; ++y)
      split_row(film, y, &words[std::size_t{y - first} * crop.width()], plane);
    file.write(1, {.first = static_cast<int>(first),
                   .last = static_cast<int>(last),
                   .width = crop.width(),
                   .plane = plane,
                   .channels = names,
                   .words = words});
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
    exr::ScanlineFile parts(file, headers);
    write_image(parts, film.layout().crop, sources);
    if (options.exact_sums) write_sums(parts, film);
    if (has_mattes) exr::write_mattes(parts, 2, headers[2], film);
    parts.end();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(fmt::format("cannot write \"{}\": {}", path.string(), error.what()));
  }
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
  const auto convert_row = [&](std::uint32_t y) {
    for (std::size_t s = 0; s < sources.size(); ++s) {
      float* const out = &image.planes[s][std::size_t{y - crop.y0} * crop.width()];
      if (sources[s].reals) {
        sources[s].reals(y, out);
      } else {
        std::vector<std::uint32_t> words(crop.width());
        sources[s].words(y, words.data());
        std::ranges::transform(words, out, [](std::uint32_t word) { return static_cast<float>(word); });
      }
    }
  };
  if (std::ranges::any_of(sources, &Source::in_order))
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y) convert_row(y);
  else
    tbb::parallel_for(crop.y0, crop.y1, convert_row);
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
    std::vector<float>& plane = image.planes.emplace_back(crop.pixel_count());
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
      film.row_means(y, *found, &plane[std::size_t{y - crop.y0} * crop.width()]);
  }
  return image;
}

}  // namespace eikon
