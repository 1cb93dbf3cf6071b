// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/help/completion.h"

namespace eikon {
namespace {

/// The last line of what is known of a command stands for words that follow no flag.
constexpr const char* kBegin = R"(# Completes eikon's command line in bash; `eikon completion bash` wrote this.
_eikon() {
  local word=${COMP_WORDS[COMP_CWORD]} flag='' command=eikon i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$command ${COMP_WORDS[i]}" in
)";
constexpr const char* kMiddle = R"() command+=" ${COMP_WORDS[i]}" ;;
      *) break ;;
    esac
  done
  # A value follows its flag, or `=`, which is a word of its own for bash.
  if [[ $word == '=' ]]; then
    flag=${COMP_WORDS[COMP_CWORD - 1]} word=''
  elif [[ ${COMP_WORDS[COMP_CWORD - 1]} == '=' && COMP_CWORD -gt 1 ]]; then
    flag=${COMP_WORDS[COMP_CWORD - 2]}
  else
    flag=${COMP_WORDS[COMP_CWORD - 1]}
  fi
  local words='' files=no list=no before=''
  case "$command $flag" in
)";
constexpr const char* kEnd = R"(  esac
  if [[ $list == yes && $word == *,* ]]; then
    before=${word%,*},
    word=${word##*,}
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  COMPREPLY=("${COMPREPLY[@]/#/$before}")
  if [[ $files == yes ]]; then
    compopt -o filenames 2>/dev/null
    local -a found
    mapfile -t found < <(compgen -f -- "$word")
    COMPREPLY+=("${found[@]}")
  fi
}
complete -F _eikon eikon
)";

void add_patterns(std::string& text, const CommandHelp& command, const FlagHelp& flag) {
  for (const std::string& name : flag.names)
    text += fmt::format("{}'{} {}'", text.empty() ? "" : "|", command.name, name);
}

/// The case of a flag whose value follows.
std::string case_of_flag(const CommandHelp& command, const FlagHelp& flag) {
  std::string patterns;
  add_patterns(patterns, command, flag);
  std::string todo;
  if (!flag.words.empty()) todo += fmt::format(" words='{}'", fmt::join(flag.words, " "));
  if (flag.takes_file()) todo += " files=yes";
  if (flag.takes_list()) todo += " list=yes";
  return fmt::format("    {}){} ;;\n", patterns, todo.empty() ? " :" : todo);
}

/// The case of all other words of a command: flags, commands, and the values of positional
/// arguments.
std::string case_of_command(const CommandHelp& command) {
  std::vector<std::string> words;
  bool files = false;
  for (const CommandHelp& below : command.commands) words.push_back(last_word(below));
  for (const FlagHelp& flag : command.flags) {
    const std::vector<std::string>& more = flag.is_positional() ? flag.words : flag.names;
    words.insert(words.end(), more.begin(), more.end());
    files = files || (flag.is_positional() && flag.takes_file());
  }
  return fmt::format("    '{} '*) words='{}'{} ;;\n", command.name, fmt::join(words, " "), files ? " files=yes" : "");
}

}  // namespace

std::string bash_completion(const CommandHelp& root) {
  std::string commands, cases;
  std::vector<const CommandHelp*> all = with_all_below(root);
  for (const CommandHelp* command : all)
    if (command != &root) commands += fmt::format("{}'{}'", commands.empty() ? "      " : "|", command->name);
  for (auto command = all.rbegin(); command != all.rend(); ++command) {  // 'eikon bench rays ' before 'eikon bench '
    for (const FlagHelp& flag : (*command)->flags)
      if (flag.takes_value && !flag.is_positional()) cases += case_of_flag(**command, flag);
    cases += case_of_command(**command);
  }
  return kBegin + commands + kMiddle + cases + kEnd;
}

}  // namespace eikon
