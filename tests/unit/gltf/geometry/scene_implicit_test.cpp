// SPDX-License-Identifier: Apache-2.0
// Surfaces by formula, as nodes of a file place them.
#include <string>

#include "scene/limits.h"
#include "support/gltf_builder.h"

namespace {

using eikon::Scene;
using eikon::Shape;
using eikon::ShapeKind;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::message_of;

Json sphere() { return {{"f", "x^2+y^2+z^2-1"}, {"bounds", {-1, -2, -3, 3, 2, 1}}, {"material", 0}}; }

Builder with(const Json& extension, const Json& node = {{"name", "blob"}}) {
  Builder builder;
  builder.json["extensionsRequired"] = {"EIKON_implicit_surface"};
  Json placed = node;
  placed["extensions"]["EIKON_implicit_surface"] = extension;
  builder.json["nodes"].push_back(placed);
  builder.json["scenes"][0]["nodes"] = {0, 1};
  return builder;
}

std::string refusal(const char* member, const Json& value, const Json& node = {{"name", "blob"}}) {
  Json extension = sphere();
  if (value.is_discarded())
    extension.erase(member);
  else
    extension[member] = value;
  return message_of([&] { (void)with(extension, node).load(); });
}

TEST(SceneImplicit, a_surface_arrives_with_its_formula_and_bounds_where_its_node_puts_it) {
  const Scene scene = with(sphere(), {{"name", "blob"}, {"translation", {10, 0, 0}}, {"scale", {2, 3, 4}}}).load();
  EXPECT_TRUE(scene.unsupported.empty());
  ASSERT_EQ(scene.shapes.size(), 1U);
  ASSERT_EQ(scene.formulas.size(), 1U);
  const Shape& shape = scene.shapes[0];
  EXPECT_EQ(shape.kind, ShapeKind::implicit);
  EXPECT_EQ(scene.materials.at(shape.material).name, "paint");
  const eikon::OwnShape own = own_shape(shape);
  EXPECT_EQ(own.center, glm::dvec3(12, 0, -4));
  EXPECT_EQ(own.half, glm::dvec3(4, 6, 8));
}

TEST(SceneImplicit, equal_formulas_are_kept_once) {
  Builder builder = with(sphere());
  Json other = builder.json["nodes"][1];
  builder.json["nodes"].push_back(other);
  other["extensions"]["EIKON_implicit_surface"]["f"] = "x";
  builder.json["nodes"].push_back(other);
  builder.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const Scene scene = builder.load();
  ASSERT_EQ(scene.shapes.size(), 3U);
  EXPECT_EQ(scene.formulas.size(), 2U);
  EXPECT_EQ(scene.shapes[1].formula, scene.shapes[0].formula);
  EXPECT_NE(scene.shapes[2].formula, scene.shapes[0].formula);
}

/// A sum whose constants occur in no other one of these.
std::string long_formula(int of) {
  std::string f = "x";
  for (int i = 0; i < 150; ++i) f += "+y^2*sin(z*" + std::to_string(of * 150 + i) + ".5)";
  return f;
}

TEST(SceneImplicit, all_formulas_together_have_a_largest_number_of_operations) {
  Builder builder = with(sphere());
  const std::size_t of_one = eikon::formula::parse_formula(long_formula(0)).expressions.size(),
                    of_sphere = builder.load().formulas.at(0).expressions.size();
  const std::size_t fits = (eikon::kMaxFormulaNodes - of_sphere) / of_one;
  for (std::size_t i = 0; i < fits + 1; ++i) {
    Json node = builder.json["nodes"][1];
    node["name"] = "long " + std::to_string(i);
    node["extensions"]["EIKON_implicit_surface"]["f"] = long_formula(int(i));
    builder.json["nodes"].push_back(node);
    if (i < fits) builder.json["scenes"][0]["nodes"].push_back(i + 2);
  }
  EXPECT_EQ(builder.load().formulas.size(), fits + 1);
  builder.json["scenes"][0]["nodes"].push_back(fits + 2);
  const std::string message = message_of([&] { (void)builder.load(); });
  EXPECT_TRUE(contains(message, "node 'long " + std::to_string(fits) + "', EIKON_implicit_surface: ") &&
              contains(message, "65536"))
      << message;
}

TEST(SceneImplicit, what_is_wrong_is_said_in_a_line) {
  const Json none(Json::value_t::discarded);
  EXPECT_TRUE(contains(refusal("f", none), "node 'blob', EIKON_implicit_surface: 'f' is missing"));
  EXPECT_TRUE(contains(refusal("f", 3), "'f' is not a string"));
  EXPECT_TRUE(contains(refusal("f", "x + foo"), "f: column 5: unknown name 'foo'; known: x y z pi"));
  EXPECT_TRUE(contains(refusal("f", ""), "f: column 1: expected"));
  EXPECT_TRUE(contains(refusal("f", "3"), "f: does not depend on x, y or z"));
  EXPECT_TRUE(contains(refusal("f", std::string(5000, 'x')), "f: too long: 5000 characters"));
  EXPECT_TRUE(contains(refusal("f", std::string(70, '(') + "x"), "f: column 65: nested more than 64 deep"));
  EXPECT_TRUE(contains(refusal("bounds", none), "'bounds' is missing; six numbers"));
  EXPECT_TRUE(contains(refusal("bounds", {-1, -1, -1, 1, 1}), "'bounds'"));
  EXPECT_TRUE(contains(refusal("bounds", {-1, -1, -1, 1, 1, "1"}), "'bounds'"));
  EXPECT_TRUE(contains(refusal("bounds", {-1, -1, -1, 1, 1, nullptr}), "'bounds'"));  // as JSON has NaN and infinity
  EXPECT_TRUE(contains(refusal("bounds", {-1, 2, -1, 1, 1, 1}), "'bounds' are empty: y from 2 to 1"));
  EXPECT_TRUE(contains(refusal("bounds", {-1, 1, -1, 1, 1, 1}), "'bounds' are empty: y from 1 to 1"));
  EXPECT_TRUE(contains(refusal("bounds", {-1, -1, -1, 1, 1, 1e300}), "'bounds' reach z = 1e+300"));
  EXPECT_TRUE(contains(refusal("bounds", {1e6, -1, -1, 1e6 + 0.1, 1, 1}), "too thin for single precision"));
  EXPECT_TRUE(contains(refusal("material", 1), "'material' names material 1, but there are only 1"));
  EXPECT_TRUE(contains(refusal("material", 0, {{"name", "blob"}, {"translation", {0, 2e12, 0}}}), "beyond 2^40 m"));
}

}  // namespace
