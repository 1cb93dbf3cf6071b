// SPDX-License-Identifier: Apache-2.0
// Attributes of meshes: every type that glTF allows, what is read for which material, and values
// that are odd.
#include <cmath>
#include <functional>
#include <limits>

#include "support/gltf_builder.h"
#include "unit/gltf/geometry/accessors.h"

namespace {

using eikon::Primitive;
using eikon::Scene;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kByte;
using scene_test::kFloat;
using scene_test::kShort;
using scene_test::kUnsignedByte;
using scene_test::kUnsignedInt;
using scene_test::kUnsignedShort;
using scene_test::leaves_out;
using scene_test::message_of;
using scene_test::only_primitive;
using scene_test::warns;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// The triangle, allowed to use the types of KHR_mesh_quantization.
Builder quantized() {
  Builder builder;
  builder.json["extensionsUsed"].push_back("KHR_mesh_quantization");
  builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  return builder;
}

/// Adds an attribute, one value of the file's type per component; `normalized` as glTF has it.
template <typename T>
void set(Builder& builder, const std::string& name, const char* type, int component, bool normalized,
         const std::vector<T>& values) {
  const std::size_t width = static_cast<std::size_t>(type[3] - '0');
  const std::size_t accessor = builder.add(type, component, values, values.size() / width);
  if (normalized) builder.json["accessors"][accessor]["normalized"] = true;
  builder.primitive()["attributes"][name] = accessor;
}

/// Gives the material a texture of one pixel in the slot `key`, with set `uv` of coordinates.
void add_texture(Builder& builder, const char* key, std::size_t uv) {
  builder.json["images"] = {
      {{"uri",
        "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAA"
        "AABJRU5ErkJggg=="}}};
  builder.json["textures"] = {{{"source", 0}}};
  const bool in_pbr = std::string(key) == "baseColorTexture";
  Json& owner = in_pbr ? builder.material()["pbrMetallicRoughness"] : builder.material();
  owner[key] = {{"index", 0}, {"texCoord", uv}};
}

TEST(SceneAttributes, positions_of_every_integer_type_are_read_plain_and_normalised) {
  const auto positions = [](int component, bool normalized, auto values) {
    Builder builder = quantized();
    set(builder, "POSITION", "VEC3", component, normalized, values);
    return only_primitive(builder.load()).positions_object;
  };
  using Values = std::vector<glm::vec3>;
  const std::vector<std::int8_t> i8{-128, 0, 0, 127, -1, 0, 0, 64, -127};
  const std::vector<std::uint8_t> u8{255, 0, 0, 1, 0, 0, 0, 51, 128};
  const std::vector<std::int16_t> i16{-32768, 0, 0, 32767, 0, 0, 0, 1, -32767};
  const std::vector<std::uint16_t> u16{65535, 0, 0, 1, 0, 0, 0, 13107, 2};
  EXPECT_EQ(positions(kByte, false, i8), (Values{{-128, 0, 0}, {127, -1, 0}, {0, 64, -127}}));
  EXPECT_EQ(positions(kByte, true, i8), (Values{{-1, 0, 0}, {1, -1 / 127.0F, 0}, {0, 64 / 127.0F, -1}}));
  EXPECT_EQ(positions(kUnsignedByte, false, u8), (Values{{255, 0, 0}, {1, 0, 0}, {0, 51, 128}}));
  EXPECT_EQ(positions(kUnsignedByte, true, u8), (Values{{1, 0, 0}, {1 / 255.0F, 0, 0}, {0, 0.2F, 128 / 255.0F}}));
  EXPECT_EQ(positions(kShort, false, i16), (Values{{-32768, 0, 0}, {32767, 0, 0}, {0, 1, -32767}}));
  EXPECT_EQ(positions(kShort, true, i16), (Values{{-1, 0, 0}, {1, 0, 0}, {0, 1 / 32767.0F, -1}}));
  EXPECT_EQ(positions(kUnsignedShort, false, u16), (Values{{65535, 0, 0}, {1, 0, 0}, {0, 13107, 2}}));
  EXPECT_EQ(positions(kUnsignedShort, true, u16), (Values{{1, 0, 0}, {1 / 65535.0F, 0, 0}, {0, 0.2F, 2 / 65535.0F}}));
}

TEST(SceneAttributes, accessors_may_be_quantised_sparse_and_strided_at_once) {
  Builder builder = quantized();
  // Four bytes each: x, y, z and padding.
  const std::size_t view = builder.add_view(std::vector<std::int8_t>{0, 0, 0, 9, 10, 0, 0, 9, 0, 10, 0, 9});
  builder.json["bufferViews"][view]["byteStride"] = 4;
  const std::size_t at = builder.add_view(std::vector<std::uint8_t>{1}),
                    to = builder.add_view(std::vector<std::int8_t>{20, 1, 2});
  builder.json["accessors"].push_back({{"bufferView", view},
                                       {"componentType", kByte},
                                       {"count", 3},
                                       {"type", "VEC3"},
                                       {"sparse",
                                        {{"count", 1},
                                         {"indices", {{"bufferView", at}, {"componentType", kUnsignedByte}}},
                                         {"values", {{"bufferView", to}}}}}});
  builder.primitive()["attributes"]["POSITION"] = builder.json["accessors"].size() - 1;
  EXPECT_EQ(only_primitive(builder.load()).positions_object,
            (std::vector<glm::vec3>{{0, 0, 0}, {20, 1, 2}, {0, 10, 0}}));
}

TEST(SceneAttributes, G11_G17_G18_hold_for_quantised_meshes) {
  Builder builder = quantized();
  set(builder, "POSITION", "VEC3", kShort, false, std::vector<std::int16_t>{0, 0, 0, 9, 0, 0, 0, 9, 0, 18, 0, 0});
  builder.primitive()["indices"] =
      builder.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{0, 1, 2, 0, 0, 1, 0, 1, 3}, 9);
  builder.node()["scale"] = {-1, 1, 1};
  Scene scene = builder.load();
  EXPECT_EQ(only_primitive(scene).indices.size(), 9U);  // degenerate triangles of lists stay
  EXPECT_TRUE(scene.nodes[0].mirrored);
  builder.node()["scale"] = {1, 1, 0};
  scene = builder.load();
  EXPECT_FALSE(scene.nodes[0].mirrored);
  EXPECT_EQ(scene.nodes.size(), 1U);
}

TEST(SceneAttributes, G12_quantised_positions_that_a_node_sends_too_far_name_it) {
  Builder builder = quantized();
  set(builder, "POSITION", "VEC3", kUnsignedShort, false, std::vector<std::uint16_t>{0, 0, 0, 65535, 0, 0, 0, 9, 0});
  builder.node()["scale"] = {1e9, 1, 1};
  EXPECT_TRUE(contains(message_of([&] { builder.load(); }), "node 'triangle': vertex 1"));
}

TEST(SceneAttributes, normals_of_normalised_integers_are_unit) {
  for (const bool wide : {false, true}) {
    Builder builder = quantized();
    if (wide) {
      set(builder, "NORMAL", "VEC3", kShort, true, std::vector<std::int16_t>{0, 0, 32767, 0, -32768, 0, 9, 9, 0});
    } else {
      set(builder, "NORMAL", "VEC3", kByte, true, std::vector<std::int8_t>{0, 0, 127, 0, -128, 0, 9, 9, 0});
    }
    const Primitive read = only_primitive(builder.load());
    ASSERT_EQ(read.normals_object.size(), 3U);
    EXPECT_EQ(read.normals_object[0], glm::vec3(0, 0, 1));
    EXPECT_EQ(read.normals_object[1], glm::vec3(0, -1, 0));
    EXPECT_LT(glm::length(read.normals_object[2] - glm::vec3(std::sqrt(0.5F), std::sqrt(0.5F), 0)), 1e-6F);
  }
}

TEST(SceneAttributes, texture_coordinates_of_every_type_are_read) {
  const auto uv = [](int component, bool normalized, auto values, bool plain_gltf = false) {
    Builder builder = plain_gltf ? Builder() : quantized();
    add_texture(builder, "baseColorTexture", 1);
    set(builder, "TEXCOORD_1", "VEC2", component, normalized, values);
    return only_primitive(builder.load()).uv[1];
  };
  using Values = std::vector<glm::vec2>;
  EXPECT_EQ(uv(kFloat, false, std::vector<float>{0, 0, -3.5F, 2, 1e7F, 1}, true),
            (Values{{0, 0}, {-3.5F, 2}, {1e7F, 1}}));
  EXPECT_EQ(uv(kUnsignedByte, true, std::vector<std::uint8_t>{0, 51, 255, 0, 0, 1}, true),
            (Values{{0, 0.2F}, {1, 0}, {0, 1 / 255.0F}}));
  EXPECT_EQ(uv(kUnsignedShort, true, std::vector<std::uint16_t>{0, 13107, 65535, 0, 0, 1}, true),
            (Values{{0, 0.2F}, {1, 0}, {0, 1 / 65535.0F}}));
  EXPECT_EQ(uv(kUnsignedByte, false, std::vector<std::uint8_t>{0, 51, 255, 0, 0, 1}),
            (Values{{0, 51}, {255, 0}, {0, 1}}));
  EXPECT_EQ(uv(kUnsignedShort, false, std::vector<std::uint16_t>{0, 51, 65535, 0, 0, 1}),
            (Values{{0, 51}, {65535, 0}, {0, 1}}));
  EXPECT_EQ(uv(kByte, false, std::vector<std::int8_t>{0, -51, 127, 0, 0, 1}), (Values{{0, -51}, {127, 0}, {0, 1}}));
  EXPECT_EQ(uv(kByte, true, std::vector<std::int8_t>{0, -128, 127, 0, 0, 1}),
            (Values{{0, -1}, {1, 0}, {0, 1 / 127.0F}}));
  EXPECT_EQ(uv(kShort, false, std::vector<std::int16_t>{0, -51, 999, 0, 0, 1}), (Values{{0, -51}, {999, 0}, {0, 1}}));
  EXPECT_EQ(uv(kShort, true, std::vector<std::int16_t>{0, -32768, 32767, 0, 0, 1}),
            (Values{{0, -1}, {1, 0}, {0, 1 / 32767.0F}}));
}

TEST(SceneAttributes, the_second_texture_coordinates_and_tangents_are_read_only_for_materials_that_need_them) {
  Builder builder;
  set(builder, "NORMAL", "VEC3", kFloat, false, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1});
  set(builder, "TEXCOORD_0", "VEC2", kFloat, false, std::vector<float>{0, 0, 1, 0, 0, 1});
  set(builder, "TEXCOORD_1", "VEC2", kFloat, false, std::vector<float>{5, 5, 6, 5, 5, 6});
  set(builder, "TANGENT", "VEC4", kFloat, false, std::vector<float>{0, 2, 0, 1, 0, 1, 0, -1, 1, 0, 0, 1});
  Primitive read = only_primitive(builder.load());
  EXPECT_TRUE(read.uv[1].empty() && read.tangents_object.empty());
  EXPECT_EQ(read.uv[0], (std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}));  // for the layer that shows them
  add_texture(builder, "baseColorTexture", 1);
  read = only_primitive(builder.load());
  EXPECT_TRUE(read.tangents_object.empty());
  EXPECT_EQ(read.uv[1], (std::vector<glm::vec2>{{5, 5}, {6, 5}, {5, 6}}));
  add_texture(builder, "normalTexture", 0);
  read = only_primitive(builder.load());
  EXPECT_EQ(read.uv[0], (std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_EQ(read.uv[1].size(), 3U);
  EXPECT_EQ(read.tangents_object, (std::vector<glm::vec4>{{0, 1, 0, 1}, {0, 1, 0, -1}, {1, 0, 0, 1}}));
}

TEST(SceneAttributes, tangents_of_normalised_integers_are_unit_with_a_whole_sign) {
  Builder builder = quantized();
  add_texture(builder, "normalTexture", 0);
  set(builder, "NORMAL", "VEC3", kByte, true, std::vector<std::int8_t>{0, 0, 127, 0, 0, 127, 0, 0, 127});
  set(builder, "TEXCOORD_0", "VEC2", kFloat, false, std::vector<float>{0, 0, 1, 0, 0, 1});
  set(builder, "TANGENT", "VEC4", kByte, true,
      std::vector<std::int8_t>{99, 0, 0, 127, 0, -128, 0, -127, 0, 9, 0, -128});
  EXPECT_EQ(only_primitive(builder.load()).tangents_object,
            (std::vector<glm::vec4>{{1, 0, 0, 1}, {0, -1, 0, -1}, {0, 1, 0, -1}}));
}

TEST(SceneAttributes, tangents_are_made_where_the_file_has_none_or_none_that_can_be_used) {
  const std::vector<float> good{0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1};
  struct Case {
    std::vector<float> tangents;
    bool with_normals, with_tangents, warned;
  };
  std::vector<float> zero = good, along = good, unsigned_one = good, not_a_number = good;
  zero[5] = 0;
  along[4] = 0, along[5] = 0, along[6] = 1;
  unsigned_one[7] = 0;
  not_a_number[5] = kNan;
  for (const Case& c : {Case{{}, true, false, false}, Case{{}, false, false, false}, Case{good, false, true, false},
                        Case{zero, true, true, true}, Case{along, true, true, true},
                        Case{unsigned_one, true, true, true}, Case{not_a_number, true, true, true}}) {
    Builder builder;
    add_texture(builder, "normalTexture", 0);
    if (c.with_normals) set(builder, "NORMAL", "VEC3", kFloat, false, std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1});
    set(builder, "TEXCOORD_0", "VEC2", kFloat, false, std::vector<float>{0, 1, 1, 1, 0, 0});
    if (c.with_tangents) set(builder, "TANGENT", "VEC4", kFloat, false, c.tangents);
    const Scene scene = builder.load();
    EXPECT_EQ(only_primitive(scene).tangents_object, std::vector<glm::vec4>(3, glm::vec4(1, 0, 0, 1)));
    EXPECT_EQ(only_primitive(scene).normals_object.empty(), !c.with_normals);
    EXPECT_EQ(warns(scene, "tangents dropped and made from the texture coordinates: accessor"), c.warned);
  }
}

TEST(SceneAttributes, a_texture_without_coordinates_is_said_once_per_material_and_taken_at_0) {
  Builder builder;
  add_texture(builder, "baseColorTexture", 1);
  builder.json["meshes"][0]["primitives"].push_back(builder.primitive());
  const Scene scene = builder.load();
  ASSERT_EQ(scene.meshes[0].primitives.size(), 2U);
  for (const Primitive& primitive : scene.meshes[0].primitives) {
    EXPECT_EQ(primitive.uv[1], std::vector<glm::vec2>(3, glm::vec2(0, 0)));
  }
  std::size_t said = 0;
  for (const std::string& warning : scene.warnings)
    said += contains(warning, "material 'paint' has a texture with TEXCOORD_1");
  EXPECT_EQ(said, 1U);
}

TEST(SceneAttributes, G12_texture_coordinates_that_are_no_numbers_or_huge_are_counted_and_taken_as_0) {
  Builder builder;
  add_texture(builder, "baseColorTexture", 0);
  set(builder, "TEXCOORD_0", "VEC2", kFloat, false, std::vector<float>{1, 1, kNan, 0, 3e38F, 1});
  const Scene scene = builder.load();
  EXPECT_EQ(only_primitive(scene).uv[0], (std::vector<glm::vec2>{{1, 1}, {0, 0}, {0, 0}}));
  EXPECT_TRUE(warns(scene, "element 1 is not finite or beyond 2^24 (2 of them)"));
}

TEST(SceneAttributes, vertex_colours_of_every_type_are_read_and_white_ones_cost_nothing) {
  const auto colors = [](const char* type, int component, auto values) {
    Builder builder;
    set(builder, "COLOR_0", type, component, component != kFloat, values);
    const Scene scene = builder.load();
    EXPECT_TRUE(scene.unsupported.empty() && scene.warnings.empty());
    return only_primitive(scene).colors;
  };
  using Values = std::vector<glm::vec4>;
  EXPECT_EQ(colors("VEC3", kFloat, std::vector<float>{0.5F, 0, 1, 1, 1, 1, 0, 0, 0}),
            (Values{{0.5F, 0, 1, 1}, {1, 1, 1, 1}, {0, 0, 0, 1}}));
  EXPECT_EQ(colors("VEC4", kUnsignedByte, std::vector<std::uint8_t>{51, 0, 255, 102, 0, 0, 0, 0, 255, 255, 255, 255}),
            (Values{{0.2F, 0, 1, 0.4F}, {0, 0, 0, 0}, {1, 1, 1, 1}}));
  EXPECT_EQ(colors("VEC4", kUnsignedShort, std::vector<std::uint16_t>{13107, 0, 65535, 1, 0, 0, 0, 0, 0, 0, 0, 0}),
            (Values{{0.2F, 0, 1, 1 / 65535.0F}, {0, 0, 0, 0}, {0, 0, 0, 0}}));
  EXPECT_TRUE(colors("VEC3", kUnsignedByte, std::vector<std::uint8_t>(9, 255)).empty());
}

TEST(SceneAttributes, vertex_colours_outside_0_to_1_are_clamped_and_those_that_are_no_numbers_white) {
  Builder builder;
  set(builder, "COLOR_0", "VEC3", kFloat, false, std::vector<float>{2, -1, 0.5F, kNan, 0, 0, 0, 0, 0});
  const Scene scene = builder.load();
  EXPECT_EQ(only_primitive(scene).colors, (std::vector<glm::vec4>{{1, 0, 0.5F, 1}, {1, 1, 1, 1}, {0, 0, 0, 1}}));
  EXPECT_TRUE(warns(scene, "element 0 is outside [0, 1] (1 of them)"));
  EXPECT_TRUE(warns(scene, "element 1 is NaN (1 of them)"));
}

TEST(SceneAttributes, a_second_set_of_vertex_colours_is_left_out_by_name) {
  Builder builder;
  set(builder, "COLOR_1", "VEC3", kFloat, false, std::vector<float>(9));
  EXPECT_TRUE(leaves_out(builder.load(), "vertex colours COLOR_1", "mesh 'flat'"));
}

struct Refusal {
  const char* name;
  std::function<void(Builder&)> apply;
  const char* says;
};

TEST(SceneAttributes, types_that_gltf_does_not_allow_are_refused) {
  const std::vector<Refusal> refusals{
      {"shorts without the extension",
       [](Builder& b) {
         b = Builder();
         set(b, "POSITION", "VEC3", kShort, false, std::vector<short>(9));
       },
       "unless extensionsUsed lists KHR_mesh_quantization"},
      {"positions of ints", [](Builder& b) { set(b, "POSITION", "VEC3", kUnsignedInt, false, std::vector<int>(9)); },
       "VEC3 of unsigned int"},
      {"positions of VEC4", [](Builder& b) { set(b, "POSITION", "VEC4", kFloat, false, std::vector<float>(12)); },
       "VEC4 of float"},
      {"plain bytes as normals", [](Builder& b) { set(b, "NORMAL", "VEC3", kByte, false, std::vector<char>(9)); },
       "NORMAL in accessor 2 is VEC3 of byte"},
      {"unsigned normals", [](Builder& b) { set(b, "NORMAL", "VEC3", kUnsignedByte, true, std::vector<char>(9)); },
       "VEC3 of normalised unsigned byte"},
      {"tangents of VEC3", [](Builder& b) { set(b, "TANGENT", "VEC3", kFloat, false, std::vector<float>(9)); },
       "TANGENT in accessor 2 is VEC3"},
      {"colours of VEC2", [](Builder& b) { set(b, "COLOR_0", "VEC2", kFloat, false, std::vector<float>(6)); },
       "COLOR_0 in accessor 2 is VEC2"},
      {"plain bytes as colours",
       [](Builder& b) { set(b, "COLOR_0", "VEC3", kUnsignedByte, false, std::vector<char>(9)); },
       "COLOR_0 in accessor 2 is VEC3 of unsigned byte"},
      {"texture coordinates of ints",
       [](Builder& b) { set(b, "TEXCOORD_0", "VEC2", kUnsignedInt, false, std::vector<int>(6)); }, "TEXCOORD_0"},
      {"too few colours", [](Builder& b) { set(b, "COLOR_0", "VEC3", kFloat, false, std::vector<float>(6)); },
       "2 elements for 3 positions"},
      {"a matrix as texture coordinates",
       [](Builder& b) { b.primitive()["attributes"]["TEXCOORD_0"] = b.add("MAT2", kFloat, std::vector<float>(12), 3); },
       "is matrices of float"},
  };
  for (const Refusal& refusal : refusals) {
    SCOPED_TRACE(refusal.name);
    Builder builder = quantized();
    refusal.apply(builder);
    const std::string message = message_of([&] { builder.load(); });
    EXPECT_TRUE(contains(message, refusal.says));
    EXPECT_TRUE(contains(message, "mesh 'flat', primitive 0"));
  }
}

}  // namespace
