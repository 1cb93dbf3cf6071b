// SPDX-License-Identifier: Apache-2.0
// What a glTF file says, before anything is laid out for a device.
// Right-handed, +Y up, metres; colours linear Rec. 709.
#pragma once
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formula/parse.h"
#include "scene/shape.h"
#include "scene/shared_vector.h"
#include "scene/triangle_indices.h"

namespace eikon {

/// Primitives that name the same data of a file share it.
struct Primitive {
  SharedVector<glm::vec3> positions_object;  // finite; each is a corner of some triangle
  // Per position, or empty where the file has none and nothing needs one.
  SharedVector<glm::vec3> normals_object;   // unit; empty: flat shading by the triangle's own normal
  SharedVector<glm::vec2> uv[2];            // finite; texture coordinates 0 and 1
  SharedVector<glm::vec4> colors;           // COLOR_0: linear RGB in [0, 1] and opacity; multiplies the base colour
  // Unit, and the sign of the bitangent; present where the material has a normal map.
  SharedVector<glm::vec4> tangents_object;
  TriangleIndices indices;                  // three per triangle, each < positions_object.size()
  std::uint32_t material = 0;               // index into Scene::materials
};

struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
};

/// The triangles and vertices of a file that are compressed (Draco, meshoptimizer).
struct CompressedMeshes {
  std::uint64_t file_bytes = 0, unpacked_bytes = 0;
  std::uint64_t decoder_bytes = 0;  // the most that a decoder has at a time beside what it unpacks
};

/// A node that carries a mesh, its parents' transforms applied.
struct Node {
  std::string name;  // or "node 3" if the file has none
  glm::dmat4 world_from_object{1.0};
  std::uint32_t mesh = 0;
  std::uint32_t light_group = 0;  // of what its mesh emits; 0: the material's
  bool moves = false;     // or its mesh bends, while the shutter is open
  bool mirrored = false;  // determinant < 0: two corners of each triangle change places, so that front stays front
};

/// A decoded picture: 8 bits per channel, as the file has them.
struct TextureImage {
  std::string name;  // for messages: a file name in quotes, or "image 3"
  std::uint32_t width = 0, height = 0;
  SharedVector<std::uint32_t> rgba8;  // row-major from the top; R in the low byte
};

enum class Wrap { repeat, clamp, mirror };
enum class TextureFilter { nearest, linear };

/// One use of an image by a material: sampler, set of coordinates and KHR_texture_transform
/// resolved.
struct Texture {
  std::uint32_t image = 0;  // index into Scene::images
  std::uint32_t uv_set = 0;
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  TextureFilter filter = TextureFilter::linear;
  bool srgb = false;  // R, G, B are sRGB-encoded (colours); alpha never is
  // Rows of the affine map from the mesh's (u, v, 1) to the image's, v down from the top.
  glm::vec3 image_from_uv[2] = {{1.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}};
};

/// The lobes of kernels/shared/features.def. The value is the bit of MaterialRecord.flags that
/// names the lobe to kernels.
enum class Lobe : std::uint32_t {
#define EK_LOBE(name, bit, traits) name = bit,
#include "shared/features.def"
};

struct MeasuredTable;  // measured_table.h

enum class AlphaMode { opaque, mask, blend };

/// Factors in their legal ranges; a texture multiplies its factor.
struct Material {
  std::string name;
  glm::vec3 base_color{1.0F};  // [0, 1]
  float opacity = 1.0F;        // baseColorFactor's alpha; counts only with alpha_mode mask or blend
  float metallic = 1.0F;
  float roughness = 1.0F;
  float ior = 1.5F;                  // KHR_materials_ior: 0 (reflects everything) or >= 1
  float specular = 1.0F;             // KHR_materials_specular; 0 with metallic 0 is exactly Lambert
  glm::vec3 specular_color{1.0F};    // >= 0, may exceed 1
  float transmission = 0.0F;         // KHR_materials_transmission
  bool solid = false;                // KHR_materials_volume with a thickness: refracts; else thin-walled
  glm::vec3 attenuation_color{1.0F};
  float attenuation_distance = 0.0F;  // metres; 0: infinite, no absorption
  std::optional<std::int32_t> medium_priority{};  // extras.mediumPriority: where solids overlap, the highest counts
  float clearcoat = 0.0F;              // KHR_materials_clearcoat
  float clearcoat_roughness = 0.0F;
  float clearcoat_normal_scale = 1.0F;
  glm::vec3 sheen_color{0.0F};         // KHR_materials_sheen, [0, 1]
  float sheen_roughness = 0.0F;
  // KHR_materials_diffuse_transmission: share of the diffuse base that light passes.
  float diffuse_transmission = 0.0F;
  glm::vec3 diffuse_transmission_color{1.0F};  // of what passes, [0, 1]
  float iridescence = 0.0F;            // KHR_materials_iridescence: share of the surface under a thin film
  float thin_film_index = 1.3F;        // of refraction, >= 1
  float thin_film_thickness_nm[2] = {100.0F, 400.0F};  // for 0 and 1 of its texture; without one the second
  float dispersion = 0.0F;             // KHR_materials_dispersion: 20 / Abbe number
  float anisotropy = 0.0F;             // KHR_materials_anisotropy: strength
  double anisotropy_rotation_rad = 0.0;  // from the tangent towards the bitangent
  std::optional<Lobe> lobe{};  // of an extension that replaces glTF's metal, plastic and glass
  // The parameters of such lobes, which count if `lobe` is theirs.
#define EK_FACTOR(name) float name = 0.0F;
#define EK_COLOR(name) glm::vec3 name{0.0F};
#define EK_UNUSED(words)
#include "shared/lobe_parameters.def"
#undef EK_FACTOR
#undef EK_COLOR
#undef EK_UNUSED
  std::shared_ptr<const MeasuredTable> measured{};  // of the lobe `measured`
  glm::vec3 emission{0.0F};          // radiance: emissiveFactor x emissiveStrength, W / (sr m^2); finite
  float normal_scale = 1.0F;
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = 0.5F;
  bool double_sided = false;
  bool unlit = false;
  std::uint32_t light_group = 0;                        // index into Scene::light_groups
  std::optional<Texture> base_color_texture{};          // RGB, and A for opacity
  std::optional<Texture> metallic_roughness_texture{};  // B metallic, G roughness
  std::optional<Texture> normal_texture{};
  std::optional<Texture> emissive_texture{};
  std::optional<Texture> transmission_texture{};    // R
  std::optional<Texture> specular_texture{};        // A
  std::optional<Texture> specular_color_texture{};  // RGB, sRGB
  std::optional<Texture> clearcoat_texture{};            // R
  std::optional<Texture> clearcoat_roughness_texture{};  // G
  std::optional<Texture> clearcoat_normal_texture{};
  std::optional<Texture> sheen_color_texture{};      // RGB, sRGB
  std::optional<Texture> sheen_roughness_texture{};  // A
  std::optional<Texture> diffuse_transmission_texture{};        // A
  std::optional<Texture> diffuse_transmission_color_texture{};  // RGB, sRGB
  std::optional<Texture> iridescence_texture{};     // R
  std::optional<Texture> thin_film_thickness_texture{};  // G
  std::optional<Texture> anisotropy_texture{};       // R, G: direction; B: strength
};

struct TextureUse {
  std::string name;  // for lists: "base color"
  const Texture* texture;
};

/// The textures that a material has.
[[nodiscard]] std::vector<TextureUse> textures_of(const Material& material);

/// The kinds of light of kernels/shared/features.def, with the values that Light.kind has in
/// kernels.
enum class LightKind : std::uint32_t {
#define EK_LIGHT(name, bit) name = bit,
#include "shared/features.def"
};

/// A light without extent, placed by its node: `point`, `spot` or `directional`
/// [KHR_lights_punctual].
struct PunctualLight {
  std::string name;
  LightKind kind = LightKind::point;
  glm::vec3 intensity{0.0F};  // colour x intensity; point, spot: W / sr (candela); directional: W / m^2 (lux)
  glm::dvec3 position{0.0};   // world, metres
  glm::dvec3 direction{0.0, 0.0, -1.0};  // unit, the way that the light travels; spot and directional
  double range_m = 0.0;                  // 0: no end
  double inner_cone_rad = 0.0, outer_cone_rad = 0.0;  // half angles, inner <= outer
  std::uint32_t light_group = 0;                      // index into Scene::light_groups
};

enum class Projection {
  perspective,
  orthographic,
  panorama,  // every direction, equirectangular: the picture's middle is ahead, u grows to the right
};

/// The opening of a perspective camera with a thin lens. What is `focus_distance_m` ahead, measured
/// along the axis, is sharp.
struct Lens {
  double radius_m = 0;         // 0: by f_number
  double f_number = 0;         // focal length over diameter
  double sensor_height_m = 0.024;  // of the film, which gives the focal length by the field of view; 35 mm film's
  double focus_distance_m = 1;
};

struct Camera {
  std::string name;
  glm::dmat4 world_from_camera{1.0};  // looks along -Z, +Y up; a rotation and a translation, never a scale
  Projection projection = Projection::perspective;
  double yfov_rad = 0.7;   // of a perspective camera
  double ymag_m = 1.0;     // of an orthographic one: half the height of the picture
  double aspect = 0.0;     // width / height; 0: not said
  std::optional<Lens> lens{};  // of a perspective camera; none: a pinhole
};

/// Radius of the lens's opening, metres; 0 of a pinhole.
[[nodiscard]] double lens_radius_m(const Camera& camera);
/// Half the height of the picture of a perspective or orthographic camera: one metre ahead, or in
/// metres.
[[nodiscard]] double half_height_m(const Camera& camera);
/// True if both show the same picture of the same scene.
[[nodiscard]] bool same_view(const Camera& a, const Camera& b);

/// A picture of the sky, equirectangular: its middle is -Z, +Y is up and u grows towards +X.
struct EnvironmentMap {
  std::string name;  // for messages: its file
  std::uint32_t width = 0, height = 0;
  std::vector<glm::vec3> radiance;  // row-major from the top; finite, >= 0; W / (sr m^2) before `scale`
};

/// Light from infinitely far away: the same from everywhere, or a map.
struct Environment {
  glm::vec3 radiance{0.0F};                   // W / (sr m^2); without a map
  std::shared_ptr<const EnvironmentMap> map{};  // null: constant
  double scale = 1.0;                         // of the map
  double rotation_rad = 0.0;                  // about +Y: what is seen at -Z moves towards -X for positive angles
};

/// A feature of the file that eikon leaves out, named once.
struct Unsupported {
  std::string feature;  // "KHR_materials_clearcoat", "texture baseColorTexture", "specular reflection", ...
  std::string user;     // "material 'paint'", "node 'lamp'"
};

/// An animation of a file: when its first and last keys are.
struct AnimationSummary {
  std::string name;
  double begin_s = 0, end_s = 0;
  std::size_t channel_count = 0;
  bool in_force = false;       // the scene stands as it has it
  bool changes_light = false;  // it may make something shine or go dark
};

struct SkinSummary {
  std::string name;
  std::size_t joint_count = 0;
};

struct MorphSummary {
  std::string mesh;
  std::size_t mesh_index = 0;  // in the file
  std::size_t target_count = 0;
  std::vector<std::string> names;  // of the targets, where the file names them
};

/// The time in which the shutter is open, on the clock of the animations.
struct Shutter {
  double open_s = 0, close_s = 0;  // the same: nothing is blurred
  std::uint32_t steps = 0;         // of equal length, in which what moves is followed; 0: by the curvature of its way

  [[nodiscard]] bool is_open() const { return close_s > open_s; }
  bool operator==(const Shutter&) const = default;
};

class SceneMemory;  // scene_memory.h

struct Scene {
  std::filesystem::path path;
  // XXH64 of the file, the buffers it names, and the choices of SceneChoice that count: 16 hex
  // digits.
  std::string hash;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Shape> shapes;
  std::vector<formula::Formula> formulas;  // of implicit surfaces, equal ones once
  std::vector<Material> materials;  // at least one (glTF's default) when any primitive needs it
  std::vector<TextureImage> images;  // those that used materials need
  std::vector<PunctualLight> lights;
  std::vector<Camera> cameras;
  std::optional<Environment> environment;
  std::vector<std::string> light_groups{"rest"};  // names of extras.lightGroup; the first is of what names none
  std::uint32_t environment_light_group = 0;      // of whatever environment is used
  std::vector<Unsupported> unsupported;
  std::vector<std::string> variants;      // names that load_scene takes
  double time_s = 0;  // at which it stands, on the clock of its animations
  Shutter shutter{};  // with the number of steps; shut if nothing moves
  // At equal steps from the shutter's opening to its closing, made of the same triangles and
  // lights; empty: nothing moves.
  std::vector<std::shared_ptr<const Scene>> poses{};
  // The scene as it stands in the next frame, made of the same triangles; null if it was not asked
  // for, or if nothing moves until then.
  std::shared_ptr<const Scene> next{};
  bool moves_surfaces = false, moves_lights = false;  // meanwhile: some triangles, some lights without extent
  // It moves surfaces, meanwhile or until the next frame, or is a pose of a scene that does; so all
  // have one order of triangles.
  bool in_motion = false;
  std::vector<AnimationSummary> animations;  // in the order of the file; those that are damaged have no channels
  std::vector<SkinSummary> skins;
  std::vector<MorphSummary> morphs;  // the meshes with morph targets
  std::vector<std::string> out_of_range;  // those of the warnings that --strict makes errors
  std::vector<std::string> warnings;  // one line each: what was changed or dropped, and why
  std::uint64_t file_bytes = 0;       // of the file and its buffers
  CompressedMeshes compressed{};
  std::shared_ptr<SceneMemory> memory{};  // of its file
};

/// What becomes of tangents that a file leaves to its reader. To make them takes several times the
/// memory of a mesh; marked ones are 0, for those who only want to know where there are some.
enum class MissingTangents { make, mark };

/// The animations that count, and when.
struct AnimationChoice {
  std::string animation;  // a name or an index; "all" or empty: all that do not move the same things; "none"
  double time_s = 0;
  bool loop = false;  // an animation begins again after its end; else it stays there
  Shutter shutter{};
  // A pose while the shutter is open has the frame's own time here: materials, the strength of
  // lights and what is visible stay as they are then.
  std::optional<double> held_s{};
  std::optional<double> next_s{};  // when the next frame is, of which Scene::next is to be the pose
  bool operator==(const AnimationChoice&) const = default;
};

/// What of a file is asked for.
struct SceneChoice {
  // Name of one of its variants [KHR_materials_variants]; empty: materials as they are without any.
  std::string variant;
  AnimationChoice animation;
  bool operator==(const SceneChoice&) const = default;
};

/// Reads a .gltf or .glb file and everything it names, every offset, index and value checked before
/// it is used. A file with animations stands as they have it at the time of `choice`.
/// memory  of another scene of the same file; null: none is loaded
/// throws InputError: what, where (accessor, node, ...), why, what to try; UsageError never
Scene load_scene(const std::filesystem::path& path, const SceneChoice& choice = {},
                 MissingTangents missing_tangents = MissingTangents::make,
                 std::shared_ptr<SceneMemory> memory = nullptr);

struct Bounds {
  glm::dvec3 lo{1e300}, hi{-1e300};
  [[nodiscard]] bool empty() const { return !(lo.x <= hi.x); }
};

/// The first material that emits and that some node shows; nullptr if none does.
[[nodiscard]] const Material* first_emitter(const Scene& scene);

/// True if all would be black without an environment: nothing that some node shows emits, no
/// punctual light shines, and what is shown is not all unlit.
[[nodiscard]] bool needs_environment(const Scene& scene);

/// World bounds of all nodes' triangles and shapes; empty if there are none.
[[nodiscard]] Bounds world_bounds(const Scene& scene);

/// A camera in front of the scene, a little to the right and above, as model viewers have it, with
/// a 40 degree vertical field of view. What is shown touches a margin of a 25th around the picture.
[[nodiscard]] Camera frame_camera(const Scene& scene, double aspect);

/// A camera at `eye` that looks at `target`. throws UsageError when they coincide, `up` is parallel
/// to the view, or the field of view is not between 0 and pi
[[nodiscard]] Camera look_at_camera(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up,
                                    double yfov_rad);

}  // namespace eikon
