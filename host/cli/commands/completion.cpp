// SPDX-License-Identifier: Apache-2.0
#include "cli/help/completion.h"

#include <fmt/format.h>

#include <memory>

#include "cli/commands.h"

namespace eikon {
namespace {

using WriteScript = std::string (*)(const CommandHelp&);

}  // namespace

void add_completion(CommandFlags& root, Command& chosen) {
  auto write = std::make_shared<WriteScript>();
  CommandFlags flags = root.command("completion", "print a script that completes eikon's command line in a shell",
                                    "Installed packages have these scripts where shells look for them.\n\n"
                                    "Example:\n  eikon completion bash > eikon.bash && source eikon.bash");
  flags.choice<WriteScript>({"SHELL", "", "the shell"}, *write,
                            {{"bash", bash_completion}, {"fish", fish_completion}, {"zsh", zsh_completion}});
  flags.run(chosen, [write] {
    fmt::print("{}", (*write)(describe_commands()));
    return ExitCode::done;
  });
}

}  // namespace eikon
