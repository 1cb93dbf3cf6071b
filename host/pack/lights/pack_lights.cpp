// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "pack/lights/find_lights.h"
#include "pack/lights/light_kind.h"
#include "pack/lights/light_table.h"
#include "pack/lights/light_tree.h"
#include "pack/lights/lights_in_media.h"
#include "pack/lights/pack_light_paths.h"
#include "pack/lights/pack_environment.h"
#include "pack/pack_parts.h"
#include "scene/emission.h"

namespace eikon {
namespace {

/// A packed light, as the table and the summary need it.
struct Strength {
  double power = 0;           // selection is proportional to it
  double area_m2 = 0;         // of a surface
  std::uint32_t summary = 0;  // entry of light_summary
  bool distant = false;       // infinitely far away
};

class LightPacker {
 public:
  LightPacker(const Scene& scene, const Features& features, const Settings& settings, PackedScene& packed)
      : scene_(scene),
        environment_(settings.environment),
        packed_(packed),
        has_tree_(features.has(Feature::light_tree)),
        has_one_(features.has(Feature::one_light)),
        each_(features.has(Feature::each_light)),
        has_light_paths_(features.has(Feature::light_paths)),
        has_media_(features.has(Feature::absorption) || features.has(Feature::nested_media)),
        finder_(scene, features, settings, packed, [this](const FoundLight& found) { add(found); }) {}

  void pack() {
    make_room();
    (void)finder_.find_triangles(false);
    finder_.find_others();
    if (packed_.lights.empty()) return;
    if (has_one_ && packed_.lights.size() > 1) throw InternalError("more lights than were counted");
    double local = 0, distant = 0;
    for (const Strength& s : strengths_) (s.distant ? distant : local) += s.power;
    const double scale = scale_of_distant(local, distant);
    if (has_tree_) grow_tree();
    const std::size_t in_tree = packed_.tree_light_count;
    std::vector<double> powers;
    powers.reserve(strengths_.size() - in_tree + 1);
    if (has_tree_) powers.push_back(local);
    for (std::size_t i = in_tree; i < strengths_.size(); ++i)
      powers.push_back(strengths_[i].power * (strengths_[i].distant ? scale : 1));
    const LightTable table = build_light_table(powers);
    if (table.buckets.empty()) throw InternalError("lights without power");
    packed_.light_alias_table = table.buckets;
    for (std::size_t i = 0; i < in_tree; ++i) set_probability(i, table.probability[0]);
    if (in_tree > 0) share_by_flux(table.probability[0], packed_.light_summary);
    for (std::size_t i = in_tree; i < packed_.lights.size(); ++i) {
      const double probability = table.probability[has_tree_ ? i - in_tree + 1 : i];
      set_probability(i, each_ ? 1 : probability);
      packed_.light_summary[strengths_[i].summary].probability += probability;
    }
    if (has_light_paths_) start_light_paths();
  }

 private:
  /// Reserves places for all lights that there can be, since vectors that grow need both the old
  /// and the new memory.
  void make_room() {
    const auto emissive = std::ranges::count_if(packed_.triangles,
                                                [&](const Triangle& t) { return emits(scene_.materials[t.material]); });
    const std::size_t most = std::size_t(emissive) + scene_.lights.size() + 1;
    packed_.lights.reserve(most);
    strengths_.reserve(most);
    if (has_tree_) moments_.reserve(most);
  }

  /// Moves the lights that have a place to the front, in the order of the tree's leaves.
  void grow_tree() {
    packed_.tree_light_count = std::uint32_t(moments_.size());
    std::vector<std::uint32_t> distant;  // in the order of the lights
    std::vector<std::uint32_t> placed;   // those behind the first distant one
    for (std::uint32_t i = 0; i < strengths_.size(); ++i) {
      if (strengths_[i].distant)
        distant.push_back(i);
      else if (!distant.empty())
        placed.push_back(i);
    }
    LightTree tree = build_light_tree(std::move(moments_));
    packed_.light_nodes = std::move(tree.nodes);
    packed_.light_scale = tree.scale;
    std::vector<std::uint32_t> from = std::move(tree.order);
    if (!placed.empty())
      for (std::uint32_t& light : from)
        if (light >= distant.front()) light = placed[light - distant.front()];
    from.insert(from.end(), distant.begin(), distant.end());
    put_in_order(std::move(from));
    name_lights(packed_.tree_light_count);
  }

  /// Moves light from[i] to place i, for all i, cycle by cycle: a copy of millions of lights would
  /// be a peak of memory.
  void put_in_order(std::vector<std::uint32_t> from) {
    for (std::uint32_t first = 0; first < from.size(); ++first) {
      const Light light = packed_.lights[first];
      const Strength strength = strengths_[first];
      std::uint32_t to = first;
      for (std::uint32_t next = from[to]; next != first; next = from[to]) {
        packed_.lights[to] = packed_.lights[next];
        strengths_[to] = strengths_[next];
        from[to] = to;
        to = next;
      }
      packed_.lights[to] = light;
      strengths_[to] = strength;
      from[to] = to;
    }
  }

  /// Notes with the triangles and shapes which of the first lights they are.
  void name_lights(std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      const Light& light = packed_.lights[i];
      if (!light_kind(LightKind(light.kind)).surface) continue;
      packed_.triangles[light.triangle].flags |= i << EK_TRIANGLE_LIGHT_SHIFT;
      if ((light.flags & EK_LIGHT_QUAD) != 0)
        packed_.triangles[light.triangle + 1].flags |= i << EK_TRIANGLE_LIGHT_SHIFT;
    }
  }

  /// Prepares the start of light paths. None starts from an environment without small lights, from
  /// lights of a limited range, whose light fades in a way that does not go on behind glass, or
  /// from what may shine within a solid that absorbs or has a priority. A plane without end may lie
  /// before any place that parallel light could start from.
  void start_light_paths() {
    bool endless = false;
    for (std::size_t i = packed_.triangle_count(); i < packed_.triangles.size(); ++i)
      endless = endless || is_endless_box(&packed_.triangles[i].p0_x);
    LightsInMedia media(packed_, has_media_);
    std::vector<LightPathSource> emitters(packed_.lights.size());
    for (std::size_t i = 0; i < emitters.size(); ++i) {
      const Light& light = packed_.lights[i];
      const double emission = mean({light.emission_r, light.emission_g, light.emission_b});
      LightPathSource& emitter = emitters[i];
      if (light.kind == kind_word(LightKind::area)) {
        emitter = {strengths_[i].power / std::numbers::pi, 0, strengths_[i].area_m2, middle_of(light)};
      } else if (light.kind == kind_word(LightKind::shape_light)) {
        const Triangle& box = packed_.triangles[light.triangle];
        emitter.radiance_area = strengths_[i].power / std::numbers::pi;
        emitter.place = 0.5 * (glm::dvec3(box.p0_x, box.p0_y, box.p0_z) + glm::dvec3(box.p1_x, box.p1_y, box.p1_z));
      } else if (light.kind == kind_word(LightKind::directional)) {
        emitter.irradiance = endless ? 0 : emission;
      } else if (light.kind == kind_word(LightKind::environment_map)) {
        emitter.irradiance =
            endless || !has_small_lights(*environment_.map) ? 0 : strengths_[i].power / section_m2(packed_.bounds);
      } else if ((light.kind == kind_word(LightKind::point) || light.kind == kind_word(LightKind::spot)) &&
                 std::isinf(light.p2_z)) {
        emitter.radiance_area = emission;
        emitter.place = {light.p0_x, light.p0_y, light.p0_z};
      }
      const bool is_surface = light_kind(LightKind(light.kind)).surface;
      if (emitter.radiance_area > 0 && (is_surface ? media.may_hold(light) : media.holds(emitter.place)))
        emitter.radiance_area = 0;
    }
    if (!has_tree_) name_lights(std::uint32_t(packed_.lights.size()));
    pack_light_paths(scene_.materials, emitters, packed_);
    for (std::size_t i = 0; i < packed_.emission_pdf.size(); ++i)
      if (packed_.lights[i].kind == kind_word(LightKind::environment_map))
        packed_.environment_emission = packed_.emission_pdf[i] / packed_.environment_probability;
  }

  void add(const FoundLight& found) {
    packed_.lights.push_back(found.light);
    strengths_.push_back({found.power, found.area_m2, found.summary, found.distant});
    if (!has_tree_ || found.distant) return;
    moments_.push_back(found.moments);
    moments_.back().power = found.power;
  }

  void set_probability(std::size_t i, double probability) {
    Light& light = packed_.lights[i];
    light.pdf_m2 = float(probability);
    if (light.kind == kind_word(LightKind::area)) {
      light.pdf_m2 = float(probability / strengths_[i].area_m2);
      packed_.triangles[light.triangle].light_pdf_m2 = light.pdf_m2;
      if ((light.flags & EK_LIGHT_QUAD) != 0) packed_.triangles[light.triangle + 1].light_pdf_m2 = light.pdf_m2;
    }
    if (light.kind == kind_word(LightKind::shape_light)) packed_.triangles[light.triangle].light_pdf_m2 = light.pdf_m2;
    const bool is_map = light.kind == kind_word(LightKind::environment_map);
    if (is_map || light.kind == kind_word(LightKind::environment)) packed_.environment_probability = light.pdf_m2;
    if (is_map)
      for (float4& texel : packed_.environment_texels) texel.w = float(probability * double(texel.w));
  }

  const Scene& scene_;
  const Environment& environment_;
  PackedScene& packed_;
  bool has_tree_, has_one_, each_, has_light_paths_, has_media_;
  LightFinder finder_;
  std::vector<Strength> strengths_;    // as packed_.lights
  std::vector<LightMoments> moments_;  // for the tree: of the lights that have a place, until it grows
};

}  // namespace

void pack_lights(const Scene& scene, const Features& features, const Settings& settings, PackedScene& packed) {
  LightPacker(scene, features, settings, packed).pack();
}

}  // namespace eikon
