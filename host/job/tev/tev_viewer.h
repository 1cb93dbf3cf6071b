// SPDX-License-Identifier: Apache-2.0
// Shows a growing image in the viewer tev. A thread beside the render sends; neither a viewer that
// is slow nor one that is not there holds the render up or changes it.
#pragma once
#include <memory>
#include <string>
#include <thread>

#include "core/time_share.h"
#include "film/exr/film_file.h"
#include "io/tcp_sender.h"
#include "job/log.h"
#include "job/tev/tev_packets.h"
#include "render/render.h"

namespace eikon {

struct TevTarget {
  NetworkAddress address;
  std::string name;       // of the image in the viewer
  ExrOptions exr;         // what the image has beside R, G and B, as in the file that is written
  bool denoised = false;  // the last picture has the channels denoised.R/G/B, too
};

class TevViewer {
 public:
  /// Begins to connect. log: takes one line if the viewer cannot be reached, closes, or does not
  /// read; called by the thread that calls attach()'s hooks or close()
  TevViewer(TevTarget target, Log log);
  /// Ends the connection at once.
  ~TevViewer();
  TevViewer(const TevViewer&) = delete;
  TevViewer& operator=(const TevViewer&) = delete;

  /// Sends the render's picture as it grows. The devices wait while it is copied, for at most one
  /// fiftieth of the time, and only when all of the one before has been sent.
  void attach(RenderHooks& hooks);
  /// Begins to send the last picture. exr: the target's, with the denoised picture if there is one
  void show_last(const Film& film, const ExrOptions& exr);
  /// Waits until the last picture, if there is one, has been sent, but only for a few seconds.
  void close();

 private:
  struct Picture;
  struct Shared;

  TevTarget target_;
  Log log_;
  std::shared_ptr<Shared> shared_;  // with the thread, which may be lost in the look-up of a name
  TimeShare copying_;               // the devices wait while a picture is copied
  std::thread thread_;

  void offer(const Film& film);
  void tell_failure();
  /// Ends the thread after what it has to send, but within so many seconds.
  void end_within(double seconds);
};

}  // namespace eikon
