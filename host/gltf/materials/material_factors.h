// SPDX-License-Identifier: Apache-2.0
// Numbers of a material, brought into their legal ranges with a warning that names it.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "gltf/document/document_check.h"
#include "scene/scene.h"
#include "io/text.h"

namespace eikon {

inline constexpr double kMaxFloat = std::numeric_limits<float>::max(), kMinFloat = std::numeric_limits<float>::min();

inline const Json* extension_of(const Place& material, std::string_view name) {
  const Json* extensions = member(material.value, "extensions");
  return extensions == nullptr ? nullptr : member(*extensions, std::string(name).c_str());
}

inline double number_of(const Json* owner, const char* key, double otherwise) {
  const Json* number = owner == nullptr ? nullptr : member(*owner, key);
  return number == nullptr ? otherwise : number->get<double>();
}

/// Factors of one material in their legal ranges. `owner` is the object that holds `key`, or null for the default.
class Factors {
 public:
  Factors(const Place& place, Notes& notes) : place_(place), notes_(notes) {}

  [[nodiscard]] float unit(const Json* owner, const char* key, double otherwise) const {
    return clamped(number_of(owner, key, otherwise), key, 0.0, 1.0);
  }

  [[nodiscard]] float clamped(double value, const char* key, double lo, double hi) const {
    const double legal = std::clamp(value, lo, hi);
    if (legal != value) notes_.clamped(fmt::format("{}: {} {:g} clamped to {:g}", place_.label(), key, value, legal));
    return static_cast<float>(legal);
  }

  /// throws InputError for a value that single precision cannot hold
  [[nodiscard]] float not_negative(double value, const char* key) const {
    if (value > kMaxFloat)
      place_.refuse(fmt::format("{} {:g} is beyond single precision; use a smaller value", key, value));
    return clamped(value, key, 0.0, kMaxFloat);
  }

  [[nodiscard]] glm::vec3 colour(const Json* owner, const char* key, double otherwise, bool unbounded = false) const {
    const Json* rgb = owner == nullptr ? nullptr : member(*owner, key);
    glm::vec3 result(static_cast<float>(otherwise));
    for (int c = 0; rgb != nullptr && c < 3; ++c) {
      const double value = (*rgb)[static_cast<std::size_t>(c)].get<double>();
      result[c] = unbounded ? not_negative(value, key) : clamped(value, key, 0.0, 1.0);
    }
    return result;
  }

 private:
  const Place& place_;
  Notes& notes_;
};

/// The scale of a normal texture `info` in slot `key`. throws InputError where it is beyond single precision
inline float normal_scale_of(const Place& material, const Json& info, const char* key) {
  const double scale = number_of(&info, "scale", 1.0);
  if (!(std::abs(scale) <= kMaxFloat)) material.refuse(fmt::format("{} scale {:g} is not finite", key, scale));
  return static_cast<float>(scale);
}

}  // namespace eikon
