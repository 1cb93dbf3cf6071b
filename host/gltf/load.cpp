// SPDX-License-Identifier: Apache-2.0
// load_scene: the one path from a file to a Scene. Order matters: nothing is used before it is checked.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <span>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "gltf/document/accessor_table.h"
#include "gltf/cameras.h"
#include "gltf/document/document.h"
#include "gltf/document/document_check.h"
#include "scene/environment.h"
#include "gltf/geometry/instances.h"
#include "gltf/light_groups.h"
#include "gltf/lights.h"
#include "gltf/materials/material_measured.h"
#include "gltf/materials/materials.h"
#include "gltf/geometry/implicit_surfaces.h"
#include "gltf/geometry/meshes.h"
#include "gltf/document/node_graph.h"
#include "scene/scene.h"
#include "gltf/geometry/shapes.h"
#include "io/source_file.h"
#include "io/text.h"
#include "gltf/materials/textures.h"
#include "scene/transform.h"
#include "gltf/materials/variants.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 34U;
constexpr std::size_t kUnread = ~std::size_t{0};
constexpr std::size_t kMaxPlacedMeshes = std::size_t{1} << 24U;
const std::vector<glm::dmat4> kOnce{glm::dmat4(1.0)};
// What nodes may have and all is read of.
constexpr std::string_view kNodeExtensions[] = {"KHR_lights_punctual", "EXT_mesh_gpu_instancing", kShapeExtension,
                                                kImplicitExtension};

/// The largest absolute coordinates of a mesh, per axis.
glm::dvec3 extent_of(const Mesh& mesh) {
  glm::dvec3 extent{0.0};
  for (const Primitive& primitive : mesh.primitives) {
    for (const glm::vec3& p : primitive.positions_object) extent = glm::max(extent, glm::abs(glm::dvec3(p)));
  }
  return extent;
}

// World positions are what is rendered. The bound of a whole mesh is nearly always enough; else each vertex is asked.
void check_world_positions(const Mesh& mesh, const glm::dvec3& extent, const glm::dmat4& m,
                           const std::string& node_name) {
  bool safe = true;
  for (int row = 0; row < 3; ++row) {
    safe = safe && std::abs(m[0][row]) * extent.x + std::abs(m[1][row]) * extent.y + std::abs(m[2][row]) * extent.z +
                           std::abs(m[3][row]) <=
                       kMaxCoordinate;
  }
  if (safe) return;
  for (const Primitive& primitive : mesh.primitives) {
    for (std::size_t i = 0; i < primitive.positions_object.size(); ++i) {
      const glm::dvec4 p = m * glm::dvec4(primitive.positions_object[i], 1.0);
      for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(p[axis]) <= kMaxCoordinate) continue;
        throw InputError(
            fmt::format("{}: vertex {} of its mesh lands at {} = {:g}, beyond 2^40 m, the largest "
                        "coordinate; scale the scene down",
                        node_name, i, "xyz"[axis], p[axis]));
      }
    }
  }
}

void place_mesh(const glm::dmat4& world_from_object, std::uint32_t mesh, const glm::dvec3& extent,
                const std::string& name, const std::string& label, Scene& scene) {
  if (scene.nodes.size() == kMaxPlacedMeshes)
    throw InputError(fmt::format("{}: more than {} meshes are placed; use fewer instances", label, kMaxPlacedMeshes));
  if (!is_finite(world_from_object)) throw InputError(label + ": the transforms of its instances overflow");
  check_world_positions(scene.meshes[mesh], extent, world_from_object, label);
  scene.nodes.push_back({.name = name,
                         .world_from_object = world_from_object,
                         .mesh = mesh,
                         .mirrored = glm::determinant(glm::dmat3(world_from_object)) < 0});
}

void note_document_features(const Json& document, const Json* scene_json, std::size_t scene_index, Notes& notes) {
  if (const Json* extensions = member(document, "extensions")) {
    for (const auto& entry : extensions->items()) {
      // Lights and shapes are read where a node places one, variants where one is asked for.
      if (entry.key() != "KHR_lights_punctual" && entry.key() != kShapeListExtension &&
          entry.key() != kVariantsExtension)
        notes.unsupported(one_line(entry.key()), "the document");
    }
  }
  if (scene_json != nullptr) {
    const Place scene{.value = *scene_json, .kind = "scene", .index = static_cast<std::int64_t>(scene_index)};
    if (const Json* extensions = member(*scene_json, "extensions")) {
      for (const auto& entry : extensions->items()) notes.unsupported(one_line(entry.key()), scene.label());
    }
  }
  const Json& animations = items(document, "animations");
  for (std::size_t i = 0; i < animations.size(); ++i) {
    notes.unsupported(
        "animation", Place{.value = animations[i], .kind = "animation", .index = static_cast<std::int64_t>(i)}.label());
  }
}

void note_node_features(const tinygltf::Model& model, const Json& document, std::size_t node, Notes& notes) {
  const Json& json = document["nodes"][node];
  if (const Json* extensions = member(json, "extensions")) {
    for (const auto& entry : extensions->items()) {
      if (std::find(std::begin(kNodeExtensions), std::end(kNodeExtensions), entry.key()) == std::end(kNodeExtensions))
        notes.unsupported(one_line(entry.key()), node_label(model, node));
    }
  }
  if (model.nodes[node].skin >= 0) notes.unsupported("skin", node_label(model, node));
  if (!model.nodes[node].matrix.empty() && (member(json, "translation") != nullptr ||
                                            member(json, "rotation") != nullptr || member(json, "scale") != nullptr)) {
    notes.warn(node_label(model, node) +
               ": has a matrix besides translation, rotation or scale; only the matrix counts");
  }
}

// Materials keep the document's numbers; glTF's default is appended when a primitive needs it: white, metallic and rough
// [glTF 2.0, section 3.9].
class MaterialList {
 public:
  MaterialList(const Json& document, TextureReader& textures, MeasuredReader& measured, Scene& scene, Notes& notes)
      : document_(document), textures_(textures), measured_(measured), scene_(scene), notes_(notes) {
    const std::size_t count = items(document, "materials").size();
    used_.resize(count, false);
    for (std::size_t i = 0; i < count; ++i) {
      scene_.materials.push_back(convert_material(document, i, notes));
      scene_.materials.back().light_group = light_group_of(place_of(i), scene_);
    }
  }

  std::uint32_t use(int index) {
    if (index < 0) {
      if (scene_.materials.size() == used_.size()) scene_.materials.emplace_back().name = "default";
      return static_cast<std::uint32_t>(used_.size());
    }
    const auto material = static_cast<std::size_t>(index);
    if (!used_[material]) {
      complete_material(document_, material, textures_, scene_.materials[material], notes_);
      measured_.complete(place_of(material), scene_.materials[material]);
    }
    used_[material] = true;
    return static_cast<std::uint32_t>(index);
  }

 private:
  [[nodiscard]] Place place_of(std::size_t index) const {
    return {.value = document_["materials"][index], .kind = "material", .index = static_cast<std::int64_t>(index)};
  }

  const Json& document_;
  TextureReader& textures_;
  MeasuredReader& measured_;
  Scene& scene_;
  Notes& notes_;
  std::vector<bool> used_;
};

void fill_scene(const tinygltf::Model& model, const Json& document, const std::vector<Accessor>& accessors,
                const BufferViews& views, Digest& digest, Scene& scene, Notes& notes) {
  const std::filesystem::path folder = scene.path.parent_path();
  const std::vector<PlacedNode> placed_nodes = walk_nodes(model, notes);
  const std::size_t scene_index = model.defaultScene >= 0 ? static_cast<std::size_t>(model.defaultScene) : 0;
  const Json& scenes = items(document, "scenes");
  const Json* scene_json = scenes.empty() ? nullptr : &scenes[scene_index];
  note_document_features(document, scene_json, scene_index, notes);
  if (scene_json != nullptr) {
    const Place place{.value = *scene_json, .kind = "scene", .index = static_cast<std::int64_t>(scene_index)};
    scene.environment = read_environment(place, folder, digest, notes);
    scene.environment_light_group = light_group_of(place, scene);
  }
  if (!scene.environment)
    scene.environment = read_environment({.value = document, .kind = "document"}, folder, digest, notes);

  // Only the meshes that the scene uses are read.
  std::vector<std::size_t> mesh_order, new_index(model.meshes.size(), kUnread);
  for (const PlacedNode& placed : placed_nodes) {
    const int mesh = model.nodes[placed.node].mesh;
    if (mesh < 0 || new_index[static_cast<std::size_t>(mesh)] != kUnread) continue;
    new_index[static_cast<std::size_t>(mesh)] = mesh_order.size();
    mesh_order.push_back(static_cast<std::size_t>(mesh));
  }
  TextureReader textures(
      {.document = document, .views = views, .folder = folder, .budget_bytes = texture_budget_bytes()}, scene, digest,
      notes);
  MeasuredReader measured(folder, digest, notes);
  MaterialList materials(document, textures, measured, scene, notes);
  MeshReader reader(
      model, document, accessors, views, scene.materials, [&](int index) { return materials.use(index); }, notes);
  reader.check_memory(mesh_order);
  std::vector<glm::dvec3> extents;
  for (const std::size_t mesh : mesh_order) {
    scene.meshes.push_back(reader.read(mesh));
    extents.push_back(extent_of(scene.meshes.back()));
  }
  ImplicitSurfaceReader implicit(
      document, [&](int index) { return materials.use(index); }, scene, notes);
  for (const PlacedNode& placed : placed_nodes) {
    const Json& node = document["nodes"][placed.node];
    const Place place{.value = node, .kind = "node", .index = static_cast<std::int64_t>(placed.node)};
    const std::size_t before = scene.shapes.size();
    if (ImplicitSurfaceReader::has(node)) implicit.add(place, model.nodes[placed.node].name, placed.world_from_object);
    if (has_shape(node))
      add_shape(
          document, place, model.nodes[placed.node].name, placed.world_from_object,
          [&](int index) { return materials.use(index); }, scene, notes);
    for (std::size_t i = before; i < scene.shapes.size(); ++i)
      scene.shapes[i].light_group = light_group_of(place, scene);
  }
  textures.decode();

  for (const PlacedNode& placed : placed_nodes) {
    const tinygltf::Node& source = model.nodes[placed.node];
    note_node_features(model, document, placed.node, notes);
    if (source.camera >= 0)
      add_camera(
          document, static_cast<std::size_t>(source.camera), placed.world_from_object,
          {.value = document["nodes"][placed.node], .kind = "node", .index = static_cast<std::int64_t>(placed.node)},
          source.name, scene, notes);
    const Place place{
        .value = document["nodes"][placed.node], .kind = "node", .index = static_cast<std::int64_t>(placed.node)};
    if (const std::int64_t light = light_of_node(place.value); light >= 0)
      add_light(document, static_cast<std::size_t>(light), place, source.name, placed.world_from_object, scene, notes);
    const std::uint32_t light_group = source.mesh >= 0 ? light_group_of(place, scene) : 0;
    const std::optional<std::vector<glm::dmat4>> instances = read_instances(place, accessors);
    if (source.mesh < 0) {
      if (instances) notes.warn(place.label() + ": its instances are of no mesh; left out");
      continue;
    }
    const auto mesh = static_cast<std::uint32_t>(new_index[static_cast<std::size_t>(source.mesh)]);
    for (const glm::dmat4& instance : instances.value_or(kOnce)) {
      place_mesh(placed.world_from_object * instance, mesh, extents[mesh], source.name, place.label(), scene);
      scene.nodes.back().light_group = light_group;
    }
  }
}

Scene load(const std::filesystem::path& path, const std::string& variant) {
  Scene scene;
  scene.path = path;
  Notes notes;
  const Bytes file = read_regular_file(path, kMaxFileBytes);
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const Container container = open_container(file.span(), extension == ".glb");

  Json document = parse_json(container.json);
  check_document(document);
  scene.variants = variants_of(document);
  if (!variant.empty()) choose_variant(document, variant);
  const Buffers buffers(document, container, path.parent_path());
  const BufferViews views(document, buffers);
  const std::vector<Accessor> accessors = check_accessors(document, views);
  const tinygltf::Model model = parse_structure(document);
  Digest digest;
  digest.add(file.span());
  for (const Bytes& bytes : buffers.files()) digest.add(bytes.span());
  fill_scene(model, document, accessors, views, digest, scene, notes);
  // Another variant is another scene, whose parts are not to be merged with this one's.
  scene.file_bytes = digest.bytes;
  if (!variant.empty()) digest.add(std::as_bytes(std::span(variant)));
  scene.hash = fmt::format("{:016x}", digest.hash);
  notes.finish(scene);
  return scene;
}

}  // namespace

Scene load_scene(const std::filesystem::path& path, const std::string& variant) {
  const std::string what = "cannot load scene " + in_quotes(path.string()) + ": ";
  try {
    return load(path, variant);
  } catch (const InputError& e) {
    throw InputError(what + e.what());
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw InputError(what + "it needs more memory than there is; split the scene");
  } catch (const std::exception& e) {
    throw InputError(what + one_line(e.what()) + "; export the file again");
  }
}

}  // namespace eikon
