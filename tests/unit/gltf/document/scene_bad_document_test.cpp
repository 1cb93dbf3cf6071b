// SPDX-License-Identifier: Apache-2.0
// Documents that lie: each is refused in one line that names the place.
#include <functional>
#include <limits>

#include "support/gltf_builder.h"

namespace {

using eikon::load_scene;
using scene_test::base64;
using scene_test::Builder;
using scene_test::contains;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kShort;
using scene_test::kUnsignedByte;
using scene_test::kUnsignedInt;
using scene_test::kUnsignedShort;
using scene_test::message_of;
using scene_test::TemporaryFolder;

struct Mutation {
  const char* name;
  std::function<void(Builder&)> apply;
  const char* says;  // part of the message
};

constexpr std::int64_t kHuge = std::numeric_limits<std::int64_t>::max();

void expect_refused(const std::vector<Mutation>& mutations) {
  const TemporaryFolder folder;
  for (const Mutation& mutation : mutations) {
    SCOPED_TRACE(mutation.name);
    Builder builder;
    mutation.apply(builder);
    for (const bool binary : {false, true}) {
      const auto path =
          binary ? folder.write("scene.glb", builder.glb_bytes()) : folder.write("scene.gltf", builder.text());
      const std::string message = message_of([&] { load_scene(path); });
      EXPECT_TRUE(contains(message, mutation.says));
      EXPECT_TRUE(contains(message, "cannot load scene '"));
    }
  }
}

TEST(SceneBadDocument, storage_that_does_not_fit_is_refused) {
  expect_refused({
      {"view offset beyond buffer", [](Builder& b) { b.json["bufferViews"][0]["byteOffset"] = 1000; }, "bufferView 0"},
      {"view offset wraps", [](Builder& b) { b.json["bufferViews"][0]["byteOffset"] = kHuge; }, "bufferView 0"},
      {"view length beyond buffer", [](Builder& b) { b.json["bufferViews"][1]["byteLength"] = 7000; }, "bufferView 1"},
      {"view offset plus length wraps",
       [](Builder& b) {
         b.json["bufferViews"][0]["byteOffset"] = 36;
         b.json["bufferViews"][0]["byteLength"] = ~std::uint64_t{0} - 35;
       },
       "bufferView 0"},
      {"view length negative", [](Builder& b) { b.json["bufferViews"][0]["byteLength"] = -1; }, "'byteLength'"},
      {"view length missing", [](Builder& b) { b.json["bufferViews"][0].erase("byteLength"); },
       "'byteLength' is missing"},
      {"view length fractional", [](Builder& b) { b.json["bufferViews"][0]["byteLength"] = 36.5; }, "not an integer"},
      {"view without buffer", [](Builder& b) { b.json["bufferViews"][0].erase("buffer"); }, "'buffer' is missing"},
      {"view of no buffer", [](Builder& b) { b.json["bufferViews"][0]["buffer"] = 1; }, "there are only 1"},
      {"view stride beyond the view", [](Builder& b) { b.json["bufferViews"][0]["byteStride"] = 13; }, "3 elements"},
      {"view stride above 252", [](Builder& b) { b.json["bufferViews"][0]["byteStride"] = 256; }, "'byteStride'"},
      {"view stride below element", [](Builder& b) { b.json["bufferViews"][0]["byteStride"] = 8; }, "overlap"},
      {"views not an array", [](Builder& b) { b.json["bufferViews"] = 3; }, "'bufferViews' is not an array"},
      {"view not an object", [](Builder& b) { b.json["bufferViews"][0] = "x"; }, "bufferView 0: is not an object"},
      {"buffer longer than its data",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", 999}, {"uri", "data:;base64,AAAA"}}};
       },
       "byteLength"},
      {"buffer of a terabyte",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", 1LL << 40}, {"uri", "data:;base64,AAAA"}}};
       },
       "byteLength"},
      {"buffer length negative",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", -4}, {"uri", "data:;base64,AAAA"}}};
       },
       "buffer 0"},
      {"second buffer without data",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", b.buffer.size()}, {"uri", "data:;base64," + base64(b.buffer)}},
                              {{"byteLength", 300}}};
         b.json["bufferViews"][0]["buffer"] = 1;
       },
       "buffer 1 has neither a URI"},
      {"buffer uri not a string",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", 3}, {"uri", 5}}};
       },
       "'uri'"},
      {"base64 of wrong length",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", 3}, {"uri", "data:;base64,AAAAA"}}};
       },
       "multiple of 4"},
      {"base64 with bad character",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", 3}, {"uri", "data:;base64,AA*A"}}};
       },
       "position 2"},
      {"data uri without base64",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", 3}, {"uri", "data:text/plain,a c"}}};
       },
       "position 1"},
      {"data uri with a broken escape",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", 3}, {"uri", "data:text/plain,a%4"}}};
       },
       "broken %-escape"},
      {"data uri without a comma",
       [](Builder& b) {
         b.json["buffers"] = {{{"byteLength", 3}, {"uri", "DATA:;base64"}}};
       },
       "no comma"},
      {"accessor count beyond view", [](Builder& b) { b.json["accessors"][0]["count"] = 4; }, "accessor 0: 4 elements"},
      {"accessor count wraps", [](Builder& b) { b.json["accessors"][0]["count"] = 1LL << 61; }, "accessor 0"},
      {"accessor count of 2^32-1", [](Builder& b) { b.json["accessors"][0]["count"] = 0xFFFFFFFFLL; }, "accessor 0"},
      {"accessor count negative", [](Builder& b) { b.json["accessors"][0]["count"] = -3; }, "'count'"},
      {"accessor count missing", [](Builder& b) { b.json["accessors"][0].erase("count"); }, "'count' is missing"},
      {"accessor offset beyond view", [](Builder& b) { b.json["accessors"][1]["byteOffset"] = 2; }, "accessor 1"},
      {"accessor offset wraps", [](Builder& b) { b.json["accessors"][0]["byteOffset"] = kHuge; }, "'byteOffset'"},
      {"accessor of no view", [](Builder& b) { b.json["accessors"][0]["bufferView"] = 9; }, "there are only 2"},
      {"component INT", [](Builder& b) { b.json["accessors"][0]["componentType"] = 5124; }, "'componentType' 5124"},
      {"component DOUBLE", [](Builder& b) { b.json["accessors"][0]["componentType"] = 5130; }, "'componentType' 5130"},
      {"component a string", [](Builder& b) { b.json["accessors"][0]["componentType"] = "5126"; }, "'componentType'"},
      {"unknown type", [](Builder& b) { b.json["accessors"][0]["type"] = "VEC5"; }, "'type' is none of"},
      {"type missing", [](Builder& b) { b.json["accessors"][0].erase("type"); }, "'type' is none of"},
      {"normalized a number", [](Builder& b) { b.json["accessors"][0]["normalized"] = 1; }, "'normalized'"},
      {"a billion zeros from nothing",
       [](Builder& b) {
         b.json["accessors"][0].erase("bufferView");
         b.json["accessors"][0]["count"] = 1000000000;
       },
       "without a bufferView"},
  });
}

TEST(SceneBadDocument, sparse_accessors_that_lie_are_refused) {
  const auto sparse = [](const std::vector<std::uint16_t>& at, std::size_t count, const Json& change) {
    return [=](Builder& b) {
      const std::size_t indices = b.add_view(at), values = b.add_view(std::vector<float>(3 * at.size()));
      Json s = {{"count", count},
                {"indices", {{"bufferView", indices}, {"componentType", kUnsignedShort}}},
                {"values", {{"bufferView", values}}}};
      s.merge_patch(change);
      b.json["accessors"][0]["sparse"] = s;
    };
  };
  expect_refused({
      {"index beyond count", sparse({0, 3}, 2, Json::object()), "element 1 is 3"},
      {"indices not ascending", sparse({1, 1}, 2, Json::object()), "not ascending"},
      {"count above accessor", sparse({0, 1, 2, 3}, 4, Json::object()), "'count' is 4"},
      {"count negative", sparse({0}, 1, {{"count", -1}}), "'count'"},
      {"count beyond data", sparse({0}, 3, Json::object()), "indices: 3 elements"},
      {"indices missing", sparse({0}, 1, {{"indices", nullptr}}), "sparse"},
      {"values missing", sparse({0}, 1, {{"values", nullptr}}), "sparse"},
      {"signed indices", sparse({0}, 1, {{"indices", {{"componentType", kShort}}}}), "unsigned"},
      {"indices in no view", sparse({0}, 1, {{"indices", {{"bufferView", 77}}}}), "there are only"},
      {"values in negative view", sparse({0}, 1, {{"values", {{"bufferView", -1}}}}), "values"},
      {"values offset wraps", sparse({0}, 1, {{"values", {{"byteOffset", kHuge}}}}), "'byteOffset'"},
      {"values beyond view", sparse({0}, 1, {{"values", {{"byteOffset", 4}}}}), "values: 1 elements"},
      {"not an object", [](Builder& b) { b.json["accessors"][0]["sparse"] = 1; }, "'sparse' is not an object"},
  });
}

TEST(SceneBadDocument, indices_between_the_parts_of_a_document_are_checked) {
  expect_refused({
      {"default scene", [](Builder& b) { b.json["scene"] = 1; }, "scene 1"},
      {"default scene negative", [](Builder& b) { b.json["scene"] = -1; }, "'scene'"},
      {"node of scene", [](Builder& b) { b.json["scenes"][0]["nodes"] = {7}; }, "scene 0"},
      {"nodes of scene not a list", [](Builder& b) { b.json["scenes"][0]["nodes"] = 0; }, "not an array"},
      {"child", [](Builder& b) { b.node()["children"] = {1}; }, "node 'triangle': 'children' holds 1"},
      {"child a string", [](Builder& b) { b.node()["children"] = {"a\nb"}; }, "node 'triangle'"},
      {"mesh of node", [](Builder& b) { b.node()["mesh"] = 1; }, "names mesh 1"},
      {"mesh of node negative", [](Builder& b) { b.node()["mesh"] = -1; }, "'mesh'"},
      {"mesh of node huge", [](Builder& b) { b.node()["mesh"] = ~std::uint64_t{0}; }, "'mesh'"},
      {"camera of node", [](Builder& b) { b.node()["camera"] = 0; }, "names camera 0"},
      {"skin of node", [](Builder& b) { b.node()["skin"] = 0; }, "names skin 0"},
      {"material of primitive", [](Builder& b) { b.primitive()["material"] = 1; }, "primitive 0: 'material' names"},
      {"indices of primitive", [](Builder& b) { b.primitive()["indices"] = 5; }, "names accessor 5"},
      {"attribute of primitive", [](Builder& b) { b.primitive()["attributes"]["POSITION"] = 5; }, "'POSITION'"},
      {"attribute negative", [](Builder& b) { b.primitive()["attributes"]["NORMAL"] = -1; }, "'NORMAL'"},
      {"morph target",
       [](Builder& b) {
         b.primitive()["targets"] = {{{"POSITION", 9}}};
       },
       "target 0"},
      {"mode", [](Builder& b) { b.primitive()["mode"] = 7; }, "'mode' is 7"},
      {"no attributes", [](Builder& b) { b.primitive().erase("attributes"); }, "'attributes' is missing"},
      {"no primitives", [](Builder& b) { b.json["meshes"][0].erase("primitives"); }, "'primitives' is missing"},
      {"texture of material",
       [](Builder& b) {
         b.material()["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
       },
       "names texture 0"},
      {"texture without index", [](Builder& b) { b.material()["normalTexture"] = Json::object(); },
       "'index' is missing"},
      {"image of texture",
       [](Builder& b) {
         b.json["textures"] = {{{"source", 0}}};
         b.material()["normalTexture"] = {{"index", 0}};
       },
       "texture 0"},
      {"sampler of texture",
       [](Builder& b) {
         b.json["textures"] = {{{"sampler", 3}}};
         b.material()["normalTexture"] = {{"index", 0}};
       },
       "texture 0"},
      {"view of image",
       [](Builder& b) {
         b.json["images"] = {{{"bufferView", 99}}};
         b.json["textures"] = {{{"source", 0}}};
         b.material()["normalTexture"] = {{"index", 0}};
       },
       "image 0"},
      {"joint of skin",
       [](Builder& b) {
         b.json["skins"] = {{{"joints", {4}}}};
         b.node()["skin"] = 0;
       },
       "skin 0"},
      {"matrices of skin",
       [](Builder& b) {
         b.json["skins"] = {{{"joints", {0}}, {"inverseBindMatrices", 8}}};
         b.node()["skin"] = 0;
       },
       "skin 0"},
  });
}

TEST(SceneBadDocument, values_of_the_wrong_kind_are_refused) {
  const auto camera = [](const Json& lens) {
    return [=](Builder& b) {
      b.json["cameras"] = {{{"name", "eye"}, {"type", "perspective"}, {"perspective", lens}}};
      b.node()["camera"] = 0;
    };
  };
  const auto orthographic = [](const Json& lens) {
    return [=](Builder& b) {
      b.json["cameras"] = {{{"name", "plan"}, {"type", "orthographic"}, {"orthographic", lens}}};
      b.node()["camera"] = 0;
    };
  };
  expect_refused({
      {"no asset", [](Builder& b) { b.json.erase("asset"); }, "'asset'"},
      {"no version", [](Builder& b) { b.json["asset"].erase("version"); }, "'version' is missing"},
      {"version a number", [](Builder& b) { b.json["asset"]["version"] = 2.0; }, "'version' is not a string"},
      {"version 1.0", [](Builder& b) { b.json["asset"]["version"] = "1.0"; }, "'1.0'"},
      {"minVersion 2.1", [](Builder& b) { b.json["asset"]["minVersion"] = "2.1"; }, "'2.1'"},
      {"required dds", [](Builder& b) { b.json["extensionsRequired"] = {"MSFT_texture_dds"}; }, "'MSFT_texture_dds"},
      {"required nonsense", [](Builder& b) { b.json["extensionsRequired"] = {"ACME_\n'x'"}; }, "ACME_\\x0a"},
      {"required not a list", [](Builder& b) { b.json["extensionsRequired"] = "x"; }, "'extensionsRequired'"},
      {"matrix of 15", [](Builder& b) { b.node()["matrix"] = std::vector<int>(15); }, "16 numbers"},
      {"matrix projective", [](Builder& b) { b.node()["matrix"] = std::vector<int>(16, 1); }, "0 0 0 1"},
      {"translation of 2",
       [](Builder& b) {
         b.node()["translation"] = {1, 2};
       },
       "3 numbers"},
      {"scale of strings",
       [](Builder& b) {
         b.node()["scale"] = {"1", "2", "3"};
       },
       "3 numbers"},
      {"rotation null", [](Builder& b) { b.node()["rotation"] = nullptr; }, "'rotation'"},
      {"scales that overflow",
       [](Builder& b) {
         b.json["nodes"] = {{{"name", "a"}, {"scale", {1e200, 1, 1}}, {"children", {1}}},
                            {{"name", "b"}, {"mesh", 0}, {"scale", {1e200, 1, 1}}}};
       },
       "node 'b'"},
      {"name a number", [](Builder& b) { b.node()["name"] = 5; }, "'name' is not a string"},
      {"extensions a list", [](Builder& b) { b.node()["extensions"] = Json::array(); }, "'extensions'"},
      {"base colour of 3",
       [](Builder& b) {
         b.material()["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1};
       },
       "4 numbers"},
      {"metallic a string", [](Builder& b) { b.material()["pbrMetallicRoughness"]["metallicFactor"] = "1"; },
       "'metallicFactor'"},
      {"emissive of 4",
       [](Builder& b) {
         b.material()["emissiveFactor"] = {1, 1, 1, 1};
       },
       "3 numbers"},
      {"strength a list",
       [](Builder& b) { b.material()["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = {1}; },
       "'emissiveStrength'"},
      {"doubleSided a number", [](Builder& b) { b.material()["doubleSided"] = 1; }, "'doubleSided'"},
      {"position of VEC2", [](Builder& b) { b.json["accessors"][0]["type"] = "VEC2"; }, "POSITION"},
      {"position of shorts",
       [](Builder& b) { b.primitive()["attributes"]["POSITION"] = b.add("VEC3", kShort, std::vector<short>(9), 3); },
       "POSITION"},
      {"normals too few",
       [](Builder& b) { b.primitive()["attributes"]["NORMAL"] = b.add("VEC3", kFloat, std::vector<float>(6), 2); },
       "NORMAL"},
      {"index beyond positions",
       [](Builder& b) {
         b.primitive()["indices"] = b.add("SCALAR", kUnsignedShort, std::vector<std::uint16_t>{0, 1, 3}, 3);
       },
       "accessor 2, element 2 is 3"},
      {"restart value u8",
       [](Builder& b) {
         b.primitive()["indices"] = b.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{0, 255, 1}, 3);
       },
       "accessor 2, element 1 is 255, the primitive restart value"},
      {"restart value u16",
       [](Builder& b) {
         b.primitive()["indices"] = b.add("SCALAR", kUnsignedShort, std::vector<std::uint16_t>{0, 1, 65535}, 3);
       },
       "restart"},
      {"restart value u32",
       [](Builder& b) {
         b.primitive()["indices"] = b.add("SCALAR", kUnsignedInt, std::vector<std::uint32_t>{~0U, 1, 2}, 3);
       },
       "restart"},
      {"indices of floats",
       [](Builder& b) { b.primitive()["indices"] = b.add("SCALAR", kFloat, std::vector<float>(3), 3); },
       "SCALAR of unsigned"},
      {"indices of vectors",
       [](Builder& b) { b.primitive()["indices"] = b.add("VEC2", kUnsignedShort, std::vector<short>(6), 3); },
       "SCALAR of unsigned"},
      {"camera of no type",
       [](Builder& b) {
         b.json["cameras"] = {{{"name", "eye"}}};
         b.node()["camera"] = 0;
       },
       "camera 'eye': 'type'"},
      {"camera fisheye",
       [](Builder& b) {
         b.json["cameras"] = {{{"type", "fisheye"}}};
         b.node()["camera"] = 0;
       },
       "camera 0: 'type'"},
      {"camera without lens",
       [](Builder& b) {
         b.json["cameras"] = {{{"type", "perspective"}}};
         b.node()["camera"] = 0;
       },
       "'perspective' is missing"},
      {"yfov missing", camera({{"znear", 1}}), "camera 'eye'"},
      {"yfov zero", camera({{"yfov", 0}}), "yfov"},
      {"yfov negative", camera({{"yfov", -0.5}}), "yfov"},
      {"yfov 180 degrees", camera({{"yfov", 3.1415926535897932}}), "yfov"},
      {"yfov a string", camera({{"yfov", "wide"}}), "'yfov' is not a number"},
      {"aspect zero", camera({{"yfov", 1}, {"aspectRatio", 0}}), "aspectRatio"},
      {"aspect negative", camera({{"yfov", 1}, {"aspectRatio", -1}}), "aspectRatio"},
      {"xmag missing", orthographic({{"ymag", 1}}), "'xmag' is missing, 0"},
      {"ymag zero", orthographic({{"xmag", 1}, {"ymag", 0}}), "camera 'plan', orthographic: 'ymag'"},
      {"ymag a string", orthographic({{"xmag", 1}, {"ymag", "1"}}), "'ymag' is not a number"},
      {"ymag huge", orthographic({{"xmag", 1}, {"ymag", 1e300}}), "'ymag'"},
      {"picture a line", orthographic({{"xmag", 1e-9}, {"ymag", 1e9}}), "is a line"},
      {"environment negative",
       [](Builder& b) {
         b.json["extras"]["environment"]["radiance"] = {1, -1, 1};
       },
       "radiance -1"},
      {"environment too large",
       [](Builder& b) {
         b.json["extras"]["environment"]["radiance"] = {1e300, 1, 1};
       },
       "radiance"},
      {"environment of 2",
       [](Builder& b) {
         b.json["extras"]["environment"]["radiance"] = {1, 1};
       },
       "3 numbers"},
  });
}

}  // namespace
