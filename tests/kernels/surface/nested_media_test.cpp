// SPDX-License-Identifier: Apache-2.0
// Lists of the solids that a path is in, against plain vectors; and what a boundary is between two
// of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "kernels/probe.h"
#include "pack/pack.h"

namespace eikon::test {
namespace {

/// The ranks of the solids that a path is in, the highest first.
using List = std::vector<std::uint32_t>;

std::uint32_t below(std::mt19937& random, std::size_t end) { return std::uint32_t(random() % end); }

std::uint32_t word_of(const List& list) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < list.size(); ++i) word |= list[i] << (24 - 8 * i);
  return word;
}

List with(List list, std::uint32_t rank) {
  list.push_back(rank);
  std::ranges::sort(list, std::greater<>());
  if (list.size() > EK_MEDIA_MOST) list.pop_back();
  return list;
}

List without(List list, std::uint32_t rank) {
  const auto found = std::ranges::find(list, rank);
  if (found != list.end()) list.erase(found);
  return list;
}

TEST(NestedMedia, lists_are_those_of_sorted_vectors_after_any_events) {
  std::mt19937 random(1);
  std::vector<Words> in(2);
  Words expected_with, expected_without;
  std::size_t full = 0, absent = 0, twice = 0;
  for (int walk = 0; walk < 400; ++walk) {
    // Few ranks, so that they repeat; or all that there are.
    const std::uint32_t most = walk % 2 == 0 ? 4 : 255;
    List list;
    for (int event = 0; event < 25; ++event) {
      const bool known = !list.empty() && below(random, 2) == 0;
      const std::uint32_t rank = known ? list[below(random, list.size())] : 1 + below(random, most);
      in[0].push_back(word_of(list));
      in[1].push_back(rank);
      expected_with.push_back(word_of(with(list, rank)));
      expected_without.push_back(word_of(without(list, rank)));
      full += list.size() == EK_MEDIA_MOST;
      absent += std::ranges::find(list, rank) == list.end();
      twice += std::ranges::count(list, rank) > 1;
      list = below(random, 5) < 3 ? with(list, rank) : without(list, rank);
    }
  }
  for (const std::uint32_t word : {0U, 0x01000000U, 0xff030201U}) {  // surfaces that are no solid's have rank 0
    in[0].push_back(word);
    in[1].push_back(0);
    expected_with.push_back(word);
    expected_without.push_back(word);
  }
  EXPECT_GT(std::min({full, absent, twice}), 500U);
  const auto out = Probe("material").define("EK_HAS_nested_media", "1").run("probe_media_list", in, 2);
  EXPECT_EQ(out[0], expected_with);
  EXPECT_EQ(out[1], expected_without);
}

struct Solid {
  int priority;
  float ior, dispersion;
  glm::vec3 attenuation;
  float transmission = 1;
};
/// Solids of these priorities and indices, each a material on a triangle of its own.
struct Solids {
  static constexpr std::size_t kCount = 5;
  // water, glass, air in it, flint, a mirror to everything [KHR_materials_ior: 0]
  static inline const std::array<Solid, kCount> kSolids{{{1, 1.33F, 0, {0.5F, 0.25F, 1}},
                                                         {5, 1.5F, 0, {1, 1, 1}, 0.5F},
                                                         {9, 1, 0, {1, 1, 1}},
                                                         {7, 1.62F, 1, {0.25F, 1, 1}},
                                                         {-3, 0, 0, {1, 1, 1}}}};
  static constexpr std::array<std::uint32_t, kCount> kRanks{2, 3, 5, 4, 1};
  PackedScene packed;

  Solids() {
    Scene scene;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      Material m;
      m.metallic = 0;
      m.transmission = kSolids[i].transmission;
      m.solid = true;
      m.ior = kSolids[i].ior;
      m.dispersion = kSolids[i].dispersion;
      m.attenuation_color = kSolids[i].attenuation;
      m.attenuation_distance = 1;
      m.medium_priority = kSolids[i].priority;
      scene.materials.push_back(m);
    }
    scene.materials.emplace_back();  // no solid
    for (std::uint32_t i = 0; i <= kCount; ++i) {
      Primitive p;
      p.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
      p.indices = {0, 1, 2};
      p.material = i;
      scene.meshes.push_back({"", {p}});
      scene.nodes.emplace_back().mesh = i;
    }
    const Settings settings;
    const Features features(scene, settings);
    EXPECT_TRUE(features.has(Feature::nested_media));
    packed = pack_in_world(scene, features, settings);
  }

  [[nodiscard]] Probe probe() const {
    const std::size_t triangles = packed.triangles.size();
    Probe probe("material");
    probe.define("EK_HAS_nested_media", "1")
        .buffer("triangles", packed.triangles)
        .buffer("triangle_normals", std::vector<TriangleNormals>(triangles))
        .buffer("triangle_tangents", std::vector<TriangleTangents>(triangles))
        .buffer("triangle_colors", std::vector<TriangleColors>(triangles))
        .buffer("materials", packed.materials)
        .buffer("material_extensions", packed.material_extensions)
        .buffer("material_details", packed.material_details)
        .buffer("textures", std::vector<TextureRecord>(1))
        .buffer("texels", Words(256));
    return probe;
  }
};

TEST(NestedMedia, ranks_go_by_priority_and_then_by_place_in_the_file) {
  const Solids solids;
  for (std::uint32_t i = 0; i < Solids::kCount; ++i) {
    EXPECT_EQ(solids.packed.material_extensions[i].medium_rank, Solids::kRanks[i]);
    EXPECT_EQ(solids.packed.material_extensions[Solids::kRanks[i] - 1].medium_of_rank, i);
  }
  EXPECT_EQ(solids.packed.material_extensions[Solids::kCount].medium_rank, 0U);
}

TEST(NestedMedia, a_boundary_shows_where_the_highest_solid_changes_with_the_indices_of_both) {
  const Solids solids;
  std::vector<Words> in(3);
  std::vector<List> lists;
  std::mt19937 random(2);
  for (int i = 0; i < 4000; ++i) {
    List list;
    for (std::uint32_t left = below(random, 5); left > 0; --left) list = with(list, 1 + below(random, Solids::kCount));
    lists.push_back(list);
    in[0].push_back(word_of(list));
    in[1].push_back(below(random, Solids::kCount + 1));
    in[2].push_back(below(random, 2));
  }
  const auto out = solids.probe().run("probe_media_meet", in, 12);
  const auto solid_of = [](std::uint32_t rank) {
    return Solids::kSolids[std::size_t(std::ranges::find(Solids::kRanks, rank) - Solids::kRanks.begin())];
  };
  const auto index_of = [&](const List& list) { return list.empty() ? 1.0 : double(solid_of(list.front()).ior); };
  int shown = 0, hidden = 0, dispersing = 0;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    const List& list = lists[i];
    const std::uint32_t material = in[1][i];
    const bool front = in[2][i] != 0, solid = material < Solids::kCount;
    const List beyond = !solid  ? list
                        : front ? with(list, Solids::kRanks[material])
                                : without(list, Solids::kRanks[material]);
    const std::uint32_t here_rank = list.empty() ? 0 : list.front(), beyond_rank = beyond.empty() ? 0 : beyond.front();
    EXPECT_EQ(out[0][i], word_of(beyond));
    EXPECT_EQ(out[1][i], solid && here_rank == beyond_rank ? 1U : 0U);
    const double here = index_of(list), there = index_of(beyond);
    EXPECT_NEAR(as_float(out[8][i]), here == 0 ? 1 : here * here, 1e-6);
    const glm::vec3 kept = list.empty() ? glm::vec3(1) : solid_of(list.front()).attenuation;
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(as_float(out[9 + std::size_t(k)][i]), std::log2(double(kept[k])), 1e-6);
    if (!solid) continue;
    if (out[1][i] == 1) {
      ++hidden;
      EXPECT_EQ(as_float(out[6][i]), 0);
      EXPECT_EQ(as_float(out[7][i]), 0);
      continue;
    }
    ++shown;
    if (here != 0 && there != 0) {
      EXPECT_NEAR(as_float(out[2][i]), there / here, 1e-6);
    } else {
      const float eta = as_float(out[2][i]);
      EXPECT_TRUE(!(eta > 0x1p-27F && eta < 0x1p27F)) << eta;  // stands for a mirror
    }
    // Of the share that is no glass: ((n1 - n2) / (n1 + n2))^2, from either side.
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(as_float(out[3 + k][i]), std::pow((there - here) / (there + here), 2), 1e-6);
    const auto spread_of = [&](std::uint32_t rank) { return rank == Solids::kRanks[3] ? 0.025 * (1.62 - 1) : 0.0; };
    EXPECT_NEAR(as_float(out[front ? 6 : 7][i]), spread_of(beyond_rank), 1e-7);
    EXPECT_NEAR(as_float(out[front ? 7 : 6][i]), spread_of(here_rank), 1e-7);
    dispersing += spread_of(beyond_rank) + spread_of(here_rank) > 0;
  }
  EXPECT_GT(std::min({shown, hidden, dispersing}), 200);
}

}  // namespace
}  // namespace eikon::test
