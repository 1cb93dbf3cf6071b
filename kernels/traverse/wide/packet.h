// SPDX-License-Identifier: Apache-2.0
// Traversal of the wide trees by packets: all lanes' rays go together. It is for rays that are
// neighbours, and for trees so small that any rays share most of the way. A node's boxes are first
// tested against bounds of the whole packet, all boxes at once, and then one by one against the
// rays. The bounds need no margin, because rounding is monotone, and each ray's own test is that of
// wide.h. So a ray meets every triangle that could be its hit, and the hits have the same bits.
// source [Wald, Boulos, Shirley 2007, "Ray tracing deformable scenes using dynamic bounding volume
// hierarchies"]
#ifndef EK_TRAVERSE_PACKET_H
#define EK_TRAVERSE_PACKET_H
#include "traverse/wide/packet_leaf8.h"

// The number of packets that are traced at once.
#ifndef EK_PACKETS
#define EK_PACKETS (EK_LARGE_TREE ? 8 : 1)
#endif

// Children still to be visited, and the lanes that meet them. Lanes are noted only in large trees,
// whose triangles may be as small as pixels.
typedef struct {
  ulong entry[EK_STACK_SIZE];
#if EK_LARGE_TREE
  ushort lanes[EK_STACK_SIZE];
#endif
} PacketStack;

EK_FN void packet_push(Geometry geometry, PacketStack* stack, uint base, uint* stack_size, ulong entry, uint lanes) {
  // This sorts the new entries at the end of the stack by insertion, the nearest last.
  uint at = (*stack_size)++;
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

// The children that are there, as bits. In the world no ray meets a missing child (valid_rays); in
// the space of an instance's mesh a ray's numbers are whatever the instance makes of them.
EK_FN uint packet_there(global const uint* children) { return EK_HAS_instance ? wide_there(children) : 0xffffffffu; }

// Visits one node or leaf; returns 0 when the packet is done. apart: 1 if the rays share little
// (packet_wait)
EK_FN int packet_step(Geometry geometry, Packet* p, PacketStack* stack, const int any_hit, const int apart) {
  const RayLanes* ray = &p->ray;
  HitLanes* hit = &p->hit;
  const uint current = p->current;
  uint stack_size = p->stack_size;
  if (EK_HAS_instance && current == INSTANCE_EXIT) {
    packet_exit(p);
  } else if (EK_HAS_instance && is_instance_child(current)) {
    const uint instance = current & ~INSTANCE_CHILD;
    packet_enter(geometry, p, instance);
    stack->entry[stack_size++] = INSTANCE_EXIT;  // as an entry it begins at 0, so it is never culled
    p->stack_size = stack_size;
    p->current = geometry.scene.instances[instance].root;
    return 1;
  } else if (!(current & WIDE_LEAF)) {
    global const float* node = wide_node(geometry, current);
    global const uint* children = (global const uint*)node + 6u * EK_NODE_WIDTH;
    float begin[EK_NODE_WIDTH] __attribute__((aligned(64)));
    const uint base = stack_size;
    const wf begins = wide_max(wide_max(packet_begin(p->x, node), packet_begin(p->y, node)),
                               wide_max(packet_begin(p->z, node), (wf)(0.0f)));
    const wf ends = wide_min(wide_min(packet_end(p->x, node), packet_end(p->y, node)),
                             wide_min(packet_end(p->z, node), (wf)(lanes_max(hit->t))));
    *(wf*)begin = begins;
    const vi negative_x = ray->rcp_d.x < 0.0f, negative_y = ray->rcp_d.y < 0.0f, negative_z = ray->rcp_d.z < 0.0f;
    for (uint bits = wide_bits(begins <= ends) & packet_there(children); bits != 0; bits &= bits - 1u) {
      const uint k = lowest_bit(bits);
      global const float* plane = node + k;
      const vf lo_x = (vf)(plane[0]), hi_x = (vf)(plane[EK_NODE_WIDTH]), lo_y = (vf)(plane[2u * EK_NODE_WIDTH]),
               hi_y = (vf)(plane[3u * EK_NODE_WIDTH]), lo_z = (vf)(plane[4u * EK_NODE_WIDTH]),
               hi_z = (vf)(plane[5u * EK_NODE_WIDTH]);
      const vf begin_x = ((negative_x ? hi_x : lo_x) - ray->o_near.x) * ray->rcp_d.x, end_x = ((negative_x ? lo_x : hi_x) - ray->o_far.x) * ray->rcp_d.x;
      const vf begin_y = ((negative_y ? hi_y : lo_y) - ray->o_near.y) * ray->rcp_d.y, end_y = ((negative_y ? lo_y : hi_y) - ray->o_far.y) * ray->rcp_d.y;
      const vf begin_z = ((negative_z ? hi_z : lo_z) - ray->o_near.z) * ray->rcp_d.z, end_z = ((negative_z ? lo_z : hi_z) - ray->o_far.z) * ray->rcp_d.z;
      const vf first = shape_max_lanes(shape_max_lanes(begin_x, begin_y), shape_max_lanes(begin_z, (vf)(0.0f)));
      const vf last = shape_min_lanes(shape_min_lanes(end_x, end_y), shape_min_lanes(end_z, hit->t));
      const uint lanes = mask_bits(first <= last);
      if (lanes != 0) packet_push(geometry, stack, base, &stack_size, wide_entry(begin, children, k), lanes);
    }
  } else {
    packet_leaf8(geometry, p, current, any_hit, apart);
    if (any_hit && mask_bits(hit->t >= 0.0f) == 0) return 0;
  }
  ulong next;
#if EK_LARGE_TREE
  do {
    if (stack_size == 0) return 0;
    next = stack->entry[--stack_size];
    if (EK_HAS_instance && (uint)next == INSTANCE_EXIT) break;
    p->lanes = stack->lanes[stack_size] & mask_bits((vf)(as_float((uint)(next >> 32))) <= hit->t);
  } while (p->lanes == 0);
#else
  do {
    if (stack_size == 0) return 0;
    next = stack->entry[--stack_size];
  } while (mask_bits((vf)(as_float((uint)(next >> 32))) <= hit->t) == 0);
#endif
  p->current = (uint)next;
  p->stack_size = stack_size;
  return 1;
}

EK_FN void packet_report_given_up(Geometry geometry, const Packet* p) {
  for (uint bits = mask_bits(p->valid & (p->hit.gave_up < EK_INFINITY)); bits != 0; bits &= bits - 1u) {
    const uint lane = lowest_bit(bits);
    report_given_up(geometry, ((const float*)&p->hit.gave_up)[lane], ((const uint*)&p->hit.gave_up_surface)[lane],
                    ((const float*)&p->hit.t)[lane]);
  }
}

// Traces several packets. In a large tree they take one step each in turn, so that the next node of
// one is fetched while the others move.
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
