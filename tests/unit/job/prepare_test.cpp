// SPDX-License-Identifier: Apache-2.0
#include "job/prepare.h"

#include <gtest/gtest.h>

#include <memory>

#include "support/gltf_builder.h"

namespace eikon::test {
namespace {

TEST(Prepare, the_width_of_a_picture_follows_from_any_aspect) {
  for (const auto& [aspect, width] :
       {std::pair(2.0, 1440U), std::pair(1e-9, 1U), std::pair(1e6, kMaxImageSide), std::pair(1e30, kMaxImageSide)}) {
    auto scene = std::make_shared<Scene>(scene_test::Builder().load());
    scene->cameras.push_back({.name = "wide", .projection = Projection::orthographic, .ymag_m = 1, .aspect = aspect});
    SceneOptions options;
    options.environment.radiance = glm::vec3(1);
    const Prepared prepared = prepare(options, scene, [](const std::string&) {});
    EXPECT_EQ(prepared.settings.width, width) << aspect;
    EXPECT_EQ(prepared.settings.height, 720U);
  }
}

}  // namespace
}  // namespace eikon::test
