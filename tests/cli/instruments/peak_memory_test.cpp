// SPDX-License-Identifier: Apache-2.0
// What many triangles take of the host's memory, from the file's bytes to the film.
#include <draco/compression/encode.h>
#include <fmt/format.h>
#include <meshoptimizer.h>
#include <sys/resource.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "support/gltf_builder.h"

namespace eikon::test {
namespace {

using scene_test::kFloat;
using scene_test::kUnsignedByte;
using scene_test::kUnsignedInt;

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

/// A .glb of meshes of side x side vertices with normals, indexed: 24 bytes per triangle. Each
/// begins one vertex after the one before, so they share bytes, but no accessor. emits: every
/// triangle is a light
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
      {"accessors", {accessor(2, 0, kUnsignedInt, indices.size(), "SCALAR")}},
      {"scenes", {{{"nodes", nlohmann::json::array()}}}},
      {"scene", 0}};
  if (emits) document["materials"] = {{{"emissiveFactor", {1, 1, 1}}}};
  for (std::uint32_t mesh = 0; mesh < meshes; ++mesh) {
    for (const int view : {0, 1})
      document["accessors"].push_back(accessor(view, mesh * step, kFloat, vertices, "VEC3"));
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
      {"accessors", {accessor(0, 0, kFloat, kVertices, "VEC3"), accessor(1, 0, kUnsignedByte, corners, "SCALAR")}},
      {"nodes", {{{"mesh", 0}}}},
      {"scenes", {{{"nodes", {0}}}}},
      {"scene", 0}};
  nlohmann::json primitives = nlohmann::json::array();
  for (int i = 0; i < 20; ++i) primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"mode", 5}});
  document["meshes"].push_back({{"primitives", primitives}});
  return scene_test::glb(document.dump(), std::move(binary));
}

/// A flat grid, which both codecs compress best of all: corners on a lattice of side x side.
struct Grid {
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;

  explicit Grid(std::uint32_t side) {
    for (std::uint32_t y = 0; y < side; ++y)
      for (std::uint32_t x = 0; x < side; ++x) {
        positions.insert(positions.end(), {float(x), float(y), 0.0F});
        const std::uint32_t a = y * side + x;
        if (x + 1 < side && y + 1 < side)
          indices.insert(indices.end(), {a, a + 1, a + side, a + 1, a + side + 1, a + side});
      }
  }
  [[nodiscard]] std::size_t vertex_count() const { return positions.size() / 3; }
  [[nodiscard]] std::size_t bytes() const { return (positions.size() + indices.size()) * sizeof(float); }
};

/// A document of one mesh of the grid, whose accessors have no bufferViews yet.
nlohmann::json document_of(const Grid& grid, std::size_t buffer_bytes) {
  return {{"asset", {{"version", "2.0"}}},
          {"buffers", {{{"byteLength", buffer_bytes}}}},
          {"accessors",
           {{{"componentType", kFloat}, {"count", grid.vertex_count()}, {"type", "VEC3"}},
            {{"componentType", kUnsignedInt}, {"count", grid.indices.size()}, {"type", "SCALAR"}}}},
          {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
          {"nodes", {{{"mesh", 0}}}},
          {"scenes", {{{"nodes", {0}}}}},
          {"scene", 0}};
}

std::string in_draco(const Grid& grid) {
  draco::Mesh mesh;
  mesh.set_num_points(std::uint32_t(grid.vertex_count()));
  for (std::size_t i = 0; i < grid.indices.size(); i += 3)
    mesh.AddFace({draco::PointIndex(grid.indices[i]), draco::PointIndex(grid.indices[i + 1]),
                  draco::PointIndex(grid.indices[i + 2])});
  draco::GeometryAttribute positions;
  positions.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
  const int id = mesh.AddAttribute(positions, true, mesh.num_points());
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i)
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), &grid.positions[3 * i]);
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 10);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  draco::EncoderBuffer stream;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &stream).ok());
  nlohmann::json document = document_of(grid, stream.size());
  document["bufferViews"] = {{{"buffer", 0}, {"byteLength", stream.size()}}};
  document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", 0}, {"attributes", {{"POSITION", mesh.attribute(id)->unique_id()}}}};
  document["extensionsUsed"] = document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return scene_test::glb(document.dump(), std::string(stream.data(), stream.size()));
}

std::string in_meshopt(const Grid& grid) {
  const std::size_t vertices = grid.vertex_count(), corners = grid.indices.size();
  std::vector<unsigned char> positions(meshopt_encodeVertexBufferBound(vertices, 12)),
      indices(meshopt_encodeIndexBufferBound(corners, vertices));
  positions.resize(meshopt_encodeVertexBuffer(positions.data(), positions.size(), grid.positions.data(), vertices, 12));
  indices.resize(meshopt_encodeIndexBuffer(indices.data(), indices.size(), grid.indices.data(), corners));
  std::string binary;
  append(binary, positions);
  append(binary, indices);
  nlohmann::json document = document_of(grid, binary.size());
  document["buffers"].push_back({{"byteLength", grid.bytes()}});
  const auto view = [&](std::size_t offset, std::size_t length, std::size_t count, std::size_t stride,
                        const char* mode) {
    nlohmann::json packed = {{"buffer", 0},          {"byteOffset", offset}, {"byteLength", length},
                             {"byteStride", stride}, {"count", count},       {"mode", mode}};
    nlohmann::json whole = {{"buffer", 1}, {"byteLength", count * stride}};
    whole["extensions"]["EXT_meshopt_compression"] = packed;
    return whole;
  };
  document["bufferViews"] = {view(0, positions.size(), vertices, 12, "ATTRIBUTES"),
                             view(positions.size(), indices.size(), corners, 4, "TRIANGLES")};
  for (int i = 0; i < 2; ++i) document["accessors"][std::size_t(i)]["bufferView"] = i;
  document["extensionsUsed"] = document["extensionsRequired"] = {"EXT_meshopt_compression"};
  return scene_test::glb(document.dump(), std::move(binary));
}

/// The number, in 10^6, that stands before a text in what `eikon info` prints; -1 without it.
double megabytes_before(const std::string& printed, const std::string& text) {
  const std::size_t end = printed.find(text), begin = printed.rfind(' ', end - 1);
  return end == std::string::npos ? -1 : std::stod(printed.substr(begin));
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
  for (const char* file : {"small.glb", "large.glb"}) here.peak_bytes(fmt::format("render {}{}", file, how));
  const std::int64_t small = here.peak_bytes("render small.glb" + how);
  const std::int64_t large = here.peak_bytes("render large.glb" + how);
  ASSERT_GT(small, 0);
  ASSERT_GT(large, 0);
  // A Triangle, its TriangleNormals and an entry in the list of triangles; and half of the meshes,
  // 12 bytes, for the one that is being packed and for what the C library keeps of memory that was
  // given back. All meshes beside the records would be 24 bytes, another copy of the records 128.
  EXPECT_LT(double(large - small) / double(triangles_of(side)), 64 + 64 + 4 + 12) << large << " and " << small;
}

TEST(PeakMemory, of_info_is_at_most_three_times_the_file) {
  const Workplace here;
  here.write("bare.glb", strips(3));
  here.write("dense.glb", sheets(1001, 1));       // 2 million triangles: packed and with a tree they take 600 MB
  here.write("glow.glb", sheets(1001, 1, true));  // with lights and their tree they take 600 MB more
  here.write("strips.glb", strips(275'000));      // 5.5 million triangles in .3 MB
  const std::int64_t bare = here.peak_bytes("info bare.glb");
  ASSERT_GT(bare, 0);
  for (const char* file : {"dense.glb", "glow.glb", "strips.glb"}) {
    const std::int64_t peak = here.peak_bytes(fmt::format("info {}", file));
    ASSERT_GT(peak, 0) << file;
    EXPECT_LE(double(peak) - double(bare), 3 * double(std::filesystem::file_size(here / file)))
        << file << ": " << peak << " and " << bare;
  }
}

TEST(PeakMemory, of_info_with_compressed_meshes_is_within_what_it_says_of_them) {
  const Workplace here;
  const Grid grid(801);  // 1.28 million triangles
  here.write("bare.glb", strips(3));
  here.write("draco.glb", in_draco(grid));
  here.write("meshopt.glb", in_meshopt(grid));
  const std::int64_t bare = here.peak_bytes("info bare.glb");
  ASSERT_GT(bare, 0);
  EXPECT_FALSE(contains(here.eikon("info bare.glb").out, "compressed"));
  for (const std::string file : {"draco.glb", "meshopt.glb"}) {
    const std::string printed = here.eikon("info " + file).out;
    EXPECT_NEAR(megabytes_before(printed, " MB unpacked"), double(grid.bytes()) * 1e-6, 0.06) << printed;
    EXPECT_NEAR(megabytes_before(printed, " MB in the file"), double(std::filesystem::file_size(here / file)) * 1e-6,
                0.1)
        << printed;
    const double decoder = megabytes_before(printed, " MB at most");
    EXPECT_EQ(decoder > 0, file == "draco.glb") << printed;
    const std::int64_t peak = here.peak_bytes("info " + file);
    ASSERT_GT(peak, 0) << file;
    const double file_bytes = double(std::filesystem::file_size(here / file));
    EXPECT_LE(double(peak) - double(bare), file_bytes + double(grid.bytes()) + std::max(decoder, 0.0) * 1e6)
        << file << ": " << peak << " and " << bare << "\n"
        << printed;
    EXPECT_LE(double(peak) - double(bare), 3 * (file_bytes + double(grid.bytes()))) << file;
  }
}

TEST(PeakMemory, does_not_grow_with_samples) {
  const Workplace here;
  // Room for so many samples would be 12 bytes each: 3 and 25 MB. Units are as large in both, and
  // the set of samples has no more parts.
  const auto peak = [&](int spp) {
    return here.peak_bytes("render --devices cpu " + scene("cornell.gltf") + " -o out.exr --size 64x64 --quiet --spp " +
                           std::to_string(spp));
  };
  (void)peak(4);  // compiles
  const std::uint64_t few = peak(64), many = peak(512);
  ASSERT_GT(few, 0U);
  ASSERT_GT(many, 0U);
  EXPECT_LT(double(many), 1.02 * double(few) + 2e6);
}

}  // namespace
}  // namespace eikon::test
