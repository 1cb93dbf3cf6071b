// SPDX-License-Identifier: Apache-2.0
// Oblique planes of the layout `bsp`: n (x - c) = d, where |n| is 1 but for rounding, and c, a
// point amid the scene, is in the words of the header from 7. Their rounding is not monotone, so a
// margin replaces item 1 of cells.h. A list in front holds every triangle that may be hit at a
// point P = o + t d there, and one behind likewise; so it is enough that a ray visits the side that
// P is on. The computed distance of P from the plane errs by 16 u E at the origin and by 18 u E
// along the ray, from the direction's shear, and the quotient by 14 u E; P is the point of t's own
// value. The margin is 128 u E + 8 u |o|, so that rays that pass a triangle within 7 u E (item 3)
// meet its cells, too. Planes across an axis are those of a kd-tree, which the paper has beside the
// others [Ize, Wald, Parker 2008, "Ray tracing with the BSP tree"].
#ifndef EK_TRAVERSE_BSP_H
#define EK_TRAVERSE_BSP_H
#include "traverse/classic/cells.h"

// In world axes: the origin from c, and the direction scaled to 1 along the ray's longest axis.
typedef struct {
  float ox, oy, oz, dx, dy, dz, margin;
} BspRay;

EK_FN BspRay bsp_ray(Geometry geometry, const RayOne* ray) {
  global const float* center = (global const float*)geometry.nodes + 7;
  const uint z = ray->axis_z / 8u, x = ray->axis_x / 8u, y = 3u - z - x;
  float o[3], d[3];
  o[x] = ray->p_o.x; o[y] = ray->p_o.y; o[z] = ray->p_o.z;
  d[x] = ray->sx; d[y] = ray->sy; d[z] = 1.0f;
  const float o_max = shape_max_one(shape_max_one(shape_abs_one(o[0]), shape_abs_one(o[1])), shape_abs_one(o[2]));
  const BspRay r = {o[0] - center[0], o[1] - center[1], o[2] - center[2], d[0], d[1], d[2],
                    ray->extent * 0x1p-17f + o_max * 0x1p-21f};
  return r;
}

// The two sides of a plane along the ray. p: the node
EK_FN CellParts bsp_parts(const BspRay* r, const RayOne* ray, global const float* p) {
  const float nx = p[2], ny = p[3], nz = p[4];
  const float a = ((nx * r->ox + ny * r->oy) + nz * r->oz) - p[0];
  float b = (nx * r->dx + ny * r->dy) + nz * r->dz;
  // A parallel plane: the margin divided by this is beyond all scenes.
  b = shape_abs_one(b) < 0x1p-100f ? 0x1p-100f : b;
  const float inverse = div_f(1.0f, b);
  const float front = ((-r->margin - a) * inverse) * ray->p_rcp_d.z, back = ((r->margin - a) * inverse) * ray->p_rcp_d.z;
  const int rises = (b > 0.0f) == (ray->p_rcp_d.z > 0.0f);
  const CellParts parts = {rises ? back : front, rises ? front : back, !rises};
  return parts;
}

#endif
