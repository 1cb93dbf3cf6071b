// SPDX-License-Identifier: Apache-2.0
// The flags of one command: a thin layer over CLI11, which takes eight seconds to compile wherever it is included. Here is
// the only place that includes it; a value reaches its command through a function that parses text or throws UsageError.
#pragma once
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "core/error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace eikon {

/// What a command does once its flags are read.
using Command = std::function<ExitCode()>;

/// Takes the text of a flag's value, which is not empty. throws UsageError naming the flag
using ParseText = std::function<void(const std::string&)>;

/// How --help shows a flag: "--spp N [64]    samples per pixel".
struct FlagText {
  std::string names;        // "-o,--output"; a positional argument has no dashes
  std::string placeholder;  // "N"; what follows the name in --help, with the default in brackets
  std::string about;        // one line
};

class CommandFlags {
 public:
  explicit CommandFlags(CLI::App& app) : app_(&app) {}

  /// A command below this one. "Example: ..." and whatever else follows the flags is its footer.
  CommandFlags command(const std::string& name, const std::string& about, const std::string& footer);
  /// Names one command, which must be given, of those below.
  void require_command();
  /// `chosen` becomes `command` when the user names this command.
  void run(Command& chosen, Command command);

  /// The heading of the flags that follow, in --help.
  void group(const std::string& title) { group_ = title; }

  // All that is referred to must live as long as the parser.
  void parsed(const FlagText& flag, ParseText parse);
  void text(const FlagText& flag, std::string& value);
  void toggle(const std::string& name, const std::string& about, bool& value);
  /// Decimal numbers, or whole ones (also 0x..), within a range.
  template <class Number>
  void number(const FlagText& flag, Number& value, double least, double most) {
    parsed(flag, [&value, name = last_name(flag.names), least, most](const std::string& text) {
      value = parse_number<Number>(name, text, least, most);
    });
  }
  /// One of some words.
  template <class Value>
  void choice(const FlagText& flag, Value& value, const std::map<std::string, Value>& values) {
    parsed(flag, [&value, values, name = last_name(flag.names)](const std::string& text) {
      value = choose(name, text, values);
    });
  }
  void choice(const FlagText& flag, std::string& value, const std::vector<std::string>& words);
  /// Any number of values; of a flag, also with commas between them.
  void list(const FlagText& flag, ParseText parse_each);
  /// --json, which means --json -, or --json=FILE.
  void json(std::string& file, const std::string& about);

  void require(const std::string& name);
  void exclude(const std::string& name, const std::string& other);
  /// Flags that are accepted, but not shown by --help, since they change nothing of what this command tells.
  void hide(std::initializer_list<const char*> names);

 private:
  CLI::App* app_;
  std::string group_ = "Options";

  [[nodiscard]] static std::string last_name(const std::string& names);
};

/// Reads the process's arguments; `add` adds commands to the root. Returns the exit code where that ends the process, after
/// --help or an error, and nothing where a command is to run.
[[nodiscard]] std::optional<int> parse_command_line(int argc, char** argv, const std::string& footer,
                                                    const std::function<void(CommandFlags)>& add);

/// Reads words as the flags that `add` adds. Returns each flag that was given, with its values, except those in `left_out`.
/// throws UsageError
[[nodiscard]] std::string parse_words(std::vector<std::string> words, const std::function<void(CommandFlags)>& add,
                                      const std::vector<std::string>& left_out);

}  // namespace eikon
