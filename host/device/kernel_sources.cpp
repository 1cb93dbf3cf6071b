// SPDX-License-Identifier: Apache-2.0
#include "device/kernel_sources.h"

#include <cstdlib>
#include <fstream>
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

// Expands as a preprocessor does, every time it is met: include guards and X-macro files keep their meaning.
void expand(const std::string& text, const std::string& name, int depth, std::string& out) {
  if (depth > 32) throw InternalError("kernel includes are nested too deep at '" + name + "'");
  const std::string directive = "#include \"";
  out += "#line 1 \"" + name + "\"\n";
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.compare(0, directive.size(), directive) == 0) {
      const std::string file = line.substr(directive.size(), line.find('"', directive.size()) - directive.size());
      expand(source(file), file, depth + 1, out);
      out += "#line " + std::to_string(number + 1) + " \"" + name + "\"\n";
    } else {
      out += line + "\n";
    }
  }
}

}  // namespace

std::string expand_includes(const std::string& text, const std::string& name) {
  std::string out;
  expand(text, name, 0, out);
  return out;
}

std::string kernel_text(const std::string& entry) { return expand_includes(source(entry), entry); }

}  // namespace eikon
