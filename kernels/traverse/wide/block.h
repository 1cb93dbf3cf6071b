// SPDX-License-Identifier: Apache-2.0
// The first questions to blocks of eight triangles, written once and included by traverse/wide/wide.h for
//   EK_BLOCKS 1  one ray at a block                          -> wide_candidates
//   EK_BLOCKS 2  two rays, each at a block, in one vector  -> wide_candidates_2, the second's triangles in bits 8 to 15
// The triangles that the ray may hit: those that pass the first questions of traverse/triangle.h, in the same bits, and do not lie wholly
// behind the ray's end; never those that it leaves or goes to. (Corners are negated, which does not show in the signs of products: as
// second operand of a difference they need no load of their own. With A the distance to the first corner on z, its t first_t is at
// most A (1 + 2u), u = 2^-24, and the box of the triangle begins at or behind A (1 - 2u) - 1.51 pad |rz|, pad being 2u |o| and more;
// A is at most reach |rz|, so that 4u A is an eighth of pad |rz|. Twice pad |rz| covers both, and the rounding of the sum.)
// sure, for an any-hit query: those of them that the ray hits for certain before its end. Their edges have one sign and none is zero, and
// all corners lie in front of the origin beyond error and before the end: all that the whole test asks then is true. (Its box's
// intervals on x and y have the ray's true t in common, which lies between those of the corners but for less than the pad.)
#if EK_BLOCKS == 1
#define BlockF float8
#define BLOCK_BITS mask_bits8
#define BLOCK_RAY(name, k) ((float8)(ray->name))
#define BLOCK_CORNER(axis, offset) (o##axis - wide_corner(geometry, ray, block, offset, axis))
EK_FN uint wide_candidates(Geometry geometry, global const float* block, const RayOne* ray, const int any_hit, uint* sure) {
#else
#define BlockF float16
#define BLOCK_BITS mask_bits16
// Word k of the rays' part for triangles: one instruction for both, which the compiler does not see by itself.
#define BLOCK_RAY(name, k) \
  __builtin_shufflevector(words, words_2, k, k, k, k, k, k, k, k, 16 + k, 16 + k, 16 + k, 16 + k, 16 + k, 16 + k, 16 + k, 16 + k)
#define BLOCK_CORNER(axis, offset)                                       \
  (o##axis - (float16)(wide_corner(geometry, ray, block, offset, axis), \
                       wide_corner(geometry, ray_2, block_2, offset, axis##_2)))
EK_FN uint wide_candidates_2(Geometry geometry, global const float* block, const RayOne* ray, global const float* block_2,
                             const RayOne* ray_2, const int any_hit, uint* sure) {
  const float16 words = *(const float16*)((const float*)ray + 16), words_2 = *(const float16*)((const float*)ray_2 + 16);
  const uint x_2 = ray_2->axis_x, z_2 = ray_2->axis_z, y_2 = 24u - x_2 - z_2;
#endif
  *sure = 0;
  uint shapes = 0;
#if EK_HAS_shape
  int triangles, triangles_2 = 0;
  shapes = wide_shapes(block, ray, &triangles);
#if EK_BLOCKS == 2
  shapes |= wide_shapes(block_2, ray_2, &triangles_2) << 8;
#endif
  if (!(triangles | triangles_2)) return shapes;
#endif
  const uint x = ray->axis_x, z = ray->axis_z, y = 24u - x - z;
  const BlockF ox = BLOCK_RAY(p_ox, 0), oy = BLOCK_RAY(p_oy, 1), oz = BLOCK_RAY(p_oz, 2), sx = BLOCK_RAY(sx, 3), sy = BLOCK_RAY(sy, 4),
               rz = -BLOCK_RAY(p_rz, 7);
  const BlockF az = BLOCK_CORNER(z, 0), bz = BLOCK_CORNER(z, 24), cz = BLOCK_CORNER(z, 48);
  const BlockF ax = BLOCK_CORNER(x, 0) - sx * az, ay = BLOCK_CORNER(y, 0) - sy * az;
  const BlockF bx = BLOCK_CORNER(x, 24) - sx * bz, by = BLOCK_CORNER(y, 24) - sy * bz;
  const BlockF cx = BLOCK_CORNER(x, 48) - sx * cz, cy = BLOCK_CORNER(y, 48) - sy * cz;
  const BlockF ea = cx * by - cy * bx, eb = ax * cy - ay * cx, ec = bx * ay - by * ax;
  const BlockF zero = (BlockF)(0.0f);
  const BlockF less = ea < eb ? ea : eb, more = ea > eb ? ea : eb;
  const BlockF least = less < ec ? less : ec, most = more > ec ? more : ec;
  const BlockF at = az * rz, bt = bz * rz, ct = cz * rz;
  const BlockF first = at < bt ? at : bt, last = at > bt ? at : bt;
  const BlockF first_t = first < ct ? first : ct, last_t = last > ct ? last : ct;
#if EK_BLOCKS == 1
  const BlockF end = (float8)(ray->t + ray->slack);
  const BlockF before = (float8)(ray->t - ray->slack);
  const uint ends = wide_ends(block, ray, any_hit);
#else
  const BlockF end = (float16)((float8)(ray->t + ray->slack), (float8)(ray_2->t + ray_2->slack));
  const BlockF before = (float16)((float8)(ray->t - ray->slack), (float8)(ray_2->t - ray_2->slack));
  const uint ends = wide_ends(block, ray, any_hit) | wide_ends(block_2, ray_2, any_hit) << 8;
#endif
  if (any_hit & !EK_HAS_opacity) {
    const BlockF tiny = (BlockF)(0x1p-126f);
    *sure = BLOCK_BITS(((least >= tiny) | (most <= -tiny)) & (first_t > 0x1p-22f * last_t) & (last_t < before)) & ~ends;
  }
  return shapes | (BLOCK_BITS(((least >= zero) | (most <= zero)) & (last_t > zero) & !(first_t > end)) & ~ends);
}

#undef BlockF
#undef BLOCK_BITS
#undef BLOCK_RAY
#undef BLOCK_CORNER
#undef EK_BLOCKS
