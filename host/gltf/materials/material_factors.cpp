// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/material_factors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace eikon {

double number_of(const Json* owner, const char* key, double otherwise) {
  const Json* number = member(owner, key);
  return number == nullptr ? otherwise : to_number(*number);
}

void Factors::warn(const std::string& what) const { notes_.warn(material_.label() + ": " + what); }

float Factors::unit(const Json* owner, const char* key, double otherwise) const {
  return clamped(number_of(owner, key, otherwise), key, 0.0, 1.0);
}

float Factors::clamped(double value, const char* key, double lo, double hi) const {
  const double legal = std::clamp(value, lo, hi);
  if (legal != value) notes_.mended(fmt::format("{}: {} {:g} clamped to {:g}", material_.label(), key, value, legal));
  return static_cast<float>(legal);
}

float Factors::not_negative(double value, const char* key) const {
  if (value > kMaxFloat)
    material_.refuse(fmt::format("{} {:g} is beyond single precision; use a smaller value", key, value));
  return clamped(value, key, 0.0, kMaxFloat);
}

glm::vec3 Factors::color(const Json* owner, const char* key, double otherwise, bool unbounded) const {
  const Json* rgb = member(owner, key);
  glm::vec3 result(static_cast<float>(otherwise));
  for (int c = 0; rgb != nullptr && c < 3; ++c) {
    const double value = number_at(*rgb, static_cast<std::size_t>(c));
    result[c] = unbounded ? not_negative(value, key) : clamped(value, key, 0.0, 1.0);
  }
  return result;
}

float normal_scale_of(const JsonView& material, const Json& info, const char* key) {
  const double scale = number_of(&info, "scale", 1.0);
  if (!(std::abs(scale) <= kMaxFloat)) material.refuse(fmt::format("{} scale {:g} is not finite", key, scale));
  return static_cast<float>(scale);
}

}  // namespace eikon
