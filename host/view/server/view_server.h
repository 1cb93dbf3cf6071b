// SPDX-License-Identifier: Apache-2.0
// Serves the page of a view, to this machine and to whoever knows the token.
#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "view/server/dropped_files.h"
#include "view/server/final_render.h"
#include "view/view_session.h"

namespace eikon {

/// Holds what a request says of where it comes from.
struct RequestOrigin {
  std::string host;        // header Host
  std::string origin;      // header Origin; empty: none
  std::string fetch_site;  // header Sec-Fetch-Site; empty: none
};
/// True if a request comes from the page itself, or from somebody who typed its address: its host
/// is this machine by name or number, so no name of another server leads here, and no page of
/// another origin sends it. The port may be another one, as through a tunnel.
[[nodiscard]] bool comes_from_here(const RequestOrigin& request);

/// GET  /?token=T               the page; other sites may lead to it, if they know the token
/// GET  /api/news?after=VERSION&frame=NUMBER
///                              waits up to a second for news: four bytes with the length of a JSON
///                              text, least significant first, the text {"version", "status",
///                              "final": FinalRender::status(), "frame": null or what is known of
///                              it}, and the pixels of the frame if its number is not NUMBER
/// POST /api/look               takes what read_look() reads; answers {"number"}, that of the look
/// GET  /api/path?x=X&y=Y&sample=N   answers as ViewSession::path()
/// POST /api/drop?name=NAME     takes a scene file, and shows it
/// POST /api/render             starts the final render of what is shown
/// POST /api/stop               interrupts it
/// All but the page want the token in the header X-Eikon-Token. There are no other paths. Errors
/// are {"error": line}.
class ViewServer {
 public:
  /// port  0: any that is free
  /// throws InputError if the port is taken
  ViewServer(ViewSession& session, int port);
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  /// "http://127.0.0.1:PORT/?token=..."
  [[nodiscard]] std::string address() const;
  /// Serves until `stop` is set. Ends the session, and interrupts a final render.
  /// throws InputError if the server cannot go on
  void serve(const std::atomic<bool>& stop);

 private:
  struct Http;
  ViewSession& session_;
  FinalRender final_;
  DroppedFiles dropped_;
  std::string token_;
  int port_;
  std::unique_ptr<Http> http_;
  // Held while another scene takes the place of the one that is shown, or a final render of that
  // one is started.
  std::mutex scene_;

  void guard();
  void add_handlers();
  void add_orders();
  /// Shows a scene instead of the one before. throws InputError, and removes its file, if it cannot
  /// be opened now
  void show(DroppedFiles::Incoming& scene);
};

}  // namespace eikon
