// SPDX-License-Identifier: Apache-2.0
// These tests show which flags pages may ask for, and who may ask.
#include "view/view_look.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "job/prepare.h"
#include "view/server/view_server.h"

namespace eikon {
namespace {

using Words = std::vector<std::string>;

TEST(ViewLook, what_is_read_comes_back_as_it_was_asked_for) {
  const char* text = R"({"flags": {"--size": "64x48", "--fov": "40", "--exposure": "1.5"}, "layer": "lights",
                         "mix": {"lamp": 0.5}, "moving": true})";
  const ViewLook look = read_look(text);
  EXPECT_EQ(look.flags, (std::map<std::string, std::string>{{"--size", "64x48"}, {"--fov", "40"}}));
  EXPECT_EQ(look.png, (std::map<std::string, std::string>{{"--exposure", "1.5"}}));
  EXPECT_EQ(look.layer, "lights");
  EXPECT_EQ(look.mix.at("lamp"), 0.5);
  EXPECT_TRUE(look.moving);
  EXPECT_EQ(read_look(look_json(look).dump()), look);
}

TEST(ViewLook, environments_are_words_or_numbers_and_no_files) {
  const auto look_at = [](const std::string& value) {
    return read_look(Json({{"flags", {{"--size", "8x8"}, {"--env", value}}}}).dump());
  };
  for (const char* value : {"none", "neutral", "1,2,3", "0.5", "1e3,0,0"}) EXPECT_NO_THROW(look_at(value)) << value;
  for (const char* value : {"sky.hdr", "/etc/passwd", "./1,2,3", "1.hdr", "~/a", "neutral2", " 1", "-"})
    EXPECT_THROW(look_at(value), UsageError) << value;
  // The command line goes by the same function. What is wrong with numbers, it says itself.
  for (const char* value : {"none", "neutral", "1,sky.hdr", "-1", "1e3"})
    EXPECT_FALSE(names_environment_file(value)) << value;
  for (const char* value : {"None", "neutral,", ",1", "1.hdr", "x,1", ""})
    EXPECT_TRUE(names_environment_file(value)) << value;
}

TEST(ViewLook, sizes_have_a_limit) {
  const auto look_at = [](const std::string& size) { return read_look(Json({{"flags", {{"--size", size}}}}).dump()); };
  EXPECT_NO_THROW(look_at("2048x2048"));
  for (const char* size : {"2049x8", "8x2049", "0x8", "8", "8x8x8", "x8", "8x", "-8x8", "1e1x8", "8x8 "})
    EXPECT_THROW(look_at(size), UsageError) << size;
}

TEST(ViewLook, flags_of_the_page_replace_those_of_the_user) {
  const Words given = {"scene.gltf", "--camera=front", "--f-number=2", "--size=10x10", "--frame=3", "--seed=7"};
  const auto words = [&](std::map<std::string, std::string> flags) {
    return words_of({.flags = std::move(flags)}, given);
  };
  EXPECT_EQ(words({{"--size", "8x8"}}),
            (Words{"scene.gltf", "--camera=front", "--f-number=2", "--frame=3", "--seed=7", "--size=8x8"}));
  // Another camera has none of the old one's lens.
  EXPECT_EQ(words({{"--camera", "1"}, {"--size", "8x8"}}),
            (Words{"scene.gltf", "--frame=3", "--seed=7", "--camera=1", "--size=8x8"}));
  EXPECT_EQ(words({{"--scene-time", "2"}, {"--size", "8x8"}}),
            (Words{"scene.gltf", "--camera=front", "--f-number=2", "--seed=7", "--scene-time=2", "--size=8x8"}));
}

TEST(ViewLook, a_flag_is_found_with_and_without_a_value) {
  EXPECT_TRUE(has_flag({"a.gltf", "--env=none"}, "--env"));
  EXPECT_TRUE(has_flag({"--transparent"}, "--transparent"));
  EXPECT_FALSE(has_flag({"--env-scale=2", "--environment"}, "--env"));
}

TEST(ViewServer, only_this_machine_by_its_own_names_is_answered) {
  const auto comes = [](const char* host, const char* origin = "", const char* site = "") {
    return comes_from_here({.host = host, .origin = origin, .fetch_site = site});
  };
  for (const char* host : {"localhost", "localhost:1", "127.0.0.1:65535", "[::1]", "[::1]:80"})
    EXPECT_TRUE(comes(host)) << host;
  for (const char* host : {"", ":80", "localhost:", "localhost:65536", "localhost:1:2", "localhost.", "127.1", "::1",
                           "[::1", "[::1]x", "evil.localhost", "localhost@evil"})
    EXPECT_FALSE(comes(host)) << host;
  EXPECT_TRUE(comes("localhost:1", "http://localhost:1", "same-origin"));
  EXPECT_TRUE(comes("localhost:1", "", "none"));
  for (const char* origin : {"null", "http://localhost:2", "https://localhost:1", "http://localhost:1.evil.com"})
    EXPECT_FALSE(comes("localhost:1", origin)) << origin;
  for (const char* site : {"cross-site", "same-site", "other"}) EXPECT_FALSE(comes("localhost:1", "", site)) << site;
}

}  // namespace
}  // namespace eikon
