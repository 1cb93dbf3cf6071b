// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace eikon {

/// Makes an empty folder NAME_XXXXXX that only the user may enter. It stands in the folder of
/// temporary files (TMPDIR), where other users may put links, so that a file there with a name that
/// they can guess is not safe. throws InputError
[[nodiscard]] std::filesystem::path make_private_folder(const std::string& name);

}  // namespace eikon
