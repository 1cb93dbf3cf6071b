// SPDX-License-Identifier: Apache-2.0
// Small glTF files made on the spot, for the tests of the loader.
#pragma once
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace scene_test {

using Json = nlohmann::json;
using eikon::test::contains;
using eikon::test::message_of;
using eikon::test::TemporaryFolder;

// The component types of accessors.
inline constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
                     kFloat = 5126;

template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

inline std::string base64(const std::string& bytes) {
  constexpr const char* kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k <= bytes.size() ? kAlphabet[(bits >> (18 - 6 * k)) & 63U] : '=';
    }
  }
  return out;
}

inline std::string u32_bytes(std::size_t value) {
  std::string out;
  for (int i = 0; i < 4; ++i) out += static_cast<char>((value >> (8 * i)) & 0xFFU);
  return out;
}

inline std::string glb(std::string json, std::string binary, bool with_binary = true) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string chunks = u32_bytes(json.size()) + "JSON" + json;
  if (with_binary) chunks += u32_bytes(binary.size()) + std::string("BIN\0", 4) + binary;
  return "glTF" + u32_bytes(2) + u32_bytes(12 + chunks.size()) + chunks;
}

/// A document and its one buffer; the constructor gives the triangle (0,0,0) (1,0,0) (0,1,0) with
/// u16 indices 0 1 2 under node 'triangle' with material 'paint', exactly Lambert.
struct Builder {
  Json json;
  std::string buffer;

  Builder() {
    json = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
      "nodes": [{"name": "triangle", "mesh": 0}],
      "materials": [{"name": "paint",
                     "pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 0.25, 0.125, 1]},
                     "extensions": {"KHR_materials_specular": {"specularFactor": 0}}}],
      "extensionsUsed": ["KHR_materials_specular"]})");
    const std::size_t positions = add("VEC3", kFloat, std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
    const std::size_t indices = add("SCALAR", kUnsignedShort, std::vector<std::uint16_t>{0, 1, 2}, 3);
    json["meshes"] = {
        {{"name", "flat"},
         {"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}}}}}};
  }

  /// Appends data and its bufferView; returns the view's index.
  template <typename T>
  std::size_t add_view(const std::vector<T>& values) {
    buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
    const std::string bytes = bytes_of(values);
    json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}});
    buffer += bytes;
    return json["bufferViews"].size() - 1;
  }

  /// Appends data, bufferView and accessor; returns the accessor's index.
  template <typename T>
  std::size_t add(const char* type, int component, const std::vector<T>& values, std::size_t count) {
    const std::size_t view = add_view(values);
    json["accessors"].push_back({{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
    return json["accessors"].size() - 1;
  }

  Json& primitive() { return json["meshes"][0]["primitives"][0]; }
  Json& node(std::size_t i = 0) { return json["nodes"][i]; }
  Json& material() { return json["materials"][0]; }

  [[nodiscard]] std::string text() const {
    Json copy = json;
    if (!copy.contains("buffers")) {
      copy["buffers"] = {
          {{"byteLength", buffer.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer)}}};
    }
    return copy.dump();
  }
  [[nodiscard]] std::string glb_bytes() const {
    Json copy = json;
    if (!copy.contains("buffers")) copy["buffers"] = {{{"byteLength", buffer.size()}}};
    return glb(copy.dump(), buffer);
  }
  eikon::Scene load() const {
    const TemporaryFolder folder;
    return eikon::load_scene(folder.write("scene.gltf", text()));
  }
};

inline bool leaves_out(const eikon::Scene& scene, const std::string& feature, const std::string& user) {
  for (const eikon::Unsupported& u : scene.unsupported) {
    if (contains(u.feature, feature) && contains(u.user, user)) return true;
  }
  return false;
}

inline bool warns(const eikon::Scene& scene, const std::string& part) {
  for (const std::string& warning : scene.warnings) {
    if (contains(warning, part)) return true;
  }
  return false;
}

}  // namespace scene_test
