// SPDX-License-Identifier: Apache-2.0
// Scenes that stay in memory from one job to the next.
#pragma once
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "job/batch/job_key.h"
#include "job/prepare.h"
#include "pack/pack.h"

namespace eikon {

/// Keeps scenes as loaded and as packed. Any thread may call it.
class SceneCache {
 public:
  /// A scene as loaded, and as packed for different settings.
  struct Kept {
    Digest digest{};
    std::shared_ptr<Scene> scene{};  // with its meshes
    SceneChoice choice{};
    std::shared_ptr<TreeMemory> trees{};  // of all poses of the file
    double load_s = 0;
    struct Packed {
      std::string key{};
      bool improved = false;  // its trees are improved by reinsertion
      std::shared_ptr<PackedScene> scene{};
    };
    std::list<Packed> packed{};
  };

  /// budget_bytes  rough limit of everything that is kept
  explicit SceneCache(std::uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// True if a scene of such files may stay. A larger one is loaded for one job, and freed as it is
  /// packed.
  [[nodiscard]] bool takes(const Digest& digest) const { return digest.bytes < budget_bytes_ / 8; }
  /// Called before work that takes long, if there is any.
  using Before = std::function<void()>;
  /// The scene whose files have this digest, as `choice` asks for it: from memory, or loaded.
  /// throws InputError
  std::shared_ptr<Kept> load(const std::filesystem::path& path, const SceneChoice& choice, const Digest& digest,
                             const Before& loading = {});
  /// Packs the scene for these settings, or finds it packed.
  /// environment  a text that is the same whenever the environment is
  std::shared_ptr<PackedScene> pack(Kept& kept, const Settings& settings, const Execution& execution,
                                    const std::string& environment, const Before& packing = {});
  void clear();

 private:
  std::mutex mutex_;
  std::uint64_t budget_bytes_;
  std::list<std::shared_ptr<Kept>> kept_;  // the most recently used at the end
};

}  // namespace eikon
