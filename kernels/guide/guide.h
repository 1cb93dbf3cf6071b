// SPDX-License-Identifier: Apache-2.0
// Path guiding: what a pilot learned about the light that arrives at a cell steers where paths go
// on.
//
// A cell has a table of 8 x 8 bins over the unit square from which warp_cosine_hemisphere makes
// directions, so the cosine of a diffuse surface is in it without cost. guide_warp moves a point of
// the square towards heavy bins, and guide_density is the density of the directions that come out
// of it over that of the cosine; it is at least EK_GUIDE_LEAST, so no weight grows by more than its
// inverse. The table is frozen before the render begins, so samples stay independent and unbiased
// whatever is in it. Its words are listed in shared/guide.h.
#ifndef EK_GUIDE_H
#define EK_GUIDE_H
#include "guide/cell.h"
#include "lanes/warp.h"

/// The buffers of the table.
typedef struct {
  global const uint* slots;  // hash table (cell_find)
  global const uint* cells;
} GuideData;

#if EK_USES_GUIDE
#define EK_GUIDE_ARGUMENTS , global const uint *guide_slots, global const uint *guide_cells
#define EK_GUIDE_DATA , {guide_slots, guide_cells}
#else
#define EK_GUIDE_ARGUMENTS
#define EK_GUIDE_DATA
#endif

// GGX's alpha, the square of glTF's roughness, from which on highlights are so wide that a table of
// 8 x 8 bins helps to sample them.
#define EK_GUIDED_ALPHA 0.16f
// Probability that such a surface follows the table, over that of following the highlight: at least
// so much.
#define EK_GUIDED_SHARE 0.2f

// Density over that of the cosine, of one unit of weight.
#define GUIDE_DENSITY ((float)EK_GUIDE_BINS / EK_GUIDE_TOTAL)

/// The table that each lane follows: a cell of the guide, or of light_aim (lights/light_aim.h).
typedef struct {
  global const uint* cells;
  vu cell;  // EK_NO_CELL: plain sampling
} GuideCell;

EK_FN vi guide_has(GuideCell g) { return g.cell != EK_NO_CELL; }

// First word of the lane's cell; of some valid cell where it has none.
EK_FN vu guide_words(GuideCell g) { return (guide_has(g) ? g.cell : (vu)(0u)) * (uint)EK_GUIDE_CELL_WORDS; }

// The half of a word that holds the 16 bits of this index.
EK_FN vf guide_half_word(vu word, uint which) { return TO_F(AS_I((which & 1u) != 0u ? word >> 16 : word & 0xffffu)); }

/// Mean radiance that arrives at the cell from surfaces, and from lights that are sampled.
EK_FN vf guide_indirect(GuideCell g) { return gather_f((global const float*)g.cells, guide_words(g) + (uint)GUIDE_indirect); }
EK_FN vf guide_direct(GuideCell g) { return gather_f((global const float*)g.cells, guide_words(g) + (uint)GUIDE_direct); }

/// Moves u and v, in [0, 1 - 2^-24]. returns the density; 1 for lanes without a cell, which keep
/// theirs
EK_FN vf guide_warp(GuideCell g, vf* u, vf* v) {
  const vi has = guide_has(g);
  if (!ANY(has)) return (vf)(1.0f);
  const vf most = (vf)(1.0f - 0x1p-24f);
  const vu words = guide_words(g);
  const vf x = *u * (float)EK_GUIDE_TOTAL;
  vu row = (vu)(0u);
  vf lower = (vf)(0.0f), upper = (vf)((float)EK_GUIDE_TOTAL);
  vu word = (vu)(0u);
  for (uint i = 0; i < EK_GUIDE_ROWS; ++i) {
    if ((i & 1u) == 0u) word = gather_u(g.cells, words + (uint)GUIDE_bounds + i / 2);
    const vf bound = guide_half_word(word, i);
    const vi beyond = bound <= x;
    row = (beyond & (i > 0u ? ALL_LANES : (vi)(0))) ? row + 1u : row;
    lower = beyond ? bound : lower;
    upper = beyond ? upper : min_f(upper, bound);
  }
  const vf height = upper - lower;
  const vf along_x = min_f(div_f(x - lower, height), most);

  const vf y = *v * height;
  vu column = (vu)(0u);
  vf begin = (vf)(0.0f), end = (vf)(0.0f), width = (vf)(0.0f);
  for (uint i = 0; i < EK_GUIDE_ROWS; ++i) {
    if ((i & 1u) == 0u) word = gather_u(g.cells, words + (uint)GUIDE_weights + row * (EK_GUIDE_ROWS / 2) + i / 2);
    const vf weight = guide_half_word(word, i);
    const vi reached = (end <= y) | (i == 0u ? ALL_LANES : (vi)(0));
    column = (reached & (i > 0u ? ALL_LANES : (vi)(0))) ? column + 1u : column;
    begin = reached ? end : begin;
    width = reached ? weight : width;
    end = end + weight;
  }
  const vf along_y = min_f(div_f(y - begin, width), most);
  *u = has ? min_f((TO_F(AS_I(row)) + along_x) * (1.0f / EK_GUIDE_ROWS), most) : *u;
  *v = has ? min_f((TO_F(AS_I(column)) + along_y) * (1.0f / EK_GUIDE_ROWS), most) : *v;
  return has ? width * GUIDE_DENSITY : (vf)(1.0f);
}

/// The bin of a local direction of the upper hemisphere: row * 8 + column.
EK_FN vu guide_bin(v3 wi) {
  // The inverse of warp_disk.
  const vi wide = abs_f(wi.x) > abs_f(wi.y);
  const vf greater = wide ? wi.x : wi.y, lesser = wide ? wi.y : wi.x;
  const vf radius = copysign_f(sqrt_f(wi.x * wi.x + wi.y * wi.y), greater);
  const vf slope = greater == 0.0f ? (vf)(0.0f) : div_f(lesser, greater);
  const vf other = (8.0f * radius) * atan2_turns(slope, (vf)(1.0f));
  const vf a = wide ? radius : other, b = wide ? other : radius;
  const vf half_rows = (vf)(0.5f * EK_GUIDE_ROWS), last = (vf)(EK_GUIDE_ROWS - 1.0f);
  const vf x = min_f(max_f((a + 1.0f) * half_rows, (vf)(0.0f)), last);
  const vf y = min_f(max_f((b + 1.0f) * half_rows, (vf)(0.0f)), last);
  return AS_U(TO_I(x)) * EK_GUIDE_ROWS + AS_U(TO_I(y));
}

/// Density of wi (local) among the directions that guide_warp leads to, over that of the cosine; 1
/// without a cell.
EK_FN vf guide_density(GuideCell g, v3 wi) {
  const vi has = guide_has(g);
  if (!ANY(has)) return (vf)(1.0f);
  const vu bin = guide_bin(wi);
  const vu word = gather_u(g.cells, guide_words(g) + (uint)GUIDE_weights + (bin >> 1));
  const vf weight = TO_F(AS_I((bin & 1u) != 0u ? word >> 16 : word & 0xffffu));
  return has ? weight * GUIDE_DENSITY : (vf)(1.0f);
}

#endif
