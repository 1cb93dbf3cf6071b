// SPDX-License-Identifier: Apache-2.0
// A sample is a pure function of (scene, settings, pixel, sample index), and sums are exact:
// however the work is cut, ordered or executed, the film has the same bits.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

constexpr std::uint32_t kWidth = 41, kHeight = 27;  // no multiple of a lane width or block
constexpr std::uint64_t kSpp = 12;

std::pair<Scene, Settings> subject() {
  auto made = room(kWidth, kHeight, kSpp);
  made.second.aovs = {"albedo", "normal", "depth", "id"};
  return made;
}

Film part_of(const Scene& scene, Settings settings, Crop crop, std::uint64_t begin, std::uint64_t end) {
  settings.crop = crop;
  settings.sample_begin = begin;
  settings.sample_end = end;
  return film_of(scene, settings);
}

TEST(SameBits, N6_twice_on_every_device) {
  const auto [scene, settings] = subject();
  const Film once = film_of(scene, settings);
  for (const DeviceInfo& info : select_devices("all")) {
    Execution execution;
    execution.devices = std::to_string(info.index);
    EXPECT_TRUE(same_film(once, film_of(scene, settings, execution))) << info.name;
    EXPECT_TRUE(same_film(once, film_of(scene, settings, execution))) << info.name;
  }
  Settings other = settings;
  other.seed = 1;
  EXPECT_FALSE(same_film(once, film_of(scene, other))) << "the comparison sees nothing";
}

TEST(SameBits, N5_any_crop_is_the_window_of_the_full_frame) {
  const auto [scene, settings] = subject();
  const Film whole = film_of(scene, settings);
  for (const Crop crop : {Crop{0, 0, 1, 1}, Crop{40, 26, 41, 27}, Crop{7, 3, 20, 16}, Crop{13, 0, 14, 27},
                          Crop{0, 5, 41, 6}, Crop{1, 1, 40, 26}})
    EXPECT_TRUE(same_window(whole, part_of(scene, settings, crop, 0, kSpp))) << crop.x0 << "," << crop.y0;
}

TEST(SameBits, N4_any_split_of_samples_adds_up_in_any_order) {
  const auto [scene, base] = subject();
  Settings settings = base;
  settings.width = 16, settings.height = 8;
  settings.crop = {0, 0, 16, 8};
  const auto samples = [&, &scene = scene](std::uint64_t begin, std::uint64_t end) {
    return part_of(scene, settings, settings.crop, begin, end);
  };
  const auto sum = [&](std::initializer_list<const Film*> parts) {
    Film film((*parts.begin())->layout());
    for (const Film* part : parts) film.add(*part);
    return film;
  };
  const Film whole = samples(0, 128), lower = samples(0, 64), upper = samples(64, 128);
  EXPECT_TRUE(same_film(whole, sum({&lower, &upper})));
  const Film a = samples(0, 17), b = samples(17, 100), c = samples(100, 128);
  EXPECT_TRUE(same_film(whole, sum({&c, &a, &b})));
  EXPECT_TRUE(same_film(whole, sum({&b, &c, &a})));
  EXPECT_FALSE(same_film(whole, sum({&lower, &lower}))) << "the comparison sees nothing";
}

TEST(SameBits, N3_samples_beyond_32_bits_are_new_ones_and_split_as_others_do) {
  const auto [scene, base] = subject();
  Settings settings = base;
  settings.width = 16, settings.height = 8;
  const Crop all{0, 0, 16, 8};
  constexpr std::uint64_t edge = std::uint64_t{1} << 32;
  const Film whole = part_of(scene, settings, all, edge - 7, edge + 10);
  Film parts = part_of(scene, settings, all, edge + 3, edge + 10);
  parts.add(part_of(scene, settings, all, edge - 7, edge + 3));
  EXPECT_TRUE(same_film(whole, parts));
  EXPECT_FALSE(same_film(part_of(scene, settings, all, edge, edge + 16), part_of(scene, settings, all, 0, 16)));
}

TEST(SameBits, N5_any_unit_chunk_and_block_on_chunks) {
  const auto [scene, settings] = subject();
  const Film expected = film_of(scene, settings);
  struct Cut {
    std::uint32_t unit_paths, chunk, block;
  };
  for (const Cut cut :
       {Cut{1024, 1024, 64}, Cut{64, 16, 5}, Cut{1U << 20, 1024, 64}, Cut{4096, 1024, 1}, Cut{3000, 48, 17}}) {
    Execution execution;
    execution.chunked = true;
    execution.unit_paths = cut.unit_paths, execution.chunk = cut.chunk, execution.block = cut.block;
    EXPECT_TRUE(same_film(expected, film_of(scene, settings, execution)))
        << "paths of a unit " << cut.unit_paths << " chunk " << cut.chunk << " block " << cut.block;
  }
}

TEST(SameBits, N5_any_unit_and_block_on_queues) {
  const auto [scene, settings] = subject();
  const Film expected = film_of(scene, settings);
  struct Cut {
    std::uint32_t unit_paths, block;
  };
  for (const Cut cut : {Cut{1U << 10, 64}, Cut{1U << 20, 64}, Cut{64, 3}, Cut{1U << 14, 13}}) {
    Execution execution;
    execution.chunked = false;
    execution.unit_paths = cut.unit_paths, execution.block = cut.block;
    EXPECT_TRUE(same_film(expected, film_of(scene, settings, execution)))
        << "paths of a unit " << cut.unit_paths << " block " << cut.block;
  }
}

TEST(SameBits, any_number_of_build_threads) {
  const auto [scene, settings] = subject();
  const Film expected = film_of(scene, settings);
  for (unsigned threads : {1U, 2U, 4U}) {
    Execution execution;
    execution.threads = threads;
    EXPECT_TRUE(same_film(expected, film_of(scene, settings, execution))) << threads << " threads";
  }
}

TEST(SameBits, any_lane_width_order_of_paths_and_tree) {
  const auto [scene, settings] = subject();
  Execution shipped;
  shipped.extra_flags = kAsShipped;
  const Film expected = film_of(scene, settings, shipped);
  for (const Execution& execution : ways_to_trace())
    EXPECT_TRUE(same_film(expected, film_of(scene, settings, execution))) << describe(execution);
}

// Between them: every lobe, most lights, opacity, absorption, textures, all layers, and every way
// to find light.
struct Variant {
  const char* scene;
  std::function<void(Settings&)> change;
};
const std::vector<Variant>& variants() {
  static const std::vector<Variant> all = {
      {"alpha.gltf",
       [](Settings& s) {
         s.aovs = {"albedo", "normal", "depth", "id"};
       }},
      {"textured.gltf", [](Settings& s) { s.transparent = true; }},
      {"ior_row.gltf", [](Settings& s) { s.max_depth = 3; }},
      {"rough_glass.gltf", [](Settings& s) { s.filter = parse_filter("mitchell"); }},
      {"cornell_spheres.gltf", [](Settings& s) { s.light_sampling = LightSampling::light; }},
      {"cornell.gltf", [](Settings& s) { s.light_sampling = LightSampling::hemisphere, s.roulette_depth = 1; }},
      {"window_room.gltf", [](Settings& s) { s.light_sampling = LightSampling::bsdf; }},
      {"sun_room.gltf", [](Settings& s) { s.camera.projection = Projection::orthographic; }},
  };
  return all;
}

TEST(SameBits, all_stages_in_one_launch_as_shipped_or_each_in_its_own_and_out_of_line_with_every_feature) {
  for (const Variant& variant : variants()) {
    const Scene scene = load_shipped(variant.scene);
    Settings settings = settings_of(scene, 27, 6);
    variant.change(settings);
    Execution fused, unfused;
    fused.chunked = unfused.chunked = true;
    fused.fused = true, unfused.fused = false;
    fused.extra_flags = kAsShipped;
    fused.unit_paths = 1200, fused.chunk = 400;  // portions of unequal size
    EXPECT_TRUE(same_film(film_of(scene, settings, unfused), film_of(scene, settings, fused))) << variant.scene;
  }
}

TEST(SameBits, kernels_without_optimisation) {
  const auto [scene, settings] = subject();
  Execution shipped, execution;
  shipped.extra_flags = kAsShipped;
  execution.optimise = false;
  EXPECT_TRUE(same_film(film_of(scene, settings, shipped), film_of(scene, settings, execution)));
}

TEST(SameBits, G9_scene_times_a_power_of_two) {
  auto original = subject();
  original.second.aovs = {"albedo", "normal", "id"};  // depth is in metres
  const Film expected = film_of(original.first, original.second);
  for (int k : {-20, -7, 5, 20}) {
    const auto [scene, settings] = times(original, std::ldexp(1.0, k));
    EXPECT_TRUE(same_film(expected, film_of(scene, settings))) << "2^" << k;
  }
}

TEST(SameBits, layers_do_not_change_the_picture) {
  const auto [scene, settings] = subject();
  Settings plain = settings;
  plain.aovs.clear();
  const Film with = film_of(scene, settings), without = film_of(scene, plain);
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x)
      for (std::uint32_t c = 0; c < 3; ++c) ASSERT_EQ(with.total(x, y, c), without.total(x, y, c)) << x << "," << y;
}

TEST(SameBits, G14_of_coincident_triangles_the_first_wins_everywhere) {
  const Scene scene = load_shipped("coincident.gltf");
  const Settings settings = settings_of(scene, 32, 4);
  std::vector<std::string> layouts = tree_layouts();
  layouts.emplace_back("none");
  for (const std::string& layout : layouts) {
    Execution execution;
    execution.accel = layout == "none" ? "none" : "bvh";
    execution.layout = layout;
    const Film film = film_of(scene, settings, execution);
    double red = 0;
    for (std::uint32_t y = 0; y < 32; ++y)
      for (std::uint32_t x = 0; x < 32; ++x) {
        red += film.mean(x, y, 0);
        ASSERT_EQ(film.total(x, y, 1), 0) << layout << " pixel " << x << "," << y;
      }
    EXPECT_GT(red, 100) << layout;
  }
}

TEST(SameBits, G17_a_mirrored_node_is_the_mirrored_mesh) {
  const auto original = room(kWidth, kHeight, kSpp);
  const glm::dmat4 mirror = glm::scale(glm::dmat4(1), {-1.0, 1.0, 1.0});
  auto by_node = original, baked = original;
  for (Node& node : by_node.first.nodes) node.world_from_object = mirror * node.world_from_object, node.mirrored = true;
  for (Node& node : baked.first.nodes) {
    for (Primitive& primitive : baked.first.meshes[node.mesh].primitives) {
      for (glm::vec3& p : primitive.positions_object) p = glm::vec3(mirror * node.world_from_object * glm::dvec4(p, 1));
      const glm::dmat3 to_world = glm::transpose(glm::inverse(glm::dmat3(mirror * node.world_from_object)));
      for (glm::vec3& n : primitive.normals_object) n = glm::vec3(glm::normalize(to_world * glm::dvec3(n)));
      std::vector<std::uint32_t> turned = primitive.indices.list();
      for (std::size_t i = 0; i < turned.size(); i += 3) std::swap(turned[i + 1], turned[i + 2]);
      primitive.indices = turned;
    }
    node.world_from_object = glm::dmat4(1);
  }
  const Film film = film_of(by_node.first, by_node.second);
  EXPECT_TRUE(same_film(film, film_of(baked.first, baked.second)));
  EXPECT_GT(mean_of(film).mean, 0.1);
}

}  // namespace
}  // namespace eikon::test
