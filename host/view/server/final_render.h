// SPDX-License-Identifier: Apache-2.0
// A render that a page starts: the command that the page shows, run as a process of its own.
#pragma once
#include <sys/types.h>

#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "io/json_text.h"

namespace eikon {

class FinalRender {
 public:
  FinalRender() = default;
  /// Interrupts the render, which keeps what is done, and waits for its end.
  ~FinalRender();
  FinalRender(const FinalRender&) = delete;
  FinalRender& operator=(const FinalRender&) = delete;

  /// Starts `eikon render` with these words, and names for the image and a PNG beside it in the
  /// current folder, of `name` and the first number for which there are no such files.
  /// throws UsageError while one is running; InputError if it cannot be started
  void start(std::vector<std::string> words, const std::string& name);
  /// Interrupts it, if there is one.
  void stop();
  [[nodiscard]] bool is_running();
  /// "state" (none, running, done, stopped or failed), "share" (0 to 1) of what is done, "image"
  /// and "png" (names of files), "message" (why it failed).
  [[nodiscard]] Json status();

 private:
  void watch(int output, int messages);

  std::mutex starting_;  // start() holds it to its end, so that nobody else finds that none is running
  std::mutex mutex_;     // guards what follows
  pid_t process_ = 0;    // 0: none is running
  std::string state_ = "none", image_{}, png_{}, message_{};
  double share_ = 0;
  bool stopped_ = false;

  std::thread watcher_;
};

}  // namespace eikon
