// SPDX-License-Identifier: Apache-2.0
// `eikon measure`, and scenes by its tables.
#include <cmath>
#include <cstring>

#include "cli/command.h"

namespace eikon::test {
namespace {

constexpr std::uintmax_t kTableBytes = 34992012;

/// A sphere of each material under a white sky. materials: a JSON array
std::string scene_of(const std::string& materials, int count) {
  std::string nodes, roots;
  for (int i = 0; i < count; ++i) {
    nodes += (i == 0 ? "" : ", ") + std::string(R"({"extensions": {"EIKON_shape": {"material": )") + std::to_string(i) +
             R"(, "shape": {"type": "sphere", "sphere": {"radius": 0.5}}}}})";
    roots += (i == 0 ? "" : ", ") + std::to_string(i);
  }
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [)" + roots +
         R"(], "extras": {"environment": {"radiance": [1, 1, 1]}}}], "nodes": [)" + nodes + R"(], "materials": )" +
         materials + "}\n";
}

const char* const kCopper = R"({"name": "copper", "pbrMetallicRoughness": {"roughnessFactor": 0.4},
  "extensions": {"EIKON_materials_conductor": {"metal": "Cu"}}})";
const char* const kByTable =
    R"({"name": "table", "extensions": {"EIKON_materials_measured": {"uri": "copper.binary"}}})";

TEST(Measure, a_table_of_copper_renders_as_copper_does) {
  const Workplace here;
  here.write("copper.gltf", scene_of("[" + std::string(kCopper) + "]", 1));
  here.write("table.gltf", scene_of("[" + std::string(kByTable) + "]", 1));
  const Outcome measured = here.eikon("measure copper.gltf --material copper -o copper.binary");
  ASSERT_TRUE(succeeded(measured));
  EXPECT_TRUE(contains(measured.out, "copper.binary: material 'copper', 90 x 90 x 180 cells"));
  EXPECT_EQ(std::filesystem::file_size(here / "copper.binary"), kTableBytes);
  for (const char* name : {"copper", "table"})
    ASSERT_TRUE(succeeded(
        here.eikon(std::string("render ") + name + ".gltf -o " + name + ".exr --size 24x24 --spp 256 --quiet")));
  const Outcome compared = here.eikon("compare table.exr copper.exr --json --fail-above 1e-3");
  EXPECT_TRUE(succeeded(compared)) << compared.out;
  const Outcome info = here.eikon("info table.gltf");
  EXPECT_TRUE(contains(info.out, "material 'table': measured by 'copper.binary'"));
  EXPECT_TRUE(contains(info.out, "1 of 17.5 MB each"));
}

TEST(Measure, a_table_of_a_table_is_that_table_but_for_the_rounding_of_directions) {
  const Workplace here;
  here.write("copper.gltf", scene_of("[" + std::string(kCopper) + "]", 1));
  here.write("table.gltf", scene_of("[" + std::string(kByTable) + "]", 1));
  ASSERT_TRUE(succeeded(here.eikon("measure copper.gltf --material 0 -o copper.binary")));
  ASSERT_TRUE(succeeded(here.eikon("measure table.gltf --material table -o again.binary")));
  const std::string once = read_bytes(here / "copper.binary"), twice = read_bytes(here / "again.binary");
  ASSERT_EQ(once.size(), twice.size());
  double worst = 0, worst_grazing = 0;
  for (std::size_t at = 12; at < once.size(); at += 8) {
    double a = 0, b = 0;
    std::memcpy(&a, &once[at], 8);
    std::memcpy(&b, &twice[at], 8);
    ASSERT_EQ(a < 0, b < 0);
    double& which = (at - 12) / 8 / 180 % 90 < 81 ? worst : worst_grazing;
    if (a > 0) which = std::max(which, std::abs(a - b) / a);
  }
  std::printf("entries differ by %.2g of themselves at most, beyond 81 degrees of theta_d by %.2g\n", worst,
              worst_grazing);
  // Components of directions are known to 6e-8, their sum to 1.2e-7: the half vector to that over 2
  // cos theta_d, 4e-7 rad below 81 degrees, 1/1000 of the cells in which entries change at all
  // (4e-4 rad), and entries change by less than themselves from cell to cell. At 89.5 degrees it is
  // 7e-6 rad, 1/100 of cells where grazing entries change so (7e-4 rad and more).
  EXPECT_LT(worst, 1e-3);
  EXPECT_LT(worst_grazing, 1e-2);
}

TEST(Measure, what_no_table_holds_is_refused_by_name) {
  const Workplace here;
  const std::pair<std::string, std::string> cases[] = {
      {R"({"name": "m", "pbrMetallicRoughness": {"roughnessFactor": 0}})", "perfect mirror"},
      {R"({"name": "m", "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1}}})", "perfect mirror"},
      {R"({"name": "m", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.5},
           "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1}}})",
       "lets light through"},
      {R"({"name": "m", "extensions": {"KHR_materials_unlit": {}}})", "unlit"},
      {R"({"name": "m", "pbrMetallicRoughness": {"roughnessFactor": 0.3},
           "extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}}})",
       "anisotropic"},
  };
  for (const auto& [material, words] : cases) {
    here.write("scene.gltf", scene_of("[" + material + "]", 1));
    here.write("out.binary", "kept");
    const Outcome outcome = here.eikon("measure scene.gltf --material m -o out.binary");
    EXPECT_TRUE(refused(outcome, kInput)) << material << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "material 'm'") && contains(outcome.err, words)) << outcome.err;
    EXPECT_EQ(read_bytes(here / "out.binary"), "kept");
    EXPECT_EQ(here.files().size(), 2U);
  }
}

TEST(Measure, bad_arguments_and_full_disks_leave_nothing_behind) {
  const Workplace here;
  here.write("scene.gltf", scene_of("[" + std::string(kCopper) + "]", 1));
  const Outcome unknown = here.eikon("measure scene.gltf --material gold -o out.binary");
  EXPECT_TRUE(refused(unknown, kUsage));
  EXPECT_TRUE(contains(unknown.err, "'gold'") && contains(unknown.err, "material 'copper'")) << unknown.err;
  EXPECT_TRUE(refused(here.eikon("measure scene.gltf --material 1 -o out.binary"), kUsage));
  EXPECT_TRUE(refused(here.eikon("measure scene.gltf --material copper --uv 1 -o out.binary"), kUsage));
  EXPECT_TRUE(refused(here.eikon("measure scene.gltf --material copper -o none/out.binary"), kInput));
  EXPECT_TRUE(refused(here.eikon("measure none.gltf --material copper -o out.binary"), kInput));
  EXPECT_TRUE(refused(here.eikon("measure scene.gltf --material copper -o out.binary", "ulimit -f 40000;"), kInput));
  EXPECT_EQ(here.files(), std::vector<std::string>{"scene.gltf"});
}

TEST(Measure, M23_a_table_that_is_none_is_one_line) {
  const Workplace here;
  here.write("table.gltf", scene_of("[" + std::string(kByTable) + "]", 1));
  for (const std::string& bytes : {std::string("x"), std::string(100, '\0'), std::string(100, '\xff')}) {
    here.write("copper.binary", bytes);
    const Outcome outcome = here.eikon("render table.gltf -o out.exr");
    EXPECT_TRUE(refused(outcome, kInput));
    EXPECT_TRUE(contains(outcome.err, "material 'table'") && contains(outcome.err, "'copper.binary'")) << outcome.err;
  }
  std::filesystem::remove(here / "copper.binary");
  EXPECT_TRUE(refused(here.eikon("info table.gltf"), kInput));
  EXPECT_EQ(here.files(), std::vector<std::string>{"table.gltf"});
}

TEST(Measure, light_beyond_what_arrives_is_an_error_under_strict) {
  const Workplace here;
  here.write("table.gltf", scene_of("[" + std::string(kByTable) + "]", 1));
  // f of 1: pi times the light.
  std::string bytes(kTableBytes, '\0');
  const std::int32_t dimensions[] = {90, 90, 180};
  std::memcpy(bytes.data(), dimensions, 12);
  const double value = 1500;
  for (std::size_t at = 12; at < bytes.size() / 3; at += 8) std::memcpy(&bytes[at], &value, 8);
  here.write("copper.binary", bytes);
  const Outcome lenient = here.eikon("render table.gltf -o out.exr --size 8x8 --spp 1 --quiet");
  EXPECT_TRUE(succeeded(lenient));
  const Outcome strict = here.eikon("info table.gltf --strict");
  EXPECT_EQ(strict.code, kInput);
  EXPECT_TRUE(contains(strict.err, "reflects 3.1") && contains(strict.err, "--strict")) << strict.err;
}

}  // namespace
}  // namespace eikon::test
