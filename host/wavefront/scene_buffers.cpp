// SPDX-License-Identifier: Apache-2.0
#include "wavefront/scene_buffers.h"

#include <algorithm>

namespace eikon {
namespace {

class Uploader {
 public:
  Uploader(Device& device, Arguments& arguments) : device_(device), arguments_(arguments) {}
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  template <class Array>
  void share(const char* name, const Array& values) {
    // An argument needs a buffer even if it is empty. Then it is one record of zeros, which is
    // never read.
    static const Array nothing(1);
    const Array& source = values.empty() ? nothing : values;
    const std::size_t size = source.size() * sizeof(source[0]);
    bytes_ += size;
    arguments_.set(name, device_.share(source.data(), size));
  }
  void copy_texels(const PackedScene& scene) {
    const std::size_t size = 4 * std::max<std::size_t>(scene.texel_count(), 1);
    const Buffer texels = device_.allocate(size);
    bytes_ += size;
    std::size_t offset = 0;
    for (const std::span<const std::uint32_t> part : scene.texels) {
      device_.write(texels, part.data(), part.size_bytes(), offset);
      offset += part.size_bytes();
    }
    arguments_.set("texels", texels);
  }

 private:
  Device& device_;
  Arguments& arguments_;
  std::uint64_t bytes_ = 0;
};

void share_tree_and_lights(Uploader& to, const PackedScene& scene, const Accel& accel) {
  to.share("accel_nodes", accel.nodes);
  to.share("accel_leaves", accel.leaves);
  to.share("triangles", scene.triangles);
  to.share("instances", accel.instances);
  to.share("shapes", scene.shapes);
  to.share("lights", scene.lights);
  to.share("light_alias_table", scene.light_alias_table);
  to.share("light_nodes", scene.light_nodes);
  to.share("environment_texels", scene.environment_texels);
  to.share("environment_alias_table", scene.environment_alias_table);
}

}  // namespace

void upload_tree_and_lights(Device& device, const PackedScene& scene, const Accel& accel, Arguments& arguments) {
  Uploader to(device, arguments);
  share_tree_and_lights(to, scene, accel);
}

std::uint64_t upload_scene(Device& device, const PackedScene& scene, const Accel& accel,
                           const std::vector<float>& filter, Arguments& arguments) {
  Uploader to(device, arguments);
  share_tree_and_lights(to, scene, accel);
  to.share("triangle_normals", scene.normals);
  to.share("triangle_tangents", scene.tangents);
  to.share("triangle_colors", scene.colors);
  to.share("materials", scene.materials);
  to.share("material_extensions", scene.material_extensions);
  to.share("material_details", scene.material_details);
  to.share("textures", scene.textures);
  to.copy_texels(scene);
  to.share("filter_table", filter);
  return to.bytes();
}

}  // namespace eikon
