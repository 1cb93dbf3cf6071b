// SPDX-License-Identifier: Apache-2.0
#include "gltf/animation/shutter_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "scene/transform.h"

namespace eikon {
namespace {

// A straight way between two poses may be off by so much:
constexpr double kMeshShare = 1e-3;      // of the diagonal of a mesh's box, for its vertices
constexpr double kWayShare = 1e-2;       // of the way of a camera or lamp within the step
constexpr double kDirection = 2e-4;      // of the unit vectors of a camera: a fifth of a pixel of 720 rows
constexpr double kZoom = 5e-4;           // of the height of the picture, for that height: also a fifth of a pixel
constexpr double kLampDirection = 2e-3;  // of the axis of a lamp
constexpr double kNormal = 5e-3;         // of the shading normals of a mesh
constexpr double kRounding = 1e-9;       // of coordinates, for what does not move but by rounding

constexpr std::uint32_t kMinProbes = 4;
// Probes lie off the middle of a step, so that a motion that swings to and fro is not taken for
// rest.
constexpr double kProbeShare = 0.381966;
constexpr std::size_t kMaxVertices = 512;  // of a primitive that keeps its form, which are looked at

double over(double distance, double allowed) {
  if (distance <= 0) return 0;
  return allowed > 0 ? distance / allowed : std::numeric_limits<double>::infinity();
}

const Primitive& primitive_of(const Scene& scene, std::size_t node, std::size_t primitive) {
  return scene.meshes[scene.nodes[node].mesh].primitives[primitive];
}

/// Returns a function of a number that gives the vertex of a primitive, in the world.
auto vertices_of(const Scene& scene, std::size_t node, std::size_t primitive) {
  return [&world_from_object = scene.nodes[node].world_from_object,
          &positions = primitive_of(scene, node, primitive).positions_object](std::size_t i) {
    return transform_point(world_from_object, positions[i]);
  };
}

/// Returns a function of a number that gives the shading normal of a vertex of a primitive, in the
/// world; of length 1, or 0 where it has none.
auto normals_of(const Scene& scene, std::size_t node, std::size_t primitive) {
  return [world_from_normal = cofactors(glm::dmat3(scene.nodes[node].world_from_object)),
          &normals = primitive_of(scene, node, primitive).normals_object](std::size_t i) {
    return direction_of(world_from_normal * glm::dvec3(normals[i]));
  };
}

/// Returns how far the normals of a primitive are from the way between the two poses, in units of
/// kNormal.
double normal_deviation(const MidPose& step, std::size_t node, std::size_t primitive, std::size_t stride) {
  const auto count = [&](const Scene& scene) { return primitive_of(scene, node, primitive).normals_object.size(); };
  if (count(step.before) != count(step.after) || count(step.before) != count(step.true_pose)) return 0;
  const auto before = normals_of(step.before, node, primitive), after = normals_of(step.after, node, primitive),
             at = normals_of(step.true_pose, node, primitive);
  double off = 0;
  for (std::size_t i = 0; i < count(step.before); i += stride)
    off = std::max(off, glm::length(at(i) - direction_of(glm::mix(before(i), after(i), step.share))));
  return off / kNormal;
}

double node_deviation(const MidPose& step, std::size_t node) {
  const auto same_place = [&](const Scene& other) {
    return step.before.nodes[node].world_from_object == other.nodes[node].world_from_object;
  };
  const auto same_form = [&](const Scene& other, std::size_t p) {
    const Primitive &own = primitive_of(step.before, node, p), &others = primitive_of(other, node, p);
    return own.positions_object == others.positions_object && own.normals_object == others.normals_object;
  };
  const bool stands = same_place(step.after) && same_place(step.true_pose);
  double off = 0, most = 0;
  Bounds bounds;
  const Mesh& mesh = step.before.meshes[step.before.nodes[node].mesh];
  for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
    const bool is_rigid = same_form(step.after, p) && same_form(step.true_pose, p);
    if (stands && is_rigid) continue;
    // A part of a mesh that changes its form may move alone.
    const std::size_t count = mesh.primitives[p].positions_object.size(),
                      stride = is_rigid ? count / kMaxVertices + 1 : 1;
    most = std::max(most, normal_deviation(step, node, p, stride));
    const auto before = vertices_of(step.before, node, p), after = vertices_of(step.after, node, p),
               at = vertices_of(step.true_pose, node, p);
    for (std::size_t i = 0; i < count; i += stride) {
      const glm::dvec3 a = before(i), b = after(i), way = at(i) - glm::mix(a, b, step.share);
      bounds.lo = glm::min(bounds.lo, a), bounds.hi = glm::max(bounds.hi, a);
      off = std::max(off, glm::length(way) - kRounding * glm::length(a));
    }
  }
  return bounds.empty() ? most : std::max(most, over(off, kMeshShare * glm::length(bounds.hi - bounds.lo)));
}

double way_deviation(const glm::dvec3& before, const glm::dvec3& after, const glm::dvec3& at, double share) {
  const double off = glm::length(at - glm::mix(before, after, share)) - kRounding * glm::length(at);
  return over(off, kWayShare * glm::length(after - before));
}

double camera_deviation(const Camera& before, const Camera& after, const Camera& at, double share) {
  double most = way_deviation(glm::dvec3(before.world_from_camera[3]), glm::dvec3(after.world_from_camera[3]),
                              glm::dvec3(at.world_from_camera[3]), share);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 a(before.world_from_camera[axis]), b(after.world_from_camera[axis]);
    most = std::max(most, glm::length(glm::dvec3(at.world_from_camera[axis]) - glm::mix(a, b, share)) / kDirection);
  }
  const auto off = [&](const auto& value) {
    return std::abs(value(at) - std::lerp(value(before), value(after), share));
  };
  most = std::max(most, over(off(half_height_m), kZoom * half_height_m(at)));
  if (!before.lens || !after.lens || !at.lens) return most;
  // The blur of a point on the plane one metre ahead is the radius times the difference of two
  // inverse distances.
  const auto inverse_focus = [](const Camera& camera) { return 1 / camera.lens->focus_distance_m; };
  return std::max(
      {most, lens_radius_m(at) * off(inverse_focus) / kDirection, off(lens_radius_m) * inverse_focus(at) / kDirection});
}

/// The reason why poses cannot be compared triangle by triangle; empty if they can.
std::string difference_of(const Scene& a, const Scene& b) {
  if (a.nodes.size() != b.nodes.size()) return "the number of meshes that it shows";
  if (a.lights.size() != b.lights.size()) return "the number of its lights";
  if (a.cameras.size() != b.cameras.size()) return "the number of its cameras";
  for (std::size_t n = 0; n < a.nodes.size(); ++n) {
    const auto &p = a.meshes[a.nodes[n].mesh].primitives, &q = b.meshes[b.nodes[n].mesh].primitives;
    if (p.size() != q.size()) return fmt::format("the mesh of node '{}'", a.nodes[n].name);
    for (std::size_t i = 0; i < p.size(); ++i)
      if (p[i].indices.triangle_count() != q[i].indices.triangle_count() ||
          p[i].positions_object.size() != q[i].positions_object.size())
        return fmt::format("the mesh of node '{}'", a.nodes[n].name);
  }
  return {};
}

bool node_differs(const Scene& a, const Scene& b, std::size_t node) {
  if (a.nodes[node].world_from_object != b.nodes[node].world_from_object) return true;
  const auto &p = a.meshes[a.nodes[node].mesh].primitives, &q = b.meshes[b.nodes[node].mesh].primitives;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!(p[i].positions_object == q[i].positions_object) || !(p[i].normals_object == q[i].normals_object)) return true;
  return false;
}

bool lights_differ(const Scene& a, const Scene& b) {
  const auto same = [](const PunctualLight& x, const PunctualLight& y) {
    return x.position == y.position && x.direction == y.direction;
  };
  return !std::ranges::equal(a.lights, b.lights, same);
}

bool cameras_differ(const Scene& a, const Scene& b) { return !std::ranges::equal(a.cameras, b.cameras, same_view); }

/// Names the shapes of a scene that stand elsewhere in some of the poses; empty if none do.
/// poses  pointers to scenes
template <class Poses>
std::string moving_shapes(const Scene& scene, const Poses& poses) {
  std::string named;
  std::size_t count = 0;
  for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
    const Shape& shape = scene.shapes[i];
    const auto moves = [&](const auto& pose) {
      return i < pose->shapes.size() && pose->shapes[i].world_from_object != shape.world_from_object;
    };
    if (std::ranges::any_of(poses, moves) && count++ == 0) named = fmt::format("shape '{}'", shape.name);
  }
  return count > 1 ? named + fmt::format(" and {} more", count - 1) : named;
}

template <class T>
void share_if_equal(SharedVector<T>& own, const SharedVector<T>& other) {
  if (own == other) own = other;
}

/// Gives the triangles of a primitive of a pose the order of corners that they have in the frame:
/// the reader turns a triangle that its joints mirror, and a pose would have another triangle then.
/// The normals of its corners are turned back with it, so that they lie on the side that the order
/// says. (Where a vertex belongs to turned and other triangles that is right for one kind alone.)
/// returns true if there was such a triangle
bool take_order(Primitive& own, const Primitive& other) {
  if (own.indices.triangle_count() != other.indices.triangle_count() || own.indices == other.indices) return false;
  std::vector<bool> is_turned(own.normals_object.size());
  for (std::size_t t = 0; t < own.indices.triangle_count(); ++t)
    if (const std::array<std::uint32_t, 3> corners = own.indices.triangle(t); corners != other.indices.triangle(t))
      for (const std::uint32_t corner : corners)
        if (corner < is_turned.size()) is_turned[corner] = true;
  std::vector<glm::vec3> normals(own.normals_object.begin(), own.normals_object.end());
  for (std::size_t i = 0; i < normals.size(); ++i)
    if (is_turned[i]) normals[i] = -normals[i];
  own.normals_object = std::move(normals);
  own.indices = other.indices;
  return true;
}

/// True if it is to be seen which side of the material's surfaces is the front.
bool has_sides(const Material& material) {
  return !material.double_sided || material.solid || material.normal_texture || material.clearcoat_normal_texture;
}

/// Makes a pose of a scene that was loaded at another time. What does not change is in memory once.
/// returns the name of a node whose fronts and backs change places meanwhile; empty if there is
/// none
std::string make_pose(Scene& pose, const Scene& scene) {
  std::vector<bool> turns(pose.meshes.size());
  const auto note = [&](std::size_t mesh, std::size_t primitive) {
    const std::uint32_t material = scene.meshes[mesh].primitives[primitive].material;
    if (has_sides(scene.materials[material])) turns[mesh] = true;
  };
  for (std::size_t m = 0; m < std::min(pose.meshes.size(), scene.meshes.size()); ++m)
    for (std::size_t i = 0; i < std::min(pose.meshes[m].primitives.size(), scene.meshes[m].primitives.size()); ++i) {
      Primitive& own = pose.meshes[m].primitives[i];
      const Primitive& other = scene.meshes[m].primitives[i];
      if (take_order(own, other)) note(m, i);
      share_if_equal(own.positions_object, other.positions_object);
      share_if_equal(own.normals_object, other.normals_object);
      share_if_equal(own.tangents_object, other.tangents_object);
      share_if_equal(own.colors, other.colors);
      for (std::size_t set = 0; set < std::size(own.uv); ++set) share_if_equal(own.uv[set], other.uv[set]);
    }
  std::string turned;
  for (std::size_t n = 0; n < std::min(pose.nodes.size(), scene.nodes.size()); ++n) {
    Node& own = pose.nodes[n];
    const Node& other = scene.nodes[n];
    if (own.mirrored != other.mirrored && own.mesh < scene.meshes.size())
      for (std::size_t i = 0; i < scene.meshes[own.mesh].primitives.size(); ++i) note(own.mesh, i);
    if (turned.empty() && turns[own.mesh]) turned = own.name;
    own.mirrored = other.mirrored;
  }
  pose.in_motion = true;
  return turned;
}

/// The poses of a file by the share of the shutter's time that has passed, each loaded once.
class Poses {
 public:
  Poses(const Scene& scene, const Shutter& shutter, const PoseLoader& load)
      : scene_(scene), shutter_(shutter), load_(load) {}

  std::shared_ptr<const Scene> at(double share) {
    std::shared_ptr<const Scene>& pose = known_[share];
    if (pose != nullptr) return pose;
    Scene scene = load_(shutter_.open_s + (shutter_.close_s - shutter_.open_s) * share);
    if (trouble_.empty()) trouble_ = difference_of(scene_, scene);
    const std::string turned = make_pose(scene, scene_);
    if (turned_.empty()) turned_ = turned;
    pose = std::make_shared<const Scene>(std::move(scene));
    return pose;
  }
  /// Set once a pose is not made of the same triangles.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  /// A node that turns inside out in one of the poses; empty if there is none.
  [[nodiscard]] const std::string& turned() const { return turned_; }

  /// The largest deviation of any step, 0 where poses cannot be compared.
  double deviation_of(std::uint32_t steps) {
    double most = 0;
    const std::uint32_t probes = std::max(steps, kMinProbes);
    for (std::uint32_t i = 0; i < probes && trouble_.empty(); ++i) {
      const double time = (i + kProbeShare) / probes * steps;
      const double begin = std::floor(time);
      const auto before = at(begin / steps), after = at((begin + 1) / steps),
                 true_pose = at((i + kProbeShare) / probes);
      if (trouble_.empty()) most = std::max(most, deviation({*before, *after, *true_pose, time - begin}));
    }
    return most;
  }

 private:
  const Scene& scene_;
  const Shutter& shutter_;
  const PoseLoader& load_;
  std::map<double, std::shared_ptr<const Scene>> known_;
  std::string trouble_, turned_;
};

}  // namespace

double deviation(const MidPose& step) {
  double most = 0;
  const auto &before = step.before, &after = step.after, &at = step.true_pose;
  for (std::size_t n = 0; n < before.nodes.size(); ++n) most = std::max(most, node_deviation(step, n));
  for (std::size_t i = 0; i < before.lights.size(); ++i) {
    const PunctualLight &a = before.lights[i], &b = after.lights[i], &mid = at.lights[i];
    most = std::max({most, way_deviation(a.position, b.position, mid.position, step.share),
                     glm::length(mid.direction - glm::mix(a.direction, b.direction, step.share)) / kLampDirection});
  }
  for (std::size_t i = 0; i < before.cameras.size(); ++i)
    most = std::max(most, camera_deviation(before.cameras[i], after.cameras[i], at.cameras[i], step.share));
  return most;
}

void add_shutter_poses(Scene& scene, const Shutter& shutter, const PoseLoader& pose_at) {
  if (!shutter.is_open() || std::ranges::none_of(scene.animations, &AnimationSummary::in_force)) return;
  Poses poses(scene, shutter, pose_at);
  std::uint32_t steps = std::max(shutter.steps, 1U);
  double off = shutter.steps == 0 ? poses.deviation_of(steps) : 0;
  while (off > 1 && steps < kMaxShutterSteps) off = poses.deviation_of(steps *= 2);
  std::vector<std::shared_ptr<const Scene>> found;
  for (std::uint32_t i = 0; i <= steps; ++i) found.push_back(poses.at(double(i) / steps));
  if (!poses.trouble().empty()) {
    scene.warnings.push_back(
        fmt::format("--shutter: nothing is blurred, as {} changes while the shutter is open", poses.trouble()));
    return;
  }
  if (!poses.turned().empty())
    scene.warnings.push_back(
        fmt::format("--shutter: node '{}' turns inside out while the shutter is open: its front stays "
                    "the side that it is at the time of the frame",
                    poses.turned()));
  const auto some = [&](bool (*differ)(const Scene&, const Scene&)) {
    return std::any_of(found.begin(), found.end(), [&](const auto& pose) { return differ(*found.front(), *pose); });
  };
  if (const std::string shapes = moving_shapes(scene, found); !shapes.empty())
    scene.warnings.push_back(
        fmt::format("--shutter: {}: not blurred, shapes stand where they are at the time of the frame", shapes));
  for (std::size_t n = 0; n < scene.nodes.size(); ++n)
    scene.nodes[n].moves = std::any_of(found.begin(), found.end(),
                                       [&](const auto& pose) { return node_differs(*found.front(), *pose, n); });
  scene.moves_surfaces = scene.in_motion = std::ranges::any_of(scene.nodes, &Node::moves);
  scene.moves_lights = some(lights_differ);
  if (!scene.moves_surfaces && !scene.moves_lights && !some(cameras_differ)) return;
  scene.poses = std::move(found);
  scene.shutter = shutter;
  scene.shutter.steps = steps;
  if (off > 1)
    scene.warnings.push_back(fmt::format(
        "--motion-steps auto: {} steps leave what moves {:.2g} times as far from its way as they should; use a "
        "shorter --shutter, or more with --motion-steps N",
        steps, off));
}

void add_next_pose(Scene& scene, Scene next) {
  if (const std::string trouble = difference_of(scene, next); !trouble.empty()) {
    scene.warnings.push_back(
        fmt::format("layer motion: nothing moves in it, as {} changes until the next frame", trouble));
    return;
  }
  if (const std::string shapes = moving_shapes(scene, std::array{&next}); !shapes.empty())
    scene.warnings.push_back(
        fmt::format("layer motion: {}: only the way of the camera is in it, shapes stand still for the layer", shapes));
  (void)make_pose(next, scene);
  bool surfaces = false;
  for (std::size_t n = 0; n < scene.nodes.size() && !surfaces; ++n) surfaces = node_differs(scene, next, n);
  next.in_motion = surfaces || scene.in_motion;
  scene.in_motion = next.in_motion;
  if (surfaces || cameras_differ(scene, next)) scene.next = std::make_shared<const Scene>(std::move(next));
}

}  // namespace eikon
