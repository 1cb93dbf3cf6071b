// SPDX-License-Identifier: Apache-2.0
#include <ImfChannelList.h>
#include <ImfIntAttribute.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <bit>
#include <set>

#include <fmt/format.h>

#include "image/exr_file.h"
#include "film/exr/integer_chunks.h"
#include "film/exr/layout.h"
#include "film/exr/mattes.h"
#include "film/exr/film_file.h"
#include "io/text.h"

namespace eikon {
namespace {

using exr::Reader, exr::reading, exr::refuse;

// 2 GPixel; it is read a few rows at a time.
constexpr std::uint64_t kMaxSumsBytes = std::uint64_t{1} << 38;

constexpr std::size_t kMaxMattes = 16;

void read_channels(const std::filesystem::path& path, const Imf::Header& header, FilmLayout& layout) {
  const auto* replicates = header.findTypedAttribute<Imf::IntAttribute>(exr::kReplicates);
  const auto* channels = header.findTypedAttribute<Imf::StringAttribute>(exr::kChannels);
  if (replicates == nullptr || channels == nullptr) refuse(path, "its part \"sums\" was not written by eikon");
  if (replicates->value() < 1 || replicates->value() > 64 ||
      !std::has_single_bit(static_cast<unsigned>(replicates->value())))
    refuse(path, fmt::format("{} replicates", replicates->value()));
  layout.replicates = static_cast<std::uint32_t>(replicates->value());

  layout.channels = split(channels->value(), ',');
  const auto* mattes = header.findTypedAttribute<Imf::StringAttribute>(exr::kMattes);
  layout.mattes = mattes == nullptr ? std::vector<std::string>() : split(mattes->value(), ',');
  if (layout.mattes.size() > kMaxMattes) refuse(path, fmt::format("{} mattes", layout.mattes.size()));
  if (layout.channels.size() < 3 || layout.channels[0] != "R" || layout.channels[1] != "G" || layout.channels[2] != "B")
    refuse(path, "its sums are not of R, G, B");
  // A list of names may be long without the channels that it names.
  if (std::set<std::string>(layout.channels.begin(), layout.channels.end()).size() != layout.channels.size() ||
      std::set<std::string>(layout.mattes.begin(), layout.mattes.end()).size() != layout.mattes.size())
    refuse(path, "its sums have a channel twice");
  for (const std::string& name : exr::sums_channels(layout)) {
    const Imf::Channel* channel = header.channels().findChannel(name);
    if (channel == nullptr || channel->type != Imf::UINT)
      refuse(path, fmt::format("the integer channel {} is missing", name));
  }
}

void read_windows(const std::filesystem::path& path, const Imf::Header& header, FilmLayout& layout) {
  const Imath::Box2i &display = header.displayWindow(), &data = header.dataWindow();
  const bool inside = display.min == Imath::V2i(0, 0) && data.min.x >= 0 && data.min.y >= 0 &&
                      data.max.x <= display.max.x && data.max.y <= display.max.y && display.max.x < exr::kMaxSide &&
                      display.max.y < exr::kMaxSide;
  if (!inside) refuse(path, "its data window lies outside its display window");
  const auto end = [](int last) { return static_cast<std::uint32_t>(last) + 1; };
  layout.width = end(display.max.x);
  layout.height = end(display.max.y);
  layout.crop = {static_cast<std::uint32_t>(data.min.x), static_cast<std::uint32_t>(data.min.y), end(data.max.x),
                 end(data.max.y)};
}

/// Numbers of a row, in the order of a film.
struct Row {
  std::vector<int128> sums;
  std::vector<std::uint64_t> counts;
};

/// Joins the words of row y of a chunk.
void join_words(const FilmLayout& layout, const exr::IntegerChunk& chunk, std::uint32_t y, Row& row) {
  const std::size_t width = layout.crop.width();
  int128* sum = row.sums.data();
  std::uint64_t* count = row.counts.data();
  for (std::size_t x = 0; x < width; ++x) {
    const std::uint32_t* word = chunk.words + (y - chunk.first_row) * width + x;
    const auto take = [&] {
      const std::uint64_t value = *word;
      word += chunk.words_per_channel;
      return value;
    };
    for (std::uint32_t r = 0; r < layout.replicates; ++r) {
      for (std::size_t c = 0; c < layout.channels.size(); ++c) {
        const std::uint64_t w0 = take(), w1 = take(), w2 = take(), w3 = take();
        *sum++ = static_cast<int128>(static_cast<std::int64_t>(w3 << 32 | w2)) << 64 | (w1 << 32 | w0);
      }
      const std::uint64_t low = take(), high = take();
      *count++ = high << 32 | low;
    }
  }
}

}  // namespace

std::string exr::light_paths_text(std::span<const LightPathCount> counts) {
  std::string text;
  for (const LightPathCount& count : counts) {
    const Crop& w = count.window;
    text += fmt::format("{}{} {} {} {} {}", text.empty() ? "" : ";", w.x0, w.y0, w.x1, w.y1, fmt::join(count.paths, " "));
  }
  return text;
}

std::optional<std::vector<LightPathCount>> exr::parse_light_paths(std::string_view text, const FilmLayout& layout) {
  constexpr std::size_t kMaxWindows = 1U << 16;
  std::vector<LightPathCount> counts;
  for (const std::string& part : split(text, ';')) {
    std::vector<std::uint64_t> numbers;
    for (const std::string& word : split(part, ' ')) {
      const auto number = number_in<std::uint64_t>(word);
      if (!number) return std::nullopt;
      numbers.push_back(*number);
    }
    if (numbers.size() != 4 + layout.replicates) return std::nullopt;
    const auto fits = [&](std::size_t begin, std::size_t end, std::uint32_t size) {
      return numbers[begin] < numbers[end] && numbers[end] <= size;
    };
    if (!fits(0, 2, layout.width) || !fits(1, 3, layout.height)) return std::nullopt;
    const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(numbers[i]); };
    const Crop window{at(0), at(1), at(2), at(3)};
    // In their order, and each once: see Film::add_light_paths.
    if (counts.size() == kMaxWindows || (!counts.empty() && order_of(counts.back().window) >= order_of(window)))
      return std::nullopt;
    counts.push_back({window, {numbers.begin() + 4, numbers.end()}});
  }
  return counts;
}

struct SumsReader::Impl {
  std::filesystem::path path;
  Reader reader;
  int part = 0;
  FilmLayout layout;
  std::string record, hash, light_paths_text;
  std::vector<LightPathCount> light_paths;

  explicit Impl(const std::filesystem::path& file) : path(file), reader(file) {
    while (part < reader.file().parts() &&
           !(reader.header(part).hasName() && reader.header(part).name() == exr::kSumsPart))
      ++part;
    if (part == reader.file().parts())
      refuse(path,
             "a plain picture without exact sums, which only checkpoints, merged files and outputs of renders "
             "with --samples or --crop have");
    const Imf::Header& header = reader.header(part);
    read_format(header);
    reader.check(part, kMaxSumsBytes);
    read_channels(path, header, layout);
    read_windows(path, header, layout);
    if (const auto* text = header.findTypedAttribute<Imf::StringAttribute>(exr::kLightPaths)) {
      light_paths_text = text->value();
      const auto counts = exr::parse_light_paths(light_paths_text, layout);
      if (!counts || !layout.channels.back().starts_with(kSplats)) refuse(path, "its count of light paths is damaged");
      light_paths = *counts;
    }
  }

  void read_format(const Imf::Header& header) {
    const auto* format = header.findTypedAttribute<Imf::IntAttribute>(exr::kFormat);
    if (format == nullptr)
      refuse(path, "it does not say what its sums are of: an older eikon wrote it, render it again");
    if (format->value() > exr::kSumsFormat)
      refuse(path, fmt::format("a newer eikon wrote it (format {}, this one reads up to {}): use that one",
                               format->value(), exr::kSumsFormat));
    const auto* text = header.findTypedAttribute<Imf::StringAttribute>(exr::kRecord);
    const auto* checksum = header.findTypedAttribute<Imf::StringAttribute>(exr::kSumsHash);
    if (format->value() < 1 || text == nullptr || checksum == nullptr || text->value().size() > exr::kMaxRecordBytes)
      refuse(path, "the header of its sums is damaged");
    record = text->value();
    hash = checksum->value();
  }
};

SumsReader::SumsReader(const std::filesystem::path& path)
    : impl_(reading(path, [&] { return std::make_unique<Impl>(path); })) {}
SumsReader::~SumsReader() = default;
const FilmLayout& SumsReader::layout() const { return impl_->layout; }
const std::string& SumsReader::record() const { return impl_->record; }

void SumsReader::add_to(Film& film) {
  const FilmLayout& layout = impl_->layout;
  const Crop& crop = layout.crop;
  const std::size_t cells = std::size_t{crop.width()} * layout.replicates;
  Row row{std::vector<int128>(cells * layout.channels.size()), std::vector<std::uint64_t>(cells)};
  exr::SumsHash hash(layout, impl_->record, impl_->light_paths_text);
  reading(impl_->path, [&] {
    exr::IntegerChunks chunks(impl_->path, impl_->part, crop, exr::sums_channels(layout));
    for (std::uint32_t y = crop.y0; y < crop.y1;) {
      const exr::IntegerChunk chunk = chunks.read(y);
      for (const std::uint32_t end = y + chunk.rows; y < end; ++y) {
        join_words(layout, chunk, y, row);
        hash.add_row(row.sums, row.counts);
        try {
          film.add_row(crop.x0, y, row.sums, row.counts);
        } catch (const InputError& error) {
          refuse(impl_->path, fmt::format("{}; or the file is damaged", error.what()));
        }
      }
    }
    if (hash.text() != impl_->hash) refuse(impl_->path, "its checksum is wrong: the file is damaged");
    for (const LightPathCount& count : impl_->light_paths) film.add_light_paths(count);
    if (!layout.mattes.empty()) exr::read_mattes(impl_->path, impl_->reader, layout, impl_->hash, film);
  });
}

Film read_film(const std::filesystem::path& path) {
  return reading(path, [&] {
    SumsReader reader(path);
    Film film(reader.layout());
    reader.add_to(film);
    return film;
  });
}

}  // namespace eikon
