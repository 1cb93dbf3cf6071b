// SPDX-License-Identifier: Apache-2.0
// All lanes' rays together through a tree of wide nodes: for rays that are neighbours, and for trees so small that any rays share
// most of the way. A node's boxes are first held against bounds of the whole packet, all at once, then one by one against
// the rays. The bounds need no margin, because rounding is monotone; each ray's own test is that of traverse_wide.h; so a
// ray meets every triangle that could be its hit, and the hits have the same bits.
// source [Wald, Boulos, Shirley 2007, "Ray tracing deformable scenes using dynamic bounding volume hierarchies"]
#ifndef EK_TRAVERSE_PACKET_H
#define EK_TRAVERSE_PACKET_H
#include "packet_bounds.h"

// Packets that are traced at once.
#ifndef EK_PACKETS
#define EK_PACKETS (EK_LARGE_TREE ? 8 : 1)
#endif
// So few rays of a packet are taken one by one at a block, and 1 at a node. It pays where triangles are about as small as
// pixels; so it is 0, and nobody keeps account of which rays meet what, in smaller trees.
#ifndef EK_FEW
#define EK_FEW (EK_LARGE_TREE ? 6 : 0)
#endif

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
#else
typedef global const float* PacketBlock;
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

EK_FN void packet_corner(PacketAxes axes, PacketBlock p, vf* x, vf* y, vf* z) {
  if (axes.same) {
    *x = (vf)(p[axes.x]);
    *y = (vf)(p[axes.y]);
    *z = (vf)(p[axes.z]);
  } else {
    const vf a = (vf)(p[0]), b = (vf)(p[8]), c = (vf)(p[16]);
    *x = axes.z_is_x ? b : axes.z_is_y ? c : a;
    *y = axes.z_is_x ? c : axes.z_is_y ? a : b;
    *z = axes.z_is_x ? a : axes.z_is_y ? b : c;
  }
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

// Children that wait, and which lanes meet them.
typedef struct {
  ulong entry[EK_STACK_SIZE];
#if EK_FEW
  ushort lanes[EK_STACK_SIZE];
#endif
} PacketStack;

#if EK_FEW
EK_FN RayOne packet_lane(const Packet* p, uint lane) {
  RayOne one;
#define PACKET_LANE(name) one.name = ((const float*)&p->ray.name)[lane];
  PACKET_LANE(rx) PACKET_LANE(ry) PACKET_LANE(rz) PACKET_LANE(nx) PACKET_LANE(ny) PACKET_LANE(nz) PACKET_LANE(fx) PACKET_LANE(fy)
  PACKET_LANE(fz) PACKET_LANE(p_ox) PACKET_LANE(p_oy) PACKET_LANE(p_oz) PACKET_LANE(sx) PACKET_LANE(sy) PACKET_LANE(p_rz)
  PACKET_LANE(slack)
#undef PACKET_LANE
  one.left = ((const uint*)&p->ray.ends.left)[lane];
  one.t = ((const float*)&p->hit.t)[lane];
  one.near_x = one.rx < 0.0f ? EK_NODE_WIDTH : 0u;
  one.near_y = 2u * EK_NODE_WIDTH + (one.ry < 0.0f ? EK_NODE_WIDTH : 0u);
  one.near_z = 4u * EK_NODE_WIDTH + (one.rz < 0.0f ? EK_NODE_WIDTH : 0u);
  one.axis_z = 8u * (uint)((const float*)&p->ray.axis)[lane];
  one.axis_x = one.axis_z == 16u ? 0u : one.axis_z + 8u;
#if EK_HAS_instance
  one.instance = p->instance;
#else
  one.goal = ((const uint*)&p->ray.ends.goal)[lane];
#endif
  return one;
}
#endif

// Which triangles of a block to try with all rays.
EK_FN uint packet_candidates(Geometry geometry, global const float* block, const Packet* p) {
  uint bits = 0xffu;
#if EK_FEW
  if (popcount(p->lanes) <= EK_FEW) {
    bits = 0;
    for (uint lanes = p->lanes; lanes != 0; lanes &= lanes - 1u) {
      const RayOne one = packet_lane(p, lowest_bit(lanes));
      uint sure;
      bits |= wide_candidates(geometry, block, &one, 0, &sure);
    }
  }
#endif
  return bits;
}

#if EK_HAS_shape
// Tests the shape of a place in a block, and keeps where its search was given up; u is its part.
EK_FN TriangleHit_lanes packet_shape(SceneData scene, Packet* p, global const float* at, uint id) {
  const ShapeHit met = shape_hit_one(scene, &p->ray, p->valid, p->hit.t, id, V3((vf)(at[0]), (vf)(at[8]), (vf)(at[16])),
                                     V3((vf)(at[24]), (vf)(at[32]), (vf)(at[40])));
#if EK_HAS_implicit
  const vu shape = (vu)(as_uint(((global const float*)(scene.triangles + id))[12]));
  HitLanes* hit = &p->hit;
  const vi nearer = (met.gave_up < hit->gave_up) | ((met.gave_up == hit->gave_up) & (shape < hit->gave_up_surface));
  hit->gave_up = nearer ? met.gave_up : hit->gave_up;
  hit->gave_up_surface = nearer ? shape : hit->gave_up_surface;
#endif
  const TriangleHit_lanes found = {met.hit, met.t, met.part, (vf)(0.0f)};
  return found;
}
#endif

// Keeps hits that are nearer than those so far.
EK_FN void packet_keep(Packet* p, TriangleHit_lanes found, vu triangle, vu instance, const int any_hit) {
  HitLanes* hit = &p->hit;
  if (any_hit) {
    hit->t = (found.hit & (found.t < hit->t)) ? (vf)(-1.0f) : hit->t;
    return;
  }
  const vi closer = found.hit & lanes_closer(hit, found.t, triangle, instance);
  hit->t = closer ? found.t : hit->t;
  hit->u = closer ? found.u : hit->u;
  hit->v = closer ? found.v : hit->v;
  hit->triangle = closer ? triangle : hit->triangle;
#if EK_HAS_instance
  hit->instance = closer ? instance : hit->instance;
#endif
}

// Triangle `triangle`, at `corners` in a block, for all lanes.
EK_FN PacketTriangles packet_triangle(Geometry geometry, const Packet* p, PacketBlock corners, uint triangle, const int any_hit) {
  PacketTriangles all;
  all.here = p->valid & (p->ray.ends.left != (vu)(triangle));
  if (any_hit) all.here = all.here & (p->ray.ends.goal != (vu)(triangle));
  packet_corner(p->axes, corners, &all.corners.ax, &all.corners.ay, &all.corners.az);
  packet_corner(p->axes, corners + 24, &all.corners.bx, &all.corners.by, &all.corners.bz);
  packet_corner(p->axes, corners + 48, &all.corners.cx, &all.corners.cy, &all.corners.cz);
  all.triangle = (vu)(triangle);
#if EK_HAS_instance
  all.instance = (vu)(p->instance);
#endif
#if EK_HAS_opacity
  all.passable = (vi)(may_be_passed(geometry.scene, triangle) ? -1 : 0);
#endif
  return all;
}

// Tests each ray of `here` with its triangle.
EK_FN void packet_test(Geometry geometry, Packet* p, const PacketTriangles* each, const int any_hit) {
  TriangleHit_lanes found = triangle_hit_lanes(&p->ray, each->corners);
  found.hit = found.hit & each->here;
  if (mask_bits(found.hit) == 0) return;
#if EK_HAS_opacity
  const vi ask = found.hit & (found.t <= p->hit.t) & each->passable;
  if (mask_bits(ask) != 0) {
    const vu triangle = ask ? each->triangle : (vu)(0u);  // where none has waited yet there is none
    found.hit = found.hit & !(ask & passes(geometry.scene, triangle, found.u, found.v, p->ray.key));
  }
#endif
#if EK_HAS_instance
  packet_keep(p, found, each->triangle, each->instance, any_hit);
#else
  packet_keep(p, found, each->triangle, (vu)(0u), any_hit);
#endif
}

// The triangles that wait.
EK_FN void packet_test_waiting(Geometry geometry, Packet* p, const int any_hit) {
  if (mask_bits(p->waits.here) == 0) return;
  packet_test(geometry, p, &p->waits, any_hit);
  p->waits.here = (vi)(0);
}

// Where rays share little, each may hit few of the triangles that the packet meets, and not the same ones: the exact test
// waits until a ray has a second.
EK_FN void packet_wait(Geometry geometry, Packet* p, const PacketTriangles* each, const int any_hit) {
  PacketTriangles* waits = &p->waits;
  const vi may = each->here & triangle_may_be_hit_lanes(&p->ray, each->corners, p->hit.t);
  if (mask_bits(may & waits->here) != 0) packet_test_waiting(geometry, p, any_hit);
  waits->here = waits->here | may;
#define PACKET_WAITS(name) waits->name = may ? each->name : waits->name;
  PACKET_WAITS(corners.ax) PACKET_WAITS(corners.ay) PACKET_WAITS(corners.az) PACKET_WAITS(corners.bx) PACKET_WAITS(corners.by)
  PACKET_WAITS(corners.bz) PACKET_WAITS(corners.cx) PACKET_WAITS(corners.cy) PACKET_WAITS(corners.cz) PACKET_WAITS(triangle)
#if EK_HAS_instance
  PACKET_WAITS(instance)
#endif
#if EK_HAS_opacity
  PACKET_WAITS(passable)
#endif
#undef PACKET_WAITS
}

EK_FN void packet_push(Geometry geometry, PacketStack* stack, uint base, uint* waiting, ulong entry, uint lanes) {
  // Insertion into the stack's end, nearest last.
  uint at = (*waiting)++;
  for (; at > base && stack->entry[at - 1] < entry; --at) {
    stack->entry[at] = stack->entry[at - 1];
#if EK_FEW
    stack->lanes[at] = stack->lanes[at - 1];
#endif
  }
  stack->entry[at] = entry;
#if EK_FEW
  stack->lanes[at] = (ushort)lanes;
#endif
  wide_prefetch(geometry, (uint)entry);
}

// In the world no ray meets a missing child (valid_rays); in a mesh's space its numbers are whatever the place makes of them.
#if EK_HAS_instance
#define PACKET_THERE(children) wide_there(children)
#else
#define PACKET_THERE(children) 0xffffffffu
#endif

// One node or block. apart: the rays share little (packet_wait). returns 0 when the packet is done.
EK_FN int packet_step(Geometry geometry, Packet* p, PacketStack* stack, const int any_hit, const int apart) {
  const RayLanes* ray = &p->ray;
  HitLanes* hit = &p->hit;
  const uint current = p->current;
  uint waiting = p->waiting;
#if EK_HAS_instance
  if (current == INSTANCE_EXIT) {
    packet_exit(p);
  } else if (is_instance_child(current)) {
    const uint place = current & ~INSTANCE_CHILD;
    packet_enter(geometry, p, place);
    stack->entry[waiting++] = INSTANCE_EXIT;  // where it begins is 0
    p->waiting = waiting;
    p->current = geometry.scene.instances[place].root;
    return 1;
  } else
#endif
  if (!(current & WIDE_LEAF)) {
    global const float* node = wide_node(geometry, current);
    global const uint* children = (global const uint*)node + 6u * EK_NODE_WIDTH;
    float begin[EK_NODE_WIDTH] __attribute__((aligned(64)));
    const uint base = waiting;
#if EK_FEW
    const int alone = (p->lanes & (p->lanes - 1u)) == 0;
    if (alone) {
      const RayOne one = packet_lane(p, lowest_bit(p->lanes));
      const wf begins = wide_begin(node, &one);
      *(wf*)begin = begins;
      for (uint bits = wide_bits(begins <= wide_end(node, &one)) & PACKET_THERE(children); bits != 0; bits &= bits - 1u)
        packet_push(geometry, stack, base, &waiting, wide_entry(begin, children, lowest_bit(bits)), p->lanes);
    } else
#endif
    {
      const wf begins = wide_max(wide_max(packet_begin(p->x, node), packet_begin(p->y, node)),
                                 wide_max(packet_begin(p->z, node), (wf)(0.0f)));
      const wf ends = wide_min(wide_min(packet_end(p->x, node), packet_end(p->y, node)),
                               wide_min(packet_end(p->z, node), (wf)(lanes_max(hit->t))));
      *(wf*)begin = begins;
      const vi negative_x = ray->rx < 0.0f, negative_y = ray->ry < 0.0f, negative_z = ray->rz < 0.0f;
      for (uint bits = wide_bits(begins <= ends) & PACKET_THERE(children); bits != 0; bits &= bits - 1u) {
        const uint k = lowest_bit(bits);
        global const float* plane = node + k;
        const vf lo_x = (vf)(plane[0]), hi_x = (vf)(plane[EK_NODE_WIDTH]), lo_y = (vf)(plane[2u * EK_NODE_WIDTH]),
                 hi_y = (vf)(plane[3u * EK_NODE_WIDTH]), lo_z = (vf)(plane[4u * EK_NODE_WIDTH]),
                 hi_z = (vf)(plane[5u * EK_NODE_WIDTH]);
        const vf begin_x = ((negative_x ? hi_x : lo_x) - ray->nx) * ray->rx, end_x = ((negative_x ? lo_x : hi_x) - ray->fx) * ray->rx;
        const vf begin_y = ((negative_y ? hi_y : lo_y) - ray->ny) * ray->ry, end_y = ((negative_y ? lo_y : hi_y) - ray->fy) * ray->ry;
        const vf begin_z = ((negative_z ? hi_z : lo_z) - ray->nz) * ray->rz, end_z = ((negative_z ? lo_z : hi_z) - ray->fz) * ray->rz;
        const vf first = shape_max_lanes(shape_max_lanes(begin_x, begin_y), shape_max_lanes(begin_z, (vf)(0.0f)));
        const vf last = shape_min_lanes(shape_min_lanes(end_x, end_y), shape_min_lanes(end_z, hit->t));
        const uint lanes = mask_bits(first <= last);
        if (lanes != 0) packet_push(geometry, stack, base, &waiting, wide_entry(begin, children, k), lanes);
      }
    }
  } else {
    global const float* stored = wide_block(geometry, current);
#if EK_HAS_instance
    float block[72] __attribute__((aligned(64)));
    packet_place_block(geometry, p, stored, block);
#else
    global const float* block = stored;
#endif
    for (uint bits = packet_candidates(geometry, stored, p); bits != 0; bits &= bits - 1u) {
      const uint k = lowest_bit(bits);
      const uint triangle = as_uint(stored[72 + k]);
      if (triangle == EK_NO_HIT) break;
#if EK_HAS_shape
      if (stored[48 + k] != stored[48 + k]) {
        // Behind all triangles, by its instance.
        packet_keep(p, packet_shape(geometry.scene, p, stored + k, triangle), (vu)(triangle), (vu)(EK_NO_HIT), any_hit);
        continue;
      }
#endif
      const PacketTriangles all = packet_triangle(geometry, p, block + k, triangle, any_hit);
      if (apart)
        packet_wait(geometry, p, &all, any_hit);
      else
        packet_test(geometry, p, &all, any_hit);
    }
    if (any_hit && mask_bits(hit->t >= 0.0f) == 0) return 0;
  }
  ulong next;
#if EK_FEW
  do {
    if (waiting == 0) return 0;
    next = stack->entry[--waiting];
#if EK_HAS_instance
    if ((uint)next == INSTANCE_EXIT) break;
#endif
    p->lanes = stack->lanes[waiting] & mask_bits((vf)(as_float((uint)(next >> 32))) <= hit->t);
  } while (p->lanes == 0);
#else
  do {
    if (waiting == 0) return 0;
    next = stack->entry[--waiting];
  } while (mask_bits((vf)(as_float((uint)(next >> 32))) <= hit->t) == 0);
#endif
  p->current = (uint)next;
  p->waiting = waiting;
  return 1;
}

#if EK_HAS_implicit
EK_FN void packet_report_given_up(Geometry geometry, const Packet* p) {
  for (uint bits = mask_bits(p->valid & (p->hit.gave_up < EK_INFINITY)); bits != 0; bits &= bits - 1u) {
    const uint lane = lowest_bit(bits);
    report_given_up(geometry, ((const float*)&p->hit.gave_up)[lane], ((const uint*)&p->hit.gave_up_surface)[lane],
                    ((const float*)&p->hit.t)[lane]);
  }
}
#endif

// Several at once, one step of each in turn: in a large tree the next node of a packet is fetched while the others move.
EK_FN void traverse_packets(Geometry geometry, Packet* packets, uint count, const int any_hit, const int apart) {
#if EK_LARGE_TREE
  PacketStack stacks[EK_PACKETS];
  uint open[EK_PACKETS], open_count = count;
  for (uint i = 0; i < count; ++i) open[i] = i;
  while (open_count != 0) {
    uint still = 0;
    for (uint i = 0; i < open_count; ++i) {
      const uint k = open[i];
      open[still] = k;
      still += packet_step(geometry, packets + k, stacks + k, any_hit, apart) ? 1u : 0u;
    }
    open_count = still;
  }
#else
  PacketStack stack;
  for (uint i = 0; i < count; ++i) {
    Packet packet = packets[i];
    while (packet_step(geometry, &packet, &stack, any_hit, apart)) {
    }
    if (apart) packet_test_waiting(geometry, &packet, any_hit);
    packets[i].hit = packet.hit;
  }
#endif
}

#endif
