// SPDX-License-Identifier: Apache-2.0
// Loads a scene from a glTF file, in steps whose order matters: nothing is used before it is
// checked.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>  // a tree of JSON lives and dies here
#include <new>
#include <span>

#include "core/error.h"
#include "gltf/animation/animations.h"
#include "gltf/animation/shutter_poses.h"
#include "gltf/cameras.h"
#include "gltf/document/accessor_table.h"
#include "gltf/document/document_check.h"
#include "gltf/document/names.h"
#include "gltf/document/node_graph.h"
#include "gltf/environment.h"
#include "gltf/extensions.h"
#include "gltf/geometry/implicit_surfaces.h"
#include "gltf/geometry/instances.h"
#include "gltf/geometry/meshes.h"
#include "gltf/geometry/morph.h"
#include "gltf/geometry/shapes.h"
#include "gltf/light_groups.h"
#include "gltf/lights.h"
#include "gltf/materials/materials.h"
#include "gltf/materials/variants.h"
#include "gltf/skin/skins.h"
#include "io/source_file.h"
#include "io/text.h"
#include "scene/scene_memory.h"
#include "scene/transform.h"
#include "scene/limits.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 34U;
constexpr std::size_t kNone = ~std::size_t{0};
constexpr std::size_t kMaxInstances = std::size_t{1} << 24U;
const std::vector<glm::dmat4> kOnce{glm::dmat4(1.0)};

/// The largest absolute coordinates of a mesh, per axis.
glm::dvec3 extent_of(const Mesh& mesh) {
  glm::dvec3 extent{0.0};
  for (const Primitive& primitive : mesh.primitives) {
    for (const glm::vec3& p : primitive.positions_object) extent = glm::max(extent, glm::abs(glm::dvec3(p)));
  }
  return extent;
}

/// Checks that a mesh whose vertices lie within `extent` stands within kMaxCoordinate. The bound of
/// the whole mesh is nearly always enough; if it is not, each vertex is checked.
void check_instance(const glm::dmat4& m, const Mesh& mesh, const glm::dvec3& extent, const std::string& label) {
  if (!is_finite(m)) throw InputError(label + ": the transforms of its instances overflow");
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
                        label, i, "xyz"[axis], p[axis]));
      }
    }
  }
}

/// The checked sources of a scene, and what is learnt while it is read.
struct SceneSource {
  const Document& document;
  WrongParts& wrong;  // the document's
  const AccessorTable& accessors;
  const BufferViews& views;
  std::filesystem::path folder;  // files outside it are refused
  Digest& digest;
  Notes& notes;
  MissingTangents missing_tangents;
};

/// The meshes of the document that the scene uses. One that morphs differently under two nodes is
/// two meshes.
struct UsedMeshes {
  std::vector<std::size_t> of_node;  // as the placed nodes; an index into Scene::meshes, or kNone
  std::vector<glm::dvec3> extents;   // as Scene::meshes
};

void note_document_features(const Document& document, Notes& notes) {
  // Lights and shapes are read where a node places one, variants where one is asked for.
  note_unsupported_extensions(document.json, ExtensionOwner::document, "the document", notes);
  if (document.scene)
    note_unsupported_extensions(document.scene->value, ExtensionOwner::scene, document.scene->label(), notes);
}

void note_node_features(const Document& document, const GltfNode& node, Notes& notes) {
  note_unsupported_extensions(node.view.value, ExtensionOwner::node, node.view.label(), notes);
  if (node.skin) document.wrong.check("skin", *node.skin);
  note_unused_skin(document, node, notes);
  if (node.matrix.empty()) return;
  for (const char* key : {"translation", "rotation", "scale"})
    if (member(node.view.value, key) != nullptr)
      return notes.warn(node.view.label() +
                        ": has a matrix besides translation, rotation or scale; only the matrix counts");
}

/// The scene's environment counts before the document's.
void find_environment(const SceneSource& source, Scene& scene) {
  const Document& document = source.document;
  if (document.scene) {
    scene.environment = read_environment(*document.scene, source.folder, source.digest, source.notes);
    scene.environment_light_group = light_group_of(*document.scene, scene);
  }
  if (!scene.environment)
    scene.environment =
        read_environment({.value = document.json, .kind = "document"}, source.folder, source.digest, source.notes);
}

/// Reads the meshes that the scene uses, in the order of their first nodes.
UsedMeshes read_meshes(const SceneSource& source, const std::vector<PlacedNode>& placed_nodes, SkinReader& skins,
                       MaterialReader& materials, Scene& scene) {
  UsedMeshes used{.of_node = {}, .extents = {}};
  std::vector<MeshReader::Wanted> order;
  std::map<MeshReader::Wanted, std::size_t> index_of;
  for (const PlacedNode& placed : placed_nodes) {
    used.of_node.push_back(kNone);
    if (!placed.node.mesh || !placed.visible) continue;
    const std::size_t mesh = *placed.node.mesh;
    source.document.wrong.check("mesh", mesh);
    MeshReader::Wanted wanted{.mesh = mesh,
                              .weights = morph_weights(placed.node, source.document.meshes[mesh], source.notes),
                              .skin = skin_of(source.document, placed.node)};
    const auto [known, is_new] = index_of.try_emplace(wanted, order.size());
    used.of_node.back() = known->second;
    if (is_new) order.push_back(std::move(wanted));
  }
  MeshReader reader({.document = source.document,
                     .accessors = source.accessors,
                     .views = source.views,
                     .materials = scene.materials,
                     .reader = materials,
                     .skins = skins,
                     .notes = source.notes,
                     .missing_tangents = source.missing_tangents,
                     // Other files have one pose.
                     .memory = scene.animations.empty() ? nullptr : scene.memory.get()});
  reader.check_memory(order);
  for (const MeshReader::Wanted& wanted : order) {
    scene.meshes.push_back(reader.read(wanted));
    used.extents.push_back(extent_of(scene.meshes.back()));
  }
  scene.compressed = reader.compressed();
  return used;
}

void read_shapes(const SceneSource& source, const std::vector<PlacedNode>& placed_nodes, MaterialReader& materials,
                 Scene& scene) {
  ImplicitSurfaceReader implicit(source.document.json, materials, scene, source.notes);
  for (const PlacedNode& placed : placed_nodes) {
    if (!placed.visible) continue;
    const std::size_t before = scene.shapes.size();
    implicit.add(placed);
    add_shape(source.document.json, placed, materials, scene, source.notes);
    for (std::size_t i = before; i < scene.shapes.size(); ++i)
      scene.shapes[i].light_group = light_group_of(placed.node.view, scene);
  }
}

/// The transforms, world from object, of the instances of a node's mesh. With a skin it has one,
/// whatever the node says.
std::vector<glm::dmat4> instances_of(const SceneSource& source, const PlacedNode& placed) {
  if (skin_of(source.document, placed.node)) {
    if (has_instances(placed.node.view))
      source.notes.warn(placed.node.view.label() + ": its instances are left out, as its mesh has a skin");
    return {glm::dmat4(1.0)};
  }
  std::vector<glm::dmat4> instances = read_instances(placed.node.view, source.accessors).value_or(kOnce);
  for (glm::dmat4& instance : instances) instance = placed.world_from_object * instance;
  return instances;
}

/// Adds the camera, the light and the mesh that a node has. `mesh`: its index in Scene::meshes, or
/// kNone. Of a node that is not visible only the camera remains.
void place_node(const SceneSource& source, const PlacedNode& placed, std::size_t mesh, const glm::dvec3& extent,
                Scene& scene) {
  const GltfNode& node = placed.node;
  if (node.camera) {
    source.document.wrong.check("camera", *node.camera);
    add_camera(source.document.json, placed, scene, source.notes);
  }
  if (!placed.visible) return;
  note_node_features(source.document, node, source.notes);
  add_light(source.document.json, placed, scene, source.notes);
  const std::uint32_t light_group = node.mesh ? light_group_of(node.view, scene) : 0;
  if (mesh == kNone) {
    if (has_instances(node.view)) source.notes.warn(node.view.label() + ": its instances are of no mesh; left out");
    return;
  }
  const std::vector<glm::dmat4> instances = instances_of(source, placed);
  if (instances.size() > scene.nodes.size()) scene.nodes.reserve(scene.nodes.size() + instances.size());
  for (const glm::dmat4& world_from_object : instances) {
    if (scene.nodes.size() == kMaxInstances)
      node.view.refuse(fmt::format("more than {} meshes are placed; use fewer instances", kMaxInstances));
    check_instance(world_from_object, scene.meshes[mesh], extent, node.view.label());
    scene.nodes.push_back({.name = node.shown_name(),
                           .world_from_object = world_from_object,
                           .mesh = static_cast<std::uint32_t>(mesh),
                           .light_group = light_group,
                           .mirrored = glm::determinant(glm::dmat3(world_from_object)) < 0});
  }
}

void fill_scene(const SceneSource& source, Scene& scene) {
  const std::vector<PlacedNode> placed_nodes = walk_nodes(source.document, source.notes);
  note_document_features(source.document, source.notes);
  find_environment(source, scene);
  TextureReader textures({.document = source.document.json,
                          .views = source.views,
                          .folder = source.folder,
                          .budget_bytes = texture_budget_bytes(),
                          .wrong = &source.document.wrong},
                         scene, source.digest, source.notes);
  MeasuredReader measured(source.folder, source.digest, source.notes);
  MaterialReader materials(source.document, source.wrong, textures, measured, scene, source.notes);
  SkinReader skins(source.document, source.accessors, placed_nodes, source.notes);
  const UsedMeshes meshes = read_meshes(source, placed_nodes, skins, materials, scene);
  read_shapes(source, placed_nodes, materials, scene);
  textures.decode();
  for (std::size_t i = 0; i < placed_nodes.size(); ++i) {
    const std::size_t mesh = meshes.of_node[i];
    place_node(source, placed_nodes[i], mesh, mesh == kNone ? glm::dvec3(0.0) : meshes.extents[mesh], scene);
  }
  source.document.wrong.note(source.notes);
}

Scene load(const std::filesystem::path& path, const SceneChoice& choice, MissingTangents missing_tangents,
           std::shared_ptr<SceneMemory> memory) {
  Scene scene;
  scene.path = path;
  scene.time_s = choice.animation.time_s;
  scene.memory = memory != nullptr ? std::move(memory) : std::make_shared<SceneMemory>();
  Notes notes;
  Bytes file = read_regular_file(path, kMaxFileBytes);
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const Container container = open_container(file.span(), extension == ".glb");

  Json json = parse_json(container.json);
  make_names_printable(json);
  Digest digest;
  digest.add(file.span());
  if (!container.has_binary) file = Bytes();  // nothing looks at the text again
  WrongParts wrong;
  check_document(json, wrong);
  const Buffers buffers(json, container, path.parent_path());
  const BufferViews views(json, buffers, wrong, notes);
  const AccessorTable accessors(json, views, wrong);
  const std::string pose =
      animate({.document = json, .accessors = accessors, .wrong = wrong, .notes = notes}, choice.animation, scene);
  Document document = read_structure(json, wrong);
  scene.variants = variants_of(json);
  scene.skins = list_skins(json);
  scene.morphs = list_morphs(document);
  if (!choice.variant.empty()) choose_variant(document, choice.variant);
  for (const Bytes& bytes : buffers.files()) digest.add(bytes.span());
  fill_scene({.document = document,
              .wrong = wrong,
              .accessors = accessors,
              .views = views,
              .folder = path.parent_path(),
              .digest = digest,
              .notes = notes,
              .missing_tangents = missing_tangents},
             scene);
  // Another variant or pose is another scene, whose parts are not to be merged with this one's.
  scene.file_bytes = digest.bytes;
  for (const std::string& chosen : {choice.variant, pose})
    if (!chosen.empty()) digest.add(std::as_bytes(std::span(chosen)));
  scene.hash = fmt::format("{:016x}", digest.hash);
  notes.finish(scene);
  return scene;
}

}  // namespace

Scene load_scene(const std::filesystem::path& path, const SceneChoice& choice, MissingTangents missing_tangents,
                 std::shared_ptr<SceneMemory> memory) {
  const std::string what = "cannot load scene " + in_quotes(path.string()) + ": ";
  try {
    Scene scene = load(path, choice, missing_tangents, std::move(memory));
    SceneChoice within = choice;
    within.animation.shutter = {};
    within.animation.held_s = choice.animation.time_s;
    const auto pose_at = [&](double time_s) {
      within.animation.time_s = time_s;
      return load(path, within, missing_tangents, scene.memory);
    };
    add_shutter_poses(scene, choice.animation.shutter, pose_at);
    const std::optional<double> next_s = choice.animation.next_s;
    if (next_s && std::ranges::any_of(scene.animations, &AnimationSummary::in_force)) {
      Scene next = pose_at(*next_s);
      Digest both;
      for (const std::string& of : {scene.hash, next.hash}) both.add(std::as_bytes(std::span(of)));
      scene.hash = fmt::format("{:016x}", both.hash);
      add_next_pose(scene, std::move(next));
    }
    return scene;
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
