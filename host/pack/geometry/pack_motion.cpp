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

void grow_box(float* box, const Triangle& t) {
  for (const glm::vec3& p : corners_of(t))
    for (int axis = 0; axis < 3; ++axis) {
      box[axis] = std::min(box[axis], p[axis]);
      box[3 + axis] = std::max(box[3 + axis], p[axis]);
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
  constexpr float kFar = std::numeric_limits<float>::infinity();
  packed.moving_boxes.resize(moving, {kFar, kFar, kFar, -kFar, -kFar, -kFar});
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
      grow_box(packed.moving_boxes[(at - k) / poses].data(), pose.triangles[i]);
    }
  }
}

TriangleSoup soup_over_time(const PackedScene& packed, std::vector<float>& corners) {
  const std::size_t count = packed.triangles.size();
  const std::size_t poses = packed.pose_steps + 1;
  corners.resize(9 * count);
  for (std::size_t i = 0; i < count; ++i) {
    float* const to = &corners[9 * i];
    std::memcpy(to, &packed.triangles[i].p0_x, 9 * sizeof(float));
    if (packed.motion[1 + i] == 0) continue;
    std::memcpy(to, packed.moving_boxes[(packed.motion[1 + i] - 1) / poses].data(), 6 * sizeof(float));
    std::fill(to + 6, to + 9, std::numeric_limits<float>::quiet_NaN());
  }
  return {corners.data(), count, 9, packed.shapes.size(), packed.motion.data() + 1};
}

}  // namespace eikon
