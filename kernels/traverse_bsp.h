// SPDX-License-Identifier: Apache-2.0
// Layout `bsp`: space parted by planes of any direction. Words of the header from 7: a point c amid the scene. After the header, nodes of
// 6 words:
//   words 0-2, 3  n, d: the plane n (x - c) = d; |n| is 1 but for rounding
//   words 4, 5    children behind it (n (x - c) < d) and in front: an inner node's index; or bit 31 | where its leaf lies in `leaves`:
//                 the number of its triangles, then those
// Oblique planes have no rounding that is monotone, so a margin stands for item 1 of traverse_cells.h: what may be hit at t has a point
// x of the triangle's list within 40 u E + 4 u |o| of P on each axis, and x is in a cell that lists it. So the distance of P behind the
// plane, if x is in front of it, is at most 70 u E + 7 u |o|; what is computed of it here errs by 16 u E at the origin, 18 u E along
// the ray by the direction's shear, and the quotient by 14 u E. The margin is 128 u E + 8 u |o|. Traversed as kdtree
// [Ize, Wald, Parker 2008, "Ray tracing with the BSP tree"].
#ifndef EK_TRAVERSE_BSP_H
#define EK_TRAVERSE_BSP_H

EK_FN int traverse_cells(Geometry geometry, const RayOne* ray, const int any_hit, Hit* hit) {
  global const float* center = (global const float*)geometry.nodes + 7;
  const CellRay c = cell_ray(geometry, ray, hit);
  // In world axes: the origin from c; the direction of a depth of 1.
  const uint z = ray->axis_z / 8u, x = ray->axis_x / 8u, y = 3u - z - x;
  float o[3], d[3];
  o[x] = ray->p_ox; o[y] = ray->p_oy; o[z] = ray->p_oz;
  d[x] = ray->sx; d[y] = ray->sy; d[z] = 1.0f;
  const float o_max = shape_max_one(shape_max_one(shape_abs_one(o[0]), shape_abs_one(o[1])), shape_abs_one(o[2]));
  const float margin = ray->reach * 0x1p-17f + o_max * 0x1p-21f;
  const float ox = o[0] - center[0], oy = o[1] - center[1], oz = o[2] - center[2];

  uint node[EK_STACK_SIZE];
  float begins[EK_STACK_SIZE], ends[EK_STACK_SIZE];
  uint waiting = 0, current = 0;
  float begin = c.begin, end = c.end;
  if (!(begin <= end)) return 0;
  for (;;) {
    EK_COUNT_STEP(hit);
    if (!(current & 0x80000000u)) {
      global const uint* p = geometry.nodes + CELLS_HEADER + (size_t)current * 6;
      const float nx = as_float(p[0]), ny = as_float(p[1]), nz = as_float(p[2]);
      const float a = ((nx * ox + ny * oy) + nz * oz) - as_float(p[3]);
      float b = (nx * d[0] + ny * d[1]) + nz * d[2];
      b = shape_abs_one(b) < 0x1p-100f ? 0x1p-100f : b;  // parallel: margin over that is beyond all scenes
      const int to_front = (b > 0.0f) == (ray->p_rz > 0.0f);
      const float front = ((-margin - a) / b) * ray->p_rz, back = ((margin - a) / b) * ray->p_rz;
      const float first_end = shape_min_one(end, to_front ? back : front);
      const float second_begin = shape_max_one(begin, to_front ? front : back);
      const uint first = p[to_front ? 4 : 5], second = p[to_front ? 5 : 4];
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
    } else {
      const uint leaf = current & 0x7fffffffu;
      if (try_list(geometry, ray, leaf + 1u, geometry.leaves[leaf], any_hit, hit)) return 1;
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
