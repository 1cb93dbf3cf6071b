// SPDX-License-Identifier: Apache-2.0
#include "film/exr/mattes.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfInputPart.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "film/mattes.h"
#include "io/text.h"
#include "io/xxhash64.h"

namespace eikon::exr {

namespace {

constexpr const char* kMattesPart = "mattes";
constexpr const char* kEntries = "eikon.entries";         // string attribute: number of entries
constexpr const char* kEntriesHash = "eikon.mattesHash";  // string: hash of the seal and entries
constexpr std::size_t kWords = 5;
constexpr std::array<const char*, kWords> kChannels = {"matte", "pixel", "id", "count.0", "count.1"};
constexpr std::size_t kMaxColumns = 8192;
constexpr std::size_t kRows = 16;  // rows of a block of ZIP compression
constexpr std::uint64_t kMaxMattesBytes = std::uint64_t{1} << 38;

using Entry = std::array<std::uint32_t, kWords>;  // in the order of kChannels

/// Calls take(entry) for every matte, pixel and id.
template <class Take>
void for_each_entry(const Film& film, const Take& take) {
  const Crop& crop = film.layout().crop;
  for (std::uint32_t m = 0; m < film.layout().mattes.size(); ++m) {
    std::uint32_t pixel = 0;
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x, ++pixel)
        for (const MatteCount& count : film.matte(m, x, y))
          take(Entry{m, pixel, count.id, static_cast<std::uint32_t>(count.samples),
                     static_cast<std::uint32_t>(count.samples >> 32U)});
  }
}

class EntriesHash {
 public:
  explicit EntriesHash(const std::string& seal) : hash_(xxhash64(std::as_bytes(std::span(seal)), 0)) {}
  void add(const Entry& entry) { hash_ = xxhash64(std::as_bytes(std::span(entry)), hash_); }
  [[nodiscard]] std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_;
};

std::size_t columns_for(std::uint64_t entries) {
  return static_cast<std::size_t>(std::clamp<std::uint64_t>(entries, 1, kMaxColumns));
}

/// The frame buffer for rows [first, last) of the table: words[channel][row - first][column].
Imf::FrameBuffer table_buffer(std::size_t columns, int first, int last, std::vector<std::uint32_t>& words) {
  const Imath::Box2i window(Imath::V2i(0, first), Imath::V2i(static_cast<int>(columns) - 1, last - 1));
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < kWords; ++c)
    buffer.insert(kChannels[c], Imf::Slice::Make(Imf::UINT, &words[c * columns * kRows], window, sizeof(std::uint32_t),
                                                 sizeof(std::uint32_t) * columns));
  return buffer;
}

std::string text_of(const Imf::Header& header, const char* name) {
  const auto* attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
  return attribute == nullptr ? std::string() : attribute->value();
}

}  // namespace

Imf::Header mattes_header(const Film& film, Imf::Header like, const std::string& seal) {
  std::uint64_t entries = 0;
  EntriesHash hash(seal);
  for_each_entry(film, [&](const Entry& entry) { ++entries, hash.add(entry); });
  const std::size_t columns = columns_for(entries);
  const std::uint64_t rows = std::max<std::uint64_t>((entries + columns - 1) / columns, 1);
  if (rows > kMaxSide)
    throw InputError(
        fmt::format("the mattes have {} entries, more than a file holds: render it in parts (--crop)", entries));
  like.setName(kMattesPart);
  like.dataWindow() = {Imath::V2i(0, 0), Imath::V2i(static_cast<int>(columns) - 1, static_cast<int>(rows) - 1)};
  for (const char* name : kChannels) like.channels().insert(name, Imf::Channel(Imf::UINT));
  like.insert(kEntries, Imf::StringAttribute(std::to_string(entries)));
  like.insert(kEntriesHash, Imf::StringAttribute(hash.text()));
  return like;
}

void write_mattes(ScanlineFile& file, std::size_t part, const Imf::Header& header, const Film& film) {
  const Imath::Box2i& window = header.dataWindow();
  const std::vector<std::string> channels(kChannels.begin(), kChannels.end());
  const std::size_t columns = static_cast<std::size_t>(window.max.x) + 1, plane = columns * kRows;
  const int rows = window.max.y + 1;
  std::vector<std::uint32_t> words(kWords * plane);
  std::size_t place = 0;
  int first = 0;
  const auto flush = [&] {
    const int last = std::min(first + static_cast<int>(kRows), rows);
    file.write(part, {.first = first, .last = last, .width = columns, .plane = plane, .channels = channels, .words = words});
    std::ranges::fill(words, 0U);
    first = last;
    place = 0;
  };
  for_each_entry(film, [&](const Entry& entry) {
    for (std::size_t c = 0; c < kWords; ++c) words[c * plane + place] = entry[c];
    if (++place == plane) flush();
  });
  if (first < rows) flush();
}

void read_mattes(const std::filesystem::path& path, Reader& reader, const FilmLayout& layout, const std::string& seal,
                 Film& film) {
  int index = 0;
  while (index < reader.file().parts() &&
         !(reader.header(index).hasName() && reader.header(index).name() == kMattesPart))
    ++index;
  if (index == reader.file().parts()) refuse(path, "the counts of its mattes are missing");
  reader.check(index, kMaxMattesBytes);
  const Imf::Header& header = reader.header(index);
  const auto [columns, rows] = reader.size(index);
  const auto stated = number_in<std::uint64_t>(text_of(header, kEntries));
  std::uint64_t entries = stated.value_or(0);
  bool sound = stated && entries <= std::uint64_t{columns} * rows && header.dataWindow().min == Imath::V2i(0, 0);
  for (const char* name : kChannels) {
    const Imf::Channel* channel = header.channels().findChannel(name);
    sound = sound && channel != nullptr && channel->type == Imf::UINT;
  }
  if (!sound) refuse(path, "the header of its mattes is damaged");

  const std::size_t plane = std::size_t{columns} * kRows;
  std::vector<std::uint32_t> words(kWords * plane);
  EntriesHash hash(seal);
  Imf::InputPart part(reader.file(), index);
  for (std::uint32_t first = 0; first < rows && entries > 0; first += kRows) {
    const std::uint32_t last = std::min<std::uint32_t>(first + kRows, rows);
    part.setFrameBuffer(table_buffer(columns, static_cast<int>(first), static_cast<int>(last), words));
    part.readPixels(static_cast<int>(first), static_cast<int>(last) - 1);
    const std::size_t here = std::min<std::uint64_t>(entries, std::uint64_t{columns} * (last - first));
    entries -= here;
    for (std::size_t i = 0; i < here; ++i) {
      Entry entry{};
      for (std::size_t c = 0; c < kWords; ++c) entry[c] = words[c * plane + i];
      hash.add(entry);
      const auto [matte, pixel, id, low, high] = entry;
      if (matte >= layout.mattes.size() || pixel >= layout.crop.pixel_count())
        refuse(path, "its mattes have an entry of no pixel: the file is damaged");
      film.add_to_matte(matte, layout.crop.x0 + pixel % layout.crop.width(),
                        layout.crop.y0 + pixel / layout.crop.width(), {id, std::uint64_t{high} << 32U | low});
    }
  }
  if (hash.text() != text_of(header, kEntriesHash))
    refuse(path, "the checksum of its mattes is wrong: the file is damaged");
}

MatteRanks::Ranks MatteRanks::ranks(std::uint32_t x, std::uint32_t y) const {
  std::vector<MatteCount> counts = film_.matte(matte_, x, y);
  std::uint64_t all = 0;
  for (const MatteCount& count : counts) all += count.samples;
  std::erase_if(counts, [](const MatteCount& count) { return count.id == 0; });
  std::ranges::stable_sort(counts, std::ranges::greater{}, &MatteCount::samples);
  Ranks ranks{};
  for (std::size_t r = 0; r < std::min(kRanks, counts.size()); ++r) {
    ranks[2 * r] = std::bit_cast<float>(counts[r].id);
    ranks[2 * r + 1] = static_cast<float>(static_cast<double>(counts[r].samples) / static_cast<double>(all));
  }
  return ranks;
}

float MatteRanks::value(std::uint32_t x, std::uint32_t y, std::size_t channel) {
  const Crop& crop = film_.layout().crop;
  if (y < begin_ || y >= end_) {
    begin_ = crop.y0 + (y - crop.y0) / kRows * kRows;
    end_ = std::min(begin_ + kRows, crop.y1);
    block_.clear();
    for (std::uint32_t row = begin_; row < end_; ++row)
      for (std::uint32_t column = crop.x0; column < crop.x1; ++column) block_.push_back(ranks(column, row));
  }
  return block_[std::size_t{y - begin_} * crop.width() + (x - crop.x0)][channel];
}

std::vector<std::string> matte_channels(const std::string& layer) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < MatteRanks::kChannels; ++c)
    names.push_back(fmt::format("{}{:02}.{}", layer, c / 4, "RGBA"[c % 4]));
  return names;
}

std::map<std::string, std::string> matte_attributes(const std::string& layer, const std::string& manifest) {
  const std::string prefix = fmt::format("cryptomatte/{}/", matte_hex(matte_id(layer)).substr(0, 7));
  return {{prefix + "name", layer},
          {prefix + "hash", "MurmurHash3_32"},
          {prefix + "conversion", "uint32_to_float32"},
          {prefix + "manifest", manifest}};
}

}  // namespace eikon::exr
