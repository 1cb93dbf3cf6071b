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

  /// The bounds of poses, by a text that says which.
  [[nodiscard]] std::optional<std::vector<Bounds>> poses(const std::string& which) {
    const std::lock_guard lock(mutex_);
    const auto found = poses_.find(which);
    return found == poses_.end() ? std::nullopt : std::optional(found->second);
  }
  void keep_poses(const std::string& which, const std::vector<Bounds>& bounds) {
    const std::lock_guard lock(mutex_);
    poses_[which] = bounds;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<std::vector<std::uint32_t>>> images_;
  std::map<std::string, std::vector<Bounds>> poses_;
};

}  // namespace eikon
