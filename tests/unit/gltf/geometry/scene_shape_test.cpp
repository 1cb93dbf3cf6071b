// SPDX-License-Identifier: Apache-2.0
// Shapes of a file, as nodes place them.
#include <cmath>

#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using eikon::Shape;
using eikon::ShapeKind;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::message_of;
using scene_test::warns;

/// A document with one shape under a node of its own, beside the triangle.
Builder with_shape(const Json& extension, const Json& node = {{"name", "ball"}}) {
  Builder builder;
  builder.json["extensionsRequired"] = {"EIKON_shape"};
  Json placed = node;
  placed["extensions"]["EIKON_shape"] = extension;
  builder.json["nodes"].push_back(placed);
  builder.json["scenes"][0]["nodes"] = {0, 1};
  return builder;
}

std::string refusal(const Json& extension, const Json& node = {{"name", "ball"}}) {
  return message_of([&] { (void)with_shape(extension, node).load(); });
}

Json sphere(const Json& radius) {
  return {{"shape", {{"type", "sphere"}, {"sphere", {{"radius", radius}}}}}, {"material", 0}};
}

TEST(SceneShapes, a_sphere_arrives_where_its_node_puts_it) {
  const Scene scene =
      with_shape(sphere(0.25), {{"name", "ball"}, {"translation", {1, 2, 3}}, {"scale", {2, 3, -4}}}).load();
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(scene.unsupported.empty());
  ASSERT_EQ(scene.shapes.size(), 1U);
  const Shape& shape = scene.shapes[0];
  EXPECT_EQ(shape.name, "ball");
  EXPECT_EQ(shape.kind, ShapeKind::sphere);
  EXPECT_EQ(scene.materials.at(shape.material).name, "paint");
  const eikon::OwnShape own = own_shape(shape);
  EXPECT_EQ(own.center, glm::dvec3(1, 2, 3));
  EXPECT_EQ(own.half, glm::dvec3(0.5, 0.75, 1));
  const eikon::Bounds bounds = world_bounds(scene);
  EXPECT_EQ(bounds.hi, glm::dvec3(1.5, 2.75, 4));
}

TEST(SceneShapes, each_kind_has_the_sizes_of_the_draft) {
  const auto half = [](const Json& shape) {
    const Scene scene = with_shape({{"shape", shape}}, {{"name", "one"}, {"scale", {1, 2, 1}}}).load();
    EXPECT_TRUE(scene.warnings.empty());
    return own_shape(scene.shapes.at(0)).half;
  };
  EXPECT_EQ(half({{"type", "box"}}), glm::dvec3(0.5, 1, 0.5));
  EXPECT_EQ(half({{"type", "box"}, {"box", {{"size", {2, 3, 4}}}}}), glm::dvec3(1, 3, 2));
  EXPECT_EQ(half({{"type", "plane"}, {"plane", {{"sizeX", 3}, {"sizeZ", 1}}}}), glm::dvec3(1.5, 0, 0.5));
  EXPECT_EQ(half({{"type", "plane"}, {"plane", {{"sizeX", 3}}}}), glm::dvec3(1.5, 0, 0x1p42));
  EXPECT_EQ(half({{"type", "plane"}}), glm::dvec3(0x1p42, 0, 0x1p42));
  EXPECT_EQ(half({{"type", "cylinder"}, {"cylinder", {{"height", 3}, {"radiusTop", 0}}}}), glm::dvec3(0.25, 3, 0.25));
  EXPECT_EQ(half({{"type", "capsule"}, {"capsule", {{"height", 3}}}}), glm::dvec3(0.25, 3.5, 0.25));
  EXPECT_TRUE(contains(refusal({{"shape", {{"type", "box"}, {"box", {{"size", {1, 2}}}}}}}), "size"));
  EXPECT_TRUE(contains(refusal({{"shape", {{"type", "box"}, {"box", {{"size", {1, 2, -3}}}}}}}), "'size' -3"));
}

TEST(SceneShapes, a_document_may_list_shapes) {
  Builder builder = with_shape({{"shape", 1}});
  builder.json["extensions"]["KHR_implicit_shapes"]["shapes"] = {{{"type", "sphere"}},
                                                                 {{"type", "sphere"}, {"sphere", {{"radius", 7}}}}};
  const Scene scene = builder.load();
  EXPECT_EQ(scene.shapes.at(0).size[0], 7);
  EXPECT_TRUE(scene.unsupported.empty());
  builder.json["nodes"][1]["extensions"]["EIKON_shape"]["shape"] = 0;
  EXPECT_EQ(builder.load().shapes.at(0).size[0], 0.5);  // the draft's own
  builder.json["nodes"][1]["extensions"]["EIKON_shape"]["shape"] = 2;
  EXPECT_TRUE(contains(message_of([&] { (void)builder.load(); }), "'shape' names shape 2, but there are only 2"));
}

TEST(SceneShapes, what_is_wrong_is_said_in_a_line) {
  EXPECT_TRUE(contains(refusal(Json::object()), "node 'ball', EIKON_shape: 'shape' is missing"));
  EXPECT_TRUE(contains(refusal({{"shape", Json::object()}}), "'type' is missing; there are sphere"));
  EXPECT_TRUE(contains(refusal({{"shape", {{"type", "teapot"}}}}), "'type' 'teapot' is unknown; there are sphere"));
  EXPECT_TRUE(contains(refusal({{"shape", {{"type", 3}}}}), "'type' is not a string"));
  EXPECT_TRUE(contains(refusal({{"shape", "sphere"}}), "'shape'"));
  EXPECT_TRUE(contains(refusal({{"shape", 0}}), "'shape' names shape 0, but there are only 0"));
  EXPECT_TRUE(contains(refusal({{"shape", {{"type", "sphere"}, {"sphere", 1}}}}), "'sphere' is not an object"));
  for (const double radius : {0.0, -1.0, 1e300, 1e-300})
    EXPECT_TRUE(contains(refusal(sphere(radius)), "is not a size in metres")) << radius;
  EXPECT_TRUE(contains(refusal(sphere("1")), "'radius' is not a number"));
  EXPECT_TRUE(contains(refusal(sphere(nullptr)), "'radius' is not a number"));  // as JSON has NaN
  Json wrong = sphere(1);
  wrong["material"] = 1;
  EXPECT_TRUE(contains(refusal(wrong), "'material' names material 1, but there are only 1"));
  EXPECT_TRUE(contains(refusal(sphere(1), {{"name", "ball"}, {"translation", {0, 2e12, 0}}}), "beyond 2^40 m"));
  Builder list = with_shape({{"shape", 0}});
  list.json["extensions"]["KHR_implicit_shapes"]["shapes"] = {7};
  EXPECT_TRUE(contains(message_of([&] { (void)list.load(); }), "is not an object"));
}

TEST(SceneShapes, one_that_is_scaled_to_nothing_is_left_out_with_a_note) {
  for (const Json& scale : {Json{0, 1, 1}, Json{1e-200, 1, 1}}) {
    const Scene scene = with_shape(sphere(1), {{"name", "ball"}, {"scale", scale}}).load();
    EXPECT_TRUE(scene.shapes.empty());
    EXPECT_TRUE(warns(scene, "node 'ball'"));
  }
}

TEST(SceneShapes, without_a_material_it_has_the_default_one) {
  const Scene scene = with_shape({{"shape", {{"type", "sphere"}}}}).load();
  EXPECT_EQ(scene.materials.at(scene.shapes.at(0).material).name, "default");
}

}  // namespace
