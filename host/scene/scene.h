// SPDX-License-Identifier: Apache-2.0
// What a glTF file says, before anything is laid out for a device.
// Right-handed, +Y up, metres; colours linear Rec. 709.
#pragma once
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

namespace eikon {

struct Primitive {
  std::vector<glm::vec3> positions_object;  // finite; each is a corner of some triangle
  std::vector<glm::vec3> normals_object;    // one per position, unit; empty: flat shading by the triangle's own normal
  std::vector<std::uint32_t> indices;       // three per triangle, each < positions_object.size()
  std::uint32_t material = 0;               // index into Scene::materials
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
};

/// A node that carries a mesh, its parents' transforms applied.
struct Node {
  std::string name;
  glm::dmat4 world_from_object{1.0};
  std::uint32_t mesh = 0;
  bool mirrored = false;  // determinant < 0: two corners of each triangle change places, so that front stays front
};

struct Material {
  std::string name;
  glm::vec3 base_color{1.0F};  // clamped to [0, 1]
  float metallic = 1.0F;
  float roughness = 1.0F;
  float specular = 1.0F;     // KHR_materials_specular; 0 with metallic 0 is exactly Lambert
  glm::vec3 emission{0.0F};  // radiance: emissiveFactor x emissiveStrength, W / (sr m^2); finite
  bool double_sided = false;
};

struct Camera {
  std::string name;
  glm::dmat4 world_from_camera{1.0};  // looks along -Z, +Y up; a rotation and a translation, never a scale
  double yfov_rad = 0.7;
  double aspect = 0.0;  // width / height; 0: not said
};

struct Environment {
  glm::vec3 radiance{0.0F};  // from every direction, W / (sr m^2)
};

/// A feature of the file that eikon leaves out, named once.
struct Unsupported {
  std::string feature;  // "KHR_materials_clearcoat", "texture baseColorTexture", "specular reflection", ...
  std::string user;     // "material 'paint'", "node 'lamp'"
};

struct Scene {
  std::filesystem::path path;
  std::string hash;  // XXH64 of the file and the buffers it names: 16 hex digits
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Material> materials;  // at least one (glTF's default) when any primitive needs it
  std::vector<Camera> cameras;
  std::optional<Environment> environment;
  std::vector<Unsupported> unsupported;
  std::vector<std::string> warnings;  // one line each: what was changed or dropped, and why
  std::uint64_t file_bytes = 0;       // of the file and its buffers
};

/// Reads a .gltf or .glb file and everything it names, every offset, index and value checked before it is used.
/// throws InputError: what, where (accessor, node, ...), why, what to try; UsageError never
Scene load_scene(const std::filesystem::path& path);

struct Bounds {
  glm::dvec3 lo{1e300}, hi{-1e300};
  [[nodiscard]] bool empty() const { return !(lo.x <= hi.x); }
};

/// The first material that emits and that some node shows; nullptr if none does.
[[nodiscard]] const Material* first_emitter(const Scene& scene);

/// World bounds of all nodes' triangles; empty if there are none.
[[nodiscard]] Bounds world_bounds(const Scene& scene);

/// A camera that sees the whole of `bounds` from the front, slightly above, with a 40 degree vertical field of view.
[[nodiscard]] Camera frame_camera(const Bounds& bounds, double aspect);

/// A camera at `eye` that looks at `target`.
/// throws UsageError when they coincide, `up` is parallel to the view, or the field of view is not between 0 and pi
[[nodiscard]] Camera look_at_camera(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up,
                                    double yfov_rad);

}  // namespace eikon
