// SPDX-License-Identifier: Apache-2.0
// The flags of one command: a thin layer over CLI11, which costs seconds of compile time in every
// source that includes it. Only command_flags.cpp does.
#pragma once
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/help/command_help.h"
#include "core/error.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace eikon {

/// Runs a command once its flags are read.
using Command = std::function<ExitCode()>;

/// Takes the text of a flag's value, which is not empty. throws UsageError naming the flag
using ParseText = std::function<void(const std::string&)>;

/// The text of a flag in --help: "--spp N    samples per pixel [64]".
struct FlagText {
  std::string names;        // "-o,--output"; a positional argument has no dashes
  std::string placeholder;  // "N", follows the name
  std::string about;        // one line; ends with the default in brackets
};

class CommandFlags {
 public:
  explicit CommandFlags(CLI::App& app) : app_(&app) {}

  /// Adds a command below this one. The footer follows the flags in --help.
  CommandFlags command(const std::string& name, const std::string& about, const std::string& footer);
  /// Makes it an error to name none of the commands below this one.
  void require_command();
  /// Sets `chosen` to `command` when the user names this command.
  void run(Command& chosen, Command command);
  /// The same with the words that say what the user gave, `--name=value` where they are flags.
  void run(Command& chosen, std::function<ExitCode(const std::vector<std::string>& words)> command);

  /// Sets the heading, in --help, of the flags that are added from now on.
  void group(const std::string& title) { group_ = title; }

  // These add a flag. The values that they refer to must live as long as the parser.
  void parsed(const FlagText& flag, ParseText parse);
  void text(const FlagText& flag, std::string& value);
  /// Takes the name of a picture to write (parse_picture).
  void picture(const FlagText& flag, std::string& value, const std::string& extension);
  void toggle(const std::string& name, const std::string& about, bool& value);
  /// Takes a number within a range: a whole one, also as 0x.., if Number is an integer.
  template <class Number>
  void number(const FlagText& flag, Number& value, double least, double most) {
    parsed(flag, [&value, name = last_name(flag.names), least, most](const std::string& text) {
      value = parse_number<Number>(name, text, least, most);
    });
  }
  /// Takes one of some words.
  template <class Value>
  void choice(const FlagText& flag, Value& value, const std::map<std::string, Value>& values) {
    const std::string name = last_name(flag.names);
    parsed(flag, [&value, values, name](const std::string& text) { value = choose(name, text, values); });
    std::vector<std::string> words;
    for (const auto& [word, meaning] : values) words.push_back(word);
    suggest(name, words);
  }
  void choice(const FlagText& flag, std::string& value, const std::vector<std::string>& words);
  /// Takes any number of values, which may also be separated by commas where the placeholder has
  /// one.
  void list(const FlagText& flag, ParseText parse_each);
  /// Adds --json=FILE, where --json alone means standard output.
  void json(std::string& file, const std::string& about);

  /// Names values that a flag takes, for shell completion. choice() does so itself.
  void suggest(const std::string& name, const std::vector<std::string>& words);
  void require(const std::string& name);
  /// Makes a positional argument one that may be left out.
  void make_optional(const std::string& name);
  void exclude(const std::string& name, const std::string& other);
  /// Leaves flags out of --help that are accepted but do not change this command's results.
  void hide(std::initializer_list<const char*> names);

 private:
  CLI::App* app_;
  std::string group_ = "Options";

  [[nodiscard]] static std::string last_name(const std::string& names);
};

/// Reads the process's arguments; `add` adds commands to the root.
/// returns  the exit code after --help or --version; nothing if a command is to run
/// throws UsageError
[[nodiscard]] std::optional<int> parse_command_line(int argc, char** argv, const std::string& footer,
                                                    const std::function<void(CommandFlags)>& add);

/// The text of --help of the commands that `add` adds to the root, and of the root.
[[nodiscard]] CommandHelp describe_command_line(const std::string& footer,
                                                const std::function<void(CommandFlags)>& add);

/// A flag as it was given, by its long name, and its values.
struct GivenFlag {
  std::string name;
  std::vector<std::string> values;  // none where there is nothing to say but the flag

  /// Adds `--name=value` for each value, or the values alone where the name is of no flag.
  void add_to(std::vector<std::string>& words) const;
};

/// Reads words as the flags that `add` adds. Returns the flags that were given, in the order in
/// which `add` adds them. throws UsageError
[[nodiscard]] std::vector<GivenFlag> parse_words(const std::vector<std::string>& words,
                                                 const std::function<void(CommandFlags)>& add);

}  // namespace eikon
