// SPDX-License-Identifier: Apache-2.0
// Lines on stdout for queues that speak Open Job Description [How Jobs Are Run, "Stdout/Stderr Messages"]:
// "openjd_progress: <0 to 100>", "openjd_status: <text>", "openjd_fail: <text>".
#pragma once
#include <string>

namespace eikon {

class OpenJdLines {
 public:
  /// on: false says nothing
  explicit OpenJdLines(bool on) : on_(on) {}

  /// share: of the work, 0 to 1. A line for each tenth of a percent at most, never going back.
  void progress(double share);
  void status(const std::string& text);
  void fail(const std::string& text);

 private:
  bool on_;
  long tenths_ = -1;  // of a percent, said last
  std::string status_;

  void print(const std::string& kind, const std::string& text) const;
};

}  // namespace eikon
