// SPDX-License-Identifier: Apache-2.0
#include <tbb/parallel_for.h>

#include <bit>
#include <cstring>

#include "accel/binary_tree.h"
#include "accel/box.h"
#include "core/error.h"
#include "core/host_limits.h"
#include "pack/geometry/instanced_meshes.h"
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
  tbb::parallel_for(std::size_t{0}, a.triangles.size(), [&](std::size_t i) {
    const bool differs = corners_of(a.triangles[i]) != corners_of(b.triangles[i]) ||
                         (!a.normals.empty() && !same_bits(a.normals[i], b.normals[i])) ||
                         (!a.tangents.empty() && !same_bits(a.tangents[i], b.tangents[i]));
    if (differs) moves[i] = 1;
  });
}

/// Writes the records of pose k of the triangles that move. first_records: of each triangle, 0 if
/// it stands still
void write_pose(const PackedScene& pose, std::size_t k, std::span<const std::uint32_t> first_records,
                PackedScene& packed) {
  grow(packed.bounds, pose.bounds.lo);
  grow(packed.bounds, pose.bounds.hi);
  tbb::parallel_for(std::size_t{0}, pose.triangles.size(), [&](std::size_t i) {
    if (first_records[i] == 0) return;
    const std::size_t at = first_records[i] - 1 + k;
    Triangle& record = packed.pose_triangles[at] = packed.triangles[i];
    std::memcpy(&record.p0_x, &pose.triangles[i].p0_x, 9 * sizeof(float));
    record.n_x = float(glm::length(triangle_normal(packed.triangles[i])));
    if (!pose.normals.empty()) packed.pose_normals[at] = pose.normals[i];
    if (!pose.tangents.empty()) packed.pose_tangents[at] = pose.tangents[i];
  });
}

}  // namespace

DeviceVector<std::uint32_t> motion_table(std::uint32_t steps, std::span<const std::uint32_t> records) {
  constexpr std::size_t kHead = 2;
  const std::size_t begin = kHead + (records.size() + 31) / 32;
  DeviceVector<std::uint32_t> table(begin + records.size(), 0);
  table[0] = steps;
  table[1] = std::uint32_t(begin);
  for (std::size_t i = 0; i < records.size(); ++i) {
    table[begin + i] = records[i];
    if (records[i] != 0) table[kHead + i / 32] |= 1U << i % 32;
  }
  return table;
}

std::uint64_t pose_bytes(const Scene& scene, const Features& features) {
  std::uint64_t triangles = 0;
  for (const Node& node : scene.nodes)
    for (const Primitive& primitive : scene.meshes[node.mesh].primitives)
      triangles += node.moves ? primitive.indices.triangle_count() : 0;
  return triangles * scene.poses.size() * triangle_bytes(features);
}

void pack_motion(const Scene& scene, const Features& features, PackedScene& packed) {
  if (const std::uint64_t bytes = pose_bytes(scene, features), memory = host_limits().memory_bytes;
      memory != 0 && bytes > memory)
    throw InputError(
        fmt::format("{}: what moves while the shutter is open needs {} MB of {} MB in {} poses; use fewer "
                    "--motion-steps",
                    scene.path.string(), bytes >> 20, memory >> 20, scene.poses.size()));
  const std::size_t count = packed.triangle_count(), poses = scene.poses.size();
  std::vector<char> moves(count, 0);
  // Two poses at a time are in memory: the others are packed again when their records are written.
  const PackedScene first = pack_pose(*scene.poses.front(), features, packed);
  PackedScene current;
  for (std::size_t k = 1; k < poses; ++k) {
    current = PackedScene();
    current = pack_pose(*scene.poses[k], features, packed);
    mark_differences(first, current, moves);
  }

  // Kernels read a record and the one behind it even if nothing moves.
  std::size_t moving = 0;
  std::vector<std::uint32_t> first_records(packed.triangles.size(), 0);
  for (std::size_t i = 0; i < count; ++i)
    if (moves[i] != 0) first_records[i] = std::uint32_t(1 + poses * moving++);
  const std::size_t records = poses * std::max<std::size_t>(moving, 1);
  if (records >= std::size_t{1} << 32)
    throw InputError(
        fmt::format("{}: {} triangles move through {} poses, more than an index can name; use fewer "
                    "--motion-steps",
                    scene.path.string(), moving, poses));
  packed.motion = motion_table(scene.shutter.steps, first_records);
  packed.pose_triangles.resize(records);
  packed.pose_normals.resize(first.normals.empty() ? 0 : records);
  packed.pose_tangents.resize(first.tangents.empty() ? 0 : records);
  write_pose(first, 0, first_records, packed);
  for (std::size_t k = poses - 1; k > 0; --k) {
    if (k + 1 < poses) current = pack_pose(*scene.poses[k], features, packed);
    write_pose(current, k, first_records, packed);
    current = PackedScene();
  }
}

void pack_next_corners(const Scene& scene, const Features& features, PackedScene& packed) {
  constexpr std::size_t kCorners = 9;
  packed.next_corners.assign(std::max<std::size_t>(packed.triangles.size(), 1), 0);
  if (scene.next == nullptr || !scene.in_motion) return;
  const PackedScene next = pack_pose(*scene.next, features, packed);
  for (std::size_t i = 0; i < next.triangles.size(); ++i) {
    if (corners_of(next.triangles[i]) == corners_of(packed.triangles[i])) continue;
    const std::size_t place = packed.next_corners.size();
    if (place + kCorners > ~std::uint32_t{0})
      throw InputError(fmt::format("{}: more triangles move than layer motion can name; leave it out of --aov",
                                   scene.path.string()));
    packed.next_corners[i] = std::uint32_t(place);
    packed.next_corners.resize(place + kCorners);
    std::memcpy(&packed.next_corners[place], &next.triangles[i].p0_x, kCorners * sizeof(float));
  }
}

namespace {

/// The box of a triangle that moves: around all its poses, or the mean of the boxes around each.
Box box_over_time(const PackedScene& packed, std::size_t triangle, bool mean) {
  const std::size_t poses = packed.pose_steps + 1;
  Box around;
  glm::dvec3 lo_sum(0), hi_sum(0);
  for (std::size_t k = 0; k < poses; ++k) {
    const Box box = triangle_box(&packed.pose_triangles[packed.first_records()[triangle] - 1 + k].p0_x);
    around.add(box);
    for (int axis = 0; axis < 3; ++axis) lo_sum[axis] += double{box.lo[axis]}, hi_sum[axis] += double{box.hi[axis]};
  }
  for (int axis = 0; axis < 3 && mean; ++axis) {
    around.lo[axis] = float(lo_sum[axis] / double(poses));
    around.hi[axis] = float(hi_sum[axis] / double(poses));
  }
  return around;
}

/// Writes a box in place of a triangle (TriangleSoup).
void write_box(const Box& box, float* to) {
  for (int axis = 0; axis < 3; ++axis) to[axis] = box.lo[axis], to[3 + axis] = box.hi[axis];
}

/// The words in front of the tree of triangles that move (kernels/traverse/motion_tree.h).
void write_head(const Box& around, bool some_stand_still, DeviceVector<std::uint32_t>& to) {
  to.assign(EK_MOTION_HEAD_WORDS, 0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    to[axis] = std::bit_cast<std::uint32_t>(float{around.lo[axis]});
    to[3 + axis] = std::bit_cast<std::uint32_t>(float{around.hi[axis]});
  }
  to[6] = some_stand_still ? 1 : 0;
}

}  // namespace

Accel build_over_time(const PackedScene& packed, const AccelOptions& options) {
  const std::size_t count = packed.triangles.size();
  const bool is_list = options.accel == "none" || options.layout == "none";
  // Triangles of NaN are in no tree.
  std::vector<float> still(9 * count, std::numeric_limits<float>::quiet_NaN()), moving = still;
  Box around;
  bool some_move = false, some_stand_still = !packed.shapes.empty();
  for (std::size_t i = 0; i < count; ++i) {
    if (packed.first_records()[i] == 0) {
      std::memcpy(&still[9 * i], &packed.triangles[i].p0_x, 9 * sizeof(float));
      some_stand_still = true;
    } else {
      write_box(box_over_time(packed, i, !is_list), is_list ? &still[9 * i] : &moving[9 * i]);
      around.add(box_over_time(packed, i, false));
      some_move = true;
    }
  }
  const std::uint32_t* const moves = packed.first_records();
  const TriangleSoup of_still(still.data(), count, 9, packed.shapes.size(), is_list ? moves : nullptr);
  Accel accel = build_accel(of_still, options);
  if (is_list) return accel;
  const TriangleSoup of_moving(moving.data(), count, 9, 0, moves);
  const TrianglePoses poses{.motion = moves,
                            .corners = &packed.pose_triangles.front().p0_x,
                            .stride = sizeof(Triangle) / sizeof(float),
                            .count = packed.pose_steps + 1U};
  const Accel own = build_accel(of_moving, {.accel = "bvh",
                                            .layout = is_wide(accel.layout) ? accel.layout : "bvh2",
                                            .threads = options.threads,
                                            .rays = options.rays,
                                            .poses = some_move || is_wide(accel.layout) ? &poses : nullptr});
  write_head(around, some_stand_still, accel.motion_nodes);
  accel.motion_nodes.insert(accel.motion_nodes.end(), own.nodes.begin(), own.nodes.end());
  accel.motion_leaves = own.leaves;
  accel.stack_size = std::max(accel.stack_size, own.stack_size);
  return accel;
}

}  // namespace eikon
