// SPDX-License-Identifier: Apache-2.0
// A TCP connection to another program, over which bytes only go out.
#pragma once
#include <functional>
#include <string>
#include <string_view>

namespace eikon {

struct NetworkAddress {
  std::string host;  // a name or an address of IPv4 or IPv6, without brackets
  std::string port;  // a number, in decimal

  /// "localhost:14158", or "[::1]:14158" where the host has colons.
  [[nodiscard]] std::string text() const;
};

/// Called about twenty times a second while a connection does not get on; true ends the attempt.
/// stalled_s: the seconds since the last byte was taken, or since the attempt to connect began
using GiveUp = std::function<bool(double stalled_s)>;

class TcpSender {
 public:
  /// Connects to the first of the host's addresses that answers. The look-up of a host's name is
  /// left to the system, which may take its time and cannot be given up.
  /// throws InputError, without the address: "connection refused"
  TcpSender(const NetworkAddress& address, GiveUp give_up);
  ~TcpSender();
  TcpSender(const TcpSender&) = delete;
  TcpSender& operator=(const TcpSender&) = delete;

  /// Hands all bytes to the system, which keeps up to half a megabyte of them until the other side
  /// reads. throws InputError when the other side has closed, or give_up said so
  void send(std::string_view bytes);

 private:
  int socket_ = -1;
  GiveUp give_up_;

  /// Waits until the socket takes bytes. throws InputError
  void wait_for_room(const char* what);
  [[nodiscard]] bool is_closed() const;  // by the other side
};

}  // namespace eikon
