// SPDX-License-Identifier: Apache-2.0
#include "gltf/document/wrong_parts.h"

#include <fmt/format.h>

#include "core/error.h"

namespace eikon {

constexpr std::size_t kMaxWrongParts = 1000;  // a file of which more is wrong is damaged

void WrongParts::add(const JsonView& part, const std::string& what) {
  if (parts_.size() == kMaxWrongParts) throw InputError(what);
  parts_.try_emplace({std::string(part.kind), static_cast<std::size_t>(part.index)}, what);
}

bool WrongParts::has(std::string_view kind, std::size_t index) const {
  return !parts_.empty() && parts_.contains({std::string(kind), index});
}

void WrongParts::check(std::string_view kind, std::size_t index) const {
  if (has(kind, index)) throw InputError(parts_.at({std::string(kind), index}));
}

void WrongParts::note(Notes& notes) const {
  for (auto first = parts_.begin(); first != parts_.end();) {
    auto last = first;
    std::size_t count = 0;
    while (last != parts_.end() && last->first.first == first->first.first) ++last, ++count;
    const std::string others = count > 1 ? fmt::format(" (and {} more of its kind)", count - 1) : "";
    // The scene stands still without an animation; without anything else that it uses it would not
    // be read.
    const char* const why = first->first.first == "animation" ? "" : ", as the scene does not use it";
    notes.mended(fmt::format("left out{}{}: {}", why, others, first->second));
    first = last;
  }
}

}  // namespace eikon
