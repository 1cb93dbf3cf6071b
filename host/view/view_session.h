// SPDX-License-Identifier: Apache-2.0
// One scene that is rendered anew whenever somebody asks to see it otherwise. A thread of its own
// renders, from a small picture to one with all samples; any thread may ask and look.
#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "device/device_pool.h"
#include "view/scenery.h"
#include "view/view_board.h"

namespace eikon {

class ViewSession {
 public:
  /// given  the words behind `eikon view` that `eikon render` knows, too
  /// parse  reads such words
  /// Begins at once, as `look` has it.
  ViewSession(std::vector<std::string> given, ParseRender parse, ViewLook look);
  /// Does not wait for a scene that is being loaded, nor for a compiler: their threads are lost
  /// (core/lost_threads.h).
  ~ViewSession();
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  /// Asks for another picture. What is wrong with it shows in the status.
  /// returns  the number of the look, which grows with each
  std::uint64_t look(const ViewLook& look) { return board_->look(look); }
  /// Shows another scene, from where its file has the camera, whatever is under way.
  /// throws InputError while too many scenes that nobody wants any more are being loaded
  void open(const std::string& scene);
  /// Paused: only what is asked for anew is rendered, and only small.
  void pause(bool is_paused) { board_->pause(is_paused); }
  /// Waits until there is something newer than `version`, at most for so long.
  [[nodiscard]] ViewNews news(std::uint64_t version, double most_s) { return board_->news(version, most_s); }
  /// The words behind `eikon render` for the picture in force, without names of output files; none
  /// before it is loaded.
  [[nodiscard]] std::vector<std::string> words() { return board_->words(); }
  /// Traces the path of a sample of the picture in force again, as traced_path().
  /// throws InputError, also if there is no answer in time
  [[nodiscard]] Json path(const PixelSample& at);
  /// Ends the thread, and every wait. Any number of times.
  void end() { board_->end(); }

 private:
  /// The thread of an engine. It cannot be interrupted while it loads or compiles, so it owns, or
  /// shares, all that it uses.
  struct EngineThread {
    std::thread thread;
    std::shared_ptr<const std::atomic<bool>> ended;
  };

  void start(bool is_other_scene);
  void join_ended();

  const std::shared_ptr<ViewBoard> board_;
  const ParseRender parse_;
  const DevicePool pool_;
  std::mutex mutex_;  // guards what follows
  std::vector<std::string> given_;
  std::vector<EngineThread> threads_{};
};

}  // namespace eikon
