// SPDX-License-Identifier: Apache-2.0
// Watertight ray-triangle test [Woop, Benthin, Wald 2013, JCGT 2(1)], written once and included by
// hit.h for
//   EK_SHAPE 1  one ray, one triangle                     -> triangle_hit_one
//   EK_SHAPE 0  EK_WIDTH rays, one triangle each or for all -> triangle_hit_lanes
// with the same bits in each. Deviations from the paper:
//   - The sign of a difference of two rounded products is right or zero, never wrong. Where it is
//     zero, the rounding errors of the products decide. They are found by splitting [Dekker 1971],
//     which is as exact as the paper's double precision, which not every device has.
//   - Where the error bound of t reaches zero [Pharr, Jakob, Humphreys 2023, PBR section 6.8.4], t
//     is computed anew from the plane of the corners as they were given, and refused unless it is
//     positive. Its error is less than the offset with which rays leave a surface (surface.h): they
//     miss it and its copies, but not a wall that touches it. The plane of needles and of edge-on
//     triangles is not known so well; there t is refused within its bound. None of this is done
//     where all corners lie in front of the origin beyond error, which those of the surface that a
//     ray leaves never do.
//   - t is moved into the interval of the triangle's box (ray.h). Only rounding takes it out of
//     there, for edge-on triangles.
#if EK_SHAPE == 1
#define SHAPE(name) name##_one
#define ShapeRay RayOne
#define ShapeCorner float
#define ShapeF float
#define ShapeI int
#define SHAPE_AS_F as_float
#define SHAPE_AS_U as_uint
#define SHAPE_ANY(m) (m)
#else
#define SHAPE(name) name##_lanes
#define ShapeRay RayLanes
#define ShapeCorner vf
#define ShapeF vf
#define ShapeI vi
#define SHAPE_AS_F AS_F
#define SHAPE_AS_U AS_U
#define SHAPE_ANY(m) (mask_bits(m) != 0)
#endif

// Corners in the axes of the ray's test: z is the longest component of its direction.
typedef struct {
  ShapeCorner ax, ay, az, bx, by, bz, cx, cy, cz;
} SHAPE(Corners);

typedef struct {
  ShapeI hit;
  ShapeF t, u, v;  // u, v: weights of b and c; where hit
  ShapeI back;     // the ray comes from the side from which a, b, c run clockwise; where hit
} SHAPE(TriangleHit);

EK_FN ShapeF SHAPE(shape_min)(ShapeF a, ShapeF b) { return a < b ? a : b; }
EK_FN ShapeF SHAPE(shape_max)(ShapeF a, ShapeF b) { return a > b ? a : b; }
EK_FN ShapeF SHAPE(shape_abs)(ShapeF a) { return SHAPE_AS_F(SHAPE_AS_U(a) & 0x7fffffffu); }

EK_FN ShapeCorner SHAPE(corner_min)(ShapeCorner a, ShapeCorner b, ShapeCorner c) {
  const ShapeCorner m = a < b ? a : b;
  return m < c ? m : c;
}
EK_FN ShapeCorner SHAPE(corner_max)(ShapeCorner a, ShapeCorner b, ShapeCorner c) {
  const ShapeCorner m = a > b ? a : b;
  return m > c ? m : c;
}

// a * b - product for product = fl(a * b). It is exact, because halves of 12 bits have exact
// products.
EK_FN ShapeF SHAPE(product_error)(ShapeF a, ShapeF b, ShapeF product) {
  const ShapeF a_hi = SHAPE_AS_F(SHAPE_AS_U(a) & 0xfffff000u), b_hi = SHAPE_AS_F(SHAPE_AS_U(b) & 0xfffff000u);
  const ShapeF a_lo = a - a_hi, b_lo = b - b_hi;
  return (((a_hi * b_hi - product) + a_hi * b_lo) + a_lo * b_hi) + a_lo * b_lo;
}
// a * b - c * d where the rounded products are equal.
EK_FN ShapeF SHAPE(equal_products_difference)(ShapeF a, ShapeF b, ShapeF c, ShapeF d) {
  return SHAPE(product_error)(a, b, a * b) - SHAPE(product_error)(c, d, c * d);
}

// The corners seen along the ray, and the signed areas opposite to them.
typedef struct {
  ShapeF ax, ay, az, bx, by, bz, cx, cy, cz, ea, eb, ec;
} SHAPE(Edges);

EK_FN SHAPE(Edges) SHAPE(triangle_edges)(const ShapeRay* ray, SHAPE(Corners) p) {
  SHAPE(Edges) e;
  e.az = p.az - ray->p_o.z; e.bz = p.bz - ray->p_o.z; e.cz = p.cz - ray->p_o.z;
  e.ax = (p.ax - ray->p_o.x) - ray->sx * e.az; e.ay = (p.ay - ray->p_o.y) - ray->sy * e.az;
  e.bx = (p.bx - ray->p_o.x) - ray->sx * e.bz; e.by = (p.by - ray->p_o.y) - ray->sy * e.bz;
  e.cx = (p.cx - ray->p_o.x) - ray->sx * e.cz; e.cy = (p.cy - ray->p_o.y) - ray->sy * e.cz;
  e.ea = e.cx * e.by - e.cy * e.bx; e.eb = e.ax * e.cy - e.ay * e.cx; e.ec = e.bx * e.ay - e.by * e.ax;
  return e;
}

EK_FN SHAPE(TriangleHit) SHAPE(triangle_hit)(const ShapeRay* ray, SHAPE(Corners) p) {
  SHAPE(TriangleHit) r;
  const SHAPE(Edges) e = SHAPE(triangle_edges)(ray, p);
  const ShapeF ax = e.ax, ay = e.ay, az = e.az, bx = e.bx, by = e.by, bz = e.bz, cx = e.cx, cy = e.cy, cz = e.cz;
  ShapeF ea = e.ea, eb = e.eb, ec = e.ec;
  const ShapeF zero = (ShapeF)(0.0f);
  r.t = r.u = r.v = zero;
  r.back = (ShapeI)(0);
  ShapeF least = SHAPE(shape_min)(SHAPE(shape_min)(ea, eb), ec), most = SHAPE(shape_max)(SHAPE(shape_max)(ea, eb), ec);
  r.hit = (least >= zero) | (most <= zero);
  if (SHAPE_ANY(r.hit)) {
    if (SHAPE_ANY(r.hit & ((least == zero) | (most == zero)))) {
      ea = ea == zero ? SHAPE(equal_products_difference)(cx, by, cy, bx) : ea;
      eb = eb == zero ? SHAPE(equal_products_difference)(ax, cy, ay, cx) : eb;
      ec = ec == zero ? SHAPE(equal_products_difference)(bx, ay, by, ax) : ec;
      least = SHAPE(shape_min)(SHAPE(shape_min)(ea, eb), ec);
      most = SHAPE(shape_max)(SHAPE(shape_max)(ea, eb), ec);
      r.hit = (least >= zero) | (most <= zero);
    }
    // A triangle wholly behind the origin has t <= 0. Half of the candidates end here.
    const ShapeF at = az * ray->p_rcp_d.z, bt = bz * ray->p_rcp_d.z, ct = cz * ray->p_rcp_d.z;
    const ShapeF last_t = SHAPE(shape_max)(SHAPE(shape_max)(at, bt), ct);
    r.hit = r.hit & (last_t > zero);
    if (!SHAPE_ANY(r.hit)) return r;
    const ShapeF det = (ea + eb) + ec, size = SHAPE(shape_abs)(det);
    r.hit = r.hit & (size >= (ShapeF)(0x1p-126f));
    const ShapeF inverse = div_f((ShapeF)(1.0f), det), inverse_size = SHAPE(shape_abs)(inverse);
    ShapeF t = ((ea * at + eb * bt) + ec * ct) * inverse;

    // gamma(n) = n 2^-24 / (1 - n 2^-24), rounded up.
    const ShapeF gamma2 = (ShapeF)(1.1920931e-7f), gamma3 = (ShapeF)(1.7881398e-7f), gamma5 = (ShapeF)(2.980233e-7f);
    const ShapeF first_t = SHAPE(shape_min)(SHAPE(shape_min)(at, bt), ct);
    const ShapeI in_front = first_t > gamma3 * last_t;
    const ShapeF max_t = SHAPE(shape_max)(last_t, -first_t);
    // With coordinates below twice the extent, the bound below is less than half of this one. Where
    // t exceeds this, it is certain.
    const ShapeF coarse_t = (0x1p-19f + (0x1p-14f * ray->extent) * ray->extent * inverse_size) * max_t;
    const ShapeI uncertain = r.hit & !in_front & !(t > coarse_t);
    if (SHAPE_ANY(uncertain)) {
      const ShapeF px = p.bx - p.ax, py = p.by - p.ay, pz = p.bz - p.az;
      const ShapeF qx = p.cx - p.ax, qy = p.cy - p.ay, qz = p.cz - p.az;
      // The weights and the normal are off by some 2^-24 longest^2 / size each, and the new t by
      // the product of both.
      const ShapeF max_x = SHAPE(shape_max)(SHAPE(shape_abs)(px), SHAPE(shape_abs)(qx));
      const ShapeF max_y = SHAPE(shape_max)(SHAPE(shape_abs)(py), SHAPE(shape_abs)(qy));
      const ShapeF max_z = SHAPE(shape_max)(SHAPE(shape_abs)(pz), SHAPE(shape_abs)(qz));
      const ShapeF longest = SHAPE(shape_max)(SHAPE(shape_max)(max_x, max_y), max_z);
      const ShapeI well_shaped = longest * longest < 0x1p12f * size;
      // The new t is the product of the normal, scaled so that its product with the direction (sx,
      // sy, 1) is 1, and the vector from the origin to the point of the weights. That vector is
      // short, so the normal's own error does not matter, and it is exact along an axis on which
      // the corners agree.
      const ShapeF nx = (qy * pz - qz * py) * inverse, ny = (qz * px - qx * pz) * inverse, nz = (qx * py - qy * px) * inverse;
      const ShapeF wa = ea * inverse, wb = eb * inverse, wc = ec * inverse;
      const ShapeF dx = (wa * (p.ax - ray->p_o.x) + wb * (p.bx - ray->p_o.x)) + wc * (p.cx - ray->p_o.x);
      const ShapeF dy = (wa * (p.ay - ray->p_o.y) + wb * (p.by - ray->p_o.y)) + wc * (p.cy - ray->p_o.y);
      const ShapeF plane_t = (nx * dx + ny * dy) * ray->p_rcp_d.z + nz * t;
      t = (uncertain & well_shaped) ? plane_t : t;
      r.hit = r.hit & (!uncertain | !well_shaped | (t > zero));
      if (SHAPE_ANY(r.hit & uncertain & !well_shaped)) {
        const ShapeF most_x = SHAPE(shape_max)(SHAPE(shape_max)(SHAPE(shape_abs)(ax), SHAPE(shape_abs)(bx)), SHAPE(shape_abs)(cx));
        const ShapeF most_y = SHAPE(shape_max)(SHAPE(shape_max)(SHAPE(shape_abs)(ay), SHAPE(shape_abs)(by)), SHAPE(shape_abs)(cy));
        const ShapeF most_z = SHAPE(shape_max)(SHAPE(shape_max)(SHAPE(shape_abs)(az), SHAPE(shape_abs)(bz)), SHAPE(shape_abs)(cz));
        const ShapeF max_e = SHAPE(shape_max)(most, -least);
        const ShapeF delta_x = gamma5 * (most_x + most_z), delta_y = gamma5 * (most_y + most_z);
        const ShapeF delta_e = 2.0f * ((gamma2 * most_x * most_y + delta_y * most_x) + delta_x * most_y);
        const ShapeF delta_t = 3.0f * ((2.0f * gamma3 * max_e + delta_e) * max_t) * inverse_size;
        r.hit = r.hit & (!uncertain | well_shaped | (t > delta_t));
      }
    }

    // On z, t lies between those of the corners but for 8 units of 2^-24, which is well within the
    // pad. A step into the interval on x and y leaves it there, because a ray that hits is in all
    // three intervals at once.
    const ShapeF lo_x = (ShapeF)(SHAPE(corner_min)(p.ax, p.bx, p.cx)), hi_x = (ShapeF)(SHAPE(corner_max)(p.ax, p.bx, p.cx));
    const ShapeF lo_y = (ShapeF)(SHAPE(corner_min)(p.ay, p.by, p.cy)), hi_y = (ShapeF)(SHAPE(corner_max)(p.ay, p.by, p.cy));
    const ShapeF near_x = ((ray->p_rcp_d.x < 0.0f ? hi_x : lo_x) - ray->p_near_x) * ray->p_rcp_d.x;
    const ShapeF near_y = ((ray->p_rcp_d.y < 0.0f ? hi_y : lo_y) - ray->p_near_y) * ray->p_rcp_d.y;
    const ShapeF far_x = ((ray->p_rcp_d.x < 0.0f ? lo_x : hi_x) - ray->p_far_x) * ray->p_rcp_d.x;
    const ShapeF far_y = ((ray->p_rcp_d.y < 0.0f ? lo_y : hi_y) - ray->p_far_y) * ray->p_rcp_d.y;
    const ShapeF begin = SHAPE(shape_max)(SHAPE(shape_max)(near_x, near_y), zero), end = SHAPE(shape_min)(far_x, far_y);
    r.hit = r.hit & (begin <= end);
    t = t < begin ? begin : t;
    r.t = t > end ? end : t;
    r.u = eb * inverse;
    r.v = ec * inverse;
    r.back = (det < zero) != (ray->p_rcp_d.z < zero);  // det is -(n, d) / d.z, for the normal n
  }
  return r;
}

#if EK_SHAPE == 0
// The pre-test: the lanes that may hit the triangle before `end`. It rejects what the first steps
// of triangle_hit reject.
EK_FN vi triangle_may_be_hit_lanes(const RayLanes* ray, Corners_lanes p, vf end) {
  const Edges_lanes e = triangle_edges_lanes(ray, p);
  const vf zero = (vf)(0.0f), least = shape_min_lanes(shape_min_lanes(e.ea, e.eb), e.ec),
           most = shape_max_lanes(shape_max_lanes(e.ea, e.eb), e.ec);
  const vf at = e.az * ray->p_rcp_d.z, bt = e.bz * ray->p_rcp_d.z, ct = e.cz * ray->p_rcp_d.z;
  const vf first_t = shape_min_lanes(shape_min_lanes(at, bt), ct), last_t = shape_max_lanes(shape_max_lanes(at, bt), ct);
  return ((least >= zero) | (most <= zero)) & (last_t > zero) & !(first_t > end + ray->t_slack);
}
#endif

#undef SHAPE
#undef ShapeRay
#undef ShapeCorner
#undef ShapeF
#undef ShapeI
#undef SHAPE_AS_F
#undef SHAPE_AS_U
#undef SHAPE_ANY
#undef EK_SHAPE
