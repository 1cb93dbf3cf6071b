// SPDX-License-Identifier: Apache-2.0
#include "page/page.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/json_dump.h"

namespace eikon {
namespace {

const std::string& page_file(const std::string& name) {
  const auto found = embedded_page_files().find(name);
  if (found == embedded_page_files().end()) throw InternalError("no page file " + name);
  return found->second;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += page_file(name);
  return text;
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string script_json(const Json& value) {
  // Names of files and devices need not be UTF-8.
  std::string out;
  for (const char c : dump_json(value)) {
    if (c == '<')
      out += "\\u003c";  // "</script>" and "<!--" begin with it; outside of strings JSON has none
    else
      out += c;
  }
  return out;
}

std::string make_page(const std::string& body, const PageParts& parts, bool connects) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data: blob:; "
      "style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'{}\">\n"
      "<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n{}"
      "<script type=\"application/json\" id=\"data\">{}</script>\n<script>\n{}</script>\n</body>\n</html>\n",
      connects ? "; connect-src 'self'" : "", html_text(parts.title), joined(parts.styles), page_file(body),
      script_json(parts.data), joined(parts.scripts));
}

}  // namespace eikon
