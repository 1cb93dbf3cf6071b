// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/help/man_page.h"
#include "io/text.h"
#include "io/atomic_file.h"

namespace eikon {
namespace {

struct ManOptions {
  std::vector<std::string> command;
  std::string folder;
};

const CommandHelp& find_below(const CommandHelp& above, const std::string& word) {
  std::vector<std::string> words;
  for (const CommandHelp& below : above.commands) {
    if (last_word(below) == word) return below;
    words.push_back(last_word(below));
  }
  if (words.empty()) throw UsageError(fmt::format("man: {} has no command {} below it", above.name, in_quotes(word)));
  refuse_choice("man", word, words);
}

void write_pages(const CommandHelp& command, const CommandHelp* parent, const std::filesystem::path& folder) {
  write_text(folder / (man_name(command) + ".1"), man_page(command, parent));
  for (const CommandHelp& below : command.commands) write_pages(below, &command, folder);
}

ExitCode man_command(const ManOptions& options) {
  const CommandHelp root = describe_commands();
  if (!options.folder.empty()) {
    write_pages(root, nullptr, options.folder);
    return ExitCode::done;
  }
  const CommandHelp *command = &root, *parent = nullptr;
  for (const std::string& word : options.command) {
    parent = command;
    command = &find_below(*command, word);
  }
  fmt::print("{}", man_page(*command, parent));
  return ExitCode::done;
}

}  // namespace

void add_man(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<ManOptions>();
  CommandFlags flags =
      root.command("man", "print the manual page of a command, or write those of all",
                   "Installed packages have these pages where `man` looks for them.\n\n"
                   "Examples:\n  eikon man bench rays | man -l -\n  eikon man --folder share/man/man1");
  flags.list({"COMMAND", "...", "the command, such as bench rays [eikon itself]"},
             [options](const std::string& word) { options->command.push_back(word); });
  flags.make_optional("COMMAND");
  flags.text({"--folder", "FOLDER", "write a page for each command into this folder, which exists"}, options->folder);
  flags.exclude("--folder", "COMMAND");
  flags.run(chosen, [options] { return man_command(*options); });
}

}  // namespace eikon
