// SPDX-License-Identifier: Apache-2.0
// The log of a pilot's paths tells of all the light that they bring: where surfaces are grey, so
// that luminances may be multiplied, what it says adds up to what each path brought to its pixel.
#include "render/lights/light_path_scenes.h"
#include "render/pilot/pilot_picture.h"

namespace eikon::test {
namespace {

/// Surfaces become grey; lamps and skies may have colours.
void make_grey(Scene& scene) {
  for (Material& m : scene.materials) m.base_color = glm::vec3(m.base_color.x);
}

/// The luminance that a path brought by what its log says.
double logged(const PathLog& log, std::size_t path) {
  double sum = 0, throughput = 1;
  for (std::uint32_t v = 0; v < EK_LOG_DEPTHS; ++v) {
    const std::uint32_t info = log.word(path, v, LOG_info);
    if ((info & (LOG_HIT | LOG_MISS)) == 0) break;
    sum += throughput * double(log.number(path, v, LOG_emitted));
    if ((info & LOG_MISS) != 0) break;
    sum += throughput * double(log.number(path, v, LOG_sampled));
    if ((info & LOG_CONTINUES) == 0) break;
    throughput *= double(log.number(path, v, LOG_weight));
  }
  return sum;
}

/// Checks each path of an unguided pilot. returns how many of them brought light
std::size_t expect_that_logs_add_up(const Scene& scene, Settings settings) {
  settings.max_depth = EK_LOG_DEPTHS;
  settings.guide = std::make_shared<const GuideTable>(make_guide_table({}, 1));
  Features features(scene, settings);
  features.set_guiding(false, true);
  auto packed = std::make_shared<PackedScene>(pack_scene(scene, features, settings));
  Execution execution = as_tested({});
  execution.layout = "bvh8", execution.lanes = 8, execution.chunked = true;
  add_accel(*packed, "bvh", "bvh8", 1);
  DevicePool::Lease device = open_devices->pool.take(open_devices->pool.select(execution.devices, 0, nullptr).front());
  PilotSteps steps;
  PilotPicture picture({device, packed, features, execution, steps}, settings, 1U << 14);
  picture.wavefront().trace_light_paths(false);
  std::size_t lit = 0;
  picture.render(0, settings.sample_end, true, [&](const PilotUnit& unit) {
    const PathLog& log = unit.log;
    for (std::size_t path = 0; path < log.paths; ++path) {
      const auto channel = [&](std::size_t c) {
        return double(std::bit_cast<float>(log.radiance[c * log.stride + path]));
      };
      const double brought = 0.2126 * channel(0) + 0.7152 * channel(1) + 0.0722 * channel(2);
      EXPECT_NEAR(logged(log, path), brought, 1e-4 * brought + 1e-7) << "path " << path;
      if (brought > 0) ++lit;
    }
  });
  return lit;
}

/// A closed room with a lamp and an absorbing block in front of it. In another block are a matte
/// ball and a lamp, so that light is emitted, met and sampled at the end of edges through a medium.
std::pair<Scene, Settings> room_of_smoky_glass() {
  Scene scene = closed_room_with_lamp();
  make_grey(scene);
  add_block(scene, "filter", {-0.6F, 0.5F, -0.6F}, {0.6F, 0.8F, 0.6F}, amber(0.2F, 1.5F));
  add_block(scene, "tank", {-0.9F, -0.9F, 0.4F}, {0.9F, 0.4F, 1.4F}, amber(0.1F, 1));
  add_mesh(scene, "ball", sphere({-0.2F, -0.2F, 0.8F}, 0.2F, 6, false, true), lambert(0.5F));
  Primitive lamp;
  add_quad(lamp, {0.1F, 0.1F, 0.7F}, {0.2F, 0, 0}, {0, 0, 0.2F});
  add_mesh(scene, "inner lamp", std::move(lamp), lambert(0.2F, 4));
  scene.materials.back().double_sided = true;
  return {std::move(scene), seen_from_above(16, 32)};
}

TEST(PathLog, adds_up_to_what_paths_bring) {
  auto [scene, settings] = room(16, 16, 32);
  make_grey(scene);
  EXPECT_GT(expect_that_logs_add_up(scene, settings), 4000U);
}

TEST(PathLog, leaves_out_what_media_absorb) {
  const auto [scene, settings] = room_of_smoky_glass();
  EXPECT_GT(expect_that_logs_add_up(scene, settings), 400U);
}

TEST(PathLog, has_the_share_of_a_sky_that_light_paths_leave_to_rough_metal) {
  auto [scene, settings] = floor_in_the_sun(16, 64, 300);
  make_grey(scene);
  for (Material& m : scene.materials)
    if (m.metallic == 1) m.roughness = 0.2F;
  settings = with_light_paths(settings, 1);
  ASSERT_TRUE(Features(scene, settings).has(Feature::light_paths));
  EXPECT_GT(expect_that_logs_add_up(scene, settings), 1000U);
}

}  // namespace
}  // namespace eikon::test
