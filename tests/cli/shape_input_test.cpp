// SPDX-License-Identifier: Apache-2.0
// Shapes that make no sense: one line that names the node and the parameter, exit code 3, nothing
// written.
#include <tuple>

#include "cli/command.h"

namespace eikon::test {
namespace {

std::string with_shape(const std::string& extension) {
  return R"({"asset": {"version": "2.0"}, "extensionsUsed": ["EIKON_shape"], "scene": 0, "scenes": [{"nodes": [0]}],
 "materials": [{}], "nodes": [{"name": "thing", "extensions": {"EIKON_shape": )" +
         extension + "}}]}\n";
}
std::string of(const std::string& type, const std::string& parameters) {
  return R"({"material": 0, "shape": {"type": ")" + type + R"(", ")" + type + R"(": {)" + parameters + "}}}";
}

TEST(ShapeInput, malformed_parameters_are_refused_by_node_and_name) {
  const Workplace here;
  const std::pair<std::string, std::string> cases[] = {
      {of("sphere", R"("radius": -1)"), "'radius' -1"},
      {of("sphere", R"("radius": 0)"), "'radius' 0"},
      {of("sphere", R"("radius": 1e30)"), "'radius' 1e+30"},
      {of("sphere", R"("radius": 1e-40)"), "'radius' 1e-40"},
      {of("sphere", R"("radius": "1")"), "'radius' is not a number"},
      {of("sphere", R"("radius": null)"), "'radius' is not a number"},
      {of("box", R"("size": [1, 2])"), "size"},
      {of("box", R"("size": [1, 0, 1])"), "'size' 0"},
      {of("box", R"("size": [1, -2, 1])"), "'size' -2"},
      {of("box", R"("size": 1)"), "size"},
      {of("plane", R"("sizeX": -1)"), "'sizeX' -1"},
      {of("plane", R"("sizeX": 1, "sizeZ": 1e20)"), "'sizeZ' 1e+20"},
      {of("cylinder", R"("height": 0)"), "'height' 0"},
      {of("cylinder", R"("radiusTop": -0.1)"), "'radiusTop' -0.1"},
      {of("cylinder", R"("radiusTop": 0, "radiusBottom": 0)"), "'radiusTop' and 'radiusBottom' are both 0"},
      {of("capsule", R"("height": -1)"), "'height' -1"},
      {of("capsule", R"("radiusTop": 0, "radiusBottom": 0)"), "'radiusTop' and 'radiusBottom' are both 0"},
      {of("capsule", R"("radiusBottom": 1e300)"), "'radiusBottom' 1e+300"},
      {of("torus", ""), "'type' 'torus' is unknown"},
      {R"({"material": 0, "shape": {}})", "'type' is missing"},
      {R"({"material": 0})", "'shape' is missing"},
      {R"({"material": 7, "shape": {"type": "sphere"}})", "'material' names material 7"},
  };
  for (const auto& [extension, words] : cases) {
    here.write("shape.gltf", with_shape(extension));
    const std::vector<std::string> before = here.files();
    const Outcome outcome = here.eikon("render shape.gltf -o out.exr");
    EXPECT_TRUE(refused(outcome, kInput)) << extension;
    EXPECT_TRUE(contains(outcome.err, "node 'thing'"));
    EXPECT_TRUE(contains(outcome.err, words));
    EXPECT_EQ(here.files(), before);
  }
}

TEST(ShapeInput, numbers_that_are_none_are_no_JSON) {
  const Workplace here;
  for (const char* value : {"NaN", "Infinity", "1e999", "-"}) {
    here.write("shape.gltf", with_shape(of("sphere", std::string("\"radius\": ") + value)));
    EXPECT_TRUE(refused(here.eikon("render shape.gltf -o out.exr"), kInput)) << value;
  }
}

TEST(ShapeInput, a_plane_without_sizes_has_no_end_and_frames_no_camera) {
  const Workplace here;
  here.write("shape.gltf", with_shape(of("plane", R"("sizeX": 2)")));
  const Outcome info = here.eikon("info shape.gltf --strict");
  EXPECT_TRUE(succeeded(info));
  EXPECT_TRUE(contains(info.out, "bounds (-1, 0, -0.5) to (1, 0, 0.5) m"));
  EXPECT_TRUE(succeeded(here.eikon("render shape.gltf -o out.exr --strict --size 8x8 --spp 1")));
}

TEST(ShapeInput, info_says_which_shapes_emit_without_being_lights_to_sample) {
  const Workplace here;
  for (const auto& [type, parameters, said] :
       {std::tuple("plane", "", true), std::tuple("plane", R"("sizeX": 2)", true),
        std::tuple("plane", R"("sizeX": 2, "sizeZ": 1)", false), std::tuple("sphere", "", false)}) {
    std::string scene = with_shape(of(type, parameters));
    const std::string dark = R"("materials": [{}])";
    scene.replace(scene.find(dark), dark.size(), R"("materials": [{"emissiveFactor": [1, 1, 1]}])");
    here.write("shape.gltf", scene);
    const Outcome info = here.eikon("info shape.gltf --strict");
    EXPECT_TRUE(succeeded(info));
    EXPECT_EQ(contains(info.out, "surface 'thing' without end emits, but is no light to sample"), said) << info.out;
  }
}

TEST(ShapeInput, Embree_is_not_compared_with_where_it_would_see_nothing) {
  const Workplace here;
  here.write("shape.gltf", with_shape(of("sphere", R"("radius": 1)")));
  const Outcome outcome = here.eikon("bench rays shape.gltf --versus embree");
  EXPECT_TRUE(refused(outcome, kUsage));
  EXPECT_TRUE(contains(outcome.err, "compares triangles alone"));
}

}  // namespace
}  // namespace eikon::test
