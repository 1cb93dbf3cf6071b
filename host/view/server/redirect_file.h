// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "view/server/private_folder.h"

namespace eikon {

/// A page in a file that leads a browser to an address with a secret. Only this user can read it,
/// while every user can read the words with which a browser is started. It is removed at the end.
class RedirectFile {
 public:
  /// address  without characters that HTML gives a meaning
  /// throws InputError if it cannot be written
  explicit RedirectFile(const std::string& address);

  [[nodiscard]] std::filesystem::path path() const { return folder_.path() / "view.html"; }

 private:
  PrivateFolder folder_;
};

}  // namespace eikon
