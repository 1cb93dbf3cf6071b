// SPDX-License-Identifier: Apache-2.0
// Tangents that are made for a mesh in several poses: a vertex of one pose is the same one in all.
#include <cmath>

#include "scene/transform.h"
#include "support/gltf_builder.h"

namespace {

using eikon::Primitive;
using scene_test::Builder;
using scene_test::Json;
using scene_test::kFloat;
using scene_test::kUnsignedByte;

glm::dmat4 leaning(double degrees, const glm::dvec3& scale = glm::dvec3(1)) {
  const double half = degrees * 3.14159265358979323846 / 360;
  return eikon::transform_matrix({0, 0, 0}, {0.6 * std::sin(half), 0, 0.8 * std::sin(half), std::cos(half)}, scale);
}

/// Four triangles that follow one joint. Their texture is mirrored at y = 0, where it runs along
/// |y|, so the two vertices there have two tangents each.
/// fold  height of the outer edges; with 0 all lies in one plane
Primitive strip(const glm::dmat4& joint, bool smooth, float fold) {
  std::vector<float> positions, normals, uv, weights;
  for (const float y : {-1.0F, 0.0F, 1.0F})
    for (const float x : {-0.5F, 0.5F}) {
      for (const float p : {x, y, fold * y * y}) positions.push_back(p);
      for (const float n : {0.0F, 0.0F, 1.0F}) normals.push_back(n);
      for (const float t : {std::abs(y), x + 0.5F}) uv.push_back(t);
      for (const float w : {1.0F, 0.0F, 0.0F, 0.0F}) weights.push_back(w);
    }
  Builder builder;
  Json matrix = Json::array();
  for (int i = 0; i < 16; ++i) matrix.push_back(joint[i / 4][i % 4]);
  builder.json["nodes"].push_back({{"matrix", matrix}});
  builder.json["scenes"][0]["nodes"].push_back(1);
  builder.json["skins"] = {{{"joints", {1}}}};
  builder.node()["skin"] = 0;
  Json& attributes = builder.primitive()["attributes"];
  attributes["POSITION"] = builder.add("VEC3", kFloat, positions, 6);
  if (smooth) attributes["NORMAL"] = builder.add("VEC3", kFloat, normals, 6);
  attributes["TEXCOORD_0"] = builder.add("VEC2", kFloat, uv, 6);
  attributes["JOINTS_0"] = builder.add("VEC4", kUnsignedByte, std::vector<std::uint8_t>(24, 0), 6);
  attributes["WEIGHTS_0"] = builder.add("VEC4", kFloat, weights, 6);
  builder.primitive()["indices"] =
      builder.add("SCALAR", kUnsignedByte, std::vector<std::uint8_t>{0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4}, 12);
  builder.json["images"] = {{{"uri",
                              "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+"
                              "M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="}}};
  builder.json["textures"] = {{{"source", 0}}};
  builder.material()["normalTexture"] = {{"index", 0}};
  const eikon::Scene scene = builder.load();
  return scene.meshes.at(0).primitives.at(0);
}

glm::dvec3 bitangent(const Primitive& primitive, std::size_t vertex, const glm::dvec3& normal) {
  const glm::dvec4 tangent(primitive.tangents_object.at(vertex));
  return glm::cross(normal, glm::dvec3(tangent)) * tangent.w;
}

TEST(PosedTangents, belong_to_the_same_vertices_in_every_pose) {
  for (const bool smooth : {true, false})
    for (const float fold : {0.0F, 0.5F}) {
      const Primitive rest = strip(glm::dmat4(1), smooth, fold);
      EXPECT_GE(rest.positions_object.size(), 8U);
      for (const double degrees : {-70.0, -1.1, 0.3, 1.1, 45.0, 170.0}) {
        const glm::dmat4 joint = leaning(degrees);
        const Primitive posed = strip(joint, smooth, fold);
        ASSERT_EQ(posed.positions_object.size(), rest.positions_object.size()) << degrees;
        EXPECT_EQ(posed.indices, rest.indices) << degrees;
        for (std::size_t i = 0; i < rest.tangents_object.size(); ++i) {
          const glm::dvec3 want(joint * glm::dvec4(glm::dvec3(rest.tangents_object[i]), 0));
          EXPECT_LT(glm::length(glm::dvec3(posed.tangents_object[i]) - want), 1e-5) << degrees << ", vertex " << i;
          EXPECT_EQ(posed.tangents_object[i].w, rest.tangents_object[i].w) << degrees << ", vertex " << i;
        }
      }
    }
}

TEST(PosedTangents, turn_their_sign_where_a_joint_mirrors_the_mesh) {
  const glm::dmat4 joint = leaning(30, {-1, 1, 1});
  const Primitive rest = strip(glm::dmat4(1), true, 0), mirrored = strip(joint, true, 0);
  ASSERT_EQ(mirrored.positions_object.size(), rest.positions_object.size());
  EXPECT_NE(mirrored.indices, rest.indices);
  const glm::dvec3 up(0, 0, 1), posed_up(joint * glm::dvec4(up, 0));
  for (std::size_t i = 0; i < rest.tangents_object.size(); ++i) {
    const glm::dvec3 want(joint * glm::dvec4(bitangent(rest, i, up), 0));
    EXPECT_LT(glm::length(bitangent(mirrored, i, posed_up) - want), 1e-5) << i;
  }
}

}  // namespace
