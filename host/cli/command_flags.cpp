// SPDX-License-Identifier: Apache-2.0
#include "cli/command_flags.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstring>

#include "io/text.h"
#include "job/log.h"

namespace eikon {
namespace {

constexpr std::size_t kHelpColumn = 34;

/// Refuses empty values: with nothing in OUT, `-o "$OUT"` must not write to a default that the user
/// does not know of.
CLI::Option* add(CLI::App& app, const FlagText& flag, ParseText parse) {
  const std::string name = flag.names.substr(flag.names.rfind(',') + 1);
  const bool positional = name[0] != '-';
  const auto parse_all = [=, parse = std::move(parse)](const CLI::results_t& values) {
    for (const std::string& value : values) {
      if (value.empty())
        throw CLI::ValidationError(name, positional ? "its value is empty; write one"
                                                    : "its value is empty; write one, or leave the flag out");
      parse(value);
    }
    return true;
  };
  CLI::Option* const option = app.add_option(flag.names, parse_all, flag.about);
  return option->type_size(1)->required(positional)->option_text(flag.placeholder);
}

/// Joins `--json -` to `--json=-`, since CLI11 takes a word behind a flag for a positional
/// argument.
std::vector<std::string> join_json_dash(int argc, char** argv) {
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    if (!words.empty() && words.back() == "--json" && std::string_view(argv[i]) == "-")
      words.back() = "--json=-";
    else
      words.emplace_back(argv[i]);
  }
  return words;
}

std::vector<GivenFlag> given_flags(const CLI::App& app) {
  std::vector<GivenFlag> given;
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0) given.push_back({option->get_name(), option->results()});
  return given;
}

constexpr const char* kAbout =
    "an OpenCL wavefront path tracer. Renders glTF 2.0 scenes to OpenEXR images that state their own error.";

/// The last command that a command line names, and all words that name it.
struct NamedCommand {
  const CLI::App* app;
  std::string name;
};
NamedCommand named_command(const CLI::App& root) {
  NamedCommand named{&root, root.get_name()};
  while (!named.app->get_subcommands().empty()) {
    named.app = named.app->get_subcommands().front();
    named.name += " " + named.app->get_name();
  }
  return named;
}

/// Says which command is missing or not there; nothing if the last one has none below it.
/// word  that is there instead, if any
std::optional<std::string> wrong_command(const CLI::App& app, const std::optional<std::string>& word) {
  std::vector<std::string> names;
  for (const CLI::App* below : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(below->get_name());
  if (names.empty()) return std::nullopt;
  const std::string wrong = word ? "there is no command " + in_quotes(*word) : "a command is missing";
  return fmt::format("{}; there is {}", wrong, fmt::join(names, ", "));
}

std::string unknown_flag(const CLI::App& app, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& long_name : option->get_lnames()) names.push_back("--" + long_name);
  const std::optional<std::string> likely = most_like(name, names);
  return fmt::format("there is no flag {}{}", in_quotes(name), likely ? ", but there is " + *likely : "");
}

/// Says what is wrong with the words of known flags.
std::string wrong_values(const CLI::App& app, const CLI::ParseError& error) {
  const std::string text = error.what();
  const auto until = [&](std::string_view end) { return text.substr(0, text.find(end)); };
  if (dynamic_cast<const CLI::ExcludesError*>(&error) != nullptr) {
    const std::string one = until(" excludes ");
    return fmt::format("{} and {} do not go together", one, text.substr(one.size() + std::strlen(" excludes ")));
  }
  for (const CLI::Option* option : app.get_options())  // none that takes no value, which counts as one
    if (const int most = option->get_items_expected_max(); most > 0 && option->count() > static_cast<std::size_t>(most))
      return fmt::format("{} is given {} times, but takes one value", option->get_name(), option->count());
  if (text.ends_with(" missing")) return fmt::format("{} needs a value", until(":"));
  if (text.ends_with(" flag override")) return fmt::format("--{} takes no value", until(" "));
  return text;
}

/// Says what is wrong with a command line, since much of what CLI11 says is no sentence.
std::string what_is_wrong(const CLI::App& root, const CLI::App& named, const CLI::ParseError& error) {
  const std::vector<std::string> rest = root.remaining(true);  // words that were not understood
  const auto is_flag = [](const std::string& word) { return word.starts_with('-'); };
  const auto flag = std::ranges::find_if(rest, is_flag), word = std::ranges::find_if_not(rest, is_flag);
  const std::optional<std::string> other = word == rest.end() ? std::nullopt : std::optional(*word);
  const std::optional<std::string> wrong = wrong_command(named, other);
  if (flag != rest.end() && !(wrong && other)) return unknown_flag(named, *flag);
  if (wrong) return *wrong;
  return other ? fmt::format("{} is one word too many", in_quotes(*other)) : wrong_values(named, error);
}

void set_up_root(CLI::App& app, const std::string& footer, const std::function<void(CommandFlags)>& add_flags) {
  app.name("eikon");
  app.description(fmt::format("eikon: {}", kAbout));
  app.get_formatter()->column_width(kHelpColumn);
  app.set_version_flag("--version", "eikon " EIKON_VERSION);
  app.footer(footer);
  CommandFlags root(app);
  root.require_command();
  add_flags(root);
}

FlagHelp describe(const CLI::Option& option) {
  FlagHelp help;
  for (const std::string& name : option.get_snames()) help.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) help.names.push_back("--" + name);
  if (help.names.empty()) help.names.push_back(option.get_name());
  help.placeholder = option.get_option_text();
  help.about = option.get_description();
  help.group = option.get_group().empty() ? "Options" : option.get_group();
  help.takes_value = !help.placeholder.empty() || help.is_positional();
  help.required = option.get_required();
  if (const std::string words = option.get_type_name(); help.takes_value && !words.empty())
    help.words = split(words, '|');
  return help;
}

CommandHelp describe(const CLI::App& app, const std::string& parents, const std::string& about) {
  CommandHelp help{
      .name = parents + app.get_name(), .about = about, .footer = app.get_footer(), .flags = {}, .commands = {}};
  for (const CLI::Option* option : app.get_options())
    if (!option->get_group().empty() || option == app.get_help_ptr()) help.flags.push_back(describe(*option));
  for (const CLI::App* below : app.get_subcommands([](const CLI::App*) { return true; }))
    help.commands.push_back(describe(*below, help.name + " ", below->get_description()));
  return help;
}

/// CLI11 takes the next word for a flag's value, also where that word is a flag, and a file would
/// get its name. throws UsageError unless such a value is written as --flag=--other
void refuse_flags_as_values(const CLI::App& named, const std::vector<std::string>& words) {
  const auto flag_of = [&](const std::string& word) {
    return word.starts_with('-') ? named.get_option_no_throw(word.substr(0, word.find('='))) : nullptr;
  };
  for (std::size_t i = 0; i + 1 < words.size() && words[i] != "--"; ++i) {
    const CLI::Option* const flag = words[i].find('=') == std::string::npos ? flag_of(words[i]) : nullptr;
    if (flag != nullptr && flag->get_items_expected_min() > 0 && flag_of(words[i + 1]) != nullptr)
      throw UsageError(fmt::format("{} needs a value, but {} follows; write {}={} if you mean that", words[i],
                                   words[i + 1], flag->get_name(), words[i + 1]));
  }
}

/// CLI11 takes the next word for the value of "--flag=". throws UsageError
void require_values(const std::vector<std::string>& words) {
  for (const std::string& word : words)
    if (word.starts_with("--") && word.find('=') == word.size() - 1)
      throw UsageError(fmt::format("{} has no value; write it behind the sign, or leave the flag out", word));
}

/// throws CLI::ParseError, UsageError
void read_words(CLI::App& app, const std::vector<std::string>& words) {
  require_values(words);
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // the last first, as CLI11 takes them
  } catch (const CLI::ParseError&) {
    refuse_flags_as_values(*named_command(app).app, words);
    throw;
  }
  refuse_flags_as_values(*named_command(app).app, words);
}

}  // namespace

std::string CommandFlags::last_name(const std::string& names) { return names.substr(names.rfind(',') + 1); }

CommandFlags CommandFlags::command(const std::string& name, const std::string& about, const std::string& footer) {
  CLI::App* const below = app_->add_subcommand(name, about);
  below->set_help_flag("-h,--help", "print this help and exit")
      ->group("");  // hidden, so that the commands below cannot inherit it
  below->footer(footer);
  return CommandFlags(*below);
}

void CommandFlags::require_command() { app_->require_subcommand(1); }

void CommandFlags::run(Command& chosen, Command command) {
  app_->callback([&chosen, command = std::move(command)] { chosen = command; });
}

void CommandFlags::run(Command& chosen, std::function<ExitCode(const std::vector<std::string>&)> command) {
  app_->callback([&chosen, app = app_, command = std::move(command)] {
    std::vector<std::string> words;
    for (const GivenFlag& flag : given_flags(*app)) flag.add_to(words);
    chosen = [command, words = std::move(words)] { return command(words); };
  });
}

void CommandFlags::parsed(const FlagText& flag, ParseText parse) {
  add(*app_, flag, std::move(parse))->expected(1)->group(group_);
}

void CommandFlags::list(const FlagText& flag, ParseText parse_each) {
  const bool positional = flag.names[0] != '-';
  CLI::Option* const option = add(*app_, flag, std::move(parse_each))->expected(1, -1)->group(group_);
  option->delimiter(flag.placeholder.find(',') == std::string::npos ? '\0' : ',')->allow_extra_args(positional);
}

void CommandFlags::json(std::string& file, const std::string& about) {
  app_->add_flag("--json{-}", file, about)->group(group_)->option_text("[=FILE]");
}

void CommandFlags::text(const FlagText& flag, std::string& value) {
  parsed(flag, [&value](const std::string& text) { value = text; });
}

void CommandFlags::picture(const FlagText& flag, std::string& value, const std::string& extension) {
  parsed(flag, [&value, extension, name = last_name(flag.names)](const std::string& text) {
    value = parse_picture(name, text, extension);
  });
}

void CommandFlags::toggle(const std::string& name, const std::string& about, bool& value) {
  app_->add_flag(name, value, about)->group(group_)->disable_flag_override();
}

void CommandFlags::choice(const FlagText& flag, std::string& value, const std::vector<std::string>& words) {
  std::map<std::string, std::string> values;
  for (const std::string& word : words) values[word] = word;
  choice<std::string>(flag, value, values);
}

// CLI11 calls it the name of the values' type, says it in messages about values that are missing,
// and leaves it out of --help, where FlagText has a placeholder for it.
void CommandFlags::suggest(const std::string& name, const std::vector<std::string>& words) {
  app_->get_option(name)->type_name(fmt::format("{}", fmt::join(words, "|")));
}

void CommandFlags::make_optional(const std::string& name) { app_->get_option(name)->required(false); }

void CommandFlags::require(const std::string& name) { app_->get_option(name)->required(); }

void CommandFlags::exclude(const std::string& name, const std::string& other) {
  app_->get_option(name)->excludes(app_->get_option(other));
}

void CommandFlags::hide(std::initializer_list<const char*> names) {
  for (const char* name : names) app_->get_option(name)->group("");
}

std::optional<int> parse_command_line(int argc, char** argv, const std::string& footer,
                                      const std::function<void(CommandFlags)>& add_flags) {
  CLI::App app;
  set_up_root(app, footer, add_flags);
  const std::vector<std::string> words = join_json_dash(argc, argv);
  try {
    read_words(app, words);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    const NamedCommand named = named_command(app);
    throw UsageError(fmt::format("{}; try `{} --help`", what_is_wrong(app, *named.app, error), named.name));
  }
  return std::nullopt;
}

CommandHelp describe_command_line(const std::string& footer, const std::function<void(CommandFlags)>& add_flags) {
  CLI::App app;
  set_up_root(app, footer, add_flags);
  return describe(app, "", kAbout);
}

std::vector<GivenFlag> parse_words(const std::vector<std::string>& words,
                                   const std::function<void(CommandFlags)>& add_flags) {
  CLI::App app;
  app.set_help_flag();  // a line of a batch cannot ask for help
  add_flags(CommandFlags(app));
  try {
    read_words(app, words);
  } catch (const CLI::ParseError& error) {
    throw UsageError(what_is_wrong(app, *named_command(app).app, error));
  }
  return given_flags(app);
}

void GivenFlag::add_to(std::vector<std::string>& words) const {
  for (const std::string& value : values)
    words.push_back(name.starts_with('-') ? fmt::format("{}={}", name, value) : value);
}

}  // namespace eikon
