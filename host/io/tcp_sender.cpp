// SPDX-License-Identifier: Apache-2.0
#include "io/tcp_sender.h"

#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <system_error>
#include <utility>

#include "core/clock.h"
#include "core/error.h"

namespace eikon {
namespace {

constexpr int kPollInterval_ms = 50;
// The system doubles it. Without a bound it would keep several megabytes that nobody reads.
constexpr int kKeptBytes = 1 << 18;

std::string in_words(int error) { return std::generic_category().message(error); }

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses look_up(const NetworkAddress& address) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); error != 0)
    throw InputError(error == EAI_SYSTEM ? in_words(errno) : gai_strerror(error));
  return {found, &freeaddrinfo};
}

}  // namespace

std::string NetworkAddress::text() const {
  return host.find(':') == std::string::npos ? fmt::format("{}:{}", host, port) : fmt::format("[{}]:{}", host, port);
}

TcpSender::TcpSender(const NetworkAddress& address, GiveUp give_up) : give_up_(std::move(give_up)) {
  const Addresses addresses = look_up(address);
  std::string why = "it has no address";
  for (const addrinfo* at = addresses.get(); at != nullptr; at = at->ai_next) {
    socket_ = socket(at->ai_family, at->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, at->ai_protocol);
    if (socket_ < 0) {
      why = in_words(errno);
      continue;
    }
    (void)setsockopt(socket_, SOL_SOCKET, SO_SNDBUF, &kKeptBytes, sizeof kKeptBytes);
    try {
      if (connect(socket_, at->ai_addr, at->ai_addrlen) == 0) return;
      if (errno != EINPROGRESS) throw InputError(in_words(errno));
      wait_for_room("it does not answer");
      int error = 0;
      socklen_t size = sizeof error;
      if (getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0) return;
      throw InputError(in_words(error));
    } catch (const InputError& error) {
      why = error.what();
      close(std::exchange(socket_, -1));
    }
  }
  throw InputError(why);
}

TcpSender::~TcpSender() {
  if (socket_ >= 0) close(socket_);
}

void TcpSender::wait_for_room(const char* what) {
  const double begin_s = host_seconds();
  for (;;) {
    pollfd polled{.fd = socket_, .events = POLLOUT, .revents = 0};
    const int ready = poll(&polled, 1, kPollInterval_ms);
    if (ready > 0) return;
    if (ready < 0 && errno != EINTR) throw InputError(in_words(errno));
    if (give_up_(host_seconds() - begin_s)) throw InputError(what);
  }
}

bool TcpSender::is_closed() const {
  char byte = 0;
  return recv(socket_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

void TcpSender::send(std::string_view bytes) {
  // The system takes bytes for a connection that the other side has just closed, and says so only
  // later.
  if (is_closed()) throw InputError("it closed the connection");
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent >= 0) {
      bytes.remove_prefix(std::size_t(sent));
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      wait_for_room("it does not read");
    } else if (errno == EPIPE || errno == ECONNRESET) {
      throw InputError("it closed the connection");
    } else if (errno != EINTR) {
      throw InputError(in_words(errno));
    }
  }
}

}  // namespace eikon
