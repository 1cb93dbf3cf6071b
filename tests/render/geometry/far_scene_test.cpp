// SPDX-License-Identifier: Apache-2.0
// A scene far from the origin is packed around an origin of its own (host/pack/origin.h): where its
// coordinates lose nothing on the way there, its picture has the bits of the near one.
#include "pack/origin.h"
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

// Half a million metres, and a whole number of steps of any grid that is used here.
const glm::dvec3 kAway(0x1p18, -0x1p19, 0x1p17);

PunctualLight bulb_at(const glm::dvec3& position) {
  PunctualLight bulb;
  bulb.kind = LightKind::point;
  bulb.intensity = glm::vec3(0.5F);
  bulb.position = position;
  return bulb;
}

TEST(FarScenes, have_the_bits_of_near_ones) {
  auto [near, settings] = room(32, 24, 16);
  near.lights = {bulb_at({0.2, 0.5, 0.3})};
  settings.aovs = {"position", "depth"};
  const Scene far = seen_from_origin(near, -kAway);
  const Settings far_settings = seen_from_origin(settings, -kAway);
  ASSERT_EQ(origin_of(near), glm::dvec3(0));
  ASSERT_EQ(origin_of(far), kAway);
  const Film here = film_of(near, settings), there = film_of(far, far_settings);
  for (std::uint32_t y = 0; y < 24; ++y)
    for (std::uint32_t x = 0; x < 32; ++x)
      for (std::uint32_t c = 0; c < 3; ++c) ASSERT_EQ(here.mean(x, y, c), there.mean(x, y, c)) << x << "," << y;
}

TEST(FarScenes, with_motion_have_the_bits_of_near_ones) {
  SceneChoice choice;
  choice.animation.shutter = {.open_s = 0.25, .close_s = 0.75};
  const Scene near = load_scene(std::string(EIKON_SOURCE_DIR) + "/scenes/spinning_wheel.gltf", choice);
  ASSERT_TRUE(near.moves_surfaces);
  const Settings settings = settings_of(near, 32, 16);
  const Scene far = seen_from_origin(near, -kAway);
  EXPECT_TRUE(same_film(film_of(near, settings), film_of(far, seen_from_origin(settings, -kAway))));
}

TEST(FarScenes, say_where_their_surfaces_are_in_the_world) {
  auto [near, settings] = room(16, 12, 4);
  settings.aovs = {"position"};
  const Film film = film_of(seen_from_origin(near, -kAway), seen_from_origin(settings, -kAway));
  const std::vector<std::string>& names = film.layout().channels;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const auto found = std::ranges::find(names, std::string("position.") + "XYZ"[c]);
    ASSERT_NE(found, names.end());
    EXPECT_NEAR(film.mean(8, 6, std::uint32_t(found - names.begin())), kAway[int(c)], 2) << c;
  }
}

TEST(FarScenes, trace_single_paths_in_the_world_without_rounding) {
  const auto [near, settings] = room(16, 12, 4);
  const auto vertices_of = [](const Scene& scene, const Settings& seen) {
    std::vector<PathVertex> vertices;
    (void)replay_path(scene, seen, Execution{}, {8, 6, 1}, [&](const PathVertex& v) { vertices.push_back(v); });
    return vertices;
  };
  const std::vector<PathVertex> here = vertices_of(near, settings);
  const std::vector<PathVertex> there = vertices_of(seen_from_origin(near, -kAway), seen_from_origin(settings, -kAway));
  ASSERT_GT(here.size(), 1U);
  ASSERT_EQ(here.size(), there.size());
  for (std::size_t i = 0; i < here.size(); ++i) EXPECT_EQ(there[i].origin, here[i].origin + kAway) << i;
}

TEST(FarScenes, begin_on_a_grid_that_small_motions_do_not_leave) {
  auto [near, settings] = room(8, 8, 1);
  EXPECT_EQ(origin_of(seen_from_origin(near, -glm::dvec3(40, 0, 0))), glm::dvec3(0));  // not far for its size
  for (const double way : {0.0, 0.1, -0.2})
    EXPECT_EQ(origin_of(seen_from_origin(near, -(kAway + glm::dvec3(way)))), kAway) << way;
  EXPECT_EQ(origin_of(Scene()), glm::dvec3(0));
}

/// The room, and a single small triangle at `stray`.
Scene room_and_stray(const Scene& room, const glm::dvec3& stray) {
  Scene scene = room;
  Primitive mesh;
  mesh.positions_object = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}};
  mesh.indices = {0, 1, 2};
  add_mesh(scene, "stray", std::move(mesh), lambert(0.5F)).world_from_object[3] = glm::dvec4(stray, 1);
  return scene;
}

TEST(FarScenes, stay_far_when_something_small_is_elsewhere) {
  auto [near, settings] = room(32, 24, 16);
  near.cameras = {settings.camera};
  const Scene far = seen_from_origin(near, -kAway);
  for (const glm::dvec3& stray : {glm::dvec3(0), 2.0 * kAway, -10.0 * kAway})
    EXPECT_EQ(origin_of(room_and_stray(far, stray)), kAway) << stray.x;
  EXPECT_EQ(origin_of(room_and_stray(near, kAway)), glm::dvec3(0)) << "the room is where it should be";
  Scene seen_from_elsewhere = room_and_stray(far, glm::dvec3(0));
  seen_from_elsewhere.cameras = {settings.camera};
  EXPECT_EQ(origin_of(seen_from_elsewhere), glm::dvec3(0));
  Scene halves = far;  // two rooms of the same size
  for (const Node& node : near.nodes) halves.nodes.push_back(node);
  EXPECT_EQ(origin_of(halves), glm::dvec3(0));

  // One mesh with the weight of all, and few strays beside it, on either side of the origin.
  for (const double sign : {1.0, -1.0})
    for (const int strays : {1, 2, 5}) {
      Scene city;
      add_mesh(city, "city", sphere({0, 0, 0}, 1, 32, false), lambert(0.5F)).world_from_object[3] =
          glm::dvec4(sign * kAway, 1);
      for (int i = 0; i < strays; ++i) city = room_and_stray(city, glm::dvec3(100.0 * i, 0, -3.0 * i));
      EXPECT_NE(origin_of(city), glm::dvec3(0)) << sign << ", " << strays;
    }

  const MeanAndError here = mean_of(film_of(near, settings));
  const MeanAndError there = mean_of(film_of(room_and_stray(far, glm::dvec3(0)), seen_from_origin(settings, -kAway)));
  EXPECT_NEAR(there.mean, here.mean, 0.02 * here.mean);
}

}  // namespace
}  // namespace eikon::test
