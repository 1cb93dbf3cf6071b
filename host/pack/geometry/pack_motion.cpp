// SPDX-License-Identifier: Apache-2.0
#include <cstring>

#include "core/error.h"
#include "pack/pack_parts.h"

namespace eikon {
namespace {

template <class Record>
bool same_bits(const Record& a, const Record& b) {
  return std::memcmp(&a, &b, sizeof(Record)) == 0;
}

/// The triangles of a pose, in the order of those of the frame.
PackedScene pack_pose(const Scene& pose, const Features& features, const PackedScene& packed) {
  PackedScene result;
  pack_geometry(pose, nullptr, features, result);
  if (result.triangles.size() != packed.triangle_count())
    throw InternalError("a pose has other triangles than its frame");
  return result;
}

/// Marks the triangles that differ between two poses in what kernels interpolate.
void mark_differences(const PackedScene& a, const PackedScene& b, std::vector<char>& moves) {
  const auto corners = [](const Triangle& t) { return corners_of(t); };
  for (std::size_t i = 0; i < a.triangles.size(); ++i) {
    const bool differs = corners(a.triangles[i]) != corners(b.triangles[i]) ||
                         (!a.normals.empty() && !same_bits(a.normals[i], b.normals[i])) ||
                         (!a.tangents.empty() && !same_bits(a.tangents[i], b.tangents[i]));
    if (differs) moves[i] = 1;
  }
}

}  // namespace

void pack_motion(const Scene& scene, const Features& features, PackedScene& packed) {
  const std::size_t count = packed.triangle_count(), poses = scene.poses.size();
  std::vector<char> moves(count, 0);
  const PackedScene first = pack_pose(*scene.poses.front(), features, packed);
  for (std::size_t k = 1; k < poses; ++k) mark_differences(first, pack_pose(*scene.poses[k], features, packed), moves);

  // Kernels read a record and the one behind it even if nothing moves.
  std::size_t moving = 0;
  packed.motion.assign(1 + packed.triangles.size(), 0);
  packed.motion[0] = scene.shutter.steps;
  for (std::size_t i = 0; i < count; ++i)
    if (moves[i] != 0) packed.motion[1 + i] = std::uint32_t(1 + poses * moving++);
  const std::size_t records = poses * std::max<std::size_t>(moving, 1);
  if (records >= std::size_t{1} << 32)
    throw InputError(
        fmt::format("{}: {} triangles move through {} poses, more than an index can name; use fewer "
                    "--motion-steps",
                    scene.path.string(), moving, poses));
  packed.pose_triangles.resize(records);
  packed.pose_normals.resize(first.normals.empty() ? 0 : records);
  packed.pose_tangents.resize(first.tangents.empty() ? 0 : records);
  for (std::size_t k = 0; k < poses; ++k) {
    const PackedScene pose = pack_pose(*scene.poses[k], features, packed);
    grow(packed.bounds, pose.bounds.lo);
    grow(packed.bounds, pose.bounds.hi);
    for (std::size_t i = 0; i < count; ++i) {
      if (moves[i] == 0) continue;
      const std::size_t at = packed.motion[1 + i] - 1 + k;
      Triangle& record = packed.pose_triangles[at] = pose.triangles[i];
      record.light_pdf_m2 = float(glm::length(triangle_normal(packed.triangles[i])));
      if (!pose.normals.empty()) packed.pose_normals[at] = pose.normals[i];
      if (!pose.tangents.empty()) packed.pose_tangents[at] = pose.tangents[i];
    }
  }
}

namespace {

/// The box of a triangle that moves: around all its poses, or the mean of the boxes around each.
void write_box(const PackedScene& packed, std::size_t triangle, bool mean, float* to) {
  const std::size_t poses = packed.pose_steps + 1;
  glm::vec3 lo(std::numeric_limits<float>::infinity()), hi = -lo;
  glm::dvec3 lo_sum(0), hi_sum(0);
  for (std::size_t k = 0; k < poses; ++k) {
    const auto [a, b, c] = corners_of(packed.pose_triangles[packed.motion[1 + triangle] - 1 + k]);
    const glm::vec3 least = glm::min(glm::min(a, b), c), most = glm::max(glm::max(a, b), c);
    lo = glm::min(lo, least), hi = glm::max(hi, most);
    lo_sum += glm::dvec3(least), hi_sum += glm::dvec3(most);
  }
  if (mean) lo = glm::vec3(lo_sum / double(poses)), hi = glm::vec3(hi_sum / double(poses));
  for (int axis = 0; axis < 3; ++axis) to[axis] = lo[axis], to[3 + axis] = hi[axis];
}

}  // namespace

Accel build_over_time(const PackedScene& packed, const AccelOptions& options) {
  const std::size_t count = packed.triangles.size();
  const bool is_list = options.accel == "none" || options.layout == "none";
  // Triangles of NaN are in no tree.
  std::vector<float> still(9 * count, std::numeric_limits<float>::quiet_NaN()), moving = still;
  bool some = false;
  for (std::size_t i = 0; i < count; ++i) {
    some = some || packed.motion[1 + i] != 0;
    if (packed.motion[1 + i] == 0)
      std::memcpy(&still[9 * i], &packed.triangles[i].p0_x, 9 * sizeof(float));
    else
      write_box(packed, i, !is_list, is_list ? &still[9 * i] : &moving[9 * i]);
  }
  const std::uint32_t* const moves = packed.motion.data() + 1;
  const TriangleSoup of_still(still.data(), count, 9, packed.shapes.size(), is_list ? moves : nullptr);
  Accel accel = build_accel(of_still, options);
  if (is_list) return accel;
  const TriangleSoup of_moving(moving.data(), count, 9, 0, moves);
  const TrianglePoses poses{.motion = moves,
                            .corners = &packed.pose_triangles.front().p0_x,
                            .stride = sizeof(Triangle) / sizeof(float),
                            .count = packed.pose_steps + 1U};
  Accel own = build_accel(of_moving, {.accel = "bvh",
                                      .layout = "bvh2",
                                      .threads = options.threads,
                                      .rays = options.rays,
                                      .poses = some ? &poses : nullptr});
  accel.motion_nodes = std::move(own.nodes);
  accel.motion_leaves = std::move(own.leaves);
  accel.stack_size = std::max(accel.stack_size, own.stack_size);
  return accel;
}

}  // namespace eikon
