// SPDX-License-Identifier: Apache-2.0
#include "device/kernel_sources.h"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <sstream>

#include "core/error.h"
#include "io/text.h"

namespace eikon {
namespace {

std::string source(const std::string& file) {
  if (const char* directory = std::getenv("EIKON_KERNEL_DIR")) {
    std::ifstream in(std::string(directory) + "/" + file);
    std::stringstream text;
    if (!(text << in.rdbuf()))
      throw UsageError(
          fmt::format("EIKON_KERNEL_DIR={}: there is no kernel source {} in it; name the folder kernels of "
                      "eikon's sources, or unset the variable",
                      directory, file));
    return text.str();
  }
  const auto found = embedded_kernels().find(file);
  if (found == embedded_kernels().end()) throw InternalError("kernel source '" + file + "' is not embedded");
  return found->second;
}

// Returns whether a text opens with `#ifndef X` and `#define X`. Such a header is expanded once per
// program: headers include each other so often that the text would grow to megabytes otherwise.
// X-macro files define macros with arguments; they are expanded every time.
bool is_guarded(std::string_view text) {
  const std::size_t begin = text.starts_with("#ifndef ") ? 0 : text.find("\n#ifndef ") + 1;
  const std::size_t first = text.find('#');
  if (first == std::string_view::npos || begin != first) return false;
  const std::size_t end = text.find('\n', first);
  if (end == std::string_view::npos) return false;
  const std::string define = fmt::format("#define {}\n", text.substr(first + 8, end - first - 8));
  return text.substr(end + 1).starts_with(define);
}

void expand(std::string_view text, const std::string& name, int depth, std::set<std::string>& seen, std::string& out) {
  if (depth > 32) throw InternalError("kernel includes are nested too deep at '" + name + "'");
  constexpr std::string_view directive = "#include \"";
  out += "#line 1 \"" + name + "\"\n";
  // Depth of #if around the line, without the guard's own.
  int conditions = is_guarded(text) ? -1 : 0;
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = take_line(text);
    conditions += line.starts_with("#if") ? 1 : line.starts_with("#endif") ? -1 : 0;
    if (line.starts_with(directive)) {
      const std::string file(line.substr(directive.size(), line.find('"', directive.size()) - directive.size()));
      if (!seen.contains(file)) {
        const std::string included = source(file);
        // A header that is included under a condition may be absent for later includes.
        std::set<std::string> conditional;
        if (conditions > 0) conditional = seen;
        std::set<std::string>& known = conditions > 0 ? conditional : seen;
        if (is_guarded(included)) known.insert(file);
        expand(included, file, depth + 1, known, out);
      }
      out += "#line " + std::to_string(number + 1) + " \"" + name + "\"\n";
    } else {
      (out += line) += '\n';
    }
  }
}

/// The position of a line's comment, or npos. Slashes within a string are none.
std::size_t begin_of_comment(std::string_view line) {
  std::size_t at = line.find("//");
  while (at != std::string_view::npos && std::count(line.begin(), line.begin() + std::ptrdiff_t(at), '"') % 2 != 0)
    at = line.find("//", at + 1);
  return at;
}

}  // namespace

std::string expand_includes(const std::string& text, const std::string& name) {
  std::string out;
  std::set<std::string> seen;
  expand(text, name, 0, seen, out);
  return out;
}

std::string kernel_text(const std::vector<std::string>& entries) {
  std::string out;
  std::set<std::string> seen;
  for (const std::string& entry : entries) expand(source(entry), entry, 0, seen, out);
  return out;
}

std::string bare_text(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  bool is_continued = false;  // the line before ends with a backslash
  while (!text.empty()) {
    std::string_view line = take_line(text);
    if (line.starts_with("#line ")) continue;
    line = line.substr(0, begin_of_comment(line));
    line = line.substr(0, line.find_last_not_of(" \t") + 1);
    line.remove_prefix(std::min(line.size(), line.find_first_not_of(" \t")));
    if (line.empty() && !is_continued) continue;
    is_continued = line.ends_with('\\');
    (out += line) += '\n';
  }
  return out;
}

}  // namespace eikon
