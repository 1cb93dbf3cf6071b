// SPDX-License-Identifier: Apache-2.0
// A locale whose numbers have a decimal comma, made for the test, since few machines have one
// installed.
#pragma once
#include <cstdlib>
#include <string>

#include "support/temporary_folder.h"

namespace eikon::test {

class CommaLocale {
 public:
  CommaLocale() {
    const std::string command = "localedef -i de_DE -f UTF-8 '" + (folder_ / name()).string() + "' > /dev/null 2>&1";
    made_ = std::system(command.c_str()) == 0;
  }
  /// False where `localedef` or what it needs (Debian: locales) is missing.
  [[nodiscard]] bool made() const { return made_; }
  /// For LOCPATH.
  [[nodiscard]] std::string folder() const { return folder_.path().string(); }
  static const char* name() { return "de_DE.UTF-8"; }

 private:
  TemporaryFolder folder_;
  bool made_ = false;
};

}  // namespace eikon::test
