// SPDX-License-Identifier: Apache-2.0
#include "view/server/guarded_server.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

#include "view/server/bounded_threads.h"

namespace eikon {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kThreads = 32;             // each serves a connection
constexpr std::size_t kMaxRequest = 128 << 10;   // bytes, with headers
constexpr int kMaxPerConnection = 1000;          // requests
constexpr seconds kIdle(3);                      // between two requests
constexpr seconds kRequestTime(10), kAnswerTime(60);
// A slow link may take long for a large file, so it is its silence that ends it; but nobody holds a
// thread for ever.
constexpr seconds kFileTime(3600), kFileSilence(20);
constexpr milliseconds kWake(50);  // between two looks whether the server ends
constexpr seconds kStall(5);  // of a client that reads nothing of its answer

thread_local GuardedStream* served = nullptr;  // of the request that this thread is at

}  // namespace

void GuardedStream::admit(std::size_t bytes) {
  most_ = received_ + bytes;
  until_ = Clock::now() + kFileTime;
  silence_ = kFileSilence;
}

bool GuardedStream::wait(short events, Clock::time_point until) const {
  const auto left = std::chrono::duration_cast<milliseconds>(until - Clock::now());
  pollfd file{socket_, events, 0};
  return poll(&file, 1, int(std::max<milliseconds::rep>(left.count(), 0))) > 0;
}

bool GuardedStream::wait_for_bytes(Clock::time_point until) const {
  bool comes = at_ < end_;
  while (!comes && !ending_ && Clock::now() < until) comes = wait(POLLIN, std::min(until, Clock::now() + kWake));
  return comes && !ending_;
}

bool GuardedStream::wait_for_request() {
  const bool comes = wait_for_bytes(Clock::now() + kIdle);
  received_ = end_ - at_;
  most_ = kMaxRequest;
  answers_ = false;
  until_ = Clock::now() + kRequestTime;
  silence_ = kRequestTime;
  return comes;
}

bool GuardedStream::is_readable() const { return wait_for_bytes(std::min(until_, Clock::now() + silence_)); }
bool GuardedStream::is_writable() const { return wait(POLLOUT, Clock::now() + kAnswerTime); }

ssize_t GuardedStream::read(char* bytes, std::size_t size) {
  if (at_ == end_) {
    if (received_ >= most_ || !is_readable()) return -1;
    const ssize_t count = recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (count <= 0) return count;
    at_ = 0;
    end_ = std::size_t(count);
    received_ += end_;
  }
  const std::size_t count = std::min(size, end_ - at_);
  std::copy_n(buffer_.data() + at_, count, bytes);
  at_ += count;
  return ssize_t(count);
}

ssize_t GuardedStream::write(const char* bytes, std::size_t size) {
  if (!answers_) until_ = Clock::now() + kAnswerTime;
  answers_ = true;
  if (!wait(POLLOUT, std::min(until_, Clock::now() + kStall))) return -1;
  return send(socket_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT);
}

// Every client is on this machine.
void GuardedStream::get_remote_ip_and_port(std::string& ip, int& port) const { ip = "127.0.0.1", port = 0; }
void GuardedStream::get_local_ip_and_port(std::string& ip, int& port) const { ip = "127.0.0.1", port = 0; }

GuardedServer::GuardedServer() {
  new_task_queue = [this] { return new BoundedThreads(kThreads, ending_); };
  // The library's own options let two processes share a port.
  set_socket_options([](socket_t socket) {
    const int yes = 1;
    (void)setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  set_tcp_nodelay(true);
  // The library only writes these into its answers; process_and_close_socket() keeps to them.
  set_keep_alive_timeout(kIdle.count());
  set_keep_alive_max_count(kMaxPerConnection);
}

void GuardedServer::admit(std::size_t bytes) {
  if (served != nullptr) served->admit(bytes);
}

bool GuardedServer::process_and_close_socket(socket_t socket) {
  GuardedStream stream(socket, ending_);
  served = &stream;
  for (int left = kMaxPerConnection; left > 0 && stream.wait_for_request(); --left) {
    bool closed = false;
    if (!process_request(stream, left == 1, closed, nullptr) || closed) break;
  }
  served = nullptr;
  (void)shutdown(socket, SHUT_RDWR);
  close(socket);
  return true;
}

}  // namespace eikon
