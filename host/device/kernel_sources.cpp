// SPDX-License-Identifier: Apache-2.0
#include "device/kernel_sources.h"

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "core/error.h"

namespace eikon {
namespace {

std::string source(const std::string& file) {
  if (const char* directory = std::getenv("EIKON_KERNEL_DIR")) {
    std::ifstream in(std::string(directory) + "/" + file);
    std::stringstream text;
    if (!(text << in.rdbuf())) throw InternalError("kernel source '" + file + "' is missing in EIKON_KERNEL_DIR");
    return text.str();
  }
  const auto found = embedded_kernels().find(file);
  if (found == embedded_kernels().end()) throw InternalError("kernel source '" + file + "' is not embedded");
  return found->second;
}

// Returns whether a text opens with `#ifndef X` and `#define X`. Such a header is expanded once per
// program: headers include each other so often that the text would grow to megabytes otherwise.
// X-macro files define macros with arguments; they are expanded every time.
bool is_guarded(const std::string& text) {
  const std::size_t begin = text.rfind("#ifndef ", 0) == 0 ? 0 : text.find("\n#ifndef ") + 1;
  const std::size_t first = text.find('#');
  if (first == std::string::npos || begin != first) return false;
  const std::size_t end = text.find('\n', first);
  if (end == std::string::npos) return false;
  const std::string define = "#define " + text.substr(first + 8, end - first - 8) + "\n";
  return text.compare(end + 1, define.size(), define) == 0;
}

void expand(const std::string& text, const std::string& name, int depth, std::set<std::string>& seen,
            std::string& out) {
  if (depth > 32) throw InternalError("kernel includes are nested too deep at '" + name + "'");
  const std::string directive = "#include \"";
  out += "#line 1 \"" + name + "\"\n";
  std::istringstream lines(text);
  std::string line;
  // Depth of #if around the line, without the guard's own.
  int conditions = is_guarded(text) ? -1 : 0;
  for (int number = 1; std::getline(lines, line); ++number) {
    conditions += line.rfind("#if", 0) == 0 ? 1 : line.rfind("#endif", 0) == 0 ? -1 : 0;
    if (line.compare(0, directive.size(), directive) == 0) {
      const std::string file = line.substr(directive.size(), line.find('"', directive.size()) - directive.size());
      const std::string included = source(file);
      // A header that is included under a condition may be absent for later includes.
      std::set<std::string> conditional = seen;
      std::set<std::string>& known = conditions > 0 ? conditional : seen;
      if (!is_guarded(included) || known.insert(file).second) expand(included, file, depth + 1, known, out);
      out += "#line " + std::to_string(number + 1) + " \"" + name + "\"\n";
    } else {
      out += line + "\n";
    }
  }
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

std::string bare_text(const std::string& text) {
  std::string out;
  std::istringstream lines(text);
  bool is_continued = false;  // the line before ends with a backslash
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#line ")) continue;
    bool is_quoted = false;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      if (line[i] == '"') is_quoted = !is_quoted;
      if (!is_quoted && line[i] == '/' && line[i + 1] == '/') line.resize(i);
    }
    line.erase(line.find_last_not_of(" \t") + 1);
    line.erase(0, line.find_first_not_of(" \t"));
    if (line.empty() && !is_continued) continue;
    is_continued = line.ends_with('\\');
    out += line + "\n";
  }
  return out;
}

}  // namespace eikon
