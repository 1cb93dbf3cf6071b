// SPDX-License-Identifier: Apache-2.0
#include "gltf/skin/skinning.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "scene/transform.h"

namespace eikon {
namespace {

/// Bytes of up to eight weights are rounded each.
constexpr double kSlackOfBytes = 0.02, kSlack = 1e-3;

/// Four of the joints of each vertex.
struct JointSet {
  const Accessor& joints;
  const Accessor& weights;
};

/// Blends the matrices of vertices, and counts weights that are not as they should be.
class Blender {
 public:
  Blender(const Skin& skin, const std::map<std::string, const Accessor*>& attributes, const std::string& user)
      : skin_(skin), user_(user) {
    for (std::size_t set = 0;; ++set) {
      const auto joints = attributes.find(fmt::format("JOINTS_{}", set));
      if (joints == attributes.end()) break;
      const auto weights = attributes.find(fmt::format("WEIGHTS_{}", set));
      if (weights == attributes.end())
        throw InputError(fmt::format("{}: has JOINTS_{} without WEIGHTS_{}; export the file again", user, set, set));
      sets_.push_back({.joints = *joints->second, .weights = *weights->second});
    }
  }

  [[nodiscard]] glm::dmat4 matrix_of(std::uint64_t vertex) {
    glm::dmat4 blended(0.0);
    double sum = 0;
    for (const JointSet& set : sets_) {
      const glm::vec4 joints = set.joints.vector_at(vertex), weights = set.weights.vector_at(vertex);
      for (int k = 0; k < 4; ++k) {
        double weight = static_cast<double>(weights[k]);
        if (!(weight >= 0) || !std::isfinite(weight)) {
          bad_.add(vertex);
          weight = 0;
        }
        if (weight == 0) continue;
        blended += weight * joint(set, vertex, joints[k]);
        sum += weight;
      }
    }
    const bool bytes = sets_.front().weights.component == ComponentType::u8;
    if (!(std::abs(sum - 1) <= (bytes ? kSlackOfBytes : kSlack))) off_.add(vertex);
    if (sum == 1) return blended;  // most vertices follow one joint, and a division takes as long as a joint
    const JointSet& first = sets_.front();
    return sum > 0 ? blended / sum : joint(first, vertex, first.joints.vector_at(vertex).x);
  }

  void note(Notes& notes) const {
    if (bad_.count != 0)
      notes.mended(
          fmt::format("{}: weights of joints taken as 0: {}, element {} has a negative one or no number ({} "
                      "of them)",
                      user_, sets_.front().weights.label, bad_.first, bad_.count));
    if (off_.count != 0)
      notes.mended(fmt::format("{}: weights of joints normalised: {}, element {} does not sum to 1 ({} of them)", user_,
                               sets_.front().weights.label, off_.first, off_.count));
  }

 private:
  struct Odd {
    std::uint64_t first = 0, count = 0;
    void add(std::uint64_t vertex) {
      if (count == 0 || vertex != last) ++count;
      if (count == 1) first = vertex;
      last = vertex;
    }
    std::uint64_t last = 0;
  };

  const glm::dmat4& joint(const JointSet& set, std::uint64_t vertex, float number) const {
    const auto index = static_cast<std::size_t>(number);
    if (index < skin_.joints.size()) return skin_.joints[index];
    throw InputError(fmt::format("{}: {}, element {} names joint {}, but {} has {}", user_, set.joints.label, vertex,
                                 index, skin_.label, skin_.joints.size()));
  }

  const Skin& skin_;
  const std::string& user_;
  std::vector<JointSet> sets_;
  Odd bad_, off_;
};

/// Floats that take the place of an accessor.
struct Replaced {
  const Accessor* source = nullptr;  // null: the primitive lacks it
  Bytes storage{};

  void begin(const std::map<std::string, const Accessor*>& attributes, const char* name) {
    const auto found = attributes.find(name);
    if (found == attributes.end()) return;
    source = found->second;
    storage.size = source->count * source->component_count * sizeof(float);
    storage.data = std::make_unique_for_overwrite<std::byte[]>(storage.size);
  }
  void set(std::uint64_t vertex, const glm::vec4& value) {
    const std::size_t bytes = source->component_count * sizeof(float);
    std::memcpy(storage.data.get() + vertex * bytes, &value, bytes);
  }
  void end(const char* name, OwnAttributes& result) {
    if (source == nullptr) return;
    Accessor accessor;
    accessor.data = storage.data.get();
    accessor.count = source->count;
    accessor.component_count = source->component_count;
    accessor.stride_bytes = static_cast<std::uint32_t>(source->component_count * sizeof(float));
    accessor.label = source->label + " with its skin";
    result.attributes[name] = std::move(accessor);
    result.storage.push_back(std::move(storage));
  }
};

}  // namespace

bool is_for_skins(const std::string& name) {
  return name == "POSITION" || name == "NORMAL" || name == "TANGENT" || name.starts_with("JOINTS_") ||
         name.starts_with("WEIGHTS_");
}

SkinnedVertices skin_vertices(const Skin& skin, const std::map<std::string, const Accessor*>& attributes,
                              const std::string& user, Notes& notes) {
  Blender blender(skin, attributes, user);
  Replaced positions, normals, tangents;
  positions.begin(attributes, "POSITION");
  normals.begin(attributes, "NORMAL");
  tangents.begin(attributes, "TANGENT");
  SkinnedVertices result;
  for (std::uint64_t i = 0; i < positions.source->count; ++i) {
    const glm::dmat4 matrix = blender.matrix_of(i);
    const glm::dmat3 linear(matrix);
    const bool mirrors = glm::determinant(linear) < 0;
    if (mirrors) {
      result.mirrored.resize(positions.source->count);
      result.mirrored[i] = true;
    }
    const double facing = mirrors ? -1 : 1;
    const glm::dvec3 position(glm::vec3(positions.source->vector_at(i)));
    positions.set(i, glm::vec4(glm::vec3(linear * position + glm::dvec3(matrix[3])), 0.0F));
    // Directions get length 1, since the scale of joints may be far from it.
    if (normals.source != nullptr)
      normals.set(
          i, glm::vec4(direction_of(facing * (cofactors(linear) * glm::dvec3(normals.source->vector_at(i)))), 0.0F));
    if (tangents.source != nullptr) {
      const glm::vec4 tangent = tangents.source->vector_at(i);
      const float handedness = mirrors ? -tangent.w : tangent.w;
      tangents.set(i, glm::vec4(direction_of(linear * glm::dvec3(tangent)), handedness));
    }
  }
  blender.note(notes);
  positions.end("POSITION", result.own);
  normals.end("NORMAL", result.own);
  tangents.end("TANGENT", result.own);
  return result;
}

}  // namespace eikon
