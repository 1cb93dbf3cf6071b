// SPDX-License-Identifier: Apache-2.0
// Layout `kdtree`: space parted by planes across one axis each. After the header, nodes of two words:
//   inner  plane; axis | index of the child above it << 2 (the one below comes next)
//   leaf   first entry of its triangles in `leaves`; 3 | their number << 2
// Front to back with a stack [Hapala, Havran 2011, "Review: kd-tree traversal algorithms for ray tracing", algorithm TA-B rec].
#ifndef EK_TRAVERSE_KDTREE_H
#define EK_TRAVERSE_KDTREE_H

EK_FN int traverse_cells(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  global const uint* nodes = geometry.nodes + CELLS_HEADER;
  const CellRay c = cell_ray(geometry, ray, hit);
  uint node[EK_STACK_SIZE];
  float begins[EK_STACK_SIZE], ends[EK_STACK_SIZE];
  uint waiting = 0, current = 0;
  float begin = c.begin, end = c.end;
  if (!(begin <= end)) return 0;
  for (;;) {
    const uint data = nodes[2 * (size_t)current], word = nodes[2 * (size_t)current + 1], axis = word & 3u;
    EK_COUNT_STEP(hit);
    if (axis < 3u) {
      const float plane = as_float(data), r = c.r[axis];
      const float first_end = shape_min_one(end, (plane - c.f[axis]) * r);
      const float second_begin = shape_max_one(begin, (plane - c.n[axis]) * r);
      const uint below = current + 1u, above = word >> 2;
      const uint first = r < 0.0f ? above : below, second = r < 0.0f ? below : above;
      const int in_first = begin <= first_end, in_second = second_begin <= end;
      if (in_first) {
        if (in_second) {
          node[waiting] = second;
          begins[waiting] = second_begin;
          ends[waiting++] = end;
        }
        current = first;
        end = first_end;
        continue;
      }
      if (in_second) {
        current = second;
        begin = second_begin;
        continue;
      }
    } else if (try_list(geometry, ray, data, word >> 2, any_hit, hit)) {
      return 1;
    }
    do {
      if (waiting == 0) return 0;
      begin = begins[--waiting];
    } while (is_behind(&c, hit, begin));
    current = node[waiting];
    end = ends[waiting];
  }
}

#endif
