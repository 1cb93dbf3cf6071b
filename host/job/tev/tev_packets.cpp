// SPDX-License-Identifier: Apache-2.0
#include "job/tev/tev_packets.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "io/text.h"

namespace eikon {
namespace {

static_assert(std::endian::native == std::endian::little, "the viewer reads little-endian numbers");

enum class Operation : std::uint8_t { create_image = 4, update_image = 6 };

constexpr std::size_t kMaxBytes = std::size_t{1} << 20;  // of a message's pixels, unless a row has more

/// A message grows field by field; its first four bytes are its length.
class Packet {
 public:
  explicit Packet(Operation operation) {
    number(std::uint32_t{0});
    number(static_cast<std::uint8_t>(operation));
  }

  template <class Number>
  Packet& number(Number value) {
    return raw(&value, sizeof value);
  }
  Packet& size(std::size_t value) { return number(static_cast<std::int32_t>(value)); }
  Packet& text(const std::string& value) { return raw(value.c_str(), value.size() + 1); }
  Packet& texts(const std::vector<std::string>& values) {
    for (const std::string& value : values) text(value);
    return *this;
  }
  Packet& raw(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
    return *this;
  }

  [[nodiscard]] std::string take() {
    const auto size = static_cast<std::uint32_t>(bytes_.size());
    std::memcpy(bytes_.data(), &size, sizeof size);
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
};

}  // namespace

std::string tev_create(const TevImage& image) {
  const bool to_front = true;
  return Packet(Operation::create_image)
      .number(to_front)
      .text(image.name)
      .size(image.width)
      .size(image.height)
      .size(image.channels.size())
      .texts(image.channels)
      .take();
}

void tev_update(const std::string& name, const Image& part, TevPlace at,
                const std::function<void(const std::string&)>& send) {
  const std::size_t channels = part.channels.size();
  const std::size_t row_bytes = std::max<std::size_t>(1, channels * part.width * sizeof(float));
  const auto most_rows = static_cast<std::uint32_t>(std::clamp<std::size_t>(kMaxBytes / row_bytes, 1, part.height));
  for (std::uint32_t first = 0; first < part.height; first += most_rows) {
    const std::uint32_t rows = std::min(most_rows, part.height - first);
    const std::size_t values = std::size_t{part.width} * rows;
    const bool to_front = false;
    Packet packet(Operation::update_image);
    packet.number(to_front).text(name).size(channels).texts(part.channels);
    packet.size(at.x).size(at.y + first).size(part.width).size(rows);
    for (std::size_t c = 0; c < channels; ++c) packet.number(static_cast<std::int64_t>(c * values));  // its first value
    for (std::size_t c = 0; c < channels; ++c) packet.number(std::int64_t{1});  // from a value to the next
    for (const std::vector<float>& plane : part.planes)
      packet.raw(&plane[std::size_t{first} * part.width], values * sizeof(float));
    send(packet.take());
  }
}

}  // namespace eikon
