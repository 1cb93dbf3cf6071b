// SPDX-License-Identifier: Apache-2.0
// Environment maps: from files, and what a scene says of them.
#include "scene/environment/environment.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "image/decode_hdr.h"
#include "support/gltf_builder.h"

namespace {

using eikon::EnvironmentMap;
using eikon::HdrImage;
using scene_test::Builder;
using scene_test::contains;
using scene_test::message_of;
using scene_test::TemporaryFolder;
using scene_test::warns;

constexpr std::uint64_t kPlenty = std::uint64_t{1} << 32U;

std::string hdr(const std::string& resolution, const std::string& pixels, const std::string& lines = "") {
  return "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n" + lines + "\n" + resolution + "\n" + pixels;
}

HdrImage decode(const std::string& bytes, std::uint64_t max_bytes = kPlenty) {
  return eikon::decode_hdr(std::as_bytes(std::span(bytes)), max_bytes);
}

std::string refusal(const std::string& bytes, std::uint64_t max_bytes = kPlenty) {
  return message_of([&] { decode(bytes, max_bytes); });
}

/// A pixel (r, g, b) / 256 * 2^(e - 128).
std::string rgbe(int r, int g, int b, int e) {
  return {static_cast<char>(r), static_cast<char>(g), static_cast<char>(b), static_cast<char>(e)};
}

std::string grey_row(int width, int value) {
  std::string row;
  for (int x = 0; x < width; ++x) row += rgbe(value, value, value, 128 + 8);  // exponent 8: the mantissa itself
  return row;
}

TEST(Hdr, flat_pixels_have_their_mantissas_and_exponents) {
  const HdrImage image = decode(hdr("-Y 1 +X 3", rgbe(128, 64, 0, 129) + rgbe(255, 1, 2, 136) + rgbe(9, 9, 9, 0)));
  ASSERT_EQ(image.width, 3U);
  ASSERT_EQ(image.height, 1U);
  EXPECT_EQ(image.rgb[0], glm::vec3(1, 0.5F, 0));
  EXPECT_EQ(image.rgb[1], glm::vec3(255, 1, 2));
  EXPECT_EQ(image.rgb[2], glm::vec3(0));  // exponent 0 is black
}

TEST(Hdr, rows_and_columns_may_run_either_way) {
  const std::string pixels = rgbe(1, 1, 1, 136) + rgbe(2, 2, 2, 136) + rgbe(3, 3, 3, 136) + rgbe(4, 4, 4, 136);
  // Pixels (1, 1, 1, n) would be runs in other places than the first of a row.
  const struct {
    const char* resolution;
    float expected[4];
  } rows[] = {{"-Y 2 +X 2", {1, 2, 3, 4}}, {"+Y 2 +X 2", {3, 4, 1, 2}}, {"-Y 2 -X 2", {2, 1, 4, 3}}};
  for (const auto& row : rows) {
    const HdrImage image = decode(hdr(row.resolution, pixels));
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(image.rgb[i].x, row.expected[i]) << row.resolution << ' ' << i;
  }
  EXPECT_TRUE(contains(refusal(hdr("+X 2 -Y 2", pixels)), "columns first"));
}

TEST(Hdr, both_run_length_codings_give_the_pixels) {
  // New: R is a run of 8 times 7, G is 8 literals, B a run of 5 and 3 literals, E a run.
  std::string row("\x02\x02\x00\x08", 4);
  row += std::string("\x88\x07", 2) + std::string("\x08\x00\x01\x02\x03\x04\x05\x06\x07", 9);
  row += std::string("\x85\x01\x03\x09\x08\x07", 6) + std::string("\x88\x88", 2);
  const HdrImage fresh = decode(hdr("-Y 1 +X 8", row));
  const float blue[8] = {1, 1, 1, 1, 1, 9, 8, 7};
  for (std::size_t x = 0; x < 8; ++x) {
    EXPECT_EQ(fresh.rgb[x], glm::vec3(7, static_cast<float>(x), blue[x])) << x;
  }
  // Old: one pixel, then 2 + (1 << 8) copies, then another pixel.
  const HdrImage old =
      decode(hdr("-Y 1 +X 260", rgbe(5, 6, 7, 136) + rgbe(1, 1, 1, 2) + rgbe(1, 1, 1, 1) + rgbe(9, 9, 9, 136)));
  for (std::size_t x = 0; x < 259; ++x) ASSERT_EQ(old.rgb[x], glm::vec3(5, 6, 7)) << x;
  EXPECT_EQ(old.rgb[259], glm::vec3(9));
}

TEST(Hdr, exposure_and_colour_correction_are_divided_out) {
  const std::string lines = "EXPOSURE=2\nEXPOSURE= 4.0\nCOLORCORR= 1 2 0.5\nVIEW=-vtv\n";
  EXPECT_EQ(decode(hdr("-Y 1 +X 1", rgbe(64, 64, 64, 136), lines)).rgb[0], glm::vec3(8, 4, 16));
}

TEST(Hdr, primaries_are_those_that_the_file_states) {
  EXPECT_FALSE(decode(hdr("-Y 1 +X 1", rgbe(64, 64, 64, 136))).primaries);
  const auto stated =
      decode(hdr("-Y 1 +X 1", rgbe(1, 2, 3, 136), "PRIMARIES= .64 .33 .29 .60 .15 .06 .3333 .3333\n")).primaries;
  ASSERT_TRUE(stated);
  EXPECT_EQ(stated->green, glm::dvec2(0.29, 0.6));
  EXPECT_EQ(stated->white, glm::dvec2(0.3333, 0.3333));
  // XYZE counts in lumens, 179 of which Radiance takes for a watt.
  const HdrImage xyz = decode("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n" + rgbe(179, 0, 179, 136));
  EXPECT_EQ(xyz.rgb[0], glm::vec3(1, 0, 1));
  ASSERT_TRUE(xyz.primaries);
  EXPECT_EQ(xyz.primaries->green, glm::dvec2(0, 1));
}

TEST(Hdr, what_cannot_be_read_is_said) {
  const std::string pixel = rgbe(1, 2, 3, 128);
  EXPECT_TRUE(contains(refusal("P6 1 1"), "too early"));
  EXPECT_TRUE(contains(refusal("P6 1 1\n"), "not a Radiance picture"));
  EXPECT_TRUE(contains(refusal("#?RADIANCE\n\n-Y 1 +X 1\n" + pixel), "FORMAT"));
  EXPECT_TRUE(contains(refusal(hdr("-Y 1 +X 1", pixel, "PRIMARIES= 0.6 0.3 0.2\n")), "no number"));
  EXPECT_TRUE(contains(refusal("#?RADIANCE\nFORMAT=\x01\x02\n\n-Y 1 +X 1\n" + pixel), "unknown format"));
  EXPECT_TRUE(contains(refusal(hdr("-Y 1 +X 1", pixel, "EXPOSURE=0\n")), "positive"));
  EXPECT_TRUE(contains(refusal(hdr("-Y 1 +X 1", pixel, "EXPOSURE=1e-300\n")), "positive"));
  EXPECT_TRUE(contains(refusal(hdr("-Y 1 +X 1", pixel, std::string(5000, 'x') + "\n")), "longer than"));
  for (const char* resolution : {"", "-Y 1", "-Y 0 +X 1", "-Y 1 +X 65537", "-Y 99999999999999999999 +X 1", "-Y -1 +X 1",
                                 "-Y 1 +Z 1", "Y 1 X 1", "-Y 1 -Y 1"}) {
    refusal(hdr(resolution, pixel));
  }
}

TEST(Hdr, sizes_that_lie_are_refused_before_memory_is_taken) {
  EXPECT_TRUE(contains(refusal(hdr("-Y 65536 +X 65536", rgbe(1, 2, 3, 128))), "cannot hold"));
  const std::string large = hdr("-Y 100 +X 100", grey_row(10000, 5));
  EXPECT_TRUE(contains(refusal(large, 1000), "scale it down"));
  EXPECT_EQ(decode(large).rgb.size(), 10000U);
}

TEST(Hdr, a_picture_cut_or_changed_anywhere_is_an_error_or_a_picture) {
  std::string row("\x02\x02\x00\x08", 4);
  for (int part = 0; part < 4; ++part) row += std::string("\x88\x85", 2);
  const std::string old_row = rgbe(5, 6, 7, 136) + rgbe(1, 1, 1, 7);
  const std::string good = hdr("-Y 2 +X 8", row + old_row);
  ASSERT_EQ(decode(good).rgb[15], glm::vec3(5, 6, 7));
  for (std::size_t size = 0; size < good.size(); ++size) refusal(good.substr(0, size));
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const int value : {0, 1, 2, 127, 128, 129, 255}) {
      std::string changed = good;
      changed[at] = static_cast<char>(value);
      try {
        const HdrImage image = decode(changed);
        for (const glm::vec3& texel : image.rgb) ASSERT_TRUE(std::isfinite(texel.x) && texel.x >= 0);
      } catch (const eikon::InputError&) {
      }
    }
  }
}

void write_exr_channels(const std::filesystem::path& path, int width, int height,
                        const std::vector<std::pair<std::string, std::vector<float>>>& channels) {
  Imf::Header header(width, height);
  Imf::FrameBuffer buffer;
  for (const auto& [name, values] : channels) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(values.data())), 4,
                                   4 * static_cast<std::size_t>(width)));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(height);
}

TEST(EnvironmentMaps, exr_and_hdr_are_told_apart_by_their_first_bytes) {
  const TemporaryFolder folder;
  write_exr_channels(folder / "a.hdr", 2, 1, {{"R", {1, 2}}, {"G", {3, 4}}, {"B", {5, 6}}, {"A", {7, 8}}});
  write_exr_channels(folder / "grey.exr", 2, 1, {{"Y", {0.25F, 65504.0F}}});
  folder.write("b.exr", hdr("-Y 1 +X 2", rgbe(1, 2, 3, 136) + rgbe(4, 5, 6, 136)));
  std::vector<std::string> warnings;
  const auto colour = eikon::load_environment(folder / "a.hdr", warnings);
  EXPECT_EQ(colour->name, "a.hdr");
  EXPECT_EQ(colour->width, 2U);
  EXPECT_EQ(colour->height, 1U);
  EXPECT_EQ(colour->radiance, (std::vector<glm::vec3>{{1, 3, 5}, {2, 4, 6}}));
  EXPECT_EQ(eikon::load_environment(folder / "grey.exr", warnings)->radiance,
            (std::vector<glm::vec3>{glm::vec3(0.25F), glm::vec3(65504.0F)}));
  EXPECT_EQ(eikon::load_environment(folder / "b.exr", warnings)->radiance,
            (std::vector<glm::vec3>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_TRUE(warnings.empty());
}

TEST(EnvironmentMaps, L15_texels_that_are_no_light_become_black_and_are_counted) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  write_exr_channels(folder / "bad.exr", 4, 2,
                     {{"R", {nan, 1, 1, -1, 65504, 0, 1, 1}},
                      {"G", {1, inf, 1, 2, 65504, 0, 1, 1}},
                      {"B", {1, 1, -inf, 3, 65504, 0, 1, 1}}});
  std::vector<std::string> warnings;
  const auto map = eikon::load_environment(folder / "bad.exr", warnings);
  EXPECT_EQ(map->radiance, (std::vector<glm::vec3>{glm::vec3(0), glm::vec3(0), glm::vec3(0), glm::vec3(0, 2, 3),
                                                   glm::vec3(65504), glm::vec3(0), glm::vec3(1), glm::vec3(1)}));
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_TRUE(contains(warnings[0], "3 of 8 texels are not finite"));
  EXPECT_TRUE(contains(warnings[1], "1 of 8 texels have negative"));
}

TEST(EnvironmentMaps, L15_a_black_map_is_legal_and_said) {
  const TemporaryFolder folder;
  write_exr_channels(folder / "black.exr", 2, 1, {{"Y", {0, 0}}});
  std::vector<std::string> warnings;
  EXPECT_EQ(eikon::load_environment(folder / "black.exr", warnings)->radiance.size(), 2U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "black.exr': is black altogether and gives no light"));
}

TEST(EnvironmentMaps, other_files_are_refused_with_their_name) {
  const TemporaryFolder folder;
  folder.write("sky.exr", "no picture");
  folder.write("empty.hdr", "");
  folder.write("cut.hdr", hdr("-Y 2 +X 2", rgbe(1, 2, 3, 128)));
  write_exr_channels(folder / "depth.exr", 2, 1, {{"Z", {0, 0}}});
  std::vector<std::string> warnings;
  for (const char* name : {"sky.exr", "empty.hdr", "cut.hdr", "depth.exr", "missing.exr"}) {
    EXPECT_TRUE(contains(message_of([&] { eikon::load_environment(folder / name, warnings); }), name)) << name;
  }
}

TEST(EnvironmentMaps, a_scene_names_its_map_with_scale_and_degrees) {
  const TemporaryFolder folder;
  folder.write("sky.hdr", hdr("-Y 1 +X 2", grey_row(2, 3)));
  Builder builder;
  builder.json["extras"]["environment"] = {{"uri", "sky.hdr"}, {"scale", 2.5}, {"rotate", 90}};
  const eikon::Scene scene = eikon::load_scene(folder.write("scene.gltf", builder.text()));
  ASSERT_TRUE(scene.environment && scene.environment->map);
  EXPECT_EQ(scene.environment->map->radiance.at(1), glm::vec3(3));
  EXPECT_EQ(scene.environment->scale, 2.5);
  EXPECT_DOUBLE_EQ(scene.environment->rotation_rad, std::numbers::pi / 2);
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(scene.unsupported.empty());

  // What the map shows is part of what the scene is.
  folder.write("sky.hdr", hdr("-Y 1 +X 2", grey_row(2, 4)));
  EXPECT_NE(eikon::load_scene(folder / "scene.gltf").hash, scene.hash);
}

TEST(EnvironmentMaps, a_scene_cannot_name_what_is_outside_its_folder_or_no_light) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "inner");
  folder.write("sky.hdr", hdr("-Y 1 +X 2", grey_row(2, 3)));
  const auto message = [&](const scene_test::Json& environment) {
    Builder builder;
    builder.json["extras"]["environment"] = environment;
    return message_of([&] { eikon::load_scene(folder.write("inner/scene.gltf", builder.text())); });
  };
  EXPECT_TRUE(contains(message({{"uri", "../sky.hdr"}}), "leads upwards"));
  EXPECT_TRUE(contains(message({{"uri", "/etc/passwd"}}), "absolute"));
  EXPECT_TRUE(contains(message({{"uri", "none.hdr"}}), "no such file"));
  EXPECT_TRUE(contains(message({{"uri", "scene.gltf"}}), "neither OpenEXR nor Radiance"));
  EXPECT_TRUE(contains(message({{"uri", 3}}), "not a string"));
  folder.write("inner/sky.hdr", hdr("-Y 1 +X 2", grey_row(2, 3)));
  EXPECT_TRUE(contains(message({{"uri", "sky.hdr"}, {"scale", -1}}), "negative"));
  EXPECT_TRUE(contains(message({{"uri", "sky.hdr"}, {"rotate", "90"}}), "not a number"));
  EXPECT_TRUE(contains(message({{"radiance", {1, -1, 1}}}), "negative"));
}

TEST(EnvironmentMaps, a_map_wins_over_a_radiance_and_neither_is_ignored) {
  const TemporaryFolder folder;
  folder.write("sky.hdr", hdr("-Y 1 +X 2", grey_row(2, 3)));
  Builder builder;
  builder.json["extras"]["environment"] = {{"uri", "sky.hdr"}, {"radiance", {1, 1, 1}}};
  EXPECT_TRUE(warns(eikon::load_scene(folder.write("a.gltf", builder.text())), "'radiance' ignored"));
  builder.json["extras"]["environment"] = {{"colour", 1}};
  const eikon::Scene scene = builder.load();
  EXPECT_FALSE(scene.environment);
  EXPECT_TRUE(warns(scene, "neither 'radiance' nor 'uri'"));
}

}  // namespace
