// SPDX-License-Identifier: Apache-2.0
#include "job/scene_cache.h"

#include <algorithm>
#include <set>

#include "accel/reinsertion.h"
#include "core/clock.h"
#include "pack/geometry/instanced_meshes.h"
#include "scene/measured_table.h"

namespace eikon {
namespace {

template <class T>
std::uint64_t bytes_of(const T& values) {
  return values.size() * sizeof(values[0]);
}

std::uint64_t bytes_of(const Scene& scene) {
  std::uint64_t bytes = 0;
  for (const Mesh& mesh : scene.meshes)
    for (const Primitive& p : mesh.primitives)
      bytes += bytes_of(p.positions_object) + bytes_of(p.normals_object) + bytes_of(p.uv[0]) + bytes_of(p.uv[1]) +
               bytes_of(p.colors) + bytes_of(p.tangents_object) + p.indices.bytes();
  for (const TextureImage& image : scene.images) bytes += bytes_of(image.rgba8);
  std::set<const MeasuredTable*> tables;
  for (const Material& material : scene.materials)
    if (material.measured && tables.insert(material.measured.get()).second) bytes += bytes_of(material.measured->words);
  if (scene.environment && scene.environment->map) bytes += bytes_of(scene.environment->map->radiance);
  for (const auto& pose : scene.poses) bytes += bytes_of(*pose);
  return bytes;
}

// PackedScene::bytes() cannot be asked, since a render may be adding trees. They take about as much
// as the triangles.
std::uint64_t bytes_of(const PackedScene& packed) {
  return 3 * bytes_of(packed.triangles) + 2 * packed.motion_bytes() + bytes_of(packed.shapes) + bytes_of(packed.normals) +
         bytes_of(packed.tangents) + bytes_of(packed.colors) + bytes_of(packed.lights) +
         bytes_of(packed.environment_texels);
}

std::uint64_t bytes_of(const SceneCache::Kept& kept) {
  std::uint64_t bytes = bytes_of(*kept.scene);
  for (const SceneCache::Kept::Packed& packed : kept.packed) bytes += bytes_of(*packed.scene);
  return bytes;
}

// The most that are kept, whatever their size: scenes, packed forms of one scene, and, among the
// scenes, poses and variants of one file.
constexpr std::size_t kScenes = 8, kPackedForms = 4;
constexpr std::ptrdiff_t kPoses = 2;

}  // namespace

std::shared_ptr<SceneCache::Kept> SceneCache::load(const std::filesystem::path& path, const SceneChoice& choice,
                                                   const Digest& digest, const Before& loading) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const auto& kept) {
    return kept->digest.hash == digest.hash && kept->scene->path == path && kept->choice == choice;
  });
  if (found != kept_.end()) {
    kept_.splice(kept_.end(), kept_, found);
    (*found)->load_s = 0;
    return *found;
  }
  if (loading) loading();
  const auto is_pose = [&](const auto& kept) { return kept->digest.hash == digest.hash && kept->scene->path == path; };
  // Another pose or variant of the same file shares what does not depend on these.
  const auto relative = std::find_if(kept_.rbegin(), kept_.rend(), is_pose);
  const std::shared_ptr<Kept> of_file = relative == kept_.rend() ? nullptr : *relative;
  const auto total = [&] {
    std::uint64_t bytes = 0;
    for (const auto& kept : kept_) bytes += bytes_of(*kept);
    return bytes;
  };
  // The frames of a sequence come once, so only the last poses are likely to be asked for again.
  while (std::ranges::count_if(kept_, is_pose) >= kPoses) kept_.erase(std::ranges::find_if(kept_, is_pose));
  // A scene in memory may take several times the size of its files.
  while (!kept_.empty() && (kept_.size() >= kScenes || total() + 4 * digest.bytes > budget_bytes_)) kept_.pop_front();
  auto kept = std::make_shared<Kept>();
  const double begin = host_seconds();
  kept->scene = std::make_shared<Scene>(
      load_scene(path, choice, MissingTangents::make, of_file == nullptr ? nullptr : of_file->scene->memory));
  kept->trees = of_file == nullptr ? std::make_shared<TreeMemory>() : of_file->trees;
  kept->choice = choice;
  kept->load_s = host_seconds() - begin;
  kept->digest = digest;
  if (bytes_of(*kept) <= budget_bytes_) kept_.push_back(kept);
  return kept;
}

void SceneCache::clear() {
  const std::lock_guard lock(mutex_);
  kept_.clear();
}

std::shared_ptr<PackedScene> SceneCache::pack(Kept& kept, const Settings& settings, const Execution& execution,
                                              const std::string& environment, const Before& packing) {
  const std::lock_guard lock(mutex_);
  const Features features = features_of(*kept.scene, settings, execution);
  const std::string key = features.summary() + "\n" + environment;
  const double rays = expected_rays(settings);
  for (const Kept::Packed& packed : kept.packed)
    if (packed.key == key && (packed.improved || !reinsertion_pays(packed.scene->triangles.size(), rays)))
      return packed.scene;
  if (packing) packing();
  auto packed = share(pack_scene(*kept.scene, features, settings), kept.scene);
  if (!kept.scene->animations.empty()) packed->trees = kept.trees;
  if (kept.packed.size() >= kPackedForms) kept.packed.pop_front();
  kept.packed.push_back({key, reinsertion_pays(packed->triangles.size(), rays), packed});
  return packed;
}

}  // namespace eikon
