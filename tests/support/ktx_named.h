// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdlib>
#include <optional>
#include <string>

namespace picture_test {

/// Sets EIKON_KTX while it lives.
class KtxNamed {
 public:
  explicit KtxNamed(const char* library) {
    if (const char* const before = std::getenv("EIKON_KTX")) before_ = before;
    setenv("EIKON_KTX", library, 1);
  }
  ~KtxNamed() {
    if (before_) {
      setenv("EIKON_KTX", before_->c_str(), 1);
    } else {
      unsetenv("EIKON_KTX");
    }
  }
  KtxNamed(const KtxNamed&) = delete;
  KtxNamed& operator=(const KtxNamed&) = delete;

 private:
  std::optional<std::string> before_;
};

}  // namespace picture_test
