// SPDX-License-Identifier: Apache-2.0
// Meshes in Draco's codec: what they hold, and what happens when they lie.
#include <draco/compression/encode.h>

#include <iterator>
#include <memory>
#include <string>

#include "core/host_limits.h"
#include "support/compressed_sheet.h"

namespace {

using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kSide;
using scene_test::kUnsignedByte;
using scene_test::kUnsignedShort;
using scene_test::Lie;
using scene_test::message_of;
using scene_test::refused_or_sound;
using scene_test::Sheet;
using scene_test::soup;
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

/// The sheet as a Draco stream under a primitive; `stream` may be changed before the file is
/// written.
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
    const std::size_t first = announce("VEC3", kFloat, points);
    announce("VEC3", kFloat, points);
    const std::size_t colors = announce("VEC4", kUnsignedByte, points);
    builder.json["accessors"][colors]["normalized"] = true;
    builder.primitive()["attributes"] = {{"POSITION", first}, {"NORMAL", first + 1}, {"COLOR_0", colors}};
    builder.primitive()["indices"] = announce("SCALAR", kUnsignedShort, sheet.indices.size());
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

TEST(SceneCompression, draco_extensions_that_lie_are_refused) {
  const std::vector<Lie<DracoFile>> lies{
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
      {"colours of another type", [](DracoFile& f) { f.accessor("COLOR_0")["componentType"] = kUnsignedShort; },
       "another type"},
      {"a sparse accessor",
       [](DracoFile& f) {
         Builder& b = f.builder;
         const std::size_t at = b.add_view(std::vector<std::uint16_t>{0}), to = b.add_view(std::vector<float>{1, 2, 3});
         f.extension()["bufferView"] = 4;
         f.accessor("NORMAL")["sparse"] = {{"count", 1},
                                           {"indices", {{"bufferView", at}, {"componentType", kUnsignedShort}}},
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
    for (const Lie<DracoFile>& lie : lies) {
      SCOPED_TRACE(lie.name);
      DracoFile file(method);
      lie.tell(file);
      const std::string message = message_of([&] { (void)file.load(); });
      EXPECT_TRUE(contains(message, lie.says));
      EXPECT_TRUE(contains(message, "mesh 'flat', primitive 0"));
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
  EXPECT_TRUE(contains(message, "claims 268435456 triangles"));
}

TEST(SceneCompression, draco_meshes_for_whose_decoder_there_is_too_little_memory_are_refused_before_it_runs) {
  // The mesh itself would fit sixty times. The bytes are no stream, which the decoder would say.
  DracoFile file(draco::MESH_EDGEBREAKER_ENCODING);
  const std::uint64_t triangles = eikon::usable_memory_bytes() / 2000;
  file.stream.assign(triangles / 64, 0);
  file.indices()["count"] = 3 * triangles;
  for (const char* attribute : {"POSITION", "NORMAL", "COLOR_0"}) file.accessor(attribute)["count"] = triangles / 2;
  Json& attributes = file.builder.primitive()["attributes"];
  for (int i = 0; i < 200; ++i) attributes["_" + std::to_string(i)] = attributes["COLOR_0"];
  const std::string message = message_of([&] { (void)file.load(); });
  EXPECT_TRUE(contains(message, "GB of memory while they are unpacked, there are"));
  while (attributes.size() > 3) attributes.erase(std::prev(attributes.end()));
  const std::string fits = message_of([&] { (void)file.load(); });
  EXPECT_TRUE(contains(fits, "no Draco stream"));
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
      refused += refused_or_sound(file) ? 1 : 0;
    }
    EXPECT_GT(refused, 100);
  }
}

}  // namespace
