// SPDX-License-Identifier: Apache-2.0
// Web pages that need nothing but themselves: style, scripts and data stand in the page.
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/json_text.h"

namespace eikon {

/// Name -> text of the files below host/page/web, embedded at build time (generated).
const std::map<std::string, std::string>& embedded_page_files();

/// `text` such that HTML shows it as it is, also in an attribute.
[[nodiscard]] std::string html_text(std::string_view text);

/// A value as JSON for a script element: no text in it ends the element, begins a comment, or is
/// not UTF-8.
[[nodiscard]] std::string script_json(const Json& value);

/// The parts of a page.
struct PageParts {
  std::string title;                 // plain text
  std::vector<std::string> styles;   // names of page files, in their order
  std::vector<std::string> scripts;  // likewise
  const Json& data;                  // for the scripts, as the text of the element with the id `data`
};

/// The page file `body` in a page with these parts. Its policy forbids whatever comes from
/// elsewhere.
/// connects  its scripts may ask the server that it came from
/// throws InternalError for a name of no page file
[[nodiscard]] std::string make_page(const std::string& body, const PageParts& parts, bool connects = false);

}  // namespace eikon
