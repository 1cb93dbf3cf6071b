// SPDX-License-Identifier: Apache-2.0
// `eikon bench rays`: what it measures, and what it refuses. How fast it is, no test says.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "accel/accel.h"
#include "cli/command.h"

namespace eikon::test {
namespace {

/// The rows of the JSON of `bench rays` on a scene with so many rays of each kind; none where it
/// fails.
nlohmann::json rows_of(const std::string& name, int rays, const std::string& flags = "") {
  const Workplace workplace;
  const Outcome outcome =
      workplace.eikon("bench rays " + scene(name) + " --devices 0 --rounds 1 --json rays.json --rays " +
                      std::to_string(rays) + " " + flags);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  std::ifstream file(workplace / "rays.json");
  return outcome.code == 0 ? nlohmann::json::parse(file) : nlohmann::json::array();
}

TEST(BenchRays, json_has_a_row_per_layout_and_kind_of_ray) {
  const nlohmann::json rows = rows_of("cornell.gltf", 4096);
  std::set<std::string> seen;
  std::size_t defaults = 0;
  for (const auto& row : rows) {
    seen.insert(row.at("layout").get<std::string>() + " " + row.at("rays").get<std::string>());
    EXPECT_EQ(row.at("accel"), "bvh");
    EXPECT_GT(row.at("mrays_per_s").get<double>(), 0);
    EXPECT_GT(row.at("bytes").get<std::uint64_t>(), 0U);
    EXPECT_GE(row.at("build_s").get<double>(), 0);
    EXPECT_TRUE(row.at("embree_mrays_per_s").is_null());  // not asked for
    EXPECT_TRUE(row.at("embree_build_s").is_null());
    defaults += row.at("default").get<bool>() ? 1 : 0;
  }
  std::set<std::string> expected;
  for (const std::string& layout : tree_layouts())
    for (const char* kind : {" camera", " shadow", " diffuse"}) expected.insert(layout + kind);
  EXPECT_EQ(seen, expected);
  EXPECT_EQ(defaults, 3U);
}

TEST(BenchRays, steps_are_counted_on_request_in_layouts_that_can) {
  double camera_steps[3] = {};
  for (int i = 0; const char* const layout : {"bvh2", "bvh4", "cwbvh"}) {
    const nlohmann::json rows = rows_of("cornell.gltf", 1024, std::string("--count --layout ") + layout);
    ASSERT_EQ(rows.size(), 3U);
    for (const auto& row : rows) EXPECT_GT(row.at("tests_per_ray").get<double>(), 0) << row;
    camera_steps[i++] = rows.at(0).at("steps_per_ray").get<double>();
  }
  EXPECT_GT(camera_steps[0], camera_steps[1]);  // the more children a node has, the fewer steps
  EXPECT_GT(camera_steps[1], camera_steps[2]);
  EXPECT_GE(camera_steps[2], 1);
  for (const char* const flags : {"--layout bvh2", "--layout bvh8 --count"})
    EXPECT_TRUE(rows_of("cornell.gltf", 1024, flags).at(0).at("steps_per_ray").is_null()) << flags;
}

TEST(BenchRays, rays_to_lights_chosen_by_a_tree_are_measured) {
  EXPECT_EQ(rows_of("lamps.gltf", 1024, "--layout bvh8").size(), 3U);
}

TEST(BenchRays, brute_force_can_be_measured_too) {
  const nlohmann::json rows = rows_of("cornell.gltf", 1024, "--accel none");
  ASSERT_EQ(rows.size(), 3U);
  for (const auto& row : rows) {
    EXPECT_EQ(row.at("accel"), "none");
    EXPECT_EQ(row.at("default"), false);
  }
}

TEST(BenchRays, every_accelerator_is_measured_and_counted_on_the_same_rays) {
  const nlohmann::json rows = rows_of("cornell.gltf", 1024, "--accel all");
  std::set<std::string> seen, tests;
  for (const auto& row : rows) {
    seen.insert(row.at("accel").get<std::string>());
    tests.insert(row.at("test").get<std::string>());
    EXPECT_GT(row.at("mrays_per_s").get<double>(), 0);
    EXPECT_GT(row.at("bytes").get<std::uint64_t>(), 0U);
    const std::string layout = row.at("layout");
    if (layout == "bvh16" || layout == "bvh8") continue;
    const double counted = row.at("tests_per_ray").get<double>();
    if (layout == "none" && row.at("rays") == "camera") {
      EXPECT_EQ(counted, 38);  // every triangle
    }
    EXPECT_GT(counted, 0) << layout;
    EXPECT_LE(counted, layout == "none" ? 38 : 60) << layout;  // a list or two
  }
  const std::vector<std::string> names = accelerator_names();
  EXPECT_EQ(seen, std::set<std::string>(names.begin(), names.end()));
  EXPECT_EQ(tests, (std::set<std::string>{"watertight", "Moller-Trumbore", "plane, 3 crosses"}));
}

TEST(BenchRays, an_unknown_yardstick_a_scene_without_triangles_and_all_accelerators_of_one_layout_are_refused) {
  const Workplace workplace;
  EXPECT_EQ(workplace.eikon("bench rays " + scene("cornell.gltf") + " --accel all --layout bvh8").code, 2);
  EXPECT_EQ(workplace.eikon("render " + scene("cornell.gltf") + " --accel all -o a.exr").code, 2);
  EXPECT_EQ(workplace.eikon("bench rays " + scene("cornell.gltf") + " --versus optix").code, 2);
  EXPECT_EQ(workplace.eikon("bench").code, 2);
  std::ofstream(workplace / "empty.gltf") << R"({"asset": {"version": "2.0"}})";
  EXPECT_EQ(workplace.eikon("bench rays empty.gltf --devices 0").code, 3);
}

}  // namespace
}  // namespace eikon::test
