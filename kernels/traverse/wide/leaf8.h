// SPDX-License-Identifier: Apache-2.0
// The pre-test of a leaf of eight triangles, written once and included by wide.h for
//   EK_VISITS 1  leaf8_pretest: one ray at a leaf; b is not read
//   EK_VISITS 2  leaf8_pretest_2: two rays, each at its leaf, in one vector; the bits of b's
//                triangles are 8 to 15
// It returns the candidates: the triangles that pass the first steps of triangle.h, with the same
// bits, and do not lie wholly behind the ray's end. The triangles at which the ray starts or ends
// are never among them.
//
// Why the sign of the differences is turned: corners are subtracted from the origin, because the
// second operand of a subtraction needs no load of its own. The signs of products of two such
// differences stay as they are.
//
// Why no hit before the ray's end is lost. With u = 2^-24 and A the distance on z to the first
// corner, the first_t of that corner is at most A (1 + 2u), and the triangle's box begins at or
// behind A (1 - 2u) - 1.51 pad |rz|, where pad is 2u |o| or more. A is at most extent |rz|, so 4u A
// is an eighth of pad |rz|. The slack of twice pad |rz| covers both, and the rounding of the sum.
//
// *certain, for an any-hit query without opacity: the candidates that the ray hits for certain
// before its end. Their edges have one sign and none is zero, and all corners lie in front of the
// origin beyond error and before the end, so all that the whole test asks is true. (On x and y the
// intervals of the triangle's box both contain the ray's true t, which lies between those of the
// corners but for less than the pad.)
#if EK_VISITS == 1
#define VisitF float8
#define VISIT_BITS mask_bits8
#define VISIT_RAY(name, k) ((float8)(a->ray->name))
#define VISIT_STORED(axis, offset) leaf8_corner(a, offset, a->axis)
#define VISIT_SHARE ((float8)(a->ray->share))
#define VISIT_MOVED moved_by_8
EK_FN uint leaf8_pretest(const Leaf8Visit* a, const Leaf8Visit* b, const int any_hit, uint* certain) {
  const VisitF t = (float8)(a->ray->t), slack = (float8)(a->ray->t_slack);
#else
#define VisitF float16
#define VISIT_BITS mask_bits16
// Word k of the rays' part for triangles: one instruction for both rays, which the compiler does
// not find by itself.
#define VISIT_RAY(name, k) \
  __builtin_shufflevector(words, words_b, k, k, k, k, k, k, k, k, 16 + k, 16 + k, 16 + k, 16 + k, 16 + k, 16 + k, 16 + k, 16 + k)
#define VISIT_STORED(axis, offset) ((float16)(leaf8_corner(a, offset, a->axis), leaf8_corner(b, offset, b->axis)))
#define VISIT_SHARE ((float16)((float8)(a->ray->share), (float8)(b->ray->share)))
#define VISIT_MOVED moved_by_16
EK_FN uint leaf8_pretest_2(const Leaf8Visit* a, const Leaf8Visit* b, const int any_hit, uint* certain) {
  const float16 words = *(const float16*)((const float*)a->ray + 16), words_b = *(const float16*)((const float*)b->ray + 16);
#endif
  *certain = 0;
  uint shapes = 0;
#if EK_HAS_shape
  int triangles, triangles_b = 0;
  shapes = leaf8_shapes(a->leaf8, a->ray, &triangles);
#if EK_VISITS == 2
  shapes |= leaf8_shapes(b->leaf8, b->ray, &triangles_b) << 8;
#endif
  if (!(triangles | triangles_b)) return shapes;
#endif
  const VisitF ox = VISIT_RAY(p_o.x, 0), oy = VISIT_RAY(p_o.y, 1), oz = VISIT_RAY(p_o.z, 2), sx = VISIT_RAY(sx, 3), sy = VISIT_RAY(sy, 4),
               rz = -VISIT_RAY(p_rcp_d.z, 7);
#if EK_HAS_moving_surface
#define VISIT_CORNER(axis, offset)                                                                                   \
  (EK_OVER_TIME(a->geometry)                                                                                         \
       ? VISIT_MOVED(VISIT_STORED(axis, offset), VISIT_STORED(axis, offset + LEAF8_WORDS), VISIT_SHARE)              \
       : VISIT_STORED(axis, offset))
#else
#define VISIT_CORNER VISIT_STORED
#endif
  const VisitF az = oz - VISIT_CORNER(z, 0), bz = oz - VISIT_CORNER(z, 24), cz = oz - VISIT_CORNER(z, 48);
  const VisitF ax = (ox - VISIT_CORNER(x, 0)) - sx * az, ay = (oy - VISIT_CORNER(y, 0)) - sy * az;
  const VisitF bx = (ox - VISIT_CORNER(x, 24)) - sx * bz, by = (oy - VISIT_CORNER(y, 24)) - sy * bz;
  const VisitF cx = (ox - VISIT_CORNER(x, 48)) - sx * cz, cy = (oy - VISIT_CORNER(y, 48)) - sy * cz;
  const VisitF ea = cx * by - cy * bx, eb = ax * cy - ay * cx, ec = bx * ay - by * ax;
  const VisitF zero = (VisitF)(0.0f);
  const VisitF less = ea < eb ? ea : eb, more = ea > eb ? ea : eb;
  const VisitF least = less < ec ? less : ec, most = more > ec ? more : ec;
  const VisitF at = az * rz, bt = bz * rz, ct = cz * rz;
  const VisitF first = at < bt ? at : bt, last = at > bt ? at : bt;
  const VisitF first_t = first < ct ? first : ct, last_t = last > ct ? last : ct;
#if EK_VISITS == 1
  const uint ends = leaf8_ends(a->leaf8, a->ray, any_hit);
#else
  const VisitF t = (float16)((float8)(a->ray->t), (float8)(b->ray->t));
  const VisitF slack = (float16)((float8)(a->ray->t_slack), (float8)(b->ray->t_slack));
  const uint ends = leaf8_ends(a->leaf8, a->ray, any_hit) | leaf8_ends(b->leaf8, b->ray, any_hit) << 8;
#endif
  if (any_hit & !EK_HAS_opacity) {
    const VisitF tiny = (VisitF)(0x1p-126f);
    *certain =
        VISIT_BITS(((least >= tiny) | (most <= -tiny)) & (first_t > 0x1p-22f * last_t) & (last_t < t - slack)) & ~ends;
  }
  return shapes | (VISIT_BITS(((least >= zero) | (most <= zero)) & (last_t > zero) & !(first_t > t + slack)) & ~ends);
}

#undef VisitF
#undef VISIT_BITS
#undef VISIT_RAY
#undef VISIT_CORNER
#undef VISIT_STORED
#undef VISIT_SHARE
#undef VISIT_MOVED
#undef EK_VISITS
