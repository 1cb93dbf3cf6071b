// SPDX-License-Identifier: Apache-2.0
#include "view/server/view_server.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "io/json_dump.h"
#include "io/text.h"
#include "page/page.h"
#include "view/server/guarded_server.h"

namespace eikon {
namespace {

constexpr std::size_t kMaxPayload = 64 << 10;  // bytes of a request's body
constexpr const char* kDrop = "/api/drop";
constexpr double kNews_s = 1;

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (getentropy(bytes.data(), bytes.size()) != 0) throw InternalError("the system gives no random numbers");
  std::string token;
  for (const unsigned char byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

/// Compares in a time that does not depend on where the texts differ.
bool same_secret(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

/// "localhost" of "localhost:8080", "[::1]" of "[::1]:8080"; empty if what follows is no port.
std::string host_name(const std::string& host) {
  const std::size_t colon = host.starts_with('[') ? host.find(':', host.find(']')) : host.find(':');
  if (colon == std::string::npos) return host;
  return number_in<std::uint16_t>(host.substr(colon + 1)) ? host.substr(0, colon) : "";
}

std::uint64_t number_parameter(const httplib::Request& request, const char* name) {
  const auto number = number_in<std::uint64_t>(request.get_param_value(name));
  if (!number) throw UsageError(fmt::format("view: {} takes a number", name));
  return *number;
}

void refuse(httplib::Response& response, int status, const std::string& message) {
  response.status = status;
  response.set_content(dump_json({{"error", message}}), "application/json");
}

std::string page_of_view() {
  const Json data = {{"layers", view_layers()}};
  return make_page("view.html",
                   {.title = "eikon view",
                    .styles = {"style.css", "view.css"},
                    .scripts = {"parts.js", "tone.js", "view_camera.js", "view_parts.js", "view_picture.js", "view.js",
                                "view_input.js"},
                    .data = data},
                   true);
}

std::string news_bytes(const ViewNews& news, const Json& final_render, std::uint64_t frame_seen) {
  const bool sends = news.frame && news.frame->number != frame_seen;
  const std::string text = fmt::format(
      "{{\"version\":{},\"status\":{},\"final\":{},\"frame\":{}}}", news.version, news.status, dump_json(final_render),
      sends ? fmt::format("{{\"number\":{},\"about\":{}}}", news.frame->number, news.frame->about) : "null");
  std::string bytes;
  for (unsigned shift = 0; shift < 32; shift += 8) bytes += char(text.size() >> shift & 0xFFU);
  bytes += text;
  if (sends) bytes.append(reinterpret_cast<const char*>(news.frame->pixels.data()), news.frame->pixels.size());
  return bytes;
}

/// Why a request is not read any further, or nothing. None needs a body that is compressed, in
/// chunks or of several parts, and libraries have had errors in all of these.
std::string unwanted(const httplib::Request& request) {
  for (const char* header : {"Transfer-Encoding", "Content-Encoding", "Range", "Expect"})
    if (request.has_header(header)) return fmt::format("view: requests have no header {}", header);
  if (request.is_multipart_form_data()) return "view: requests have one part";
  if (request.get_header_value_count("Content-Length") > 1) return "view: a request has one length";
  const std::string length = request.get_header_value("Content-Length");
  // Without its length, a file whose connection is cut looks whole.
  if (request.path == kDrop && length.empty()) return "view: a dropped file comes with its Content-Length";
  const std::uint64_t most = request.path == kDrop ? kMaxDropped : kMaxPayload;
  if (!length.empty() && number_in<std::uint64_t>(length).value_or(most + 1) > most)
    return fmt::format("view: a request has at most {} bytes here", most);
  return "";
}

}  // namespace

bool comes_from_here(const RequestOrigin& request) {
  const std::array<std::string_view, 3> here = {"localhost", "127.0.0.1", "[::1]"};
  if (std::ranges::find(here, host_name(request.host)) == here.end()) return false;
  if (!request.origin.empty() && request.origin != "http://" + request.host) return false;
  return request.fetch_site.empty() || request.fetch_site == "same-origin" || request.fetch_site == "none";
}

struct ViewServer::Http {
  GuardedServer server;
};

ViewServer::ViewServer(ViewSession& session, int port)
    : session_(session), token_(random_token()), port_(port), http_(std::make_unique<Http>()) {
  httplib::Server& server = http_->server;
  server.set_payload_max_length(kMaxDropped);
  guard();
  add_handlers();
  const bool bound =
      port == 0 ? (port_ = server.bind_to_any_port("127.0.0.1")) > 0 : server.bind_to_port("127.0.0.1", port);
  if (!bound)
    throw InputError(
        fmt::format("--port {}: cannot listen there; another program may have it: choose another one, or "
                    "leave --port out",
                    port));
}

ViewServer::~ViewServer() = default;

/// Adds the checks that come before every handler, and what every answer has in common.
void ViewServer::guard() {
  httplib::Server& server = http_->server;
  server.set_default_headers({{"Cache-Control", "no-store"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"X-Frame-Options", "DENY"},
                              {"Referrer-Policy", "no-referrer"},
                              {"Cross-Origin-Opener-Policy", "same-origin"},
                              {"Cross-Origin-Resource-Policy", "same-origin"}});
  server.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
    RequestOrigin origin{request.get_header_value("Host"), request.get_header_value("Origin"),
                         request.get_header_value("Sec-Fetch-Site")};
    // A RedirectFile is a page of another site to browsers, and it leads here; its token says that
    // it may.
    if (request.path == "/" && request.get_header_value("Sec-Fetch-Dest") == "document") origin.fetch_site.clear();
    const std::string token =
        request.path == "/" ? request.get_param_value("token") : request.get_header_value("X-Eikon-Token");
    const std::string problem = unwanted(request);
    if (!comes_from_here(origin) || !same_secret(token, token_))
      refuse(response, 403, "open the address that `eikon view` printed, with its token");
    else if (!problem.empty())
      refuse(response, 400, problem);
    else {
      if (request.path == kDrop) GuardedServer::admit(kMaxDropped);
      return httplib::Server::HandlerResponse::Unhandled;
    }
    return httplib::Server::HandlerResponse::Handled;
  });
  server.set_exception_handler([](const httplib::Request&, httplib::Response& response, std::exception_ptr exception) {
    try {
      std::rethrow_exception(exception);
    } catch (const Error& error) {
      refuse(response, 400, error.what());
    } catch (const std::exception& error) {
      refuse(response, 500, error.what());
    }
  });
}

void ViewServer::add_handlers() {
  httplib::Server& server = http_->server;
  server.Get("/", [page = page_of_view()](const httplib::Request&, httplib::Response& response) {
    response.set_content(page, "text/html; charset=utf-8");
  });
  server.Get("/api/news", [this](const httplib::Request& request, httplib::Response& response) {
    const std::uint64_t frame = number_parameter(request, "frame");
    const ViewNews news = session_.news(number_parameter(request, "after"), kNews_s);
    response.set_content(news_bytes(news, final_.status(), frame), "application/octet-stream");
  });
  server.Post("/api/look", [this](const httplib::Request& request, httplib::Response& response) {
    const std::uint64_t number = session_.look(read_look(request.body));
    response.set_content(fmt::format("{{\"number\":{}}}", number), "application/json");
  });
  server.Get("/api/path", [this](const httplib::Request& request, httplib::Response& response) {
    const std::uint64_t x = number_parameter(request, "x"), y = number_parameter(request, "y");
    if (x > kMaxViewSide || y > kMaxViewSide) throw UsageError("view: no such pixel");
    const std::uint64_t sample = number_parameter(request, "sample");
    if (sample >> 32U != 0) throw UsageError("view: no such sample");
    response.set_content(session_.path({std::uint32_t(x), std::uint32_t(y), sample}).dump(), "application/json");
  });
  add_orders();
}

/// Adds the requests that change more than the picture.
void ViewServer::add_orders() {
  httplib::Server& server = http_->server;
  const auto receive = [this](const httplib::Request& request, httplib::Response& response,
                              const httplib::ContentReader& read) {
    DroppedFiles::Incoming incoming = dropped_.begin(request.get_param_value("name"));
    const bool is_whole = read(
        [&](const char* bytes, std::size_t size) { return bool(incoming.file.write(bytes, std::streamsize(size))); });
    if (!is_whole && incoming.file) {
      DroppedFiles::drop(incoming);
      throw UsageError("view: the file did not come as a whole; drop it again");
    }
    DroppedFiles::finish(incoming);
    show(incoming);
    response.set_content("{}", "application/json");
  };
  server.Post(kDrop, httplib::Server::HandlerWithContentReader(receive));
  server.Post("/api/render", [this](const httplib::Request&, httplib::Response& response) {
    const std::lock_guard lock(scene_);
    const std::vector<std::string> words = session_.words();
    if (words.empty()) throw UsageError("view: there is no picture yet that could be rendered");
    final_.start(words, std::filesystem::path(words.front()).stem().string() + "-view");
    response.set_content("{}", "application/json");
  });
  server.Post("/api/stop", [this](const httplib::Request&, httplib::Response& response) {
    final_.stop();
    response.set_content("{}", "application/json");
  });
}

void ViewServer::show(DroppedFiles::Incoming& scene) {
  const std::lock_guard lock(scene_);
  try {
    session_.open(scene.path.string());
  } catch (...) {
    DroppedFiles::drop(scene);
    throw;
  }
  dropped_.keep(scene);
  if (!final_.is_running()) dropped_.remove_old();  // it may be loading one
}

std::string ViewServer::address() const { return fmt::format("http://127.0.0.1:{}/?token={}", port_, token_); }

void ViewServer::serve(const std::atomic<bool>& stop) {
  httplib::Server& server = http_->server;
  std::atomic<bool> over{false};
  std::thread listening([&] {
    (void)server.listen_after_bind();
    over = true;
  });
  bool paused = false;
  while (!stop && !over) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    // The view leaves the devices to a final render.
    if (const bool is_running = final_.is_running(); is_running != paused) session_.pause(paused = is_running);
  }
  session_.end();  // and with it every wait for news
  while (!over && !server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  http_->server.end();
  server.stop();
  listening.join();
  if (!stop) throw InputError("the server ended by itself: its socket was closed");
}

}  // namespace eikon
