// SPDX-License-Identifier: Apache-2.0
#include "view/server/private_folder.h"

#include <system_error>

#include "io/private_folder.h"

namespace eikon {

PrivateFolder::PrivateFolder() : path_(make_private_folder("eikon_view")) {}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace eikon
