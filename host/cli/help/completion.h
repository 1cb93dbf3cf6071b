// SPDX-License-Identifier: Apache-2.0
// Scripts that complete eikon's command line in a shell.
#pragma once
#include <string>

#include "cli/help/command_help.h"

namespace eikon {

/// For bash 4.1 and later; needs nothing of the package bash-completion.
[[nodiscard]] std::string bash_completion(const CommandHelp& root);
/// For a file `_eikon` in a folder of zsh's fpath.
[[nodiscard]] std::string zsh_completion(const CommandHelp& root);
/// For a file `eikon.fish` in a folder of fish's fish_complete_path.
[[nodiscard]] std::string fish_completion(const CommandHelp& root);

}  // namespace eikon
