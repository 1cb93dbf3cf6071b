// SPDX-License-Identifier: Apache-2.0
// Numbers of a material, brought into their legal ranges with a warning that names it.
#pragma once
#include <glm/glm.hpp>
#include <limits>
#include <string>

#include "io/json_text.h"
#include "scene/notes.h"

namespace eikon {

inline constexpr double kMaxFloat = std::numeric_limits<float>::max(), kMinFloat = std::numeric_limits<float>::min();

/// The number `key` of an object, or `otherwise` if the object or its member is absent.
[[nodiscard]] double number_of(const Json* owner, const char* key, double otherwise);

/// Factors of one material in their legal ranges. `owner` is the object that holds `key`, or null
/// for the default.
class Factors {
 public:
  /// The arguments outlive the factors.
  Factors(const JsonView& material, Notes& notes) : material_(material), notes_(notes) {}

  /// Names the material in messages.
  [[nodiscard]] const JsonView& material() const { return material_; }
  /// Warns of something about the material.
  void warn(const std::string& what) const;

  [[nodiscard]] float unit(const Json* owner, const char* key, double otherwise) const;
  [[nodiscard]] float clamped(double value, const char* key, double lo, double hi) const;
  /// throws InputError for a value that single precision cannot hold
  [[nodiscard]] float not_negative(double value, const char* key) const;
  /// In [0, 1], or only not negative if `unbounded`.
  [[nodiscard]] glm::vec3 color(const Json* owner, const char* key, double otherwise, bool unbounded = false) const;

 private:
  const JsonView& material_;
  Notes& notes_;
};

/// The scale of the normal texture `info` in slot `key`. throws InputError if it is beyond single
/// precision
[[nodiscard]] float normal_scale_of(const JsonView& material, const Json& info, const char* key);

}  // namespace eikon
