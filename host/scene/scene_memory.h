// SPDX-License-Identifier: Apache-2.0
// What the poses and variants of a file have in common, so that a sequence makes it once.
#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene.h"

namespace eikon {

/// The vertex data beyond positions, normals and colours that a material needs.
struct MaterialNeeds {
  std::array<bool, 2> uv{};               // sets of texture coordinates
  std::optional<std::size_t> tangents{};  // the set that they are made from,
  // and the map from it to the image whose axes they follow, (u, v) to (u, v).
  std::array<float, 4> tangents_from_uv{1, 0, 0, 1};
  auto operator<=>(const MaterialNeeds&) const = default;
};

/// A primitive as it stands in the file, which no pose changes.
struct PrimitiveAtRest {
  std::size_t mesh = 0, primitive = 0;  // indices of the file
  auto operator<=>(const PrimitiveAtRest&) const = default;
};

/// The triangles of a primitive, which no pose changes, and the vertices of the file that they use,
/// or none if that is all of them.
struct Connections {
  TriangleIndices indices;
  std::vector<std::uint32_t> used;
};

/// Belongs to one file, whose bytes do not change meanwhile. Any thread may call it.
class SceneMemory {
 public:
  using Texels = SharedVector<std::uint32_t>;

  /// The pixels of a source of the file that some scene still has, or nothing.
  [[nodiscard]] std::optional<Texels> image(const std::string& source) {
    const std::lock_guard lock(mutex_);
    const auto found = images_.find(source);
    return found == images_.end() ? std::nullopt : Texels::shared(found->second.lock());
  }
  void keep_image(const std::string& source, const Texels& texels) {
    const std::lock_guard lock(mutex_);
    images_[source] = texels.owner();
  }

  /// A camera that frames poses, by a text that says which.
  [[nodiscard]] std::optional<Camera> camera(const std::string& which) {
    const std::lock_guard lock(mutex_);
    const auto found = cameras_.find(which);
    return found == cameras_.end() ? std::nullopt : std::optional(found->second);
  }
  void keep_camera(const std::string& which, const Camera& camera) {
    const std::lock_guard lock(mutex_);
    cameras_[which] = camera;
  }

  /// True if it was read for some material.
  [[nodiscard]] bool has_primitive(const PrimitiveAtRest& which) {
    const std::lock_guard lock(mutex_);
    const auto first = primitives_.lower_bound({which, {}});
    return first != primitives_.end() && first->first.first == which;
  }
  /// The geometry of a primitive that was read for a material with these needs, or nothing.
  [[nodiscard]] std::optional<Primitive> primitive(const PrimitiveAtRest& which, const MaterialNeeds& needs) {
    const std::lock_guard lock(mutex_);
    const auto found = primitives_.find({which, needs});
    return found == primitives_.end() ? std::nullopt : std::optional(found->second);
  }
  void keep_primitive(const PrimitiveAtRest& which, const MaterialNeeds& needs, const Primitive& primitive) {
    const std::lock_guard lock(mutex_);
    primitives_.insert_or_assign({which, needs}, primitive);
  }
  /// The triangles of a primitive that moves, or null.
  [[nodiscard]] std::shared_ptr<const Connections> connections(const PrimitiveAtRest& which) {
    const std::lock_guard lock(mutex_);
    const auto found = connections_.find(which);
    return found == connections_.end() ? nullptr : found->second;
  }
  void keep_connections(const PrimitiveAtRest& which, std::shared_ptr<const Connections> connections) {
    const std::lock_guard lock(mutex_);
    connections_[which] = std::move(connections);
  }
  /// Shares no geometry any longer, so that scenes can give theirs away.
  void forget_primitives() {
    const std::lock_guard lock(mutex_);
    primitives_.clear();
    connections_.clear();
  }

  /// The most light that arrives at what a camera sees over poses, by a text that says which.
  [[nodiscard]] std::optional<double> light(const std::string& which) {
    const std::lock_guard lock(mutex_);
    const auto found = lights_.find(which);
    return found == lights_.end() ? std::nullopt : std::optional(found->second);
  }
  void keep_light(const std::string& which, double light) {
    const std::lock_guard lock(mutex_);
    lights_[which] = light;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<std::vector<std::uint32_t>>> images_;
  std::map<std::string, Camera> cameras_;
  std::map<std::pair<PrimitiveAtRest, MaterialNeeds>, Primitive> primitives_;
  std::map<PrimitiveAtRest, std::shared_ptr<const Connections>> connections_;
  std::map<std::string, double> lights_;
};

}  // namespace eikon
