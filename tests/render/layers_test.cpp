// SPDX-License-Identifier: Apache-2.0
// Layers against known geometry, replay of single paths, and samples that are left out.
#include "image/image.h"
#include "render/scene_builder.h"
#include "unit/temporary_folder.h"

namespace eikon::testing {
namespace {

/// A small square of node 0 in front of a large one of node 1 that covers the lower half; nothing above.
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
  // The middle pixel looks along -z at the small square; (15, 25) down at the large one; (3, 3) at nothing.
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
  // Along the ray: 2 m in the middle; elsewhere the plane's distance over the cosine, up to the pixel's own extent.
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
  const std::uint32_t hits = film.channel_index("depth.hits").value();
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

TEST(Replay, of_a_sample_is_what_the_film_has_of_it) {
  const auto [scene, base] = room(20, 14, 8);
  for (const bool chunked : {true, false})
    for (const auto& [x, y, sample] : {std::tuple{0U, 0U, 0U}, {19U, 13U, 5U}, {7U, 9U, 3U}, {10U, 12U, 6U}}) {
      Settings settings = base;
      Execution execution;
      execution.chunked = chunked;
      std::vector<PathVertex> vertices;
      const glm::vec3 radiance =
          replay_path(scene, settings, execution, x, y, sample, [&](const PathVertex& v) { vertices.push_back(v); });
      settings.crop = {x, y, x + 1, y + 1};
      settings.sample_begin = sample;
      settings.sample_end = sample + 1;
      const Film film = film_of(scene, settings, execution);
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(to_fixed(radiance[c]), film.total(x, y, static_cast<std::uint32_t>(c)))
            << x << "," << y << " sample " << sample;
      ASSERT_FALSE(vertices.empty());
      EXPECT_EQ(vertices[0].depth, 1U);
      EXPECT_EQ(vertices[0].origin, glm::vec3(glm::dvec3(settings.camera.world_from_camera[3])));
      EXPECT_EQ(vertices[0].beta, glm::vec3(1));
      for (std::size_t i = 1; i < vertices.size(); ++i) {
        EXPECT_EQ(vertices[i].depth, i + 1);
        const glm::vec3 before = vertices[i - 1].origin + vertices[i - 1].t * vertices[i - 1].dir;
        EXPECT_LT(glm::length(before - vertices[i].origin), 1e-5F) << "edge " << i;
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
  settings.light_sampling = LightSampling::cosine;
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
  for (const RejectedSample& sample : report.rejected) {
    const glm::vec3 radiance =
        replay_path(scene, settings, {}, sample.x, sample.y, sample.sample, [](const PathVertex&) {});
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
  execution.pool = 4096;  // 64 units
  std::atomic<bool> stop{true};
  const RenderOutput output = render(scene, settings, execution, stop);
  EXPECT_TRUE(output.report.interrupted);
  EXPECT_EQ(output.report.samples, 0U);
  EXPECT_EQ(output.film.samples(0, 0), 0U);
}

}  // namespace
}  // namespace eikon::testing
