// SPDX-License-Identifier: Apache-2.0
// Layout `cwbvh`, for GPU devices: nodes of 20 words with eight children, whose boxes are quantised
// [Ylitie, Karras, Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide
// BVHs"]. The paper also shares triangle tests among the threads of a warp; this does not, because
// votes across work-items are missing in OpenCL C 1.2.
//   words 0-3    origin and exponents of the boxes (quantised.h); highest byte of word 3: bit k,
//                child k is a node
//   word 4       index of the node of the first child that is one; the others follow
//   word 5       first entry of the node's triangles, at most 24, in `leaves`
//   words 6, 7   a byte per child, that of child 0 lowest. 0: there is none; a node: 1 << 5 | 24 +
//                its number; triangles: as many ones as it has (1 to 3) << 5 | the first's place
//                among the node's
//   words 8-19   planes lo x, lo y, lo z, hi x, hi y, hi z of children 0-3 and 4-7
// Child k is the one that rays of octant k (bit 0: x < 0, ...) are likely to meet first; in general
// children come in the order of k ^ octant. All children of a node that a ray meets are one entry
// of the stack: bits 24 + 7 - (k ^ octant), so that the highest is next, and below them one bit for
// each child that is a node.
#ifndef EK_TRAVERSE_CWBVH_H
#define EK_TRAVERSE_CWBVH_H
#include "traverse/quantised.h"

// The children, of four, that a ray meets, as bits: nodes from bit 24 on, triangles below. kinds:
// their bytes; in: those that are met
EK_FN uint cwbvh_bits(uint kinds, int4 in, uint inverse) {
  // A byte whose place is 24 or more is a node. `inverse` is repeated in each byte.
  const uint is_node = ((kinds & (kinds << 1) & 0x10101010u) >> 4) * 255u;
  const uint place = (kinds ^ (inverse & is_node)) & 0x1f1f1f1fu, ones = (kinds >> 5) & 0x07070707u;
  uint bits = in.x ? (ones & 255u) << (place & 255u) : 0u;
  bits |= in.y ? ((ones >> 8) & 255u) << ((place >> 8) & 255u) : 0u;
  bits |= in.z ? ((ones >> 16) & 255u) << ((place >> 16) & 255u) : 0u;
  return bits | (in.w ? (ones >> 24) << (place >> 24) : 0u);
}

EK_FN int traverse_cwbvh(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  uint2 stack[EK_STACK_SIZE];
  uint stack_size = 0;
  const uint octant = (ray->rcp_d.x < 0.0f ? 1u : 0u) | (ray->rcp_d.y < 0.0f ? 2u : 0u) | (ray->rcp_d.z < 0.0f ? 4u : 0u);
  const uint inverse = (7u ^ octant) * 0x01010101u;
  // The children of a node that are still to be visited: the index of the first, and bits as above.
  // At first it is the root alone.
  uint2 group = (uint2)(0u, 0x80000000u);
  for (;;) {
    const RayBoxes boxes = ray_boxes(geometry, ray);
    uint triangles = 0, first_triangle = 0;
    while (triangles == 0) {
      if (group.y <= 0x00ffffffu) {
        if (stack_size == 0) return 0;
        group = stack[--stack_size];
      }
      EK_COUNT_STEP(hit);
      const uint next = 31u - clz(group.y), child = (next & 7u) ^ (inverse & 7u);
      const uint index = group.x + popcount(group.y & ((1u << child) - 1u));
      group.y &= ~(1u << next);
      if (group.y > 0x00ffffffu) stack[stack_size++] = group;

      global const uint4* node = (global const uint4*)geometry.nodes + (size_t)index * 5;
      const uint4 frame = node[0], links = node[1], lo_xy = node[2], lo_z_hi_x = node[3], hi_yz = node[4];
      float4 end;
      const float4 limit = (float4)(hit->t);
      const float4 begin_a = quantised_boxes(frame, (uint2)(lo_xy.x, lo_z_hi_x.z), (uint2)(lo_xy.z, hi_yz.x),
                                             (uint2)(lo_z_hi_x.x, hi_yz.z), &boxes, &end);
      uint bits = cwbvh_bits(links.z, begin_a <= min_plane(end, limit), inverse);
      const float4 begin_b = quantised_boxes(frame, (uint2)(lo_xy.y, lo_z_hi_x.w), (uint2)(lo_xy.w, hi_yz.y),
                                             (uint2)(lo_z_hi_x.y, hi_yz.w), &boxes, &end);
      bits |= cwbvh_bits(links.w, begin_b <= min_plane(end, limit), inverse);
      group = (uint2)(links.x, (bits & 0xff000000u) | frame.w >> 24);
      triangles = bits & 0x00ffffffu;
      first_triangle = links.y;
    }
    for (; triangles != 0; triangles &= triangles - 1u) {
      const uint place = 31u - clz(triangles & (0u - triangles));
      if (try_triangle(geometry, ray, geometry.leaves[first_triangle + place], any_hit, hit)) return 1;
    }
  }
}

#endif
