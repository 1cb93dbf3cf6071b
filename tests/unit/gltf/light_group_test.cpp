// SPDX-License-Identifier: Apache-2.0
// extras.lightGroup of nodes, materials, lights and the scene.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/light_groups.h"

namespace eikon {
namespace {

std::uint32_t group_of(const char* text, Scene& scene) {
  const Json json = Json::parse(text);
  return light_group_of({.value = json, .kind = "node", .index = 3}, scene);
}

TEST(LightGroup, is_numbered_in_the_order_in_which_names_come) {
  Scene scene;
  EXPECT_EQ(group_of(R"({})", scene), 0U);
  EXPECT_EQ(group_of(R"({"extras": 7})", scene), 0U);
  EXPECT_EQ(group_of(R"({"extras": {"lightGroup": "key"}})", scene), 1U);
  EXPECT_EQ(group_of(R"({"extras": {"lightGroup": "fill_2-b"}})", scene), 2U);
  EXPECT_EQ(group_of(R"({"extras": {"lightGroup": "key"}})", scene), 1U);
  EXPECT_EQ(group_of(R"({"extras": {"lightGroup": "rest"}})", scene), 0U);
  EXPECT_EQ(scene.light_groups, (std::vector<std::string>{"rest", "key", "fill_2-b"}));
}

TEST(LightGroup, names_that_are_no_layers_are_refused) {
  for (const char* bad : {R"({"extras": {"lightGroup": 1}})", R"({"extras": {"lightGroup": ""}})",
                          R"({"extras": {"lightGroup": "a.b"}})", R"({"extras": {"lightGroup": "a,b"}})",
                          R"({"extras": {"lightGroup": "k\u00f6y"}})", R"({"extras": {"lightGroup": null}})"}) {
    Scene scene;
    EXPECT_THROW(group_of(bad, scene), InputError) << bad;
    EXPECT_EQ(scene.light_groups.size(), 1U);
  }
  Scene scene;
  const std::string longest(64, 'x');
  EXPECT_EQ(group_of((R"({"extras": {"lightGroup": ")" + longest + "\"}}").c_str(), scene), 1U);
  EXPECT_THROW(group_of((R"({"extras": {"lightGroup": ")" + longest + "x\"}}").c_str(), scene), InputError);
}

TEST(LightGroup, the_sixty_fifth_is_refused) {
  Scene scene;
  for (int i = 1; i < 64; ++i)
    EXPECT_EQ(group_of((R"({"extras": {"lightGroup": "g)" + std::to_string(i) + "\"}}").c_str(), scene),
              std::uint32_t(i));
  EXPECT_THROW(group_of(R"({"extras": {"lightGroup": "one-more"}})", scene), InputError);
}

}  // namespace
}  // namespace eikon
