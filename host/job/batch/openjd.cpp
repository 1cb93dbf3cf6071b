// SPDX-License-Identifier: Apache-2.0
#include "job/batch/openjd.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace eikon {

void OpenJdLines::print(const std::string& kind, const std::string& text) const {
  if (!on_) return;
  std::string line = text;
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  (void)std::fputs(fmt::format("openjd_{}: {}\n", kind, line).c_str(), stdout);  // main() reports a failure of stdout
  std::fflush(stdout);
}

void OpenJdLines::progress(double share) {
  const long tenths = std::lround(1000 * std::clamp(share, 0.0, 1.0));
  if (tenths <= tenths_) return;
  tenths_ = tenths;
  print("progress", fmt::format("{}.{}", tenths / 10, tenths % 10));
}

void OpenJdLines::status(const std::string& text) {
  if (text == status_) return;
  status_ = text;
  print("status", text);
}

void OpenJdLines::fail(const std::string& text) { print("fail", text); }

}  // namespace eikon
