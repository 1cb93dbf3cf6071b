// SPDX-License-Identifier: Apache-2.0
#include "cli/help/completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "cli/commands.h"

namespace eikon {
namespace {

using WriteScript = std::string (*)(const CommandHelp&);

/// A command and those below it as words behind others, without flags.
CommandHelp as_words(const CommandHelp& command, const std::string& before) {
  CommandHelp words{
      .name = before + last_word(command), .about = command.about, .footer = {}, .flags = {}, .commands = {}};
  for (const CommandHelp& below : command.commands) words.commands.push_back(as_words(below, words.name + " "));
  return words;
}

/// All commands, and behind `eikon man` those that have a page: `eikon man bench rays`.
CommandHelp completed_commands() {
  CommandHelp root = describe_commands();
  const auto man = std::ranges::find(root.commands, "eikon man", &CommandHelp::name);
  std::erase_if(man->flags, [](const FlagHelp& flag) { return flag.is_positional(); });
  std::vector<CommandHelp> pages;
  for (const CommandHelp& command : root.commands) pages.push_back(as_words(command, man->name + " "));
  man->commands = std::move(pages);
  return root;
}

}  // namespace

void add_completion(CommandFlags& root, Command& chosen) {
  auto write = std::make_shared<WriteScript>();
  CommandFlags flags = root.command("completion", "print a script that completes eikon's command line in a shell",
                                    "Installed packages have these scripts where shells look for them.\n\n"
                                    "Example:\n  eikon completion bash > eikon.bash && source eikon.bash");
  flags.choice<WriteScript>({"SHELL", "", "the shell"}, *write,
                            {{"bash", bash_completion}, {"fish", fish_completion}, {"zsh", zsh_completion}});
  flags.run(chosen, [write] {
    fmt::print("{}", (*write)(completed_commands()));
    return ExitCode::done;
  });
}

}  // namespace eikon
