// SPDX-License-Identifier: Apache-2.0
// Cameras of files, what they see, and which scenes are dark without an environment.
#include "pack/frame.h"
#include "support/gltf_builder.h"

namespace eikon {
namespace {

using scene_test::Builder;
using scene_test::Json;

Builder with_camera(double xmag, double ymag) {
  Builder builder;
  builder.json["cameras"] = {{{"name", "flat"},
                              {"type", "orthographic"},
                              {"orthographic", {{"xmag", xmag}, {"ymag", ymag}, {"znear", 0.1}, {"zfar", 9}}}}};
  builder.json["nodes"].push_back({{"camera", 0}, {"translation", {1, 2, 3}}});
  builder.json["scenes"][0]["nodes"] = {0, 1};
  return builder;
}

TEST(Camera, orthographic_ones_keep_their_magnification) {
  const Scene scene = with_camera(3, 2).load();
  ASSERT_EQ(scene.cameras.size(), 1U);
  EXPECT_TRUE(scene.unsupported.empty());
  EXPECT_EQ(scene.cameras[0].projection, Projection::orthographic);
  EXPECT_EQ(scene.cameras[0].ymag_m, 2);
  EXPECT_EQ(scene.cameras[0].aspect, 1.5);
  const Scene mirrored = with_camera(-3, 2).load();
  EXPECT_EQ(mirrored.cameras.at(0).aspect, 1.5);
  EXPECT_EQ(mirrored.warnings.size(), 1U);
  EXPECT_THROW(static_cast<void>(with_camera(3, 0).load()), InputError);
  EXPECT_THROW(static_cast<void>(with_camera(1e300, 1e-300).load()), InputError);
}

// The corners of the film of a 4 x 2 picture, 6 m wide, looking along -x from far away.
TEST(Camera, orthographic_rays_begin_just_before_the_scene_however_far_the_camera_is) {
  PackedScene packed;
  packed.bounds = {glm::dvec3(-1, -2, -3), glm::dvec3(1, 2, 3)};
  Settings settings;
  settings.width = 4;
  settings.height = 2;
  settings.camera = look_at_camera({1e5, 0, 0}, {0, 0, 0}, {0, 1, 0}, 1);
  settings.camera.projection = Projection::orthographic;
  settings.camera.ymag_m = 1.5;
  const Frame frame = pack_frame(packed, settings);
  EXPECT_EQ(frame.camera_corner.x, -1);
  EXPECT_EQ(frame.camera_corner.y, 0);
  EXPECT_EQ(frame.camera_corner.z, 0);
  EXPECT_GT(frame.camera_origin.x, 1);
  EXPECT_LT(frame.camera_origin.x, 2);
  EXPECT_EQ(double(frame.camera_origin.x) + double(frame.camera_origin.w), 1e5);
  EXPECT_FLOAT_EQ(frame.camera_origin.y, 1.5F);
  EXPECT_FLOAT_EQ(frame.camera_origin.z, 3);  // the viewer's left
  EXPECT_FLOAT_EQ(frame.camera_x.z, -1.5F);
  EXPECT_FLOAT_EQ(frame.camera_y.y, -1.5F);
  // From within the scene rays begin at the camera: what is behind it stays unseen.
  settings.camera = look_at_camera({0.5, 0, 0}, {0, 0, 0}, {0, 1, 0}, 1);
  settings.camera.projection = Projection::orthographic;
  EXPECT_EQ(pack_frame(packed, settings).camera_origin.x, 0.5F);
  EXPECT_EQ(pack_frame(packed, settings).camera_origin.w, 0);
}

Builder with_lens(const Json& lens) {
  Builder builder;
  builder.json["cameras"] = {{{"type", "perspective"},
                              {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}},
                              {"extensions", {{"EIKON_camera_lens", lens}}}}};
  builder.json["nodes"].push_back({{"camera", 0}, {"name", "seat"}});
  builder.json["scenes"][0]["nodes"] = {0, 1};
  return builder;
}

TEST(Camera, lenses_of_files_open_by_radius_or_by_f_number) {
  const Scene scene = with_lens({{"radius", 0.25}, {"focusDistance", 3}}).load();
  ASSERT_TRUE(scene.cameras.at(0).lens);
  EXPECT_EQ(lens_radius_m(scene.cameras[0]), 0.25);
  EXPECT_EQ(scene.cameras[0].lens->focus_distance_m, 3);
  EXPECT_EQ(scene.cameras[0].name, "seat");
  EXPECT_TRUE(scene.unsupported.empty());
  const Scene stop = with_lens({{"fNumber", 2}, {"sensorHeight", 0.012}, {"focusDistance", 3}}).load();
  EXPECT_NEAR(lens_radius_m(stop.cameras.at(0)), 0.006 / std::tan(0.25) / 4, 1e-15);
}

TEST(Camera, a_lens_that_makes_no_sense_is_refused) {
  for (const Json& lens : std::vector<Json>{{{"radius", 0.1}},
                                            {{"focusDistance", 1}},
                                            {{"radius", 0.1}, {"fNumber", 2}, {"focusDistance", 1}},
                                            {{"radius", -0.1}, {"focusDistance", 1}},
                                            {{"radius", 0.1}, {"focusDistance", 0}},
                                            {{"radius", "wide"}, {"focusDistance", 1}},
                                            {{"radius", 1e300}, {"focusDistance", 1}},
                                            {{"fNumber", 2}, {"sensorHeight", 0}, {"focusDistance", 1}},
                                            Json::array()}) {
    try {
      static_cast<void>(with_lens(lens).load());
      ADD_FAILURE() << lens.dump();
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("EIKON_camera_lens"), std::string::npos) << error.what();
    }
  }
}

TEST(Camera, panoramas_have_no_lens) {
  Builder builder = with_lens({{"radius", 0.25}, {"focusDistance", 3}});
  builder.json["cameras"][0]["extensions"]["EIKON_camera_panorama"] = Json::object();
  builder.json["cameras"][0]["extensions"]["VENDOR_filters"] = Json::object();
  const Scene scene = builder.load();
  EXPECT_EQ(scene.cameras.at(0).projection, Projection::panorama);
  EXPECT_EQ(scene.cameras[0].aspect, 2);
  EXPECT_FALSE(scene.cameras[0].lens);
  EXPECT_EQ(scene.warnings.size(), 1U);
  ASSERT_EQ(scene.unsupported.size(), 1U);
  EXPECT_EQ(scene.unsupported[0].feature, "VENDOR_filters");
}

TEST(Environment, is_needed_where_nothing_else_gives_light) {
  Scene scene;
  EXPECT_TRUE(needs_environment(scene));
  scene.materials.resize(2);
  scene.meshes.push_back({"m", {Primitive{}}});
  scene.nodes.emplace_back();
  EXPECT_TRUE(needs_environment(scene));
  scene.materials[1].emission = glm::vec3(1);  // nobody shows it
  EXPECT_TRUE(needs_environment(scene));
  scene.materials[0].unlit = true;
  EXPECT_FALSE(needs_environment(scene));
  scene.meshes[0].primitives.emplace_back().material = 1;
  EXPECT_FALSE(needs_environment(scene));
  scene.materials[1].emission = glm::vec3(0);
  EXPECT_TRUE(needs_environment(scene)) << "only some of what is shown is unlit";
  scene.lights.emplace_back();
  EXPECT_TRUE(needs_environment(scene)) << "a light of no intensity";
  scene.lights[0].intensity = glm::vec3(0, 0, 1);
  EXPECT_FALSE(needs_environment(scene));
}

}  // namespace
}  // namespace eikon
