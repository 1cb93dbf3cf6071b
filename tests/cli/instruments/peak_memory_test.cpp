// SPDX-License-Identifier: Apache-2.0
// What many triangles take of the host's memory, from the file's bytes to the film.
#include <fmt/format.h>
#include <sys/resource.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "support/gltf_builder.h"

namespace eikon::test {
namespace {

template <class T>
void append(std::string& bytes, const std::vector<T>& values) {
  const std::size_t end = bytes.size();
  bytes.resize(end + values.size() * sizeof(T));
  std::memcpy(bytes.data() + end, values.data(), values.size() * sizeof(T));
}

constexpr std::uint32_t kMeshes = 8;

constexpr std::uint64_t triangles_of(std::uint32_t side) {
  return std::uint64_t{2} * kMeshes * (side - 1) * (side - 1);
}

nlohmann::json accessor(int view, std::size_t offset, int component, std::size_t count, const char* type) {
  return {{"bufferView", view}, {"byteOffset", offset}, {"componentType", component}, {"count", count}, {"type", type}};
}

/// A .glb of meshes of side x side vertices with normals, indexed: 24 bytes per triangle. Each begins one vertex after the
/// one before, so they share bytes, but no accessor. emits: every triangle is a light
std::string sheets(std::uint32_t side, std::uint32_t meshes, bool emits = false) {
  std::vector<float> positions, normals;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      positions.insert(positions.end(), {float(x) / float(side - 1), float(y) / float(side - 1), 0.0F});
      normals.insert(normals.end(), {0.0F, 0.6F, 0.8F});
      if (x + 1 == side || y + 1 == side) continue;
      const std::uint32_t a = y * side + x;
      indices.insert(indices.end(), {a, a + 1, a + side, a + 1, a + side + 1, a + side});
    }
  const std::size_t vertices = positions.size() / 3, step = 3 * sizeof(float);
  positions.resize(positions.size() + 3 * meshes, 0.5F);
  normals.resize(positions.size(), 0.6F);
  std::string binary;
  const std::size_t plane = positions.size() * sizeof(float);
  append(binary, positions);
  append(binary, normals);
  append(binary, indices);
  nlohmann::json document = {
      {"asset", {{"version", "2.0"}}},
      {"buffers", {{{"byteLength", binary.size()}}}},
      {"bufferViews",
       {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", plane}},
        {{"buffer", 0}, {"byteOffset", plane}, {"byteLength", plane}},
        {{"buffer", 0}, {"byteOffset", 2 * plane}, {"byteLength", indices.size() * sizeof(std::uint32_t)}}}},
      {"accessors", {accessor(2, 0, 5125, indices.size(), "SCALAR")}},
      {"scenes", {{{"nodes", nlohmann::json::array()}}}},
      {"scene", 0}};
  if (emits) document["materials"] = {{{"emissiveFactor", {1, 1, 1}}}};
  for (std::uint32_t mesh = 0; mesh < meshes; ++mesh) {
    for (const int view : {0, 1}) document["accessors"].push_back(accessor(view, mesh * step, 5126, vertices, "VEC3"));
    nlohmann::json primitive = {{"attributes", {{"POSITION", 2 * mesh + 1}, {"NORMAL", 2 * mesh + 2}}}, {"indices", 0}};
    if (emits) primitive["material"] = 0;
    document["meshes"].push_back({{"primitives", {primitive}}});
    document["nodes"].push_back({{"mesh", mesh}, {"translation", {0, 0, mesh}}});
    document["scenes"][0]["nodes"].push_back(mesh);
  }
  return scene_test::glb(document.dump(), std::move(binary));
}

/// A .glb of one mesh: 20 strips of the same `corners` bytes, each a triangle more per byte.
std::string strips(std::size_t corners) {
  constexpr std::size_t kVertices = 251;
  std::vector<float> positions;
  for (std::size_t i = 0; i < 3 * kVertices; ++i) positions.push_back(float(i * i % 97));
  std::vector<std::uint8_t> indices;
  for (std::size_t i = 0; i < corners; ++i) indices.push_back(std::uint8_t(i % kVertices));
  std::string binary;
  append(binary, positions);
  append(binary, indices);
  const std::size_t plane = positions.size() * sizeof(float);
  nlohmann::json document = {
      {"asset", {{"version", "2.0"}}},
      {"buffers", {{{"byteLength", binary.size()}}}},
      {"bufferViews",
       {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", plane}},
        {{"buffer", 0}, {"byteOffset", plane}, {"byteLength", corners}}}},
      {"accessors", {accessor(0, 0, 5126, kVertices, "VEC3"), accessor(1, 0, 5121, corners, "SCALAR")}},
      {"nodes", {{{"mesh", 0}}}},
      {"scenes", {{{"nodes", {0}}}}},
      {"scene", 0}};
  nlohmann::json primitives = nlohmann::json::array();
  for (int i = 0; i < 20; ++i) primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"mode", 5}});
  document["meshes"].push_back({{"primitives", primitives}});
  return scene_test::glb(document.dump(), std::move(binary));
}

/// Most bytes that a run had in memory at a time; 0 if it failed.
std::uint64_t peak_bytes(const Workplace& here, const std::string& arguments) {
  const pid_t child = here.start(arguments);
  int status = 0;
  rusage usage{};
  if (wait4(child, &status, 0, &usage) != child || status != 0) return 0;
  return std::uint64_t(usage.ru_maxrss) * 1024;
}

TEST(PeakMemory, of_a_render_is_what_its_devices_read_and_no_copy_of_it) {
  const Workplace here;
  if (here.eikon("render --devices cpu " + scene("furnace.gltf") + " --size 4x4 --spp 1 --quiet").code != 0)
    GTEST_SKIP() << "other devices than CPUs have memory of their own";
  constexpr std::uint32_t side = 501;
  here.write("small.glb", sheets(2, kMeshes));
  here.write("large.glb", sheets(side, kMeshes));
  // Without a tree, whose building takes what it likes; one ray per pixel, against all triangles.
  const std::string how = " --devices cpu --accel none --size 2x2 --spp 1 --max-depth 1 --quiet -o out.exr";
  // Compiles, which takes a hundred megabytes: large trees have programs of their own.
  for (const char* file : {"small.glb", "large.glb"}) peak_bytes(here, fmt::format("render {}{}", file, how));
  const std::uint64_t small = peak_bytes(here, "render small.glb" + how);
  const std::uint64_t large = peak_bytes(here, "render large.glb" + how);
  ASSERT_GT(small, 0U);
  ASSERT_GT(large, 0U);
  // A Triangle, its TriangleNormals and an entry in the list of triangles; and half of the meshes, 12 bytes, for the one that
  // is being packed and for what the C library keeps of memory that was given back. All meshes beside the records would be 24
  // bytes, another copy of the records 128.
  EXPECT_LT(double(large - small) / double(triangles_of(side)), 64 + 64 + 4 + 12) << large << " and " << small;
}

TEST(PeakMemory, of_info_is_at_most_three_times_the_file) {
  const Workplace here;
  here.write("bare.glb", strips(3));
  here.write("dense.glb", sheets(1001, 1));       // 2 million triangles: packed and with a tree they take 600 MB
  here.write("glow.glb", sheets(1001, 1, true));  // with lights and their tree they take 600 MB more
  here.write("strips.glb", strips(275'000));      // 5.5 million triangles in .3 MB
  const std::uint64_t bare = peak_bytes(here, "info bare.glb");
  ASSERT_GT(bare, 0U);
  for (const char* file : {"dense.glb", "glow.glb", "strips.glb"}) {
    const std::uint64_t peak = peak_bytes(here, fmt::format("info {}", file));
    ASSERT_GT(peak, 0U) << file;
    EXPECT_LE(double(peak) - double(bare), 3 * double(std::filesystem::file_size(here / file)))
        << file << ": " << peak << " and " << bare;
  }
}

TEST(PeakMemory, does_not_grow_with_samples) {
  const Workplace here;
  // Room for so many samples would be 12 bytes each: 3 and 25 MB. Units are as large in both, and the ledger has no more parts.
  const auto peak = [&](int spp) {
    return peak_bytes(here, "render --devices cpu " + scene("cornell.gltf") +
                                " -o out.exr --size 64x64 --quiet --spp " + std::to_string(spp));
  };
  (void)peak(4);  // compiles
  const std::uint64_t few = peak(64), many = peak(512);
  ASSERT_GT(few, 0U);
  ASSERT_GT(many, 0U);
  EXPECT_LT(double(many), 1.02 * double(few) + 2e6);
}

}  // namespace
}  // namespace eikon::test
