// SPDX-License-Identifier: Apache-2.0
// Paths that hit surfaces of one class are shaded together: on chunks they wait until there are
// enough of them, and devices with queues have a stage for each class. None is lost, and the bits
// do not tell which went together.

#include "pack/features.h"
#include "pack/materials/material_traits.h"
#include "render/scene_builder.h"
#include "wavefront/config.h"

namespace eikon::test {
namespace {

Primitive one_triangle() {
  Primitive primitive;
  primitive.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  primitive.indices = {0, 1, 2};
  return primitive;
}

Material flat_lambert() {
  Material material;
  material.metallic = 0;
  material.specular = 0;
  return material;
}

TEST(ShadingClass, flat_lambert_is_what_is_flat_and_exactly_lambert) {
  const Primitive flat = one_triangle();
  EXPECT_EQ(shading_class(flat_lambert(), &flat), SHADING_FLAT_LAMBERT);
  EXPECT_EQ(shading_class(flat_lambert(), nullptr), SHADING_FLAT_LAMBERT) << "a shape";
  Primitive round = flat, colored = flat, brushed = flat;
  round.normals_object.assign(3, {0, 0, 1});
  colored.colors.assign(3, glm::vec4(1));
  brushed.tangents_object.assign(3, {1, 0, 0, 1});
  for (const Primitive* primitive : {&round, &colored, &brushed})
    EXPECT_EQ(shading_class(flat_lambert(), primitive), SHADING_OPAQUE);
}

TEST(ShadingClass, is_by_what_the_material_takes) {
  const Primitive flat = one_triangle();
  Material shiny = flat_lambert(), coated = flat_lambert(), velvet = flat_lambert(), textured = flat_lambert(),
           glass = flat_lambert();
  shiny.specular = 1;
  coated.clearcoat = 1;
  velvet.sheen_color = glm::vec3(1);
  textured.base_color_texture.emplace();
  glass.transmission = 1;
  for (const Material* material : {&shiny, &coated, &velvet, &textured})
    EXPECT_EQ(shading_class(*material, &flat), SHADING_OPAQUE);
  EXPECT_EQ(shading_class(glass, &flat), SHADING_TRANSMISSIVE);
  EXPECT_EQ(shading_class(glass, nullptr), SHADING_TRANSMISSIVE);
}

TEST(ShadingClass, a_box_with_a_mirror_and_glass_has_all) {
  const Scene scene = load_shipped("cornell_spheres.gltf");
  const Features features(scene, settings_of(scene, 8, 1));
  for (const Feature each : {Feature::flat_lambert_hits, Feature::opaque_hits, Feature::transmissive_hits})
    EXPECT_TRUE(features.has(each)) << int(each);
  const Scene box = load_shipped("cornell.gltf");
  const Features of_box(box, settings_of(box, 8, 1));
  EXPECT_TRUE(of_box.has(Feature::flat_lambert_hits));
  EXPECT_FALSE(of_box.has(Feature::opaque_hits) || of_box.has(Feature::transmissive_hits));
}

/// The stages of a device that launches each stage, of a scene that is shipped.
std::vector<std::string> stages_that_shade(const std::string& file) {
  const Scene scene = load_shipped(file);
  WavefrontConfig queues;
  std::vector<std::string> needed;
  for (const char* stage : {"shade", "sort_hits", "shade_flat_lambert", "shade_opaque", "shade_transmissive"})
    if (needs_stage(queues, Features(scene, settings_of(scene, 8, 1)), stage)) needed.push_back(stage);
  return needed;
}

TEST(ShadingClass, each_class_has_a_stage_on_devices_with_queues_if_there_are_several) {
  using Stages = std::vector<std::string>;
  EXPECT_EQ(stages_that_shade("cornell_spheres.gltf"),
            (Stages{"sort_hits", "shade_flat_lambert", "shade_opaque", "shade_transmissive"}));
  EXPECT_EQ(stages_that_shade("lacquer.gltf"), (Stages{"sort_hits", "shade_flat_lambert", "shade_opaque"}));
  EXPECT_EQ(stages_that_shade("cornell.gltf"), Stages{"shade"});
  EXPECT_EQ(stages_that_shade("textured.gltf"), Stages{"shade"});
}

TEST(ShadingClass, every_hit_is_shaded_once_by_the_stage_of_its_class) {
  const Scene scene = load_shipped("cornell_spheres.gltf");
  const Settings settings = settings_of(scene, 33, 8);
  Execution queues;
  queues.chunked = false, queues.devices = "0";
  const RenderOutput output = output_of(scene, settings, queues);
  const DeviceReport& device = output.report.devices.at(0);
  EXPECT_EQ(device.stages.count("shade"), 0U);
  std::uint64_t hits = 0;
  for (const char* stage : {"shade_flat_lambert", "shade_opaque", "shade_transmissive"}) {
    EXPECT_GT(device.stages.at(stage).items, 0U) << stage;
    EXPECT_EQ(device.stages.at(stage).launches, device.stages.at("compact").launches) << stage;
    hits += device.stages.at(stage).items;
  }
  // Only paths that leave the room by its open side have no hit.
  EXPECT_LT(hits, device.stages.at("intersect").items);
  EXPECT_GT(hits, device.stages.at("intersect").items / 2);
}

TEST(ShadingClass, which_paths_wait_together_shows_in_no_bit) {
  const Scene scene = load_shipped("cornell_spheres.gltf");
  Settings settings = settings_of(scene, 37, 6);  // vectors and chunks with lanes left over
  settings.aovs = {"uv", "normal", "albedo"};
  Execution one_by_one;
  one_by_one.chunked = false;
  const Film expected = film_of(scene, settings, one_by_one);
  struct Chunks {
    std::uint32_t lanes, chunk;
  };
  for (const Chunks chunks : {Chunks{16, 4096}, Chunks{16, 16}, Chunks{16, 48}, Chunks{8, 64}}) {
    Execution execution;
    execution.chunked = true;
    execution.lanes = chunks.lanes;
    execution.chunk = chunks.chunk, execution.unit_paths = 3 * chunks.chunk;
    EXPECT_TRUE(same_film(expected, film_of(scene, settings, execution)))
        << chunks.lanes << " lanes, chunks of " << chunks.chunk;
  }
}

}  // namespace
}  // namespace eikon::test
