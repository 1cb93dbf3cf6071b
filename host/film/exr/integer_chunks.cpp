// SPDX-License-Identifier: Apache-2.0
#include "film/exr/integer_chunks.h"

#include <openexr.h>

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

namespace eikon::exr {
namespace {

/// Takes the place of the library's own, which prints; what is wrong is known from the code that a
/// function returns.
void be_silent(exr_const_context_t, exr_result_t, const char*) {}

void check(exr_result_t code, const char* doing) {
  if (code != EXR_ERR_SUCCESS)
    throw std::runtime_error(fmt::format("{}: {}.", doing, exr_get_default_error_message(code)));
}

}  // namespace

struct IntegerChunks::Impl {
  exr_context_t file = nullptr;
  int part = 0;
  Crop window;
  std::vector<std::string> channels;
  std::int32_t rows_per_chunk = 1;
  exr_decode_pipeline_t decoder{};
  bool has_decoder = false;
  std::vector<std::uint32_t> words;

  ~Impl() {
    if (has_decoder) exr_decoding_destroy(file, &decoder);
    if (file != nullptr) exr_finish(&file);
  }

  [[nodiscard]] std::size_t words_per_channel() const {
    return std::size_t{window.width()} * std::size_t(rows_per_chunk);
  }

  /// Lets the decoder read a chunk, and write it to `words`.
  void aim(const exr_chunk_info_t& chunk) {
    if (has_decoder) {
      check(exr_decoding_update(file, part, &chunk, &decoder), "reading a chunk");
    } else {
      check(exr_decoding_initialize(file, part, &chunk, &decoder), "reading its first chunk");
      has_decoder = true;
    }
    for (int i = 0; i < decoder.channel_count; ++i) {
      exr_coding_channel_info_t& channel = decoder.channels[i];
      const auto found = std::find(channels.begin(), channels.end(), channel.channel_name);
      // Channels that nobody has asked for are skipped.
      channel.decode_to_ptr = nullptr;
      if (found == channels.end() || channel.data_type != EXR_PIXEL_UINT) continue;
      std::uint32_t* const begin = &words[std::size_t(found - channels.begin()) * words_per_channel()];
      channel.decode_to_ptr = reinterpret_cast<std::uint8_t*>(begin);
      channel.user_bytes_per_element = sizeof(std::uint32_t);
      channel.user_pixel_stride = sizeof(std::uint32_t);
      channel.user_line_stride = static_cast<std::int32_t>(window.width() * sizeof(std::uint32_t));
      channel.user_data_type = EXR_PIXEL_UINT;
    }
    check(exr_decoding_choose_default_routines(file, part, &decoder), "reading a chunk");
  }
};

IntegerChunks::IntegerChunks(const std::filesystem::path& path, int part, const Crop& window,
                             const std::vector<std::string>& channels)
    : impl_(std::make_unique<Impl>()) {
  Impl& own = *impl_;
  own.part = part;
  own.window = window;
  own.channels = channels;
  exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
  settings.error_handler_fn = be_silent;
  check(exr_start_read(&own.file, path.c_str(), &settings), "opening it");
  exr_attr_box2i_t found{};
  check(exr_get_data_window(own.file, part, &found), "reading its data window");
  const auto end = [](std::int32_t last) { return static_cast<std::uint32_t>(last) + 1; };
  const Crop read{static_cast<std::uint32_t>(found.min.x), static_cast<std::uint32_t>(found.min.y), end(found.max.x),
                  end(found.max.y)};
  if (read != window) throw std::runtime_error("it was replaced while it was read.");
  check(exr_get_scanlines_per_chunk(own.file, part, &own.rows_per_chunk), "reading its header");
  own.rows_per_chunk = std::min(own.rows_per_chunk, static_cast<int>(window.height()));
  own.words.resize(own.words_per_channel() * channels.size());
}

IntegerChunks::~IntegerChunks() = default;

IntegerChunk IntegerChunks::read(std::uint32_t row) {
  Impl& own = *impl_;
  const auto y = static_cast<int>(row);
  exr_chunk_info_t chunk{};
  check(exr_read_scanline_chunk_info(own.file, own.part, y, &chunk), "looking for a chunk");
  const bool fits = chunk.start_y == y && chunk.start_x == static_cast<int>(own.window.x0) &&
                    chunk.width == static_cast<int>(own.window.width()) && chunk.height >= 1 &&
                    chunk.height <= std::min(own.rows_per_chunk, static_cast<int>(own.window.y1) - y);
  if (!fits) throw std::runtime_error("a chunk has other rows than its place says.");
  own.aim(chunk);
  check(exr_decoding_run(own.file, own.part, &own.decoder), "decoding a chunk");
  return {row, static_cast<std::uint32_t>(chunk.height), own.words.data(), own.words_per_channel()};
}

}  // namespace eikon::exr
