// SPDX-License-Identifier: Apache-2.0
// Meshes in Draco's and meshoptimizer's codecs: what they hold, and what happens when they lie.
#include <draco/compression/encode.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>

#include "scene_builder.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::Json;
using scene_test::mentions;
using scene_test::message_of;
using scene_test::TemporaryFolder;

constexpr std::uint32_t kSide = 6;
constexpr std::int64_t kHuge = std::numeric_limits<std::int64_t>::max();

/// A bumpy sheet of kSide x kSide vertices with normals and colours.
struct Sheet {
  std::vector<float> positions, normals;
  std::vector<std::uint8_t> colors;  // RGBA
  std::vector<std::uint32_t> indices;
  Sheet() {
    for (std::uint32_t j = 0; j < kSide; ++j) {
      for (std::uint32_t i = 0; i < kSide; ++i) {
        const float x = static_cast<float>(i), y = static_cast<float>(j), z = static_cast<float>((i * j) % 3);
        positions.insert(positions.end(), {x, y, z});
        const float length = std::sqrt(x * x + 1.0F);
        normals.insert(normals.end(), {x / length, 0.0F, 1.0F / length});
        colors.insert(colors.end(), {static_cast<std::uint8_t>(i * 40), static_cast<std::uint8_t>(j * 40), 255, 255});
      }
    }
    for (std::uint32_t j = 0; j + 1 < kSide; ++j) {
      for (std::uint32_t i = 0; i + 1 < kSide; ++i) {
        const std::uint32_t a = j * kSide + i;
        for (const std::uint32_t k : {a, a + 1, a + kSide + 1, a, a + kSide + 1, a + kSide}) indices.push_back(k);
      }
    }
  }
  [[nodiscard]] std::size_t vertex_count() const { return positions.size() / 3; }
};

// Corners of each triangle as a multiset of lines: codecs reorder triangles and vertices, and turn corners.
std::vector<std::vector<float>> soup(const std::vector<glm::vec3>& positions,
                                     const std::vector<std::uint32_t>& indices) {
  std::vector<std::vector<float>> triangles;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    std::vector<float> best;
    for (std::size_t turn = 0; turn < 3; ++turn) {
      std::vector<float> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const glm::vec3& p = positions[indices[i + (turn + k) % 3]];
        corners.insert(corners.end(), {p.x, p.y, p.z});
      }
      if (best.empty() || corners < best) best = corners;
    }
    triangles.push_back(best);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::vector<std::vector<float>> soup(const Scene& scene) {
  const eikon::Primitive& primitive = scene.meshes.at(0).primitives.at(0);
  return soup(primitive.positions_object, primitive.indices);
}

std::vector<std::vector<float>> soup(const Sheet& sheet) {
  std::vector<glm::vec3> positions;
  for (std::size_t i = 0; i < sheet.vertex_count(); ++i) {
    positions.emplace_back(sheet.positions[3 * i], sheet.positions[3 * i + 1], sheet.positions[3 * i + 2]);
  }
  return soup(positions, sheet.indices);
}

template <typename T>
int add_attribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, draco::DataType data, int components,
                  bool normalized, const std::vector<T>& values) {
  draco::GeometryAttribute attribute;
  const auto stride = static_cast<std::int64_t>(sizeof(T)) * components;
  attribute.Init(type, nullptr, static_cast<std::uint8_t>(components), data, normalized, stride, 0);
  const auto count = static_cast<std::uint32_t>(values.size() / static_cast<std::size_t>(components));
  const int id = mesh.AddAttribute(attribute, true, count);
  for (std::uint32_t i = 0; i < count; ++i) {
    mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i),
                                          &values[i * static_cast<std::size_t>(components)]);
  }
  return static_cast<int>(mesh.attribute(id)->unique_id());
}

/// The sheet as a Draco stream under a primitive; `stream` may be changed before the file is written.
struct DracoFile {
  Builder builder;
  std::vector<char> stream;
  std::size_t points = 0;

  explicit DracoFile(int method, bool with_metadata = false) {
    const Sheet sheet;
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<std::uint32_t>(sheet.vertex_count()));
    for (std::size_t i = 0; i < sheet.indices.size(); i += 3) {
      mesh.AddFace({draco::PointIndex(sheet.indices[i]), draco::PointIndex(sheet.indices[i + 1]),
                    draco::PointIndex(sheet.indices[i + 2])});
    }
    const int position =
                  add_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, false, sheet.positions),
              normal =
                  add_attribute(mesh, draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, 3, false, sheet.normals),
              color = add_attribute(mesh, draco::GeometryAttribute::COLOR, draco::DT_UINT8, 4, true, sheet.colors);
    if (with_metadata) {
      auto metadata = std::make_unique<draco::GeometryMetadata>();
      metadata->AddEntryString("tool", "test");
      auto part = std::make_unique<draco::Metadata>();
      part->AddEntryInt("answer", 42);
      metadata->AddSubMetadata("part", std::move(part));
      auto own = std::make_unique<draco::AttributeMetadata>();
      own->set_att_unique_id(static_cast<std::uint32_t>(position));
      own->AddEntryInt("nested", 1);
      metadata->AddAttributeMetadata(std::move(own));
      mesh.AddMetadata(std::move(metadata));
    }
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    encoder.SetSpeedOptions(method == draco::MESH_SEQUENTIAL_ENCODING ? 10 : 3, 3);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
    stream.assign(buffer.data(), buffer.data() + buffer.size());
    points = sheet.vertex_count();

    const auto announce = [&](const char* type, int component, std::size_t count) {
      builder.json["accessors"].push_back({{"componentType", component}, {"count", count}, {"type", type}});
      return builder.json["accessors"].size() - 1;
    };
    const std::size_t first = announce("VEC3", 5126, points);
    announce("VEC3", 5126, points);
    const std::size_t colors = announce("VEC4", 5121, points);
    builder.json["accessors"][colors]["normalized"] = true;
    builder.primitive()["attributes"] = {{"POSITION", first}, {"NORMAL", first + 1}, {"COLOR_0", colors}};
    builder.primitive()["indices"] = announce("SCALAR", 5123, sheet.indices.size());
    extension() = {{"bufferView", 2}, {"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"COLOR_0", color}}}};
    builder.json["extensionsUsed"].push_back("KHR_draco_mesh_compression");
    builder.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  }

  Json& extension() { return builder.primitive()["extensions"]["KHR_draco_mesh_compression"]; }
  Json& accessor(const char* attribute) {
    return builder.json["accessors"][builder.primitive()["attributes"][attribute].get<std::size_t>()];
  }
  Json& indices() { return builder.json["accessors"][builder.primitive()["indices"].get<std::size_t>()]; }
  [[nodiscard]] Scene load() const {
    Builder copy = builder;
    copy.add_view(stream);
    return copy.load();
  }
};

TEST(SceneCompression, draco_streams_of_both_methods_hold_the_mesh) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    for (const bool with_metadata : {false, true}) {
      const Scene scene = DracoFile(method, with_metadata).load();
      EXPECT_EQ(soup(scene), soup(Sheet()));
      const eikon::Primitive& primitive = scene.meshes.at(0).primitives.at(0);
      ASSERT_EQ(primitive.normals_object.size(), kSide * kSide);
      ASSERT_EQ(primitive.colors.size(), kSide * kSide);
      for (std::size_t i = 0; i < primitive.colors.size(); ++i) {
        const glm::vec3& p = primitive.positions_object[i];
        EXPECT_EQ(primitive.colors[i], glm::vec4(p.x * 40 / 255, p.y * 40 / 255, 1, 1));
        EXPECT_LT(glm::length(primitive.normals_object[i] - glm::normalize(glm::vec3(p.x, 0, 1))), 1e-6F);
      }
      EXPECT_TRUE(scene.warnings.empty());
      EXPECT_TRUE(scene.unsupported.empty());
    }
  }
}

TEST(SceneCompression, draco_quantised_positions_are_close) {
  DracoFile file(draco::MESH_EDGEBREAKER_ENCODING);
  const Sheet sheet;
  draco::Mesh mesh;
  mesh.set_num_points(static_cast<std::uint32_t>(sheet.vertex_count()));
  for (std::size_t i = 0; i < sheet.indices.size(); i += 3) {
    mesh.AddFace({draco::PointIndex(sheet.indices[i]), draco::PointIndex(sheet.indices[i + 1]),
                  draco::PointIndex(sheet.indices[i + 2])});
  }
  const int id = add_attribute(mesh, draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, false, sheet.positions);
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
  file.stream.assign(buffer.data(), buffer.data() + buffer.size());
  file.extension()["attributes"] = {{"POSITION", id}};
  file.builder.primitive()["attributes"].erase("NORMAL");
  file.builder.primitive()["attributes"].erase("COLOR_0");
  const Scene scene = file.load();
  for (const glm::vec3& p : scene.meshes.at(0).primitives.at(0).positions_object) {
    EXPECT_LT(glm::length(p - glm::round(p)), 1e-3F);
  }
  EXPECT_EQ(scene.meshes.at(0).primitives.at(0).positions_object.size(), sheet.vertex_count());
}

struct DracoLie {
  const char* name;
  std::function<void(DracoFile&)> tell;
  const char* says;
};

TEST(SceneCompression, draco_extensions_that_lie_are_refused) {
  const std::vector<DracoLie> lies{
      {"no view", [](DracoFile& f) { f.extension().erase("bufferView"); }, "'bufferView'"},
      {"another view", [](DracoFile& f) { f.extension()["bufferView"] = 9; }, "names bufferView 9"},
      {"a view of something else", [](DracoFile& f) { f.extension()["bufferView"] = 0; }, "no Draco stream"},
      {"not an object", [](DracoFile& f) { f.extension() = 3; }, "is not an object"},
      {"no attributes", [](DracoFile& f) { f.extension().erase("attributes"); }, "'attributes'"},
      {"no position", [](DracoFile& f) { f.extension()["attributes"].erase("POSITION"); }, "POSITION"},
      {"an attribute that is not there", [](DracoFile& f) { f.extension()["attributes"]["NORMAL"] = 77; },
       "no attribute 77"},
      {"a negative attribute", [](DracoFile& f) { f.extension()["attributes"]["NORMAL"] = -1; }, "'NORMAL'"},
      {"positions as colours", [](DracoFile& f) { f.extension()["attributes"]["COLOR_0"] = 0; }, "another type"},
      {"no indices", [](DracoFile& f) { f.builder.primitive().erase("indices"); }, "needs 'indices'"},
      {"a fan", [](DracoFile& f) { f.builder.primitive()["mode"] = 6; }, "triangles and triangle strips only"},
      {"fewer indices", [](DracoFile& f) { f.indices()["count"] = 147; }, "50 triangles"},
      {"more indices", [](DracoFile& f) { f.indices()["count"] = 153; }, "50 triangles"},
      {"fewer positions", [](DracoFile& f) { f.accessor("POSITION")["count"] = 35; }, "36 vertices"},
      {"more normals", [](DracoFile& f) { f.accessor("NORMAL")["count"] = 37; }, "37 elements"},
      {"colours of another type", [](DracoFile& f) { f.accessor("COLOR_0")["componentType"] = 5123; }, "another type"},
      {"a sparse accessor",
       [](DracoFile& f) {
         Builder& b = f.builder;
         const std::size_t at = b.add_view(std::vector<std::uint16_t>{0}), to = b.add_view(std::vector<float>{1, 2, 3});
         f.extension()["bufferView"] = 4;
         f.accessor("NORMAL")["sparse"] = {{"count", 1},
                                           {"indices", {{"bufferView", at}, {"componentType", 5123}}},
                                           {"values", {{"bufferView", to}}}};
       },
       "is sparse"},
      {"another version", [](DracoFile& f) { f.stream[6] = 1; }, "version 2.1"},
      {"a point cloud", [](DracoFile& f) { f.stream[7] = 0; }, "without triangles"},
      {"an unknown method", [](DracoFile& f) { f.stream[8] = 2; }, "without triangles"},
      {"the head alone", [](DracoFile& f) { f.stream.resize(11); }, "truncated"},
      {"half of it", [](DracoFile& f) { f.stream.resize(f.stream.size() / 2); }, "do not decode"},
  };
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    for (const DracoLie& lie : lies) {
      SCOPED_TRACE(lie.name);
      DracoFile file(method);
      lie.tell(file);
      const std::string message = message_of([&] { (void)file.load(); });
      EXPECT_TRUE(mentions(message, lie.says)) << message;
      EXPECT_TRUE(mentions(message, "mesh 'flat', primitive 0")) << message;
    }
  }
}

TEST(SceneCompression, draco_streams_cannot_claim_more_than_their_bytes_hold) {
  // A head that says 2^28 triangles, with an accessor that agrees.
  DracoFile file(draco::MESH_SEQUENTIAL_ENCODING);
  const std::size_t numbers = 11;
  ASSERT_EQ(file.stream[numbers], 50);
  const std::vector<char> many{static_cast<char>(0x80), static_cast<char>(0x80), static_cast<char>(0x80),
                               static_cast<char>(0x80), 1};
  file.stream.erase(file.stream.begin() + numbers);
  file.stream.insert(file.stream.begin() + numbers, many.begin(), many.end());
  file.indices()["count"] = 3LL << 28U;
  const std::string message = message_of([&] { (void)file.load(); });
  EXPECT_TRUE(mentions(message, "claims 268435456 triangles")) << message;
}

TEST(SceneCompression, damaged_draco_streams_decode_or_are_refused) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const DracoFile good(method);
    std::mt19937 random(7);
    int refused = 0;
    for (int round = 0; round < 600; ++round) {
      DracoFile file = good;
      for (int change = 0; change <= round % 3; ++change) {
        file.stream[random() % file.stream.size()] = static_cast<char>(random() & 0xFFU);
      }
      if (round % 10 == 0) file.stream.resize(random() % file.stream.size());
      try {
        const Scene scene = file.load();
        for (const eikon::Primitive& primitive : scene.meshes.at(0).primitives) {
          for (const std::uint32_t index : primitive.indices) ASSERT_LT(index, primitive.positions_object.size());
        }
      } catch (const eikon::InputError& e) {
        ++refused;
        ASSERT_EQ(std::string(e.what()).find('\n'), std::string::npos);
      }
    }
    EXPECT_GT(refused, 100);
  }
}

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
    add(encode_vertices(sheet.positions.data(), vertices, 12), vertices, 12, "ATTRIBUTES", "NONE", "VEC3", 5126);
    // Normals of 8 bits, octahedral, padded to 4 bytes.
    std::vector<float> four;
    for (std::size_t i = 0; i < vertices; ++i) {
      four.insert(four.end(), {sheet.normals[3 * i], sheet.normals[3 * i + 1], sheet.normals[3 * i + 2], 0});
    }
    std::vector<signed char> octahedral(4 * vertices);
    meshopt_encodeFilterOct(octahedral.data(), vertices, 4, 8, four.data());
    add(encode_vertices(octahedral.data(), vertices, 4), vertices, 4, "ATTRIBUTES", "OCTAHEDRAL", "VEC3", 5120);
    Encoded indices(as_sequence ? meshopt_encodeIndexSequenceBound(corners, vertices)
                                : meshopt_encodeIndexBufferBound(corners, vertices));
    indices.resize(as_sequence
                       ? meshopt_encodeIndexSequence(indices.data(), indices.size(), sheet.indices.data(), corners)
                       : meshopt_encodeIndexBuffer(indices.data(), indices.size(), sheet.indices.data(), corners));
    add(indices, corners, 2, as_sequence ? "INDICES" : "TRIANGLES", nullptr, "SCALAR", 5123);
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
  [[nodiscard]] Scene load() const {
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

struct MeshoptLie {
  const char* name;
  std::function<void(MeshoptFile&)> tell;
  const char* says;
};

TEST(SceneCompression, meshopt_views_that_lie_are_refused) {
  const std::vector<MeshoptLie> lies{
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
      {"a newer codec", [](MeshoptFile& f) { f.data[0].second[0] = 0xA1; }, "of a newer codec"},
      {"a placeholder read without the extension", [](MeshoptFile& f) { f.view(0).erase("extensions"); },
       "outside buffer 1"},
      {"a placeholder that is none",
       [](MeshoptFile& f) { f.builder.json["buffers"][1]["extensions"]["EXT_meshopt_compression"] = Json::object(); },
       "neither a URI"},
  };
  for (const MeshoptLie& lie : lies) {
    SCOPED_TRACE(lie.name);
    MeshoptFile file;
    lie.tell(file);
    const std::string message = message_of([&] { (void)file.load(); });
    EXPECT_TRUE(mentions(message, lie.says)) << message;
  }
}

TEST(SceneCompression, meshopt_views_cannot_multiply_one_piece_of_data) {
  // Zeros compress best; the more views share them, the more comes out.
  const std::vector<std::uint32_t> zeros(1U << 18U);
  const Encoded bytes = encode_vertices(zeros.data(), zeros.size() / 4, 16);
  MeshoptFile file;
  for (int i = 0; i < 40; ++i)
    file.add(i == 0 ? bytes : Encoded{}, zeros.size() / 4, 16, "ATTRIBUTES", nullptr, "VEC4", 5126);
  const std::size_t shared = 3;
  for (std::size_t i = shared; i < file.data.size(); ++i) {
    file.extension(i)["byteOffset"] = 0;  // set below, once the place of the data is known
    file.extension(i)["byteLength"] = bytes.size();
  }
  std::size_t offset = file.builder.buffer.size();
  for (std::size_t i = 0; i < shared; ++i) offset = (offset + 3) / 4 * 4 + file.data[i].second.size();
  for (std::size_t i = shared; i < file.data.size(); ++i) file.extension(i)["byteOffset"] = (offset + 3) / 4 * 4;
  const std::string message = message_of([&] { (void)file.load(); });
  EXPECT_TRUE(mentions(message, "64 times the file")) << message;
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
    try {
      const Scene scene = file.load();
      for (const eikon::Primitive& primitive : scene.meshes.at(0).primitives) {
        for (const std::uint32_t index : primitive.indices) ASSERT_LT(index, primitive.positions_object.size());
        for (const glm::vec3& p : primitive.positions_object) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
      }
    } catch (const eikon::InputError& e) {
      ++refused;
      ASSERT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(refused, 80);
}

}  // namespace
