// SPDX-License-Identifier: Apache-2.0
// Lines on stdout for queues that speak Open Job Description [How Jobs Are Run, "Stdout/Stderr
// Messages"]:
// "openjd_progress: <0 to 100>", "openjd_status: <text>", "openjd_fail: <text>".
#pragma once
#include <string>

namespace eikon {

class OpenJdLines {
 public:
  /// on  print lines, or nothing
  explicit OpenJdLines(bool on) : on_(on) {}

  /// share  of the work that is done, 0 to 1. Prints at most one line per tenth of a percent, and
  ///        never goes back.
  void progress(double share);
  void status(const std::string& text);
  void fail(const std::string& text);

 private:
  bool on_;
  long tenths_ = -1;  // of a percent, printed last
  std::string status_;

  void print(const std::string& kind, const std::string& text) const;
};

}  // namespace eikon
