// SPDX-License-Identifier: Apache-2.0
// KHR_animation_pointer: properties of materials, lights, cameras and nodes over time.
#include "support/animation_builder.h"

namespace {

using eikon::Scene;
using scene_test::add_channel;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::leaves_out;
using scene_test::load_at;
using scene_test::pointer_to;
using scene_test::target_of;
using scene_test::warns;

Builder requiring_pointers() {
  Builder builder;
  builder.json["extensionsUsed"].push_back("KHR_animation_pointer");
  builder.json["extensionsRequired"] = {"KHR_animation_pointer"};
  return builder;
}

TEST(AnimationPointer, factors_of_materials_follow_their_keys) {
  Builder builder = requiring_pointers();
  builder.material()["extensions"]["KHR_materials_clearcoat"] = Json::object();
  add_channel(builder, 0, pointer_to("/materials/0/pbrMetallicRoughness/baseColorFactor"),
              {.times = {0, 1}, .values = {0, 0, 0, 0, 1, 0.5F, 0.25F, 1}, .type = "VEC4"});
  add_channel(builder, 0, pointer_to("/materials/0/pbrMetallicRoughness/roughnessFactor"),
              {.times = {0, 1}, .values = {0, 1}, .type = "SCALAR"});
  add_channel(builder, 0, pointer_to("/materials/0/emissiveFactor"),
              {.times = {0, 1}, .values = {0, 0, 0, 0.5F, 1, 1}, .interpolation = "STEP"});
  add_channel(builder, 0, pointer_to("/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor"),
              {.times = {0, 1}, .values = {0, 0.5F}, .type = "SCALAR"});
  const Scene scene = load_at(builder, 0.5);
  const eikon::Material& material = scene.materials.at(0);
  EXPECT_EQ(material.base_color, glm::vec3(0.5F, 0.25F, 0.125F));
  EXPECT_EQ(material.roughness, 0.5F);
  EXPECT_EQ(material.emission, glm::vec3(0));
  EXPECT_EQ(material.clearcoat, 0.25F);
  EXPECT_EQ(load_at(builder, 1).materials.at(0).emission, glm::vec3(0.5F, 1, 1));
  EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty());
}

TEST(AnimationPointer, texture_transforms_move_the_texture) {
  Builder builder = requiring_pointers();
  builder.primitive()["attributes"]["TEXCOORD_0"] =
      builder.add("VEC2", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1}, 3);
  builder.json["images"] = {
      {{"uri",
        "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAA"
        "AABJRU5ErkJggg=="}}};
  builder.json["textures"] = {{{"source", 0}}};
  builder.material()["pbrMetallicRoughness"]["baseColorTexture"] = {
      {"index", 0}, {"extensions", {{"KHR_texture_transform", Json::object()}}}};
  const std::string place = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/";
  add_channel(builder, 0, pointer_to((place + "offset").c_str()),
              {.times = {0, 2}, .values = {0, 0, 1, 0.5F}, .type = "VEC2"});
  add_channel(builder, 0, pointer_to((place + "scale").c_str()),
              {.times = {0, 2}, .values = {1, 1, 3, 5}, .type = "VEC2"});
  const Scene scene = load_at(builder, 1);
  const auto& rows = scene.materials.at(0).base_color_texture->image_from_uv;
  EXPECT_EQ(rows[0], glm::vec3(2, 0, 0.5F));
  EXPECT_EQ(rows[1], glm::vec3(0, 3, 0.25F));
}

TEST(AnimationPointer, lights_and_cameras_change) {
  Builder builder = requiring_pointers();
  builder.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.01}}}}};
  builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"spot", Json::object()}}};
  builder.json["nodes"].push_back({{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  builder.json["scenes"][0]["nodes"].push_back(1);
  add_channel(builder, 0, pointer_to("/cameras/0/perspective/yfov"),
              {.times = {0, 1}, .values = {0.5F, 1}, .type = "SCALAR"});
  add_channel(builder, 0, pointer_to("/extensions/KHR_lights_punctual/lights/0/intensity"),
              {.times = {0, 1}, .values = {0, 8}, .type = "SCALAR"});
  add_channel(builder, 0, pointer_to("/extensions/KHR_lights_punctual/lights/0/color"),
              {.times = {0, 1}, .values = {1, 1, 1, 0.5F, 1, 1}});
  add_channel(builder, 0, pointer_to("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle"),
              {.times = {0, 1}, .values = {0.25F, 0.75F}, .type = "SCALAR"});
  const Scene scene = load_at(builder, 0.5);
  EXPECT_EQ(scene.cameras.at(0).yfov_rad, 0.75);
  EXPECT_EQ(scene.lights.at(0).intensity, glm::vec3(3, 4, 4));
  EXPECT_EQ(scene.lights.at(0).outer_cone_rad, 0.5);
}

TEST(AnimationPointer, numbers_that_a_camera_cannot_have_are_brought_into_their_range) {
  Builder builder = requiring_pointers();
  builder.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.01}}}}};
  builder.node()["camera"] = 0;
  add_channel(builder, 0, pointer_to("/cameras/0/perspective/yfov"),
              {.times = {0, 1}, .values = {-1, 9}, .type = "SCALAR"});
  for (const double time : {0.0, 1.0}) {
    const Scene scene = load_at(builder, time);
    EXPECT_GT(scene.cameras.at(0).yfov_rad, 0);
    EXPECT_LT(scene.cameras.at(0).yfov_rad, 3.1416);
    EXPECT_TRUE(warns(scene, "'/cameras/0/perspective/yfov' brought into its range"));
  }
}

TEST(AnimationPointer, a_picture_that_becomes_a_line_is_refused) {
  Builder builder = requiring_pointers();
  builder.json["cameras"] = {{{"name", "plan"},
                              {"type", "orthographic"},
                              {"orthographic", {{"xmag", 2}, {"ymag", 1}, {"znear", 0.1}, {"zfar", 9}}}}};
  builder.node()["camera"] = 0;
  add_channel(builder, 0, pointer_to("/cameras/0/orthographic/xmag"),
              {.times = {0, 1}, .values = {3, 3e7F}, .type = "SCALAR"});
  EXPECT_EQ(load_at(builder, 0).cameras.at(0).aspect, 3);
  const std::string message = scene_test::message_of([&] { (void)load_at(builder, 1); });
  EXPECT_TRUE(contains(message, "camera 'plan', orthographic: its picture of aspect 3e+07 is a line"));
}

TEST(AnimationPointer, nodes_can_be_hidden_and_moved) {
  Builder builder = requiring_pointers();
  builder.node()["extensions"]["KHR_node_visibility"] = {{"visible", true}};
  const std::size_t times = builder.add("SCALAR", kFloat, std::vector<float>{0, 1}, 2),
                    visible = builder.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{1, 0}, 2);
  add_channel(builder, 0, pointer_to("/nodes/0/extensions/KHR_node_visibility/visible"), times, visible, "STEP");
  add_channel(builder, 0, pointer_to("/nodes/0/translation"), {.times = {0, 1}, .values = {0, 0, 0, 2, 0, 0}});
  EXPECT_EQ(load_at(builder, 0.5).nodes.at(0).world_from_object[3].x, 1);
  EXPECT_TRUE(load_at(builder, 1).nodes.empty());
  builder.json["animations"][0]["samplers"][0]["interpolation"] = "LINEAR";
  EXPECT_TRUE(
      contains(scene_test::message_of([&] { load_at(builder, {.animation = "0", .time_s = 0, .loop = false}); }),
               "has to be STEP"));
}

TEST(AnimationPointer, weights_of_a_mesh_count_for_nodes_without_their_own) {
  Builder builder = requiring_pointers();
  const std::size_t up = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  builder.primitive()["targets"] = {{{"POSITION", up}}};
  builder.json["meshes"][0]["weights"] = {0.0};
  add_channel(builder, 0, pointer_to("/meshes/0/weights"), {.times = {0, 1}, .values = {0, 4}, .type = "SCALAR"});
  EXPECT_EQ(load_at(builder, 0.5).meshes.at(0).primitives.at(0).positions_object[0].z, 2);
}

TEST(AnimationPointer, one_weight_moves_and_the_others_stay) {
  Builder builder = requiring_pointers();
  const std::size_t up = builder.add("VEC3", kFloat, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, 3),
                    aside = builder.add("VEC3", kFloat, std::vector<float>{1, 0, 0, 1, 0, 0, 1, 0, 0}, 3);
  builder.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}}};
  const auto corner = [](const Builder& of) {
    return load_at(of, 0.5).meshes.at(0).primitives.at(0).positions_object[0];
  };
  const glm::vec3 rest = load_at(builder, 0).meshes.at(0).primitives.at(0).positions_object[0];
  const scene_test::Keys keys{.times = {0, 1}, .values = {0, 4}, .type = "SCALAR"};
  for (const char* pointer : {"/nodes/0/weights/1", "/meshes/0/weights/1"}) {
    Builder moved = builder;
    add_channel(moved, 0, pointer_to(pointer), keys);
    EXPECT_EQ(corner(moved), rest + glm::vec3(2, 0, 0)) << pointer << ", neither has weights";
    moved.json["meshes"][0]["weights"] = {3.0, 7.0};
    EXPECT_EQ(corner(moved), rest + glm::vec3(2, 0, 3)) << pointer << ", the mesh has some";
    if (pointer[1] == 'm') continue;
    moved.node()["weights"] = {5.0, 7.0};
    EXPECT_EQ(corner(moved), rest + glm::vec3(2, 0, 5)) << pointer << ", the node has some";
  }
  Builder wrong = builder;
  add_channel(wrong, 0, pointer_to("/nodes/0/weights/2"), keys);
  EXPECT_TRUE(warns(load_at(wrong, 0), "'/nodes/0/weights/2' leads to nothing: there are 2 morph targets"));
}

TEST(AnimationPointer, the_same_place_by_a_pointer_and_a_path_is_the_same_target) {
  Builder builder = requiring_pointers();
  add_channel(builder, 0, target_of(0, "translation"), {.times = {0, 1}, .values = {1, 0, 0, 1, 0, 0}});
  add_channel(builder, 1, pointer_to("/nodes/0/translation"), {.times = {0, 1}, .values = {2, 0, 0, 2, 0, 0}});
  const Scene scene = load_at(builder, 0);
  EXPECT_EQ(scene.nodes.at(0).world_from_object[3].x, 1);
  EXPECT_TRUE(warns(scene, "animation 1: left out, as animation 0 moves the same"));
}

TEST(AnimationPointer, pointers_to_what_is_not_read_or_not_there_are_said) {
  Builder builder = requiring_pointers();
  const scene_test::Keys keys{.times = {0, 1}, .values = {2, 2}, .type = "SCALAR"};
  for (const char* pointer : {"/materials/0/occlusionTexture/strength", "/cameras/0/perspective/znear", "", "materials",
                              "/materials/0/extras/pulse", "/nodes/0/translation/0", "/asset/version"}) {
    builder.json.erase("animations");
    add_channel(builder, 0, pointer_to(pointer), keys);
    const Scene scene = load_at(builder, 0);
    EXPECT_TRUE(leaves_out(scene, "animation of '" + std::string(pointer) + "'", "animation 0")) << pointer;
    EXPECT_TRUE(scene.out_of_range.empty()) << pointer;
  }
  for (const char* pointer :
       {"/materials/7/alphaCutoff", "/materials/x/alphaCutoff", "/materials/-1/alphaCutoff",
        "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/rotation",
        "/materials/0/extensions/KHR_materials_ior/ior", "/cameras/0/perspective/yfov",
        "/extensions/KHR_lights_punctual/lights/0/intensity", "/materials/0/normalTexture/scale"}) {
    builder.json.erase("animations");
    add_channel(builder, 0, pointer_to(pointer), keys);
    const Scene scene = load_at(builder, 0);
    ASSERT_EQ(scene.out_of_range.size(), 1U) << pointer;
    EXPECT_TRUE(contains(scene.out_of_range[0], "leads to nothing"));
  }
}

}  // namespace
