// SPDX-License-Identifier: Apache-2.0
// Files that people have hold leftovers that are wrong and that nothing shows. What the scene does
// not use is no reason to refuse it.
#pragma once
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "io/json_text.h"
#include "scene/notes.h"

namespace eikon {

/// The parts of a document that failed their check, with what is wrong. Whoever uses a part asks
/// here first.
class WrongParts {
 public:
  /// `part` is an element of one of the document's arrays.
  void add(const JsonView& part, const std::string& what);
  [[nodiscard]] bool has(std::string_view kind, std::size_t index) const;
  /// throws InputError with what is wrong, if part `index` of its kind ("mesh", ...) is
  void check(std::string_view kind, std::size_t index) const;
  /// Warns of each kind once; called when the scene has been read, and so has used none of them.
  void note(Notes& notes) const;

 private:
  std::map<std::pair<std::string, std::size_t>, std::string> parts_;
};

}  // namespace eikon
