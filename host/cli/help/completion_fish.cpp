// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/help/completion.h"

namespace eikon {
namespace {

constexpr const char* kFunction = R"(# Completes eikon's command line in fish; `eikon completion fish` wrote this.
function __eikon_command -d 'Succeeds if the words before the cursor begin with these'
    set -l words (commandline -opc)
    set -l last (math 1 + (count $argv))
    test (count $words) -ge $last; and test "$words[2..$last]" = "$argv"
end
function __eikon_no_command -d 'Succeeds if these words stand before the cursor alone'
    set -l words (commandline -opc)
    test "$words[2..]" = "$argv"
end
complete -c eikon -f
)";

std::string in_fish_quotes(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return quoted + "'";
}

/// The words below `eikon`: "bench rays".
std::string path_of(const CommandHelp& command) {
  const std::size_t space = command.name.find(' ');
  return space == std::string::npos ? "" : command.name.substr(space + 1);
}

std::string line_of_flag(const std::string& condition, const FlagHelp& flag) {
  std::string line = "complete -c eikon" + condition;
  for (const std::string& name : flag.names) {
    if (name.starts_with("--"))
      line += " -l " + name.substr(2);
    else if (name.starts_with('-'))
      line += " -s " + name.substr(1);
  }
  const bool optional = flag.placeholder.starts_with('[');
  if (flag.takes_value && !flag.is_positional() && !optional) line += " -r";
  if (flag.takes_file())
    line += " -F";
  else if (flag.takes_value)
    line += " -f";
  const std::string words = fmt::format("{}", fmt::join(flag.words, " "));
  if (!words.empty()) line += " -a " + in_fish_quotes(flag.takes_list() ? "(__fish_append , " + words + ")" : words);
  return line + " -d " + in_fish_quotes(flag.about) + "\n";
}

}  // namespace

std::string fish_completion(const CommandHelp& root) {
  std::string text = kFunction;
  for (const CommandHelp* command : with_all_below(root)) {
    const std::string path = path_of(*command);
    const std::string alone = fmt::format(" -n '__eikon_no_command {}'", path);
    const std::string within = path.empty() ? alone : fmt::format(" -n '__eikon_command {}'", path);
    for (const CommandHelp& below : command->commands)
      text += fmt::format("complete -c eikon{} -a {} -d {}\n", alone, last_word(below), in_fish_quotes(below.about));
    for (const FlagHelp& flag : command->flags) text += line_of_flag(within, flag);
  }
  return text;
}

}  // namespace eikon
