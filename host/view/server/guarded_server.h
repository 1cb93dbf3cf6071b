// SPDX-License-Identifier: Apache-2.0
// The HTTP library's server with limits that it lacks: of the time and the bytes of a whole
// request, and of connections.
#pragma once
#include <httplib.h>

#include <array>
#include <atomic>
#include <chrono>
#include <string>

namespace eikon {

/// A connection with a client that may be slow, or never end.
class GuardedStream : public httplib::Stream {
 public:
  /// ending  is set when nothing is read any more
  GuardedStream(socket_t socket, const std::atomic<bool>& ending) : socket_(socket), ending_(ending) {}

  /// Lets the rest of this request take so many bytes, and the time of a file on a slow link.
  void admit(std::size_t bytes);
  /// Waits for the first byte of another request. False if none comes in time, the client has gone,
  /// or the server ends.
  [[nodiscard]] bool wait_for_request();

  [[nodiscard]] bool is_readable() const override;
  [[nodiscard]] bool is_writable() const override;
  /// -1 beyond the bytes and the time of a request, and when the server ends.
  ssize_t read(char* bytes, std::size_t size) override;
  /// -1 beyond the time of a response.
  ssize_t write(const char* bytes, std::size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  [[nodiscard]] socket_t socket() const override { return socket_; }

 private:
  using Clock = std::chrono::steady_clock;
  /// Waits until the socket is ready for `events`, at most until then.
  [[nodiscard]] bool wait(short events, Clock::time_point until) const;
  /// Waits until there is something to read. False at `until`, or when the server ends.
  [[nodiscard]] bool wait_for_bytes(Clock::time_point until) const;

  socket_t socket_;
  const std::atomic<bool>& ending_;
  std::array<char, 4096> buffer_{};
  std::size_t at_ = 0, end_ = 0;         // what is left of the buffer
  std::size_t received_ = 0, most_ = 0;  // bytes of the request
  bool answers_ = false;                 // the response has begun
  Clock::time_point until_{};            // of the request, then of the response
  std::chrono::seconds silence_{};       // of a client whose request is not complete
};

class GuardedServer : public httplib::Server {
 public:
  GuardedServer();
  /// No connection waits any more, for a thread or for a request; to be called before stop().
  void end() { ending_ = true; }
  /// Lets the rest of the request that this thread serves take so many bytes.
  static void admit(std::size_t bytes);

 private:
  bool process_and_close_socket(socket_t socket) override;

  std::atomic<bool> ending_{false};
};

}  // namespace eikon
