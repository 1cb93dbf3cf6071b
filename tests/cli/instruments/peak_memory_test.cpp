// SPDX-License-Identifier: Apache-2.0
// What many triangles take of the host's memory, from the file's bytes to the film.
#include <fmt/format.h>
#include <sys/resource.h>

#include <cstdint>
#include <cstring>
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

/// A .glb of meshes of side x side vertices with normals, indexed: 24 bytes per triangle. They share what the file has, but
/// each is read for itself.
std::string sheet(std::uint32_t side) {
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
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", 5126},
         {"count", positions.size() / 3},
         {"type", "VEC3"},
         {"min", {0, 0, 0}},
         {"max", {1, 1, 0}}},
        {{"bufferView", 1}, {"componentType", 5126}, {"count", positions.size() / 3}, {"type", "VEC3"}},
        {{"bufferView", 2}, {"componentType", 5125}, {"count", indices.size()}, {"type", "SCALAR"}}}},
      {"scenes", {{{"nodes", nlohmann::json::array()}}}},
      {"scene", 0}};
  for (std::uint32_t mesh = 0; mesh < kMeshes; ++mesh) {
    const nlohmann::json primitive = {{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}};
    document["meshes"].push_back({{"primitives", {primitive}}});
    document["nodes"].push_back({{"mesh", mesh}, {"translation", {0, 0, mesh}}});
    document["scenes"][0]["nodes"].push_back(mesh);
  }
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
  here.write("small.glb", sheet(2));
  here.write("large.glb", sheet(side));
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
