// SPDX-License-Identifier: Apache-2.0
#include "io/private_folder.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "core/error.h"

namespace eikon {

std::filesystem::path make_private_folder(const std::string& name) {
  std::error_code error;
  std::string pattern = (std::filesystem::temp_directory_path(error) / (name + "_XXXXXX")).string();
  if (!error && mkdtemp(pattern.data()) != nullptr) return pattern;
  if (!error) error.assign(errno, std::generic_category());
  throw InputError(fmt::format("no folder for temporary files can be made: {}; TMPDIR names one", error.message()));
}

}  // namespace eikon
