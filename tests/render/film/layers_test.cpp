// SPDX-License-Identifier: Apache-2.0
// Layers against known geometry, replay of single paths, and samples that are left out.
#include <fmt/format.h>

#include "film/exr/film_file.h"
#include "image/image.h"
#include "film/layers.h"
#include "render/scene_builder.h"
#include "support/temporary_folder.h"
#include "support/fixed_point.h"

namespace eikon::test {
namespace {

/// A small square of node 0 in front of a large one of node 1 that covers the lower half; nothing
/// above.
std::pair<Scene, Settings> two_squares() {
  Scene scene;
  Primitive front, back;
  add_quad(front, {-0.2F, -0.2F, -2}, {0.4F, 0, 0}, {0, 0.4F, 0});
  add_quad(back, {-9, -9, -4}, {18, 0, 0}, {0, 9, 0});
  add_mesh(scene, "front", std::move(front), lambert({0.2F, 0.4F, 0.6F}));
  add_mesh(scene, "back", std::move(back), lambert({0.7F, 0.5F, 0.3F}));
  Settings settings = settings_for(31, 31, 8);
  settings.camera.yfov_rad = 1.0;
  settings.environment.radiance = glm::vec3(1);
  settings.aovs = {"albedo", "normal", "depth", "id", "variance", "samples"};
  return {std::move(scene), settings};
}

struct Written {
  Image image;
  [[nodiscard]] float at(const std::string& channel, std::uint32_t x, std::uint32_t y) const {
    const std::vector<float>* plane = image.plane(channel);
    if (plane == nullptr) throw std::runtime_error("no channel " + channel);
    return (*plane)[y * image.width + x];
  }
};

Written written(const Film& film, const Settings& settings) {
  const TemporaryFolder folder;
  ExrOptions options;
  options.layers = settings.aovs;
  write_exr(folder / "x.exr", film, {}, options);
  return {read_exr(folder / "x.exr")};
}

TEST(Layers, show_the_first_hit) {
  const auto [scene, settings] = two_squares();
  const Written seen = written(film_of(scene, settings), settings);
  // The middle pixel looks along -z at the small square; (15, 25) down at the large one; (3, 3) at
  // nothing.
  EXPECT_FLOAT_EQ(seen.at("albedo.R", 15, 15), 0.2F);
  EXPECT_FLOAT_EQ(seen.at("albedo.B", 15, 15), 0.6F);
  EXPECT_FLOAT_EQ(seen.at("albedo.G", 15, 25), 0.5F);
  EXPECT_EQ(seen.at("albedo.R", 3, 3), 0);
  EXPECT_EQ(seen.at("normal.Z", 15, 15), 1);
  EXPECT_EQ(seen.at("normal.X", 15, 25), 0);
  EXPECT_EQ(seen.at("normal.Z", 3, 3), 0);
  EXPECT_EQ(seen.at("id", 15, 15), 1);
  EXPECT_EQ(seen.at("id", 15, 25), 2);
  EXPECT_EQ(seen.at("id", 3, 3), 0);
  EXPECT_EQ(seen.at("samples", 3, 3), 8);
  // Along the ray: 2 m in the middle; elsewhere the plane's distance over the cosine, up to the
  // pixel's own extent.
  EXPECT_NEAR(seen.at("depth.Z", 15, 15), 2, 1e-3);
  const double slope = std::tan(0.5) * (25.5 - 15.5) / 15.5;
  EXPECT_NEAR(seen.at("depth.Z", 15, 25), 4 * std::hypot(1, slope), 0.02);
  EXPECT_TRUE(std::isinf(seen.at("depth.Z", 3, 3)));
  EXPECT_GT(seen.at("depth.Z", 3, 3), 0);
  EXPECT_EQ(seen.at("variance.R", 3, 3), 0);
}

TEST(Layers, depth_is_the_mean_over_the_samples_that_hit) {
  auto [scene, settings] = two_squares();
  scene.nodes.pop_back();  // only the small square: its edge pixels see it with some samples
  const Film film = film_of(scene, settings);
  const std::uint32_t hits = film.channel_index("hits").value();
  const Written seen = written(film, settings);
  int edges = 0;
  for (std::uint32_t y = 0; y < 31; ++y)
    for (std::uint32_t x = 0; x < 31; ++x) {
      const double hit = to_double(film.total(x, y, hits));
      edges += hit > 0 && hit < 8 ? 1 : 0;
      if (hit > 0)
        EXPECT_NEAR(seen.at("depth.Z", x, y), 2, 0.03) << x << "," << y;
      else
        EXPECT_TRUE(std::isinf(seen.at("depth.Z", x, y)));
    }
  EXPECT_GT(edges, 4);
}

TEST(Layers, of_places_beyond_the_film_take_no_light_from_the_picture) {
  Scene scene;
  Primitive wall;
  add_quad(wall, {-0x1p39F, -0x1p39F, -0x1p39F}, {0x1p40F, 0, 0}, {0, 0x1p40F, 0});
  add_mesh(scene, "wall", std::move(wall), lambert(0.5F));
  Settings settings = settings_for(8, 8, 4);
  settings.camera = look_at_camera({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.5);
  settings.environment.radiance = glm::vec3(1);
  const Film plain = film_of(scene, settings);
  EXPECT_GT(mean_of(plain).mean, 0.1);
  settings.aovs = {"depth", "position"};
  const Film film = film_of(scene, settings);
  for (std::uint32_t c = 0; c < 3; ++c) EXPECT_EQ(mean_of(film, c).mean, mean_of(plain, c).mean);
  EXPECT_NEAR(film.mean(4, 4, film.channel_index("depth.Z").value()), 0x1p38, 0x1p15);
  EXPECT_NEAR(film.mean(4, 4, film.channel_index("position.Z").value()), -0x1p38, 0x1p15);
}

TEST(Layers, know_the_point_its_place_in_the_texture_the_flat_normal_and_the_material) {
  Scene scene;
  Primitive tilted;
  add_quad(tilted, {-1, -1, -3}, {2, 0, 0}, {0, 2, -1});
  tilted.normals_object.assign(4, glm::vec3(0, 0, 1));  // as if it stood upright
  tilted.uv[0] = {{2, 5}, {4, 5}, {4, 8}, {2, 8}};
  add_mesh(scene, "unseen", Primitive{tilted}, lambert(0.1F));
  scene.nodes.back().world_from_object[3].z = 50;  // behind the camera
  add_mesh(scene, "tilted", std::move(tilted), lambert(0.5F));
  Settings settings = settings_for(21, 21, 16);
  settings.camera.yfov_rad = 0.9;
  settings.aovs = {"position", "uv", "normal", "geometric_normal", "material_id"};
  const Written seen = written(film_of(scene, settings), settings);
  const double half = std::tan(0.45);
  for (const auto& [x, y] : {std::pair{10U, 10U}, {7U, 12U}, {12U, 6U}}) {
    // The ray (dx, dy, -1) t meets the plane z = -3 - (y + 1) / 2.
    const double dx = ((x + 0.5) / 10.5 - 1) * half, dy = (1 - (y + 0.5) / 10.5) * half;
    const double t = 3.5 / (1 - 0.5 * dy);
    const double pixel_m = 2 * half / 21 * t;
    EXPECT_NEAR(seen.at("position.X", x, y), dx * t, 0.2 * pixel_m);
    EXPECT_NEAR(seen.at("position.Y", x, y), dy * t, 0.3 * pixel_m);
    EXPECT_NEAR(seen.at("position.Z", x, y), -t, 0.3 * pixel_m);
    EXPECT_NEAR(seen.at("uv.U", x, y), 2 + (dx * t + 1), 0.2 * pixel_m);
    EXPECT_NEAR(seen.at("uv.V", x, y), 5 + 1.5 * (dy * t + 1), 0.5 * pixel_m);
    EXPECT_FLOAT_EQ(seen.at("geometric_normal.Y", x, y), 1 / std::sqrt(5.0F));
    EXPECT_FLOAT_EQ(seen.at("geometric_normal.Z", x, y), 2 / std::sqrt(5.0F));
    EXPECT_EQ(seen.at("normal.Z", x, y), 1);
    EXPECT_EQ(seen.at("material_id", x, y), 2);
  }
  EXPECT_EQ(seen.at("material_id", 0, 0), 0);
  EXPECT_TRUE(std::isinf(seen.at("position.X", 0, 0)));
  EXPECT_TRUE(std::isinf(seen.at("uv.V", 0, 0)));
}

TEST(Layers, emission_direct_and_indirect_light_are_the_picture) {
  auto [scene, settings] = room(24, 24, 16);
  settings.aovs = {"emission", "direct", "indirect"};
  const Film film = film_of(scene, settings);
  Settings alone = settings;
  alone.aovs.clear();
  const Film plain = film_of(scene, alone);
  const Written seen = written(film, settings);
  const auto limited = [&, &scene = scene](std::uint32_t edges) {
    alone.max_depth = edges;
    return written(film_of(scene, alone), alone);
  };
  const Written one = limited(1), two = limited(2);
  double indirect = 0;
  for (std::uint32_t y = 0; y < 24; ++y)
    for (std::uint32_t x = 0; x < 24; ++x)
      for (std::uint32_t c = 0; c < 3; ++c) {
        const auto of = [&](const char* layer) { return seen.at(fmt::format("{}.{}", layer, "RGB"[c]), x, y); };
        // The same samples, whether their light is summed apart or not.
        ASSERT_EQ(film.total(x, y, c), plain.total(x, y, c));
        const float all = seen.at(std::string(1, "RGB"[c]), x, y);
        EXPECT_NEAR(of("emission") + of("direct") + of("indirect"), all, 1e-6F * (1 + all));
        // A path of one edge is not scattered. Of two edges: its last vertex samples no light, but
        // emits.
        EXPECT_EQ(of("emission"), one.at(std::string(1, "RGB"[c]), x, y));
        EXPECT_GE(of("indirect"), 0);
        indirect += of("indirect");
      }
  EXPECT_GT(indirect, 0);
  // With both weights of the power heuristic direct light has its two halves: light's by shadow
  // rays, and by the second edge.
  for (std::uint32_t i = 0; i < 24 * 24; ++i) {
    const std::uint32_t x = i % 24, y = i / 24;
    EXPECT_NEAR(seen.at("emission.G", x, y) + seen.at("direct.G", x, y), two.at("G", x, y),
                1e-5F * (1 + two.at("G", x, y)));
  }
}

TEST(DepthSeries, has_the_bits_of_renders_that_end_there_up_to_rounding_and_brightens) {
  auto [scene, settings] = room(24, 24, 16);
  settings.depth_series = {0, 1, 2, 4, 8};
  const Film film = film_of(scene, settings);
  double before = -1;
  for (const std::uint32_t most : settings.depth_series) {
    const Film partial = scattered_at_most(film, most);
    ASSERT_EQ(partial.layout().channels, (std::vector<std::string>{"R", "G", "B"}));
    Settings limited = settings;
    limited.depth_series.clear();
    limited.max_depth = most + 1;
    const Film ended = film_of(scene, limited);
    double mean = 0;
    for (std::uint32_t y = 0; y < 24; ++y)
      for (std::uint32_t x = 0; x < 24; ++x) {
        EXPECT_EQ(partial.samples(x, y), film.samples(x, y));
        EXPECT_NEAR(partial.mean(x, y, 0), ended.mean(x, y, 0), 1e-5 * (1 + ended.mean(x, y, 0))) << most;
        mean += partial.mean(x, y, 0) / (24 * 24);
      }
    EXPECT_GT(mean, before);
    before = mean;
    EXPECT_TRUE(partial.predicted_error().known);
  }
}

/// The room with its lamp in one group, a glowing ball in another, a bulb in a third and the sky in
/// a fourth.
std::pair<Scene, Settings> grouped() {
  auto [scene, settings] = room(16, 16, 64);
  scene.light_groups = {"rest", "lamp", "ball", "bulb", "sky"};
  for (Node& node : scene.nodes) {
    if (node.name == "lamp") node.light_group = 1;
    if (node.name != "ball") continue;
    Material& glowing = scene.materials[scene.meshes[node.mesh].primitives[0].material];
    glowing.emission = {0.2F, 0.5F, 1};
    glowing.light_group = 2;
  }
  PunctualLight bulb;
  bulb.position = {-0.5, 0.6, 0.5};
  bulb.intensity = glm::vec3(0.4F, 0.3F, 0.2F);
  bulb.light_group = 3;
  scene.lights.push_back(bulb);
  scene.environment_light_group = 4;
  settings.aovs = {"light_groups"};
  return {std::move(scene), settings};
}

/// The same scene with the lights of one group alone.
std::pair<Scene, Settings> only_group(std::uint32_t group) {
  auto [scene, settings] = grouped();
  if (group != 1)
    for (const Node& node : scene.nodes)
      if (node.name == "lamp") scene.materials[scene.meshes[node.mesh].primitives[0].material].emission = glm::vec3(0);
  if (group != 2)
    for (Material& material : scene.materials)
      if (material.light_group == 2) material.emission = glm::vec3(0);
  if (group != 3) scene.lights.clear();
  if (group != 4) settings.environment.radiance = glm::vec3(0);
  settings.aovs.clear();
  return {std::move(scene), settings};
}

TEST(LightGroups, without_light_sampling_have_the_bits_of_renders_of_one_group_alone) {
  auto [scene, settings] = grouped();
  settings.light_sampling = LightSampling::bsdf;  // then no path depends on what shines
  const Film film = film_of(scene, settings);
  for (const std::uint32_t group : {1U, 2U, 4U}) {
    auto [alone, with] = only_group(group);
    with.light_sampling = LightSampling::bsdf;
    const Film expected = film_of(alone, with);
    const std::uint32_t channel = film.channel_index("light." + scene.light_groups[group] + ".R").value();
    for (std::uint32_t i = 0; i < 256; ++i)
      for (std::uint32_t c = 0; c < 3; ++c)
        ASSERT_EQ(film.total(i % 16, i / 16, channel + c), expected.total(i % 16, i / 16, c)) << group;
  }
}

TEST(LightGroups, with_light_sampling_are_the_light_of_each_and_together_the_picture) {
  const auto [scene, settings] = grouped();
  const Film all = film_of(scene, settings);
  const Written seen = written(all, settings);
  double lightest = 1e30;
  for (std::uint32_t group = 0; group < 5; ++group) {
    double mean = 0, expected = 0, error2 = 0;
    const auto [alone, with] = only_group(group);
    const Film alone_film = film_of(alone, with);
    const std::uint32_t channel = all.channel_index("light." + scene.light_groups[group] + ".G").value();
    for (std::uint32_t i = 0; i < 256; ++i) {
      const std::uint32_t x = i % 16, y = i / 16;
      mean += all.mean(x, y, channel);
      error2 += all.variance_of_mean(x, y, channel);
      expected += alone_film.mean(x, y, 1);
      error2 += alone_film.variance_of_mean(x, y, 1);
    }
    // Two replicates give each pixel's variance one degree of freedom, all pixels together 256:
    // five deviations are a chance of less than 1e-5 for each group.
    EXPECT_NEAR(mean, expected, 5 * std::sqrt(error2)) << scene.light_groups[group];
    if (group != 0) lightest = std::min(lightest, mean);
  }
  EXPECT_GT(lightest, 1);
  for (std::uint32_t i = 0; i < 256; ++i) {
    float sum = 0;
    for (const std::string& group : scene.light_groups) sum += seen.at("light." + group + ".B", i % 16, i / 16);
    const float blue = seen.at("B", i % 16, i / 16);
    EXPECT_NEAR(sum, blue, 1e-5F * (1 + blue));
  }
}

TEST(Replay, of_a_sample_is_what_the_film_has_of_it) {
  const auto [scene, base] = room(20, 14, 8);
  for (const bool chunked : {true, false})
    for (const auto& [x, y, sample] : {std::tuple{0U, 0U, 0U}, {19U, 13U, 5U}, {7U, 9U, 3U}, {10U, 12U, 6U}}) {
      Settings settings = base;
      Execution execution;
      execution.chunked = chunked;
      std::vector<PathVertex> vertices;
      const auto keep = [&](const PathVertex& v) { vertices.push_back(v); };
      const glm::vec3 radiance = replay_path(scene, settings, execution, {x, y, sample}, keep).radiance;
      settings.crop = {x, y, x + 1, y + 1};
      settings.sample_begin = sample;
      settings.sample_end = sample + 1;
      const Film film = film_of(scene, settings, execution);
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(to_fixed(radiance[c]), film.total(x, y, static_cast<std::uint32_t>(c)))
            << x << "," << y << " sample " << sample;
      ASSERT_FALSE(vertices.empty());
      EXPECT_EQ(vertices[0].depth, 1U);
      EXPECT_EQ(glm::vec3(vertices[0].origin), glm::vec3(glm::dvec3(settings.camera.world_from_camera[3])));
      EXPECT_EQ(vertices[0].beta, glm::vec3(1));
      for (std::size_t i = 1; i < vertices.size(); ++i) {
        EXPECT_EQ(vertices[i].depth, i + 1);
        const glm::dvec3 before = vertices[i - 1].origin + double(vertices[i - 1].t) * glm::dvec3(vertices[i - 1].dir);
        EXPECT_LT(glm::length(before - vertices[i].origin), 1e-5) << "edge " << i;
      }
    }
}

/// The square light, `emission` bright, found by scattered rays alone: few samples meet it.
std::pair<Scene, Settings> glaring(float emission, float albedo_of_lamp) {
  Scene scene = square_light();
  scene.materials[1] = lambert(albedo_of_lamp, emission);
  scene.meshes[0].primitives[0].positions_object = {{-3, 0, 3}, {3, 0, 3}, {3, 0, -3}, {-3, 0, -3}};
  scene.materials[0] = lambert(0.9F);
  Settings settings = settings_for(8, 8, 64);
  settings.camera = look_at_camera({1.5, 1.5, 3}, {1.2, 0, 0}, {0, 1, 0}, 0.4);
  settings.light_sampling = LightSampling::bsdf;
  settings.environment.radiance = glm::vec3(1);
  return {std::move(scene), settings};
}

void expect_left_out(const std::pair<Scene, Settings>& made, bool finite) {
  const auto& [scene, settings] = made;
  const RenderOutput output = output_of(scene, settings);
  const RenderReport& report = output.report;
  const std::uint64_t rejected = report.nonfinite + report.saturated;
  EXPECT_GT(finite ? report.saturated : report.nonfinite, 0U);
  EXPECT_LT(rejected, report.samples / 2);
  std::uint64_t counted = 0;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const double mean = output.film.mean(i % 8, i / 8, 0);
    ASSERT_TRUE(std::isfinite(mean));
    EXPECT_GT(mean, 0.1);
    EXPECT_LT(mean, 1.01);
    counted += output.film.samples(i % 8, i / 8);
  }
  EXPECT_EQ(counted + rejected, report.samples);
  EXPECT_EQ(report.samples, 64U * 64U);
  ASSERT_FALSE(report.rejected.empty());
  for (const PixelSample& sample : report.rejected) {
    const glm::vec3 radiance = replay_path(scene, settings, {}, sample, [](const PathVertex&) {}).radiance;
    EXPECT_FALSE(fits_film(radiance.x) && fits_film(radiance.y) && fits_film(radiance.z))
        << sample.x << "," << sample.y << " sample " << sample.sample;
  }
}

TEST(Rejected, N12_samples_beyond_the_film_are_counted_named_and_left_out) { expect_left_out(glaring(1e25F, 0), true); }

TEST(Rejected, N12_samples_that_are_not_finite_are_counted_named_and_left_out) {
  expect_left_out(glaring(3.4e38F, 0.9F), false);
}

TEST(Rejected, N12_a_sample_left_out_leaves_the_others_as_they_are) {
  const auto [scene, settings] = glaring(1e25F, 0);
  auto dark = scene;
  dark.materials[1] = lambert(0);
  const RenderOutput bright = output_of(scene, settings);
  Settings replicate = settings;
  // Where a replicate of a pixel lost nothing it has the bits of the scene without the glare.
  const Film expected = film_of(dark, replicate);
  int same = 0;
  for (std::uint32_t i = 0; i < 64; ++i)
    for (std::uint32_t r = 0; r < 2; ++r) {
      if (bright.film.count(i % 8, i / 8, r) != 32) continue;
      EXPECT_EQ(bright.film.sum(i % 8, i / 8, r, 0), expected.sum(i % 8, i / 8, r, 0));
      ++same;
    }
  EXPECT_GT(same, 4);
}

TEST(Stop, leaves_whole_units_and_says_so) {
  const auto [scene, settings] = room(64, 64, 64);
  Execution execution;
  execution.unit_paths = 4096;  // 64 units
  std::atomic<bool> stop{true};
  const RenderOutput output = render(scene, settings, as_tested(execution), stop);
  EXPECT_TRUE(output.report.interrupted());
  EXPECT_EQ(output.report.samples, 0U);
  EXPECT_EQ(output.film.samples(0, 0), 0U);
}

}  // namespace
}  // namespace eikon::test
