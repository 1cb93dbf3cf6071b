// SPDX-License-Identifier: Apache-2.0
// All lanes' rays together through a tree of wide nodes: for rays that are neighbours, and for trees so small that any rays share
// most of the way. A node's boxes are first held against bounds of the whole packet, all at once, then one by one against
// the rays. The bounds need no margin, because rounding is monotone; each ray's own test is that of traverse/wide/wide.h; so a
// ray meets every triangle that could be its hit, and the hits have the same bits.
// source [Wald, Boulos, Shirley 2007, "Ray tracing deformable scenes using dynamic bounding volume hierarchies"]
#ifndef EK_TRAVERSE_PACKET_H
#define EK_TRAVERSE_PACKET_H
#include "traverse/wide/packet_block.h"

// Packets that are traced at once.
#ifndef EK_PACKETS
#define EK_PACKETS (EK_LARGE_TREE ? 8 : 1)
#endif

// Children that wait; and which lanes meet them, of which account is kept only where triangles may be as small as pixels.
typedef struct {
  ulong entry[EK_STACK_SIZE];
#if EK_LARGE_TREE
  ushort lanes[EK_STACK_SIZE];
#endif
} PacketStack;

EK_FN void packet_push(Geometry geometry, PacketStack* stack, uint base, uint* waiting, ulong entry, uint lanes) {
  // Insertion into the stack's end, nearest last.
  uint at = (*waiting)++;
  for (; at > base && stack->entry[at - 1] < entry; --at) {
    stack->entry[at] = stack->entry[at - 1];
#if EK_LARGE_TREE
    stack->lanes[at] = stack->lanes[at - 1];
#endif
  }
  stack->entry[at] = entry;
#if EK_LARGE_TREE
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
  } else {
    packet_block(geometry, p, current, any_hit, apart);
    if (any_hit && mask_bits(hit->t >= 0.0f) == 0) return 0;
  }
  ulong next;
#if EK_LARGE_TREE
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
