// SPDX-License-Identifier: Apache-2.0
// A look is what a page asks to see, as flags of `eikon render`.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "io/json_text.h"

namespace eikon {

/// The longest side of a picture that a page may ask for, in pixels.
inline constexpr std::uint32_t kMaxViewSide = 2048;

struct ViewLook {
  std::map<std::string, std::string> flags{};  // "--fov" -> "40"; they decide what is rendered
  std::map<std::string, std::string> png{};    // "--exposure" and "--tonemap", which decide how it is shown
  std::string layer = "picture";               // one of view_layers()
  std::map<std::string, double> mix{};         // light group -> factor, for the layer `lights`; others have 1
  bool moving = false;                         // more is about to change: only the small picture is wanted

  bool operator==(const ViewLook&) const = default;
  /// The layer is one that the film keeps beside R, G and B.
  [[nodiscard]] bool needs_layers() const { return layer != "picture" && layer != "error"; }
};

/// picture; the same without noise; error of each pixel; and what the film sums besides: albedo,
/// normal, depth, lights.
[[nodiscard]] const std::vector<std::string>& view_layers();

/// Reads {"flags": {name: text}, "layer": name, "mix": {name: number}, "moving": boolean}, from
/// anybody. Flags of `png` are among the others.
/// throws UsageError for anything else, a flag that pages may not give, and a value that would name
/// a file
[[nodiscard]] ViewLook read_look(std::string_view text);
/// The same text, for the page.
[[nodiscard]] Json look_json(const ViewLook& look);

/// The words behind `eikon render` for a look: those that the user gave, but for what the look
/// replaces. Layers are left out.
[[nodiscard]] std::vector<std::string> words_of(const ViewLook& look, const std::vector<std::string>& given);

/// True if one of the words is the flag, with or without a value.
[[nodiscard]] bool has_flag(const std::vector<std::string>& words, std::string_view flag);

}  // namespace eikon
