// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "cli/help/completion.h"

namespace eikon {
namespace {

/// `text` with a backslash before the characters that end a part of a specification, for use
/// between single quotes.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'') result += "'\\'";  // ends the quotes, adds one, and '...' goes on
    if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
    result += c;
  }
  return result;
}

/// "_eikon_bench_rays"
std::string function_of(const CommandHelp& command) {
  std::string name = "_" + command.name;
  std::ranges::replace(name, ' ', '_');
  return name + (command.name == "eikon" ? "_commands" : "");
}

/// ":NAME:(one two)", and what completes the value.
std::string value_of(const FlagHelp& flag) {
  const bool optional = flag.placeholder.starts_with('[');
  const std::string title = optional ? "FILE" : escaped(flag.is_positional() ? flag.names[0] : flag.placeholder);
  const std::string words = fmt::format("{}", fmt::join(flag.words, " "));
  const std::string action = flag.takes_file()   ? (words.empty() ? "_files" : "{_files; compadd - " + words + "}")
                             : words.empty()     ? " "
                             : flag.takes_list() ? "_sequence compadd - " + words
                                                 : "(" + words + ")";
  return fmt::format("{}:{}:{}", optional ? ":" : "", title, action);
}

std::string specification(const FlagHelp& flag) {
  if (flag.is_positional())
    return fmt::format("'{}{}'", flag.placeholder == "..." ? "*" : flag.required ? "" : ":", value_of(flag));
  std::string text;
  for (const std::string& name : flag.names) {
    const bool optional = flag.placeholder.starts_with('[');
    const char* const joined = !flag.takes_value ? "" : optional ? "=-" : name.starts_with("--") ? "=" : "+";
    text += fmt::format("{}'({}){}{}[{}]{}'", text.empty() ? "" : " ", fmt::join(flag.names, " "), name, joined,
                        escaped(flag.about), flag.takes_value ? value_of(flag) : "");
  }
  return text;
}

/// A function that completes the words behind a command.
std::string function_text(const CommandHelp& command) {
  std::string text = function_of(command) + "() {\n";
  if (!command.commands.empty()) {
    text += "  if (( CURRENT > 2 )); then\n    case $words[2] in\n";
    for (const CommandHelp& below : command.commands)
      text +=
          fmt::format("      {}) shift words; (( CURRENT-- )); {}; return ;;\n", last_word(below), function_of(below));
    text += "    esac\n  fi\n  local -a commands=(\n";
    for (const CommandHelp& below : command.commands)
      text += fmt::format("    '{}:{}'\n", last_word(below), escaped(below.about));
    text += "  )\n  (( CURRENT == 2 )) && _describe -t commands command commands\n";
  }
  text += "  _arguments -s -S :";
  for (const FlagHelp& flag : command.flags) text += " \\\n    " + specification(flag);
  return text + "\n}\n";
}

}  // namespace

std::string zsh_completion(const CommandHelp& root) {
  std::string text = "#compdef eikon\n# Completes eikon's command line in zsh; `eikon completion zsh` wrote this.\n";
  for (const CommandHelp* command : with_all_below(root)) text += function_text(*command);
  return text + function_of(root) + " \"$@\"\n";
}

}  // namespace eikon
