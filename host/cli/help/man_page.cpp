// SPDX-License-Identifier: Apache-2.0
#include "cli/help/man_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "io/text.h"

namespace eikon {
namespace {

/// Text whose characters stay what they are: `-` would become a hyphen, and quotes typographic
/// ones.
std::string roff(const std::string& text) {
  std::string result = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (const char c : text) {
    switch (c) {
      case '\\':
        result += "\\e";
        break;
      case '-':
        result += "\\-";
        break;
      case '\'':
        result += "\\(aq";
        break;
      case '`':
        result += "\\(ga";
        break;
      case '^':
        result += "\\(ha";
        break;
      case '~':
        result += "\\(ti";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string upper(std::string text) {
  for (char& c : text) c = char(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// The sections of a footer of --help: a heading is a line that ends with a colon, and its text is
/// indented.
struct Section {
  std::string title;               // empty: text without a heading
  std::vector<std::string> lines;  // as they stand in the footer
};

/// The title that manual pages have for a heading of --help.
std::string title_of(const std::string& heading) {
  if (heading.starts_with("Example")) return "EXAMPLES";
  return heading == "Environment variables" ? "ENVIRONMENT" : upper(heading);
}

std::vector<Section> sections_of(const std::string& footer) {
  constexpr std::string_view kExitCodes = "Exit codes: ";  // the heading whose text follows in the same line
  std::vector<Section> sections;
  for (const std::string& line : split(footer, '\n')) {
    const bool indented = line.starts_with(' ');
    if (line.starts_with(kExitCodes)) {
      sections.push_back({"EXIT STATUS", {line.substr(kExitCodes.size())}});
    } else if (!line.empty() && !indented && line.ends_with(':')) {
      const std::string title = line.substr(0, line.size() - 1);
      sections.push_back({title_of(title), {}});
    } else {
      if (sections.empty() || (!indented && !line.empty() && sections.back().title != "")) sections.push_back({});
      sections.back().lines.push_back(line);
    }
  }
  return sections;
}

/// Indented lines as they stand, those of two columns as a list, all else as paragraphs.
std::string text_of(const std::vector<std::string>& lines) {
  std::string text;
  bool verbatim = false;
  for (const std::string& line : lines) {
    const std::size_t begin = line.find_first_not_of(' ');
    if (begin == std::string::npos) continue;
    const std::size_t gap = line.find("  ", begin);
    const bool as_it_stands = begin > 0 && gap == std::string::npos;
    if (as_it_stands != verbatim) text += as_it_stands ? ".nf\n" : ".fi\n";
    verbatim = as_it_stands;
    if (begin > 0 && gap != std::string::npos)
      text += fmt::format(".TP\n.B {}\n{}\n", roff(line.substr(begin, gap - begin)),
                          roff(line.substr(line.find_first_not_of(' ', gap))));
    else
      text += roff(line.substr(begin)) + "\n";
  }
  return text + (verbatim ? ".fi\n" : "");
}

std::string synopsis(const CommandHelp& command) {
  std::string text = fmt::format(".SH SYNOPSIS\n.B {}\n", roff(command.name));
  if (!command.commands.empty()) return text + "\\fICOMMAND\\fR\n[\\fIOPTIONS\\fR]\n";
  text += "[\\fIOPTIONS\\fR]\n";
  for (const FlagHelp& flag : command.flags)
    if (flag.is_positional())
      text += fmt::format("{}\\fI{}\\fR{}{}\n", flag.required ? "" : "[", roff(flag.names[0]), roff(flag.placeholder),
                          flag.required ? "" : "]");
  return text;
}

std::string entry(const FlagHelp& flag) {
  if (flag.is_positional()) return fmt::format(".TP\n.I {}\n{}\n", roff(flag.names[0]), roff(flag.about));
  std::string names;
  for (const std::string& name : flag.names)
    names += fmt::format("{}\\fB{}\\fR", names.empty() ? "" : ", ", roff(name));
  if (!flag.placeholder.empty())
    names += (flag.placeholder.starts_with('[') ? "" : " ") + fmt::format("\\fI{}\\fR", roff(flag.placeholder));
  return fmt::format(".TP\n{}\n{}\n", names, roff(flag.about));
}

/// Flags under the headings that --help gives them, in its order.
std::string options(const CommandHelp& command) {
  std::string text = ".SH OPTIONS\n", group;
  const auto add_all = [&](bool positional) {
    for (const FlagHelp& flag : command.flags) {
      if (flag.is_positional() != positional) continue;
      const std::string heading = positional ? "Arguments" : flag.group;
      if (heading != group) text += ".SS " + roff(heading) + "\n";
      group = heading;
      text += entry(flag);
    }
  };
  add_all(true);
  add_all(false);
  return text;
}

std::string see_also(const CommandHelp& command, const CommandHelp* parent) {
  std::vector<std::string> pages;
  if (parent != nullptr) pages.push_back(man_name(*parent));
  for (const CommandHelp& below : command.commands) pages.push_back(man_name(below));
  std::ranges::sort(pages);
  std::string text = pages.empty() ? "" : ".SH SEE ALSO\n";
  for (const std::string& page : pages)
    text += fmt::format(".BR {} (1){}\n", roff(page), page == pages.back() ? "" : " ,");
  return text;
}

}  // namespace

std::string man_name(const CommandHelp& command) {
  std::string name = command.name;
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string man_page(const CommandHelp& command, const CommandHelp* parent) {
  const std::string name = man_name(command);
  std::string page =
      fmt::format(".\\\" `eikon man` wrote this from the text of --help.\n.TH {} 1 {} \"eikon {}\" \"{}\"\n",
                  upper(roff(name)), EIKON_DATE, EIKON_VERSION, "User commands");
  page += fmt::format(".SH NAME\n{} \\- {}\n", roff(name), roff(command.about)) + synopsis(command);
  const std::vector<Section> sections = sections_of(command.footer);
  for (const Section& section : sections)
    if (const std::string text = text_of(section.lines); section.title.empty() && !text.empty())
      page += ".SH DESCRIPTION\n" + text;
  page += options(command);
  if (!command.commands.empty()) page += ".SH COMMANDS\n";
  for (const CommandHelp& below : command.commands)
    page += fmt::format(".TP\n.BR {} (1)\n{}\n", roff(man_name(below)), roff(below.about));
  for (const Section& section : sections)
    if (!section.title.empty()) page += ".SH " + roff(section.title) + "\n" + text_of(section.lines);
  return page + see_also(command, parent);
}

}  // namespace eikon
