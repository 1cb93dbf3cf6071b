// SPDX-License-Identifier: Apache-2.0
#include "pack/lights/pack_light_paths.h"

#include <algorithm>
#include <map>
#include <numbers>

#include "pack/lights/light_table.h"
#include "pack/lights/pack_environment.h"
#include "pack/pack_parts.h"
#include "scene/emission.h"
#include "scene/endless.h"
#include "shared/light_target.h"

namespace eikon {
namespace {

constexpr double kSmoothRoughness = 0.011;  // whose square is below EK_SMOOTH_ALPHA of kernels/bsdf/microfacet.h
constexpr float kMaxRoughness = 0.5F, kMinSpecularShare = 0.5F;  // of glossy targets
// Texels this many times as bright as the mean are small lights, if together they bring at least
// that share of the light.
constexpr double kSmallLightContrast = 64, kSmallLightShare = 1.0 / 16;
constexpr double kSmallTarget = 1.0 / 8;  // of the scene's radius: smaller targets are not divided

/// Part of a target: a triangle or the box of a shape or instance.
struct Piece {
  glm::dvec3 a{0.0}, b{0.0}, c{0.0};  // of a box: lo, hi, lo
  bool is_box = false;

  [[nodiscard]] glm::dvec3 middle() const { return is_box ? 0.5 * (a + b) : (a + b + c) / 3.0; }
};

struct Ball {
  glm::dvec3 centre{0.0};
  double radius = 0;
};

/// The ball around the middle of the pieces' bounds. It may be larger than the least one: around a
/// regular tetrahedron by up to a third.
Ball ball_around(std::span<const Piece> pieces) {
  Bounds bounds;
  for (const Piece& piece : pieces)
    for (const glm::dvec3& p : {piece.a, piece.b, piece.c}) grow(bounds, p);
  Ball ball{0.5 * (bounds.lo + bounds.hi), 0};
  for (const Piece& piece : pieces) {
    if (piece.is_box) {
      // The farthest corner of the box.
      const glm::dvec3 far = glm::max(glm::abs(piece.a - ball.centre), glm::abs(piece.b - ball.centre));
      ball.radius = std::max(ball.radius, glm::length(far));
    } else {
      for (const glm::dvec3& p : {piece.a, piece.b, piece.c})
        ball.radius = std::max(ball.radius, glm::length(p - ball.centre));
    }
  }
  return ball;
}

/// Divides a triangle in two, at the middle of its longest side.
std::pair<std::vector<Piece>, std::vector<Piece>> halves(const Piece& piece) {
  glm::dvec3 corners[] = {piece.a, piece.b, piece.c};
  const auto side = [&](std::size_t i) { return glm::length(corners[(i + 1) % 3] - corners[i]); };
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (side(i) > side(longest)) longest = i;
  std::rotate(corners, corners + longest, corners + 3);
  const glm::dvec3 middle = 0.5 * (corners[0] + corners[1]);
  return {{{corners[0], middle, corners[2], false}}, {{middle, corners[1], corners[2], false}}};
}

/// Divides the pieces in two by their middles, along the longest axis of these.
std::pair<std::vector<Piece>, std::vector<Piece>> divided(std::vector<Piece> pieces) {
  if (pieces.size() == 1) return halves(pieces.front());
  Bounds middles;
  for (const Piece& piece : pieces) grow(middles, piece.middle());
  const glm::dvec3 size = middles.hi - middles.lo;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto half = pieces.begin() + std::ptrdiff_t(pieces.size() / 2);
  // A stable order, so that the same scene has the same targets on every system.
  std::ranges::stable_sort(pieces, {}, [&](const Piece& piece) { return piece.middle()[axis]; });
  return {{pieces.begin(), half}, {half, pieces.end()}};
}

class Targets {
 public:
  Targets(std::span<const Material> materials, const PackedScene& packed) {
    if (packed.bounds.empty()) return;
    const auto is_target = [&](const Triangle& t) { return is_light_target(materials[t.material]); };
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Piece>> groups;
    const std::size_t in_world =
        packed.stored_meshes.empty() ? packed.triangle_count() : packed.stored_meshes.front().first;
    for (std::size_t i = 0; i < in_world; ++i) {
      const Triangle& t = packed.triangles[i];
      if (!is_target(t)) continue;
      const auto [a, b, c] = corners_of(t);
      groups[{t.node, t.material}].push_back({a, b, c, false});
    }
    for (std::size_t i = packed.triangle_count(); i < packed.triangles.size(); ++i) {
      const Triangle& t = packed.triangles[i];
      if (!is_target(t) || is_endless_box(&t.p0_x)) continue;
      groups[{t.node, t.material}].push_back(
          {{t.p0_x, t.p0_y, t.p0_z}, {t.p1_x, t.p1_y, t.p1_z}, {t.p0_x, t.p0_y, t.p0_z}, true});
    }
    for (std::size_t i = 0; i < packed.instances.size(); ++i) {
      const StoredMesh& mesh = packed.stored_meshes[packed.instances[i].mesh];
      const std::span<const Triangle> own(&packed.triangles[mesh.first], mesh.count);
      const auto found = std::ranges::find_if(own, is_target);
      if (found == own.end()) continue;
      const InstanceBox& box = packed.instance_boxes[i];
      groups[{packed.instances[i].node, found->material}].push_back({box.lo, box.hi, box.lo, true});
    }
    for (auto& [key, pieces] : groups) clusters_.push_back(std::move(pieces));
    if (clusters_.size() > EK_LIGHT_TARGETS_MOST) join();
    divide(kSmallTarget * 0.5 * glm::length(packed.bounds.hi - packed.bounds.lo));
  }

  [[nodiscard]] std::vector<Ball> balls() const {
    std::vector<Ball> balls;
    for (const std::vector<Piece>& cluster : clusters_) balls.push_back(ball_around(cluster));
    return balls;
  }

 private:
  /// Makes one cluster of all.
  void join() {
    for (std::size_t i = 1; i < clusters_.size(); ++i)
      clusters_.front().insert(clusters_.front().end(), clusters_[i].begin(), clusters_[i].end());
    clusters_.resize(1);
    divide(0);
  }

  /// Divides the largest clusters until none is larger than that, or there are as many as there may
  /// be.
  void divide(double small) {
    // The box of a shape or an instance stays whole.
    const auto radius_of = [](const std::vector<Piece>& cluster) {
      return cluster.size() > 1 || !cluster.front().is_box ? ball_around(cluster).radius : 0;
    };
    std::vector<double> radii;
    for (const std::vector<Piece>& cluster : clusters_) radii.push_back(radius_of(cluster));
    while (!clusters_.empty() && clusters_.size() < EK_LIGHT_TARGETS_MOST) {
      const auto largest = std::size_t(std::ranges::max_element(radii) - radii.begin());
      if (!(radii[largest] > small)) return;
      auto [first, second] = divided(std::move(clusters_[largest]));
      clusters_[largest] = std::move(first);
      clusters_.push_back(std::move(second));
      for (const std::size_t i : {largest, clusters_.size() - 1}) {
        const double radius = radius_of(clusters_[i]);
        i < radii.size() ? radii[i] = radius : (radii.push_back(radius), radius);
      }
    }
  }

  std::vector<std::vector<Piece>> clusters_;
};

/// 1 less the cosine of the half angle of a ball's cone, as target_cone of the kernels.
double cone_of(const Ball& ball, const glm::dvec3& from) {
  const glm::dvec3 way = ball.centre - from;
  const double sin2 = ball.radius * ball.radius / glm::dot(way, way);
  return sin2 < 1 ? sin2 / (1 + std::sqrt(1 - sin2)) : 2;
}

/// Number of targets that a line through one of them meets, in the mean over targets, weighted by
/// what they cover, and the axes.
double overlap_of(std::span<const Ball> balls) {
  double met = 0, covered = 0;
  for (const Ball& ball : balls) {
    const double covers = ball.radius * ball.radius;
    for (int axis = 0; axis < 3; ++axis)
      for (const Ball& other : balls) {
        glm::dvec3 across = other.centre - ball.centre;
        across[axis] = 0;
        met += glm::length(across) <= other.radius ? covers : 0;
      }
    covered += 3 * covers;
  }
  return covered > 0 ? met / covered : 1;
}

float power_of_two_below(double x) { return aim_within_bounds(float(std::exp2(std::floor(std::log2(x))))); }

}  // namespace

float aim_within_bounds(float aim) { return std::clamp(aim, 0x1p-10F, 0x1p19F); }

bool is_specular_light_target(const Material& material) {
  if (material.unlit) return false;
  // Light goes straight on through the openings of a solid, however rough that is.
  if (may_have_openings(material) && (material.opacity < 1 || material.base_color_texture)) return true;
  if (material.roughness > kSmoothRoughness) return false;
  return has_trait(material, EK_TRAIT_METAL) || (has_trait(material, EK_TRAIT_METALLIC) && material.metallic > 0) ||
         (has_trait(material, EK_TRAIT_TRANSMITS) && material.transmission > 0);
}

bool is_glossy_light_target(const Material& material) {
  if (material.unlit || !(material.roughness > kSmoothRoughness && material.roughness <= kMaxRoughness)) return false;
  return has_trait(material, EK_TRAIT_METAL) ||
         (has_trait(material, EK_TRAIT_METALLIC) && material.metallic >= kMinSpecularShare) ||
         (has_trait(material, EK_TRAIT_TRANSMITS) && material.transmission >= kMinSpecularShare);
}

bool is_light_target(const Material& material) {
  return is_specular_light_target(material) || is_glossy_light_target(material);
}

bool only_light_paths_find_some(const Scene& scene) {
  // No light path starts from a light of a limited range (LightPacker::start_light_paths).
  const auto starts = [](const PunctualLight& light) { return light.range_m == 0 && light.intensity != glm::vec3(0); };
  return std::ranges::any_of(scene.lights, starts) && std::ranges::any_of(scene.materials, is_specular_light_target);
}

bool has_small_lights(const EnvironmentMap& map) {
  const auto for_each_texel = [&](auto&& visit) {
    for (std::uint32_t j = 0; j < map.height; ++j) {
      const double solid_angle = texel_solid_angle(j, map.width, map.height);
      for (std::uint32_t i = 0; i < map.width; ++i)
        visit(mean(map.radiance[std::size_t{j} * map.width + i]), solid_angle);
    }
  };
  double all = 0, bright = 0;
  for_each_texel([&](double radiance, double solid_angle) { all += radiance * solid_angle; });
  const double least = kSmallLightContrast * all / (4 * std::numbers::pi);
  for_each_texel([&](double radiance, double solid_angle) { bright += radiance > least ? radiance * solid_angle : 0; });
  return bright > kSmallLightShare * all;
}

void pack_light_paths(std::span<const Material> materials, std::span<const LightPathSource> emitters,
                      PackedScene& packed) {
  // Paths from the camera ask for the density of each light, also where no light path can start.
  packed.emission_pdf.assign(emitters.size(), 0);
  packed.emission_aim.assign(emitters.size() + 1, 0);
  const std::vector<Ball> balls = Targets(materials, packed).balls();
  if (balls.empty()) return;
  double sections_m2 = 0;
  for (const Ball& ball : balls) sections_m2 += std::numbers::pi * ball.radius * ball.radius;
  std::vector<double> powers;
  const double overlap = overlap_of(balls);
  std::vector<float> aims = {float(overlap / sections_m2)};
  std::vector<double> shares(2 * balls.size());
  for (const LightPathSource& emitter : emitters) {
    double cones = 0;
    if (emitter.radiance_area > 0)
      for (std::size_t i = 0; i < balls.size(); ++i) {
        const double cone = cone_of(balls[i], emitter.place);
        shares[2 * i + EK_AIM_CONE] += emitter.radiance_area * cone;
        cones += cone;
      }
    aims.push_back(power_of_two_below(overlap / (2 * std::numbers::pi * cones)));
    powers.push_back(emitter.radiance_area * 2 * std::numbers::pi * cones + emitter.irradiance * sections_m2);
  }
  const LightTable table = build_light_table(powers);
  if (table.buckets.empty()) return;
  packed.emission_alias_table = table.buckets;
  packed.has_specular_light_targets = std::ranges::any_of(materials, is_specular_light_target);
  packed.emission_aim = std::move(aims);
  for (std::size_t i = 0; i < emitters.size(); ++i)
    packed.emission_pdf[i] =
        float(emitters[i].area_m2 > 0 ? table.probability[i] / emitters[i].area_m2 : table.probability[i]);
  for (std::size_t i = 0; i < balls.size(); ++i) shares[2 * i + EK_AIM_DISC] = balls[i].radius * balls[i].radius;
  packed.light_target_shares = std::move(shares);
  for (const Ball& ball : balls)
    packed.light_targets.push_back(
        {float(ball.centre.x), float(ball.centre.y), float(ball.centre.z), up(ball.radius * (1 + 0x1p-16))});
}

}  // namespace eikon
