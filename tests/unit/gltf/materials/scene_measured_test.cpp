// SPDX-License-Identifier: Apache-2.0
// Files of measured materials: what is in them, and what is refused.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "gltf/materials/material_measured.h"
#include "scene/merl.h"
#include "support/gltf_builder.h"

namespace {

using eikon::MeasuredTable;
using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::message_of;
using scene_test::TemporaryFolder;
using scene_test::warns;

constexpr std::size_t kCells = EK_MEASURED_CELLS;

/// A file with one value per channel, before the scales.
std::string file_of(double r, double g, double b, std::array<std::int32_t, 3> dimensions = {90, 90, 180}) {
  std::string bytes(eikon::kMerlBytes, '\0');
  std::memcpy(bytes.data(), dimensions.data(), 12);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < kCells; ++i) std::memcpy(&bytes[12 + 8 * (c * kCells + i)], &std::array{r, g, b}[c], 8);
  return bytes;
}

std::span<const std::byte> as_file(const std::string& bytes) { return std::as_bytes(std::span(bytes)); }

Builder measured_builder(const std::string& uri = "x.binary") {
  Builder builder;
  builder.material()["extensions"]["EIKON_materials_measured"] = {{"uri", uri}};
  builder.json["extensionsRequired"] = {"EIKON_materials_measured"};
  return builder;
}

TEST(Measured, channels_have_the_scales_of_merl_red_first) {
  const std::vector<float> rgb = eikon::read_merl(as_file(file_of(150, 300, 1500)));
  ASSERT_EQ(rgb.size(), 3 * kCells);
  EXPECT_EQ(rgb[0], float(150 / 1500.0));
  EXPECT_EQ(rgb[1], float(300 * 1.15 / 1500));
  EXPECT_EQ(rgb[3 * kCells - 1], float(1500 * 1.66 / 1500));
}

TEST(Measured, what_is_written_is_read_back_bit_for_bit) {
  const TemporaryFolder folder;
  std::mt19937 random(3);
  std::vector<float> rgb(3 * kCells);
  for (float& x : rgb) x = std::ldexp(float(random() >> 8), -int(random() % 40));
  rgb[7] = -3;
  rgb[8] = 0;
  eikon::write_merl(folder / "a.binary", rgb);
  EXPECT_EQ(folder.file_count(), 1U);
  const std::string bytes = eikon::test::read_bytes(folder / "a.binary");
  EXPECT_EQ(bytes.size(), 34992012U);
  const std::vector<float> back = eikon::read_merl(as_file(bytes));
  EXPECT_LT(back[7], 0);
  rgb[7] = back[7];
  EXPECT_TRUE(back == rgb);
}

TEST(Measured, M23_damaged_files_are_refused_by_one_line) {
  std::string good = file_of(1, 1, 1);
  const auto says = [](const std::string& bytes) {
    return message_of([&] { (void)eikon::read_merl(as_file(bytes)); });
  };
  EXPECT_TRUE(contains(says(""), "has 0 bytes"));
  EXPECT_TRUE(contains(says(good.substr(0, 11)), "has 11 bytes"));
  EXPECT_TRUE(contains(says(good.substr(0, good.size() - 1)), "has 34992011 bytes"));
  EXPECT_TRUE(contains(says(good + "x"), "has 34992013 bytes"));
  // Products that overflow 32 and 64 bits to what fits, or to nothing.
  for (const std::array<std::int32_t, 3>& dimensions : {std::array{180, 90, 90},
                                                        {90, 90, 360},
                                                        {0, 0, 0},
                                                        {-90, -90, 180},
                                                        {65536, 65536, 0x7fffffff},
                                                        {90, 90, -180},
                                                        {1458000, 1, 1},
                                                        {0x7fffffff, 0x7fffffff, 0x7fffffff}})
    EXPECT_TRUE(
        contains(says(file_of(1, 1, 1, dimensions).substr(0, 100)), "as it says; a MERL table is 90 x 90 x 180"));
  for (const double value :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), 1e35, -1e300}) {
    std::string broken = good;
    std::memcpy(&broken[12 + 8 * (kCells + 5)], &value, 8);
    EXPECT_TRUE(contains(says(broken), "entry 5 of green is")) << value;
  }
}

TEST(Measured, no_bytes_of_a_file_do_harm) {
  std::mt19937_64 random(5);
  const std::string good = file_of(100, 100, 100);
  int read = 0, refused = 0;
  for (int round = 0; round < 40; ++round) {
    std::string bytes = good;
    const std::size_t flips = 1 + random() % 8, from = round % 4 == 0 ? 16 : bytes.size();
    for (std::size_t i = 0; i < flips; ++i) bytes[random() % from] = char(random());
    if (round % 5 == 0) bytes.resize(random() % bytes.size());
    try {
      const MeasuredTable table = eikon::make_measured_table(eikon::read_merl(as_file(bytes)));
      ASSERT_EQ(table.words.size(), std::size_t{EK_MEASURED_WORDS});
      for (const std::uint32_t word : table.words) {
        const float x = std::bit_cast<float>(word);
        ASSERT_TRUE(std::isfinite(x) && x >= 0);
      }
      ++read;
    } catch (const eikon::InputError& e) {
      EXPECT_FALSE(contains(e.what(), "\n"));
      ++refused;
    }
  }
  EXPECT_GT(read, 5);
  EXPECT_GT(refused, 5);
}

TEST(Measured, sampling_tables_are_distributions) {
  std::vector<float> rgb(3 * kCells);
  std::mt19937 random(9);
  for (float& x : rgb) x = float(random()) * 0x1p-32F;
  const MeasuredTable table = eikon::make_measured_table(std::move(rgb));
  const auto word = [&](std::size_t i) { return double(std::bit_cast<float>(table.words[i])); };
  for (std::size_t view = 0; view < EK_MEASURED_VIEWS; ++view) {
    const std::size_t at = EK_MEASURED_EDGES + view * EK_MEASURED_VIEW_WORDS;
    EXPECT_GT(word(at), 0);
    EXPECT_LE(word(at), 0.875);
    double total = 0;
    for (std::size_t i = 0; i < EK_MEASURED_THETA_H; ++i) {
      EXPECT_GE(word(at + EK_MEASURED_VIEW_CUMULATIVE + i + 1), word(at + EK_MEASURED_VIEW_CUMULATIVE + i));
      total += word(at + EK_MEASURED_VIEW_DENSITY + i) * 2 * std::numbers::pi * (word(i + 1) - word(i));
    }
    EXPECT_NEAR(total, 1, 1e-6);  // 90 densities, each rounded to a float
    EXPECT_EQ(word(at + EK_MEASURED_VIEW_CUMULATIVE), 0);
    EXPECT_EQ(word(at + EK_MEASURED_VIEW_CUMULATIVE + EK_MEASURED_THETA_H), 1);
  }
}

TEST(Measured, materials_share_a_file_and_know_what_it_reflects) {
  const TemporaryFolder folder;
  Builder builder = measured_builder();
  builder.json["materials"].push_back(builder.material());
  Json second = builder.primitive();
  second["material"] = 1;
  builder.json["meshes"][0]["primitives"].push_back(second);
  const double rho = 0.6, f = rho / std::numbers::pi * 1500;
  folder.write("x.binary", file_of(f, f / 1.15, f / 1.66));
  const Scene scene = eikon::load_scene(folder.write("scene.gltf", builder.text()));
  ASSERT_TRUE(scene.materials.at(0).measured);
  EXPECT_EQ(scene.materials[0].measured, scene.materials.at(1).measured);
  EXPECT_EQ(scene.materials[0].measured->name, "'x.binary'");
  EXPECT_TRUE(scene.warnings.empty() && scene.unsupported.empty());
  for (const glm::dvec3& albedo : scene.materials[0].measured->albedos) EXPECT_NEAR(albedo.x, rho, 0.01 * rho);

  const std::string hash = scene.hash;
  folder.write("x.binary", file_of(f, f, f));
  EXPECT_NE(eikon::load_scene(folder / "scene.gltf").hash, hash) << "another table is another scene";
}

TEST(Measured, M23_negative_entries_reflect_nothing_and_are_counted) {
  const TemporaryFolder folder;
  folder.write("x.binary", file_of(-1, -1, -1));
  const Scene scene = eikon::load_scene(folder.write("scene.gltf", measured_builder().text()));
  EXPECT_TRUE(warns(scene, "of the 1458000 entries of 'x.binary' have no measurement and reflect nothing"));
  EXPECT_TRUE(scene.out_of_range.empty());
  for (std::size_t i = EK_MEASURED_VALUES; i < EK_MEASURED_WORDS; ++i)
    ASSERT_EQ(scene.materials.at(0).measured->words[i], 0U);
}

TEST(Measured, more_light_than_arrives_is_said_and_strictly_refused) {
  const TemporaryFolder folder;
  const double f = 1.5 / std::numbers::pi * 1500;
  folder.write("x.binary", file_of(0, f, 0));
  const Scene scene = eikon::load_scene(folder.write("scene.gltf", measured_builder().text()));
  EXPECT_TRUE(warns(scene, "material 'paint': 'x.binary' reflects 1.7")) << scene.warnings.at(0);  // 1.5 x 1.15
  EXPECT_EQ(scene.out_of_range.size(), 1U);  // which --strict refuses
}

TEST(Measured, bad_uses_are_refused_by_material) {
  const TemporaryFolder folder;
  const auto says = [&](const Builder& builder) {
    return message_of([&] { (void)eikon::load_scene(folder.write("scene.gltf", builder.text())); });
  };
  folder.write("short.binary", "x");
  std::filesystem::create_directory(folder / "folder.binary");
  // Large without taking room.
  folder.write("large.binary", "x");
  std::filesystem::resize_file(folder / "large.binary", std::uint64_t{1} << 40U);
  for (const auto& [uri, words] : {std::pair("none.binary", "no such file"),
                                   {"short.binary", "has 1 bytes"},
                                   {"folder.binary", "directory"},
                                   {"large.binary", "has 1099511627776 bytes"},
                                   {"../x.binary", "upwards"},
                                   {"/etc/passwd", "absolute"},
                                   {"", "is empty"},
                                   {"http://x/y.binary", "scheme"}}) {
    const std::string message = says(measured_builder(uri));
    EXPECT_TRUE(contains(message, "material 'paint'") && contains(message, words)) << uri << ": " << message;
  }
  for (const auto& [content, words] :
       {std::pair("{}", "needs \"uri\""), {R"({"uri": 7})", "uri"}, {"[]", "is not an object"}}) {
    Builder builder = measured_builder();
    builder.material()["extensions"]["EIKON_materials_measured"] = Json::parse(content);
    const std::string message = says(builder);
    EXPECT_TRUE(contains(message, "material 'paint'") && contains(message, words)) << message;
  }
  Builder both = measured_builder();
  both.material()["extensions"]["EIKON_materials_conductor"] = {{"metal", "Cu"}};
  EXPECT_TRUE(contains(says(both), "leave one out"));
  // What nothing shows is not read.
  Builder unlit = measured_builder("none.binary");
  unlit.material()["extensions"]["KHR_materials_unlit"] = Json::object();
  EXPECT_FALSE(eikon::load_scene(folder.write("scene.gltf", unlit.text())).materials.at(0).measured);
}

}  // namespace
