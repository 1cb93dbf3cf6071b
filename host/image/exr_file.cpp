// SPDX-License-Identifier: Apache-2.0
#include "image/exr_file.h"

#include <ImfChannelList.h>
#include <ImfPartType.h>

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

namespace eikon::exr {
namespace {

constexpr int kMaxTileSide = 8192, kMaxParts = 16, kMaxChannels = 4096;
// Deflate shrinks data by a factor of at most 1032, and the other codecs by less, so a file that
// claims far more lies about its size.
constexpr std::uint64_t kMaxExpansion = 4096, kAlwaysCredibleBytes = std::uint64_t{64} << 20;

}  // namespace

void refuse(const std::filesystem::path& path, const std::string& why) {
  throw InputError(fmt::format("cannot read \"{}\": {}", path.string(), why));
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Reader::Reader(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) refuse(path, "no such file; check the name");
  if (std::filesystem::is_directory(status)) refuse(path, "is a directory; name a file in it");
  if (!std::filesystem::is_regular_file(status))
    refuse(path, "is not a regular file (a pipe or device); save it to a file first");
  size_bytes_ = std::filesystem::file_size(path, error);
  if (!error && size_bytes_ == 0) refuse(path, "is empty (0 bytes); write or copy it again");
  std::ifstream file(path, std::ios::binary);
  char magic[4] = {};
  if (!file) refuse(path, "it cannot be opened: are you allowed to read it?");
  if (!file.read(magic, 4) || magic[0] != 0x76 || magic[1] != 0x2f || magic[2] != 0x31 || magic[3] != 0x01)
    refuse(path, "is no OpenEXR file (wrong magic number); name one");
  // OpenEXR checks these process-wide limits before it allocates anything for a header.
  Imf::Header::setMaxImageSize(kMaxSide, kMaxSide);
  Imf::Header::setMaxTileSize(kMaxTileSide, kMaxTileSide);
  // An incomplete chunk table is an error; OpenEXR is not to reconstruct it.
  file_ = std::make_unique<Imf::MultiPartInputFile>(path.c_str(), 0, false);
  if (file_->parts() > kMaxParts) refuse(path, fmt::format("it has {} parts, more than {}", file_->parts(), kMaxParts));
}

void Reader::check(int part, std::uint64_t max_bytes) const {
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
  if (bytes > std::max(kAlwaysCredibleBytes, size_bytes_ * kMaxExpansion))
    refuse(path_, fmt::format("its header claims {}x{} pixels of {} channels, which {} bytes cannot hold", width,
                              height, channel_count, size_bytes_));
  if (bytes > max_bytes)
    refuse(path_, fmt::format("{}x{} pixels of {} channels need {} MB; at most {} MB are for it, scale it down", width,
                              height, channel_count, bytes >> 20U, max_bytes >> 20U));
}

std::pair<std::uint32_t, std::uint32_t> Reader::size(int part) const {
  const Imath::Box2i& window = header(part).dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
    refuse(path_, fmt::format("a data window of {}x{} pixels", width, height));
  return {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
}

}  // namespace eikon::exr
