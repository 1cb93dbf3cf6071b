// SPDX-License-Identifier: Apache-2.0
// A packet of rays (packet.h), and its way into the space of an instance's mesh and back.
#ifndef EK_PACKET_H
#define EK_PACKET_H
#include "traverse/wide/packet_bounds.h"

// The corners of a leaf, in the world. With instances they are a copy that was moved there.
#if EK_HAS_instance
typedef const float* PacketCorners;
typedef const float8* PacketRow;
#else
typedef global const float* PacketCorners;
typedef global const float8* PacketRow;
#endif

// The axis that is z of each lane's triangle test. If it is the same for all lanes, `same` is 1,
// and x, y, z are the offsets of the axes in a leaf.
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

// A triangle for each lane, the same for all or its own, in the axes of its test. here: the lanes
// that may hit it
typedef struct {
  vi here;
  Corners_lanes corners;
  vu triangle;
  vu instance;
  vi alpha_tested;  // read only with EK_HAS_opacity
} PacketTriangles;

// A packet on its way. hit.t says where each ray ends. It is -1 for a lane without a valid ray, and
// where an any-hit query has found something.
typedef struct {
  RayLanes ray;
  HitLanes hit;
  PacketAxis x, y, z;
  PacketAxes axes;
  PacketTriangles waits;  // triangles that wait for the whole test (packet_wait)
  vi valid;
  uint stack_size, current, row;
  uint lanes;  // the lanes that meet the current node or leaf, as bits
  uint instance;     // 0, or 1 + the instance that it is in; read only with EK_HAS_instance, as is the rest
  EntryBoxes world;  // there, what boxes in the world need
  PacketAxis world_x, world_y, world_z;
} Packet;

EK_FN void packet_bounds(Packet* p) {
  const RayLanes* ray = &p->ray;
  p->x = packet_axis(p->valid, ray->rcp_d.x, ray->o_near.x, ray->o_far.x, 0u);
  p->y = packet_axis(p->valid, ray->rcp_d.y, ray->o_near.y, ray->o_far.y, 2u * EK_NODE_WIDTH);
  p->z = packet_axis(p->valid, ray->rcp_d.z, ray->o_near.z, ray->o_far.z, 4u * EK_NODE_WIDTH);
}

EK_FN void packet_begin_at_root(Packet* p) {
  packet_bounds(p);
  p->axes = packet_axes(&p->ray, p->valid);
  p->waits.here = (vi)(0);
  p->stack_size = p->current = 0;
  p->lanes = mask_bits(p->valid);
  p->instance = 0;
}

EK_FN void packet_set_boxes(Packet* p, EntryBoxes b) {
  p->ray.rcp_d = b.rcp_d;
  p->ray.o_near = b.o_near;
  p->ray.o_far = b.o_far;
}

EK_FN void packet_enter(Geometry geometry, Packet* p, uint instance) {
  const RayLanes* ray = &p->ray;
  const EntryBoxes world = {ray->rcp_d, ray->o_near, ray->o_far};
  p->world = world;
  p->world_x = p->x;
  p->world_y = p->y;
  p->world_z = p->z;
  const RayEntry entry = {.p_o = ray->p_o,
                          .sx = ray->sx,
                          .sy = ray->sy,
                          .p_rcp_d = ray->p_rcp_d,
                          .t_slack = ray->t_slack,
                          .z_is_x = p->axes.z_is_x,
                          .z_is_y = p->axes.z_is_y};
  packet_set_boxes(p, entry_boxes(load_entry_one(geometry.scene.instances, instance), entry));
  packet_bounds(p);
  p->instance = instance + 1u;
}

EK_FN void packet_exit(Packet* p) {
  packet_set_boxes(p, p->world);
  p->x = p->world_x;
  p->y = p->world_y;
  p->z = p->world_z;
  p->instance = 0;
}

// Moves the corners of a leaf to the world.
EK_FN void packet_world_corners(Geometry geometry, const Packet* p, global const float* stored, float* world) {
  for (uint offset = 0; offset < 72u; offset += 24u) {
    const float8 x = *(global const float8*)(stored + offset), y = *(global const float8*)(stored + offset + 8),
                 z = *(global const float8*)(stored + offset + 16);
    if (p->instance == 0u) {
      *(float8*)(world + offset) = x;
      *(float8*)(world + offset + 8) = y;
      *(float8*)(world + offset + 16) = z;
      continue;
    }
    global const float* m = (global const float*)(geometry.scene.instances + (p->instance - 1u));
    *(float8*)(world + offset) = ((m[0] * x + m[1] * y) + m[2] * z) + m[3];
    *(float8*)(world + offset + 8) = ((m[4] * x + m[5] * y) + m[6] * z) + m[7];
    *(float8*)(world + offset + 16) = ((m[8] * x + m[9] * y) + m[10] * z) + m[11];
  }
}

#endif
