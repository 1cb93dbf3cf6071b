// SPDX-License-Identifier: Apache-2.0
// A stand-in for the viewer tev: a server that decodes what is sent to it, by the protocol as tev's
// own reader has it.
#pragma once
#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace eikon::test {

/// An image as the viewer has it, NaN where nothing was sent.
struct ShownImage {
  std::int32_t width = 0, height = 0;
  std::map<std::string, std::vector<float>> channels;
};

/// Reads the fields of one message.
class MessageReader {
 public:
  explicit MessageReader(const std::string& bytes) : bytes_(bytes) {}

  template <class Number>
  Number number() {
    Number value{};
    if (bytes_.size() - at_ < sizeof value) throw std::runtime_error("a message ends within a number");
    std::memcpy(&value, &bytes_[at_], sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string text() {
    const std::size_t end = bytes_.find('\0', at_);
    if (end == std::string::npos) throw std::runtime_error("a message ends within a text");
    std::string value = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    return value;
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

class TevServer {
 public:
  enum class Reads { everything, one_message, nothing };

  explicit TevServer(Reads reads = Reads::everything) : reads_(reads) {
    listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int little = 4096;  // so that what nobody reads is soon too much for the system to keep
    if (reads == Reads::nothing) setsockopt(listener_, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listener_, 16), 0);
    EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~TevServer() {
    if (thread_.joinable()) end();
  }
  TevServer(const TevServer&) = delete;
  TevServer& operator=(const TevServer&) = delete;

  /// The flag that sends pictures here.
  [[nodiscard]] std::string flag() const { return fmt::format(" --tev 127.0.0.1:{}", port_); }
  /// Counts how often the first row of an image was sent.
  [[nodiscard]] int pictures() const { return pictures_.load(); }
  [[nodiscard]] int connections() const { return connections_.load(); }

  /// Takes what is still on its way from programs that have ended. After it:
  void end() {
    stop_ = true;
    thread_.join();
    close(listener_);
  }
  std::map<std::string, ShownImage> images;  // by name
  std::string error;                         // what was wrong with a message; empty: nothing

 private:
  Reads reads_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::atomic<int> pictures_{0}, connections_{0};

  /// One connection after the other. The listener is closed only at the end, and keeps those that
  /// wait.
  void serve() {
    for (;;) {
      const bool last = stop_.load();  // of connections that were made before, none is overlooked
      pollfd polled{.fd = listener_, .events = POLLIN, .revents = 0};
      if (poll(&polled, 1, last ? 0 : 20) <= 0) {
        if (last) return;
        continue;
      }
      const int connection = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      ++connections_;
      try {
        read_from(connection);
      } catch (const std::exception& wrong) {
        error = wrong.what();
      }
      close(connection);
    }
  }

  void read_from(int connection) {
    while (reads_ == Reads::nothing && !stop_) poll(nullptr, 0, 20);
    if (reads_ == Reads::nothing) return;
    std::string length(4, '\0'), message;
    while (receive(connection, length)) {
      message.resize(MessageReader(length).number<std::uint32_t>() - length.size());
      if (!receive(connection, message)) throw std::runtime_error("the connection ends within a message");
      take(message);
      if (reads_ == Reads::one_message) return;
    }
  }

  /// Fills `bytes`; false at the end of the connection.
  static bool receive(int connection, std::string& bytes) {
    for (std::size_t have = 0; have < bytes.size();) {
      const ssize_t got = recv(connection, &bytes[have], bytes.size() - have, 0);
      if (got <= 0) return false;
      have += std::size_t(got);
    }
    return true;
  }

  void take(const std::string& message) {
    MessageReader reader(message);
    const auto operation = reader.number<std::uint8_t>();
    (void)reader.number<std::uint8_t>();  // to the front
    const std::string name = reader.text();
    if (operation == 4)
      create(reader, images[name]);
    else if (operation == 6)
      update(reader, images.at(name));
    else
      throw std::runtime_error(fmt::format("there is no operation {}", operation));
  }

  static void create(MessageReader& reader, ShownImage& image) {
    image = {reader.number<std::int32_t>(), reader.number<std::int32_t>(), {}};
    const auto count = reader.number<std::int32_t>();
    for (std::int32_t c = 0; c < count; ++c)
      image.channels[reader.text()].assign(std::size_t(image.width) * std::size_t(image.height), NAN);
    if (reader.left() != 0) throw std::runtime_error("bytes follow the names of channels");
  }

  void update(MessageReader& reader, ShownImage& image) {
    const auto count = std::size_t(reader.number<std::int32_t>());
    std::vector<std::string> names(count);
    for (std::string& name : names) name = reader.text();
    const auto x = reader.number<std::int32_t>(), y = reader.number<std::int32_t>(),
               width = reader.number<std::int32_t>(), height = reader.number<std::int32_t>();
    if (x < 0 || y < 0 || width <= 0 || height <= 0 || x + width > image.width || y + height > image.height)
      throw std::runtime_error("a part lies outside of its image");
    std::vector<std::int64_t> offsets(count), strides(count);
    for (std::int64_t& offset : offsets) offset = reader.number<std::int64_t>();
    for (std::int64_t& stride : strides) stride = reader.number<std::int64_t>();
    std::vector<float> values(reader.left() / sizeof(float));
    for (float& value : values) value = reader.number<float>();
    for (std::size_t c = 0; c < count; ++c)
      for (std::int32_t row = 0; row < height; ++row)
        for (std::int32_t column = 0; column < width; ++column)
          image.channels.at(names[c])[std::size_t((y + row) * image.width + x + column)] =
              values.at(std::size_t(offsets[c] + (row * width + column) * strides[c]));
    pictures_ += y == 0 ? 1 : 0;
  }
};

}  // namespace eikon::test
