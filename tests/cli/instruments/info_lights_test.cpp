// SPDX-License-Identifier: Apache-2.0
// What `eikon info` says of a scene's lights.
#include <fstream>

#include "cli/command.h"

namespace eikon::test {
namespace {

TEST(InfoLights, each_light_has_its_flux_and_strength_and_815_lumens_all_around_are_64_86_candela) {
  const Workplace here;
  std::ofstream(here / "lights.gltf") << R"({
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_lights_punctual"],
    "extensions": {"KHR_lights_punctual": {"lights": [
      {"name": "bulb", "type": "point", "intensity": 64.86},
      {"name": "beam", "type": "spot", "intensity": 100, "spot": {"innerConeAngle": 0, "outerConeAngle": 0.5}},
      {"name": "sun", "type": "directional", "intensity": 100000}]}},
    "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"extensions": {"KHR_lights_punctual": {"light": 1}}},
              {"extensions": {"KHR_lights_punctual": {"light": 2}}}],
    "scenes": [{"nodes": [0, 1, 2]}], "scene": 0})";
  const Outcome outcome = here.eikon("info lights.gltf");
  ASSERT_TRUE(succeeded(outcome)) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "point           'bulb': 815.0"));
  EXPECT_TRUE(contains(outcome.out, "W (lm), intensity 64.86 W/sr (cd)"));
  // 2 pi 100 (1 - cos 0.5) / 3: the square of a ramp is a third on average.
  EXPECT_TRUE(contains(outcome.out, "spot            'beam': 25.63"));
  EXPECT_TRUE(contains(outcome.out, "directional     'sun': "));
  EXPECT_TRUE(contains(outcome.out, "irradiance 100000 W/m^2 (lx)"));
  EXPECT_FALSE(contains(outcome.err, "neutral")) << "it has lights of its own: " << outcome.err;
}

TEST(InfoLights, a_bulb_in_glass_is_named_with_the_solid_around_it) {
  const Workplace here;
  std::ofstream(here / "bulb.gltf") << R"({
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_lights_punctual", "EIKON_shape", "KHR_materials_transmission", "KHR_materials_volume"],
    "extensions": {"KHR_lights_punctual": {"lights": [
      {"name": "inside", "type": "point", "intensity": 1}, {"name": "outside", "type": "point", "intensity": 1}]}},
    "materials": [{"name": "glass", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
                   "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
                   "KHR_materials_volume": {"thicknessFactor": 1}}}],
    "nodes": [{"extensions": {"EIKON_shape": {"shape": {"type": "sphere", "sphere": {"radius": 1}}, "material": 0}}},
              {"translation": [0.5, 0.5, 0.5], "extensions": {"KHR_lights_punctual": {"light": 0}}},
              {"translation": [0.6, 0.6, 0.6], "extensions": {"KHR_lights_punctual": {"light": 1}}}],
    "scenes": [{"nodes": [0, 1, 2]}], "scene": 0})";
  const Outcome outcome = here.eikon("info bulb.gltf");
  ASSERT_TRUE(succeeded(outcome)) << outcome.err;
  EXPECT_TRUE(contains(outcome.out, "light 'inside' stands in the solid 'glass'"));
  EXPECT_FALSE(contains(outcome.out, "light 'outside' stands"));
}

TEST(InfoLights, an_animation_with_hardly_any_light_has_the_neutral_studio_at_all_times) {
  const Workplace here;
  for (const double strength : {1e-6, 1.0}) {
    nlohmann::json gltf = read_json(scene("bending_arm.gltf"));
    gltf["scenes"][0].erase("extras");  // its environment
    for (nlohmann::json& material : gltf["materials"])
      if (material.contains("emissiveFactor")) material["emissiveFactor"] = {strength, strength, strength};
    here.write("arm.gltf", gltf.dump());
    for (const char* time : {"0", "0.75"}) {
      const Outcome outcome = here.eikon(std::string("info arm.gltf --scene-time ") + time);
      ASSERT_TRUE(succeeded(outcome)) << outcome.err;
      EXPECT_EQ(contains(outcome.err, "neutral studio is added"), strength < 1) << time << ": " << outcome.err;
    }
  }
}

TEST(InfoLights, surfaces_say_their_area) {
  const Workplace here;
  const Outcome outcome = here.eikon("info " + scene("square_light.gltf"));
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "area 1 m^2, chosen with probability 1.0000"));
}

}  // namespace
}  // namespace eikon::test
