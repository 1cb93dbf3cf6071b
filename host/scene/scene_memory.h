// SPDX-License-Identifier: Apache-2.0
// What the poses and variants of a file have in common, so that a sequence makes it once.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace eikon {

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

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<std::vector<std::uint32_t>>> images_;
  std::map<std::string, Camera> cameras_;
};

}  // namespace eikon
