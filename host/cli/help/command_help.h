// SPDX-License-Identifier: Apache-2.0
// The text of --help as plain data, of which manual pages and shell completion are made.
#pragma once
#include <string>
#include <vector>

namespace eikon {

struct FlagHelp {
  std::vector<std::string> names;  // "-o", "--output"; the one name of a positional argument has no dashes
  std::string placeholder;         // "N"; "[=FILE]" where the value may be left out
  std::string about;               // one line; ends with the default in brackets
  std::string group;               // its heading
  std::vector<std::string> words;  // what its value may be, where that is known
  bool takes_value = false, required = false;

  [[nodiscard]] bool is_positional() const { return !names.front().starts_with('-'); }
  /// A positional argument is a file unless its words are known.
  [[nodiscard]] bool takes_file() const {
    return is_positional() ? words.empty() : takes_value && placeholder.find("FILE") != std::string::npos;
  }
  /// Takes values separated by commas.
  [[nodiscard]] bool takes_list() const { return placeholder == "LIST"; }
};

struct CommandHelp {
  std::string name;  // "eikon bench rays"
  std::string about;
  std::string footer;
  std::vector<FlagHelp> flags;  // those that --help shows, and --help itself, in that order
  std::vector<CommandHelp> commands;
};

/// The command and all below it, parents before children.
[[nodiscard]] std::vector<const CommandHelp*> with_all_below(const CommandHelp& command);

/// "render" of "eikon render".
[[nodiscard]] std::string last_word(const CommandHelp& command);

}  // namespace eikon
