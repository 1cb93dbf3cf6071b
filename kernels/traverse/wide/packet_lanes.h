// SPDX-License-Identifier: Apache-2.0
// All lanes' rays on their way together (traverse/wide/packet.h): what they are, and their way into the space of a mesh and back.
#ifndef EK_PACKET_H
#define EK_PACKET_H
#include "traverse/wide/packet_bounds.h"

// t in lengths of the direction; u, v: weights of corners b and c; triangle: EK_NO_HIT where nothing was hit.
typedef struct {
  vf t, u, v;
  vu triangle;
#if EK_HAS_instance
  vu instance;  // as Hit's
#endif
#if EK_HAS_implicit
  vf gave_up;
  vu gave_up_surface;
#endif
} HitLanes;

EK_FN HitLanes no_hit_lanes(vf t_max) {
  HitLanes hit;
  hit.t = t_max;
  hit.u = hit.v = (vf)(0.0f);
  hit.triangle = (vu)(EK_NO_HIT);
#if EK_HAS_instance
  hit.instance = (vu)(EK_NO_HIT);
#endif
#if EK_HAS_implicit
  hit.gave_up = EK_INFINITY;
  hit.gave_up_surface = (vu)(EK_NO_HIT);
#endif
  return hit;
}

// is_closer() of lanes.
EK_FN vi lanes_closer(const HitLanes* hit, vf t, vu triangle, vu instance) {
#if EK_HAS_instance
  const vi before = (instance < hit->instance) | ((instance == hit->instance) & (triangle < hit->triangle));
#else
  const vi before = triangle < hit->triangle;
#endif
  return (t < hit->t) | ((t == hit->t) & before);
}

// Corners of a block, or what they are at the packet's place.
#if EK_HAS_instance
typedef const float* PacketBlock;
typedef const float8* PacketRow;
#else
typedef global const float* PacketBlock;
typedef global const float8* PacketRow;
#endif

// Which axis is z of each lane's triangle test; `same` if it is one for all, with the offsets of x, y and z in a block.
typedef struct {
  vi z_is_x, z_is_y;
  int same;
  uint x, y, z;
} PacketAxes;

EK_FN PacketAxes packet_axes(const RayLanes* ray, vi valid) {
  PacketAxes a;
  a.z_is_x = ray->axis == 0.0f;
  a.z_is_y = ray->axis == 1.0f;
  const float least = lanes_min(valid ? ray->axis : (vf)(2.0f)), most = lanes_max(valid ? ray->axis : (vf)(0.0f));
  a.same = least >= most;
  a.z = 8u * (uint)least;
  a.x = a.z == 16u ? 0u : a.z + 8u;
  a.y = a.x == 16u ? 0u : a.x + 8u;
  return a;
}

// A triangle for each lane, the same or its own, in the axes of its test. here: lanes that may hit it.
typedef struct {
  vi here;
  Corners_lanes corners;
  vu triangle;
#if EK_HAS_instance
  vu instance;
#endif
#if EK_HAS_opacity
  vi passable;
#endif
} PacketTriangles;

// A packet on its way. hit.t: where each ray ends, -1 for a lane without a valid ray; an any-hit query leaves -1 where something
// was found.
typedef struct {
  RayLanes ray;
  HitLanes hit;
  PacketAxis x, y, z;
  PacketAxes axes;
  PacketTriangles waits;  // for the exact test (packet_wait)
  vi valid;
  uint waiting, current, row;
  uint lanes;  // that meet the current node or block
#if EK_HAS_instance
  uint instance;            // 0, or 1 + the place that it is at
  EntryBoxes world;         // then, what boxes in the world need
  PacketAxis world_x, world_y, world_z;
#endif
} Packet;

EK_FN void packet_begin_at_root(Packet* p) {
  const vi valid = p->valid;
  const RayLanes* ray = &p->ray;
  p->x = packet_axis(valid, ray->rx, ray->nx, ray->fx, 0u);
  p->y = packet_axis(valid, ray->ry, ray->ny, ray->fy, 2u * EK_NODE_WIDTH);
  p->z = packet_axis(valid, ray->rz, ray->nz, ray->fz, 4u * EK_NODE_WIDTH);
  p->axes = packet_axes(ray, valid);
  p->waits.here = (vi)(0);
  p->waiting = p->current = 0;
  p->lanes = mask_bits(valid);
#if EK_HAS_instance
  p->instance = 0;
#endif
}

#if EK_HAS_instance
EK_FN void packet_set_boxes(Packet* p, EntryBoxes b) {
  p->ray.rx = b.r.x; p->ray.ry = b.r.y; p->ray.rz = b.r.z;
  p->ray.nx = b.n.x; p->ray.ny = b.n.y; p->ray.nz = b.n.z;
  p->ray.fx = b.f.x; p->ray.fy = b.f.y; p->ray.fz = b.f.z;
}

EK_FN void packet_enter(Geometry geometry, Packet* p, uint place) {
  const RayLanes* ray = &p->ray;
  const EntryBoxes world = {V3(ray->rx, ray->ry, ray->rz), V3(ray->nx, ray->ny, ray->nz), V3(ray->fx, ray->fy, ray->fz)};
  p->world = world;
  p->world_x = p->x;
  p->world_y = p->y;
  p->world_z = p->z;
  packet_set_boxes(p, entry_boxes(load_entry_one(geometry.scene.instances, place), V3(ray->p_ox, ray->p_oy, ray->p_oz), ray->sx, ray->sy,
                                  V3(ray->p_rx, ray->p_ry, ray->p_rz), ray->slack, p->axes.z_is_x, p->axes.z_is_y));
  p->x = packet_axis(p->valid, ray->rx, ray->nx, ray->fx, 0u);
  p->y = packet_axis(p->valid, ray->ry, ray->ny, ray->fy, 2u * EK_NODE_WIDTH);
  p->z = packet_axis(p->valid, ray->rz, ray->nz, ray->fz, 4u * EK_NODE_WIDTH);
  p->instance = place + 1u;
}

EK_FN void packet_exit(Packet* p) {
  packet_set_boxes(p, p->world);
  p->x = p->world_x;
  p->y = p->world_y;
  p->z = p->world_z;
  p->instance = 0;
}

EK_FN void packet_place_block(Geometry geometry, const Packet* p, global const float* block, float* placed) {
  for (uint offset = 0; offset < 72u; offset += 24u) {
    const float8 x = *(global const float8*)(block + offset), y = *(global const float8*)(block + offset + 8),
                 z = *(global const float8*)(block + offset + 16);
    if (p->instance == 0u) {
      *(float8*)(placed + offset) = x;
      *(float8*)(placed + offset + 8) = y;
      *(float8*)(placed + offset + 16) = z;
      continue;
    }
    global const float* m = (global const float*)(geometry.scene.instances + (p->instance - 1u));
    *(float8*)(placed + offset) = ((m[0] * x + m[1] * y) + m[2] * z) + m[3];
    *(float8*)(placed + offset + 8) = ((m[4] * x + m[5] * y) + m[6] * z) + m[7];
    *(float8*)(placed + offset + 16) = ((m[8] * x + m[9] * y) + m[10] * z) + m[11];
  }
}
#endif

#endif
