// SPDX-License-Identifier: Apache-2.0
// What `eikon info` says of a scene's lights.
#include <fstream>

#include "cli/command.h"

namespace eikon::testing {
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
  EXPECT_TRUE(contains(outcome.out, "point           'bulb': 815.0")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "W (lm), intensity 64.86 W/sr (cd)")) << outcome.out;
  // 2 pi 100 (1 - cos 0.5) / 3: the square of a ramp is a third on average.
  EXPECT_TRUE(contains(outcome.out, "spot            'beam': 25.63")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "directional     'sun': ")) << outcome.out;
  EXPECT_TRUE(contains(outcome.out, "irradiance 100000 W/m^2 (lx)")) << outcome.out;
  EXPECT_FALSE(contains(outcome.err, "neutral")) << "it has lights of its own: " << outcome.err;
}

TEST(InfoLights, surfaces_say_their_area) {
  const Workplace here;
  const Outcome outcome = here.eikon("info " + scene("square_light.gltf"));
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "area 1 m^2, chosen with probability 1.0000")) << outcome.out;
}

}  // namespace
}  // namespace eikon::testing
