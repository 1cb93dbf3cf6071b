// SPDX-License-Identifier: Apache-2.0
// Meshes in meshoptimizer's codecs: what they hold, and what happens when they lie.
#include <meshoptimizer.h>

#include <limits>

#include "support/compressed_sheet.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kByte;
using scene_test::kFloat;
using scene_test::kSide;
using scene_test::kUnsignedShort;
using scene_test::Lie;
using scene_test::message_of;
using scene_test::refused_or_sound;
using scene_test::Sheet;
using scene_test::soup;
using scene_test::TemporaryFolder;

constexpr std::int64_t kHuge = std::numeric_limits<std::int64_t>::max();

using Encoded = std::vector<unsigned char>;

Encoded encode_vertices(const void* data, std::size_t count, std::size_t stride) {
  Encoded out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), data, count, stride));
  return out;
}

/// The sheet in the codecs of meshoptimizer; `data` may be changed before the file is written.
struct MeshoptFile {
  Builder builder;
  std::vector<std::pair<std::size_t, Encoded>> data;  // bufferView, compressed bytes

  explicit MeshoptFile(bool as_sequence = false) {
    const Sheet sheet;
    const std::size_t vertices = sheet.vertex_count(), corners = sheet.indices.size();
    builder.json["buffers"] = {
        {{"byteLength", 0}},
        {{"byteLength", 1 << 20}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
    add(encode_vertices(sheet.positions.data(), vertices, 12), vertices, 12, "ATTRIBUTES", "NONE", "VEC3", kFloat);
    // Normals of 8 bits, octahedral, padded to 4 bytes.
    std::vector<float> four;
    for (std::size_t i = 0; i < vertices; ++i) {
      four.insert(four.end(), {sheet.normals[3 * i], sheet.normals[3 * i + 1], sheet.normals[3 * i + 2], 0});
    }
    std::vector<signed char> octahedral(4 * vertices);
    meshopt_encodeFilterOct(octahedral.data(), vertices, 4, 8, four.data());
    add(encode_vertices(octahedral.data(), vertices, 4), vertices, 4, "ATTRIBUTES", "OCTAHEDRAL", "VEC3", kByte);
    Encoded indices(as_sequence ? meshopt_encodeIndexSequenceBound(corners, vertices)
                                : meshopt_encodeIndexBufferBound(corners, vertices));
    indices.resize(as_sequence
                       ? meshopt_encodeIndexSequence(indices.data(), indices.size(), sheet.indices.data(), corners)
                       : meshopt_encodeIndexBuffer(indices.data(), indices.size(), sheet.indices.data(), corners));
    add(indices, corners, 2, as_sequence ? "INDICES" : "TRIANGLES", nullptr, "SCALAR", kUnsignedShort);
    accessor(1)["normalized"] = true;
    builder.primitive()["attributes"] = {{"POSITION", 2}, {"NORMAL", 3}};
    builder.primitive()["indices"] = 4;
    builder.json["extensionsRequired"] = {"EXT_meshopt_compression", "KHR_mesh_quantization"};
    builder.json["extensionsUsed"] = {"EXT_meshopt_compression", "KHR_mesh_quantization", "KHR_materials_specular"};
  }

  void add(const Encoded& bytes, std::size_t count, std::size_t stride, const char* mode, const char* filter,
           const char* type, int component) {
    Json extension = {{"buffer", 0}, {"count", count}, {"byteStride", stride}, {"mode", mode}};
    if (filter != nullptr) extension["filter"] = filter;
    Json view = {{"buffer", 1}, {"byteLength", count * stride}};
    if (std::string(mode) == "ATTRIBUTES") view["byteStride"] = stride;
    view["extensions"]["EXT_meshopt_compression"] = extension;
    builder.json["bufferViews"].push_back(view);
    const std::size_t index = builder.json["bufferViews"].size() - 1;
    builder.json["accessors"].push_back(
        {{"bufferView", index}, {"componentType", component}, {"count", count}, {"type", type}});
    data.emplace_back(index, bytes);
  }
  Json& view(std::size_t i) { return builder.json["bufferViews"][data[i].first]; }
  Json& extension(std::size_t i) { return view(i)["extensions"]["EXT_meshopt_compression"]; }
  Json& accessor(std::size_t i) { return builder.json["accessors"][2 + i]; }
  /// `extension`: the name under which the file is written.
  [[nodiscard]] Scene load(const std::string& extension = "EXT_meshopt_compression") const {
    Builder copy = builder;
    for (const auto& [view, bytes] : data) {
      copy.buffer.resize((copy.buffer.size() + 3) / 4 * 4, '\0');
      const Json::json_pointer place("/bufferViews/" + std::to_string(view) + "/extensions/EXT_meshopt_compression");
      if (copy.json.contains(place) && copy.json[place].is_object()) {
        copy.json[place].emplace("byteOffset", copy.buffer.size());
        copy.json[place].emplace("byteLength", bytes.size());
      }
      copy.buffer += scene_test::bytes_of(bytes);
    }
    copy.json["buffers"][0]["byteLength"] = copy.buffer.size();
    const std::string text = copy.json.dump(), name = "EXT_meshopt_compression";
    std::string renamed;
    for (std::size_t from = 0, at = 0; from < text.size(); from = at + name.size()) {
      at = std::min(text.find(name, from), text.size());
      renamed += text.substr(from, at - from) + (at < text.size() ? extension : "");
    }
    copy.json = Json::parse(renamed);
    const TemporaryFolder folder;
    return eikon::load_scene(folder.write("scene.glb", copy.glb_bytes()));
  }
};

TEST(SceneCompression, meshopt_vertices_triangles_and_sequences_hold_the_mesh) {
  for (const bool as_sequence : {false, true}) {
    const Scene scene = MeshoptFile(as_sequence).load();
    EXPECT_EQ(soup(scene), soup(Sheet()));
    const eikon::Primitive& primitive = scene.meshes.at(0).primitives.at(0);
    ASSERT_EQ(primitive.normals_object.size(), kSide * kSide);
    for (std::size_t i = 0; i < primitive.normals_object.size(); ++i) {
      const glm::vec3 want = glm::normalize(glm::vec3(primitive.positions_object[i].x, 0, 1));
      EXPECT_LT(glm::length(primitive.normals_object[i] - want), 0.02F);  // 8 bits
    }
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_TRUE(scene.unsupported.empty());
  }
}

TEST(SceneCompression, the_ratified_name_is_the_same_and_newer_streams_and_filters_are_refused_by_name) {
  const std::string ratified = "KHR_meshopt_compression";
  MeshoptFile file;
  const Scene scene = file.load(ratified);
  EXPECT_EQ(soup(scene), soup(Sheet()));
  EXPECT_TRUE(scene.warnings.empty() && scene.unsupported.empty());
  file.data[0].second[0] = 0xA1;
  for (const std::string& name : {ratified, std::string("EXT_meshopt_compression")}) {
    const std::string message = message_of([&] { (void)file.load(name); });
    EXPECT_TRUE(contains(message, name + ": the data are of version 1 of meshoptimizer's vertex codec"));
  }
  file.extension(0)["filter"] = "COLOR";
  EXPECT_TRUE(contains(message_of([&] { (void)file.load(ratified); }), "'filter' COLOR is not read yet"));
  EXPECT_TRUE(contains(message_of([&] { (void)file.load(); }), "'filter' is none of"));
}

TEST(SceneCompression, a_meshopt_fallback_needs_no_tag_and_no_bytes) {
  MeshoptFile file;
  file.builder.json["buffers"][1].erase("extensions");
  const Scene scene = file.load();
  EXPECT_EQ(soup(scene), soup(Sheet()));
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(SceneCompression, meshopt_exponential_positions_are_close) {
  MeshoptFile file;
  const Sheet sheet;
  std::vector<std::uint32_t> encoded(sheet.positions.size());
  meshopt_encodeFilterExp(encoded.data(), sheet.vertex_count(), 12, 15, sheet.positions.data());
  file.data[0].second = encode_vertices(encoded.data(), sheet.vertex_count(), 12);
  file.extension(0)["filter"] = "EXPONENTIAL";
  const Scene scene = file.load();
  for (const glm::vec3& p : scene.meshes.at(0).primitives.at(0).positions_object) {
    EXPECT_LT(glm::length(p - glm::round(p)), 1e-3F);
  }
  EXPECT_EQ(soup(scene).size(), 50U);
}

TEST(SceneCompression, a_meshopt_fallback_with_data_is_no_reason_to_read_it) {
  MeshoptFile file;
  file.builder.json["buffers"][1] = {{"byteLength", 1000},
                                     {"uri", "data:;base64," + scene_test::base64(std::string(1000, '\x7F'))}};
  EXPECT_EQ(soup(file.load()), soup(Sheet()));
}

TEST(SceneCompression, meshopt_views_that_lie_are_refused) {
  const std::vector<Lie<MeshoptFile>> lies{
      {"not an object", [](MeshoptFile& f) { f.extension(0) = 7; }, "is not an object"},
      {"no buffer", [](MeshoptFile& f) { f.extension(0).erase("buffer"); }, "'buffer' is missing"},
      {"another buffer", [](MeshoptFile& f) { f.extension(0)["buffer"] = 2; }, "names buffer 2"},
      {"the placeholder", [](MeshoptFile& f) { f.extension(0)["buffer"] = 1; }, "of 0 bytes"},
      {"beyond the buffer", [](MeshoptFile& f) { f.extension(0)["byteOffset"] = 100000; }, "are outside buffer 0"},
      {"an offset that wraps", [](MeshoptFile& f) { f.extension(0)["byteOffset"] = kHuge; }, "'byteOffset'"},
      {"a length that wraps", [](MeshoptFile& f) { f.extension(0)["byteLength"] = kHuge; }, "'byteLength'"},
      {"no count", [](MeshoptFile& f) { f.extension(0).erase("count"); }, "'count' is missing"},
      {"more elements", [](MeshoptFile& f) { f.extension(0)["count"] = 37; }, "the 432 bytes of the bufferView"},
      {"countless elements",
       [](MeshoptFile& f) {
         f.extension(0)["count"] = 4000000000LL;
         f.view(0)["byteLength"] = 48000000000LL;
       },
       "cannot be in"},
      {"countless triangles",
       [](MeshoptFile& f) {
         f.extension(2)["count"] = 3000000000LL;
         f.view(2)["byteLength"] = 6000000000LL;
       },
       "cannot be in"},
      {"stride 0",
       [](MeshoptFile& f) {
         f.extension(0)["byteStride"] = 0;
         f.view(0)["byteLength"] = 0;
       },
       "'byteStride' 0"},
      {"stride 260", [](MeshoptFile& f) { f.extension(0)["byteStride"] = 260; }, "'byteStride'"},
      {"stride 6", [](MeshoptFile& f) { f.extension(0)["byteStride"] = 6; }, "'byteStride' 6"},
      {"another stride than the view", [](MeshoptFile& f) { f.view(0)["byteStride"] = 16; }, "is not the 16"},
      {"octahedral of 12", [](MeshoptFile& f) { f.extension(0)["filter"] = "OCTAHEDRAL"; }, "'byteStride' 12"},
      {"quaternions of 12", [](MeshoptFile& f) { f.extension(0)["filter"] = "QUATERNION"; }, "'byteStride' 12"},
      {"indices of 3", [](MeshoptFile& f) { f.extension(2)["byteStride"] = 3; }, "'byteStride' 3"},
      {"two and a half triangles",
       [](MeshoptFile& f) {
         f.extension(2)["count"] = 149;
         f.view(2)["byteLength"] = 298;
       },
       "no whole number of triangles"},
      {"a filter on indices", [](MeshoptFile& f) { f.extension(2)["filter"] = "OCTAHEDRAL"; }, "ATTRIBUTES only"},
      {"an unknown filter", [](MeshoptFile& f) { f.extension(0)["filter"] = "COLOR"; }, "'filter' is none of"},
      {"no mode", [](MeshoptFile& f) { f.extension(0).erase("mode"); }, "'mode' is none of"},
      {"vertices as triangles", [](MeshoptFile& f) { std::swap(f.data[0].second, f.data[2].second); }, "do not decode"},
      {"half of it", [](MeshoptFile& f) { f.data[0].second.resize(f.data[0].second.size() / 2); }, "do not decode"},
      {"nothing", [](MeshoptFile& f) { f.data[1].second.clear(); }, "cannot be in 0 bytes"},
      {"a newer codec", [](MeshoptFile& f) { f.data[0].second[0] = 0xA1; }, "of version 1"},
      {"a placeholder read without the extension", [](MeshoptFile& f) { f.view(0).erase("extensions"); },
       "buffer 1 has neither a URI"},
  };
  for (const Lie<MeshoptFile>& lie : lies) {
    SCOPED_TRACE(lie.name);
    MeshoptFile file;
    lie.tell(file);
    const std::string message = message_of([&] { (void)file.load(); });
    EXPECT_TRUE(contains(message, lie.says));
  }
}

TEST(SceneCompression, meshopt_views_cannot_multiply_one_piece_of_data) {
  // Zeros compress best; the more views share them, the more comes out.
  const std::vector<std::uint32_t> zeros(1U << 18U);
  const Encoded bytes = encode_vertices(zeros.data(), zeros.size() / 4, 16);
  MeshoptFile file;
  for (int i = 0; i < 40; ++i)
    file.add(i == 0 ? bytes : Encoded{}, zeros.size() / 4, 16, "ATTRIBUTES", nullptr, "VEC4", kFloat);
  const std::size_t shared = 3;
  for (std::size_t i = shared; i < file.data.size(); ++i) {
    file.extension(i)["byteOffset"] = 0;  // set below, once the place of the data is known
    file.extension(i)["byteLength"] = bytes.size();
  }
  std::size_t offset = file.builder.buffer.size();
  for (std::size_t i = 0; i < shared; ++i) offset = (offset + 3) / 4 * 4 + file.data[i].second.size();
  for (std::size_t i = shared; i < file.data.size(); ++i) file.extension(i)["byteOffset"] = (offset + 3) / 4 * 4;
  const std::string message = message_of([&] { (void)file.load(); });
  EXPECT_TRUE(contains(message, "64 times the file"));
}

TEST(SceneCompression, damaged_meshopt_data_decode_or_are_refused) {
  std::mt19937 random(11);
  const MeshoptFile triangles(false), sequence(true);
  int refused = 0;
  for (int round = 0; round < 600; ++round) {
    MeshoptFile file = round % 2 == 0 ? triangles : sequence;
    for (int change = 0; change <= round % 3; ++change) {
      Encoded& bytes = file.data[random() % 3].second;
      bytes[random() % bytes.size()] = static_cast<unsigned char>(random() & 0xFFU);
    }
    refused += refused_or_sound(file) ? 1 : 0;
  }
  EXPECT_GT(refused, 80);
}

}  // namespace
