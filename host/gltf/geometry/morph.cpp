// SPDX-License-Identifier: Apache-2.0
#include "gltf/geometry/morph.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "core/error.h"
#include "io/text.h"

namespace eikon {
namespace {

// The attributes that are read, and what differences to them are made of; 0: as the attribute.
struct Morphed {
  const char* name;
  std::uint32_t components;
};
constexpr std::array<Morphed, 6> kMorphed{
    {{"POSITION", 3}, {"NORMAL", 3}, {"TANGENT", 3}, {"COLOR_0", 0}, {"TEXCOORD_0", 2}, {"TEXCOORD_1", 2}}};
constexpr std::size_t kBlock = 4096;                              // elements that are summed at a time
constexpr std::uint64_t kFreeElements = std::uint64_t{1} << 20U;  // of targets, however small the file is

std::size_t target_count(const GltfPrimitive& primitive) {
  const Json* targets = member(primitive.json, "targets");
  return targets == nullptr ? 0 : size_of(*targets);
}

// The elements of an accessor that are looked at.
std::uint64_t elements_of(const Accessor& target) {
  return target.data == nullptr ? target.sparse_count : target.count;
}

}  // namespace

std::vector<double> morph_weights(const GltfNode& node, const GltfMesh& mesh, Notes& notes) {
  const bool own = !node.weights.empty();
  const std::vector<double>& weights = own ? node.weights : mesh.weights;
  const bool changes = std::any_of(weights.begin(), weights.end(), [](double weight) { return weight != 0; });
  for (std::size_t p = 0; p < mesh.primitives.size() && !weights.empty(); ++p) {
    const std::size_t count = target_count(mesh.primitives[p]);
    if (count == weights.size()) continue;
    const std::string what =
        fmt::format("{}: {} weights for the {} morph targets of {}, primitive {}",
                    (own ? node.view : mesh.view).label(), weights.size(), count, mesh.view.label(), p);
    if (changes) throw InputError(what + "; export the file again");
    notes.mended(what + "; all are 0, so they change nothing");
    break;
  }
  return changes ? weights : std::vector<double>();
}

std::vector<MorphSummary> list_morphs(const Document& document) {
  std::vector<MorphSummary> morphs;
  for (const GltfMesh& mesh : document.meshes) {
    if (mesh.primitives.empty() || target_count(mesh.primitives.front()) == 0) continue;
    MorphSummary morph{.mesh = mesh.name,
                       .mesh_index = static_cast<std::size_t>(mesh.view.index),
                       .target_count = target_count(mesh.primitives.front()),
                       .names = {}};
    // The names that exporters agree on stand in the extras of the mesh.
    const Json* const names = member(member(mesh.view.value, "extras"), "targetNames");
    for (std::size_t i = 0; names != nullptr && is_array(*names) && i < size_of(*names); ++i)
      if (is_string(element(*names, i))) morph.names.push_back(to_string(element(*names, i)));
    morphs.push_back(std::move(morph));
  }
  return morphs;
}

bool Morpher::reads(const std::string& name) {
  return std::any_of(kMorphed.begin(), kMorphed.end(), [&](const Morphed& morphed) { return morphed.name == name; });
}

OwnAttributes Morpher::apply(const GltfPrimitive& primitive, const std::vector<double>& weights,
                             const std::map<std::string, const Accessor*>& base, const std::string& user) const {
  OwnAttributes result;
  std::uint64_t elements = 0;
  for (const Morphed& morphed : kMorphed) {
    std::vector<Target> targets = targets_of(primitive, weights, morphed.name);
    if (targets.empty()) continue;
    const auto found = base.find(morphed.name);
    if (found == base.end()) {
      notes_.mended(fmt::format("{}: its morph targets change {}, which it lacks; left out", user, morphed.name));
      continue;
    }
    for (const Target& target : targets) {
      check_target(morphed.name, target.differences, *found->second, user);
      elements += elements_of(target.differences);
    }
    // Honest files hold each target once, and an element takes more than a byte.
    if (elements > kFreeElements + file_bytes_) {
      throw InputError(fmt::format("{}: its morph targets name {} elements, more than the file's {} bytes hold", user,
                                   elements, file_bytes_));
    }
    result.storage.emplace_back();
    result.attributes[morphed.name] = sum(*found->second, std::move(targets), result.storage.back());
  }
  return result;
}

std::vector<Morpher::Target> Morpher::targets_of(const GltfPrimitive& primitive, const std::vector<double>& weights,
                                                 const std::string& name) const {
  std::vector<Target> result;
  const Json* targets = member(primitive.json, "targets");
  for (std::size_t t = 0; targets != nullptr && t < size_of(*targets); ++t) {
    const Json* accessor = member(element(*targets, t), name.c_str());
    if (accessor == nullptr || weights[t] == 0) continue;
    result.push_back({.differences = accessors_[to_index(*accessor)], .weight = weights[t]});
  }
  return result;
}

// Differences have a sign, so bytes and shorts may too [glTF 2.0, section 3.7.2.2;
// KHR_mesh_quantization, "Extending Morph Target Attributes"].
void Morpher::check_target(const std::string& name, const Accessor& target, const Accessor& base,
                           const std::string& user) const {
  const auto* morphed =
      std::find_if(kMorphed.begin(), kMorphed.end(), [&](const Morphed& m) { return m.name == name; });
  const std::uint32_t components = morphed->components == 0 ? base.component_count : morphed->components;
  const bool is_uv = morphed->components == 2, is_color = morphed->components == 0;
  const bool is_float = target.component == ComponentType::f32, is_wide = target.component == ComponentType::u32;
  const bool is_signed = target.component == ComponentType::i8 || target.component == ComponentType::i16;
  const bool plain = quantized_ && (is_uv || (name == "POSITION" && is_signed));
  const bool normalized = target.normalized && (is_uv || is_color || (quantized_ && is_signed));
  const bool legal = is_float || (!is_wide && (plain || normalized));
  if (!legal || target.is_matrix || target.component_count != components)
    throw InputError(
        fmt::format("{}: {} of a morph target in {} is of a type that glTF does not allow there; export "
                    "the file again",
                    user, name, target.label));
  if (target.count != base.count)
    throw InputError(
        fmt::format("{}: {} of a morph target in {} has {} elements for {} vertices; export the file "
                    "again",
                    user, name, target.label, target.count, base.count));
}

void Morpher::add(Target& target, std::uint64_t first, std::vector<glm::dvec4>& sums) {
  const Accessor& differences = target.differences;
  if (differences.data != nullptr) {
    for (std::size_t i = 0; i < sums.size(); ++i)
      sums[i] += target.weight * glm::dvec4(differences.vector_at(first + i));
    return;
  }
  for (; target.next_sparse < differences.sparse_count; ++target.next_sparse) {
    const auto [element, value] = differences.sparse_vector_at(target.next_sparse);
    if (element >= first + sums.size()) return;
    sums[element - first] += target.weight * glm::dvec4(value);
  }
}

Accessor Morpher::sum(const Accessor& base, std::vector<Target> targets, Bytes& storage) {
  const std::size_t element_bytes = base.component_count * sizeof(float);
  storage.size = base.count * element_bytes;
  storage.data = std::make_unique_for_overwrite<std::byte[]>(storage.size);
  std::vector<glm::dvec4> sums;
  for (std::uint64_t first = 0; first < base.count; first += kBlock) {
    sums.resize(std::min<std::uint64_t>(kBlock, base.count - first));
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = glm::dvec4(base.vector_at(first + i));
    for (Target& target : targets) add(target, first, sums);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const glm::vec4 value(sums[i]);
      std::memcpy(storage.data.get() + (first + i) * element_bytes, &value, element_bytes);
    }
  }
  Accessor result;
  result.data = storage.data.get();
  result.count = base.count;
  result.stride_bytes = static_cast<std::uint32_t>(element_bytes);
  result.component_count = base.component_count;
  result.label = base.label + " with its morph targets";
  return result;
}

}  // namespace eikon
