// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/emissive_texture.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/error.h"

namespace eikon {
namespace {

constexpr double kFarthest = 0x1p30;  // texels; lookups beyond it give texel 0 (kernels/surface/texture.h)

struct Axis {
  std::uint32_t size;
  bool clamp, mirror;
};
Axis axis_u(const TextureRecord& t) {
  return {t.width, (t.flags & EK_TEXTURE_CLAMP_U) != 0, (t.flags & EK_TEXTURE_MIRROR_U) != 0};
}
Axis axis_v(const TextureRecord& t) {
  return {t.height, (t.flags & EK_TEXTURE_CLAMP_V) != 0, (t.flags & EK_TEXTURE_MIRROR_V) != 0};
}

std::uint32_t wrapped(double whole, const Axis& axis) {
  const double n = axis.size;
  if (axis.clamp) return std::uint32_t(std::clamp(whole, 0.0, n - 1));
  const double period = axis.mirror ? 2 * n : n;
  const double k = whole - std::floor(whole / period) * period;
  return std::uint32_t(std::clamp(k < n ? k : period - 1 - k, 0.0, n - 1));
}

/// The texels [first, last] of an axis that lookups between two places touch. They are all texels
/// if a border of the image lies between the places.
std::pair<std::uint32_t, std::uint32_t> touched(double lo, double hi, const Axis& axis) {
  const double first = std::floor(lo - 1), last = std::floor(hi + 1);
  if (!axis.clamp && std::floor(first / axis.size) != std::floor(last / axis.size)) return {0, axis.size - 1};
  const std::uint32_t a = wrapped(first, axis), b = wrapped(last, axis);
  return {std::min(a, b), std::max(a, b)};
}

}  // namespace

EmissiveTextures::Place EmissiveTextures::corner_place(std::uint32_t index, const TextureRecord& texture,
                                                       int corner) const {
  double u = 0, v = 0;
  const auto take = [&](const auto& r) {
    u = double(corner == 0 ? r.u0 : corner == 1 ? r.u1 : r.u2);
    v = double(corner == 0 ? r.v0 : corner == 1 ? r.v1 : r.v2);
  };
  if ((texture.flags & EK_TEXTURE_UV1) != 0)
    take(packed_.tangents.at(index));
  else
    take(packed_.normals.at(index));
  return place_of(texture, u, v);
}

EmissiveTextures::Place EmissiveTextures::place_of(const TextureRecord& texture, double u, double v) {
  return {.x = (double(texture.u_u) * u + double(texture.u_v) * v + double(texture.u_1)) * texture.width,
          .y = (double(texture.v_u) * u + double(texture.v_v) * v + double(texture.v_1)) * texture.height};
}

EmissiveTextures::Place EmissiveTextures::between(const Corners& corners, const glm::dvec3& weights) {
  return {.x = weights[0] * corners[0].x + weights[1] * corners[1].x + weights[2] * corners[2].x,
          .y = weights[0] * corners[0].y + weights[1] * corners[1].y + weights[2] * corners[2].y};
}

std::span<const std::uint32_t> EmissiveTextures::texels_of(const TextureRecord& texture) const {
  std::uint64_t first = 0;
  for (const std::span<const std::uint32_t> part : packed_.texels) {
    if (first == texture.first_texel) return part;
    first += part.size();
  }
  throw InternalError("a texture without texels");
}

const EmissiveTextures::LitTexels& EmissiveTextures::lit_texels(const TextureRecord& texture, std::uint32_t channels) {
  LitTexels& lit = lit_[{texture.first_texel, channels}];
  if (!lit.sums.empty()) return lit;
  const std::span<const std::uint32_t> texels = texels_of(texture);
  lit.width = texture.width;
  lit.height = texture.height;
  const std::size_t stride = std::size_t{lit.width} + 1;
  lit.sums.assign(stride * (std::size_t{lit.height} + 1), 0);
  for (std::size_t y = 0; y < lit.height; ++y) {
    std::uint32_t row = 0;
    for (std::size_t x = 0; x < lit.width; ++x) {
      row += (texels[y * lit.width + x] & channels) != 0 ? 1 : 0;
      lit.sums[(y + 1) * stride + x + 1] = lit.sums[y * stride + x + 1] + row;
    }
  }
  return lit;
}

bool EmissiveTextures::may_emit(const TextureRecord& texture, std::uint32_t channels, const Corners& corners) {
  const LitTexels& lit = lit_texels(texture, channels);
  const auto [x_lo, x_hi] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
  const auto [y_lo, y_hi] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  const bool near = std::max({-x_lo, x_hi, -y_lo, y_hi}) < kFarthest;  // false for NaN
  const auto [left, right] = near ? touched(x_lo, x_hi, axis_u(texture)) : std::pair(0U, texture.width - 1);
  const auto [top, bottom] = near ? touched(y_lo, y_hi, axis_v(texture)) : std::pair(0U, texture.height - 1);
  const std::size_t stride = std::size_t{lit.width} + 1;
  const auto sum = [&](std::size_t x, std::size_t y) { return lit.sums[y * stride + x]; };
  return sum(right + 1, bottom + 1) - sum(left, bottom + 1) - sum(right + 1, top) + sum(left, top) != 0;
}

glm::dvec4 EmissiveTextures::lookup(const TextureRecord& texture, Place place) const {
  const std::span<const std::uint32_t> texels = texels_of(texture);
  const auto texel = [&](double x, double y) {
    const std::uint32_t word =
        texels[std::size_t{wrapped(y, axis_v(texture))} * texture.width + wrapped(x, axis_u(texture))];
    glm::dvec4 color;
    for (int c = 0; c < 4; ++c) {
      const std::uint32_t code = (word >> (8 * c)) & 255U;
      const bool is_srgb = c < 3 && (texture.flags & EK_TEXTURE_SRGB) != 0;
      color[c] = is_srgb ? double(std::bit_cast<float>(packed_.texels[0][code])) : code / 255.0;
    }
    return color;
  };
  if (!(std::abs(place.x) < kFarthest && std::abs(place.y) < kFarthest)) return texel(0, 0);
  if ((texture.flags & EK_TEXTURE_NEAREST) != 0) return texel(std::floor(place.x), std::floor(place.y));
  const double x = std::floor(place.x - 0.5), y = std::floor(place.y - 0.5);
  const double tx = place.x - 0.5 - x, ty = place.y - 0.5 - y;
  return (1 - ty) * ((1 - tx) * texel(x, y) + tx * texel(x + 1, y)) +
         ty * ((1 - tx) * texel(x, y + 1) + tx * texel(x + 1, y + 1));
}

namespace {
double mean_factor(const MaterialRecord& m) {
  return (double(m.emission_r) + double(m.emission_g) + double(m.emission_b)) / 3;
}
}  // namespace

double EmissiveTextures::mean_emission(std::uint32_t index) {
  const Triangle& triangle = packed_.triangles[index];
  const MaterialRecord& material = packed_.materials[triangle.material];
  Part part = part_of(triangle, material);
  if (!part.emission && !part.opacity && !part.is_passable) return mean_factor(material);
  for (std::size_t k = 0; k < 3; ++k) {
    if (part.emission) part.emission_at[k] = corner_place(index, *part.emission, int(k));
    if (part.opacity) part.opacity_at[k] = corner_place(index, *part.opacity, int(k));
  }
  if (index < packed_.colors.size()) {
    const TriangleColors& colors = packed_.colors[index];
    part.alpha = {double(colors.a0), double(colors.a1), double(colors.a2)};
  }
  return mean_over(material, part);
}

double EmissiveTextures::mean_emission_of_whole_texture(std::uint32_t index) {
  const Triangle& box = packed_.triangles[index];
  const MaterialRecord& material = packed_.materials[box.material];
  Part part = part_of(box, material);
  if (!part.emission && !part.opacity && !part.is_passable) return mean_factor(material);
  double sum = 0;
  for (const std::array<glm::dvec2, 3>& half : {std::array{glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(0, 1)},
                                                std::array{glm::dvec2(1, 1), glm::dvec2(0, 1), glm::dvec2(1, 0)}}) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (part.emission) part.emission_at[k] = place_of(*part.emission, half[k].x, half[k].y);
      if (part.opacity) part.opacity_at[k] = place_of(*part.opacity, half[k].x, half[k].y);
    }
    sum += mean_over(material, part);
  }
  return 0.5 * sum;
}

EmissiveTextures::Part EmissiveTextures::part_of(const Triangle& triangle, const MaterialRecord& material) const {
  Part part;
  if (!(mean_factor(material) > 0)) return part;
  if (material.emissive_texture != EK_NO_TEXTURE) part.emission = &packed_.textures[material.emissive_texture];
  part.is_passable = (triangle.flags & EK_TRIANGLE_ALPHA_TESTED) != 0;
  if (part.is_passable && material.base_color_texture != EK_NO_TEXTURE)
    part.opacity = &packed_.textures[material.base_color_texture];
  return part;
}

double EmissiveTextures::opacity_of(const MaterialRecord& material, const Part& part, const glm::dvec3& weights) const {
  double opacity = double(material.opacity) * glm::dot(weights, part.alpha);
  if (part.opacity) opacity *= lookup(*part.opacity, between(part.opacity_at, weights)).w;
  if ((material.flags & EK_MATERIAL_MASK) != 0) return opacity >= double(material.alpha_cutoff) ? 1 : 0;
  return opacity;
}

double EmissiveTextures::mean_over(const MaterialRecord& material, const Part& part) {
  const glm::dvec3 factor(material.emission_r, material.emission_g, material.emission_b);
  const double all = mean_factor(material);
  std::uint32_t channels = 0;
  for (int c = 0; c < 3; ++c) channels |= factor[c] > 0 ? 255U << (8 * c) : 0;
  if (part.emission && !may_emit(*part.emission, channels, part.emission_at)) return 0;

  // Sums over the middles of n^2 equal parts. A part is about a texel, as long as there are not too
  // many.
  double texels = 0;
  for (const auto* corners : {&part.emission_at, &part.opacity_at})
    for (std::size_t k = 0; k < 3; ++k) {
      const Place a = (*corners)[k], b = (*corners)[(k + 1) % 3];
      texels = std::max({texels, std::abs(a.x - b.x), std::abs(a.y - b.y)});
    }
  const int n = texels < 64 ? std::max(int(texels), 4) : 64;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < 2 * i + 1; ++j) {  // row i from the first corner: 2 i + 1 parts, every second upside down
      const double down = (i + (j % 2 == 0 ? 2.0 : 1.0) / 3) / n, across = (j / 2 + (j % 2 == 0 ? 1.0 : 2.0) / 3) / n;
      const glm::dvec3 weights(1 - down, down - across, across);
      double radiance = all;
      if (part.emission) {
        const glm::dvec3 emission = factor * glm::dvec3(lookup(*part.emission, between(part.emission_at, weights)));
        radiance = (emission.x + emission.y + emission.z) / 3;
      }
      sum += part.is_passable ? radiance * opacity_of(material, part, weights) : radiance;
    }
  // The sum is at least a sixteenth of one point's emission, because all points may have missed the
  // texels that are lit, or that stop light.
  return std::max(sum, 0x1p-4 * all) / (double(n) * n);
}

}  // namespace eikon
