// SPDX-License-Identifier: Apache-2.0
// Importance sampling of many lights by a binary tree over them (host/pack/lights/light_tree.h). A
// walk goes from the root to one light, and takes each side of a node with the probability of its
// share of the light that the node is estimated to give to the shading point.
//   An estimate is the power of a side times the cosines at both ends over the squared distance.
//   It is made of three moments: the centroid of the power, the variance about it, and the mean
//   direction of emission. Each factor is smoothed by what the moments leave uncertain, so that no
//   light has an estimate of zero, be it near, behind, or below the horizon.
//   Walks split integers [arithmetic coding]: a node splits a range of random words, and the final
//   range over all words is the probability, exactly. The probability of a given light comes from
//   the same splits.
//   source  after [Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive
//           Tree Splitting"], with moments instead of bounds and cones: as cheap, and closer to the
//           mean
#ifndef EK_LIGHT_TREE_H
#define EK_LIGHT_TREE_H
#include "lanes/math.h"
#include "lanes/record_lanes.h"
#include "lights/alias_table.h"

/// A point for which the tree chooses a light.
typedef struct {
  v3 p;              // world, metres
  vu packed_normal;  // pack_normal of its normal
} LightSampleContext;

#define PACKED_NORMAL_BOTH_SIDES 0x40000000u  // light from below counts like light from above

/// Packs a unit normal into ten bits per axis, with a flag for light from both sides. A path
/// carries the result, since the probability of a choice must be computed from the same bits as the
/// choice.
EK_FN vu pack_normal(v3 n, vi both_sides) {
  const vu x = AS_U(TO_I(n.x * 511.0f + 512.0f)), y = AS_U(TO_I(n.y * 511.0f + 512.0f)), z = AS_U(TO_I(n.z * 511.0f + 512.0f));
  const vu packed = (x & 1023u) | ((y & 1023u) << 10) | ((z & 1023u) << 20);
  return both_sides ? packed | PACKED_NORMAL_BOTH_SIDES : packed;
}

// The normal, of nearly unit length.
EK_FN v3 unpack_normal(vu packed) {
  const float unit = 1.0f / 511.0f;
  return V3((TO_F(AS_I(packed & 1023u)) - 512.0f) * unit, (TO_F(AS_I((packed >> 10) & 1023u)) - 512.0f) * unit,
            (TO_F(AS_I((packed >> 20) & 1023u)) - 512.0f) * unit);
}

// Estimated light of a side of a node, times the square of `distance2`.
typedef struct { vf numerator, distance2; } LightEstimate;

// Twice the expected positive part of a number with mean x and about this variance.
EK_FN vf positive_part(vf x, vf variance) {
  const vf root = sqrt_f(x * x + variance);
  return max_f(x + root, root * 0x1p-10f);
}

// centroid, variance, mean_direction  moments of the side, in the tree's unit, as p
EK_FN LightEstimate light_estimate(v3 p, v3 n, vi both_sides, v3 centroid, vf variance, v3 mean_direction) {
  const v3 d = sub3(centroid, p);
  const vf d2 = dot3(d, d);
  const vf height = dot3(n, d);
  const vf above = positive_part(both_sides ? abs_f(height) : height, variance);
  // Isotropic emission gives a quarter of what the same power gives in front of a surface.
  const vf isotropic = 0.25f * max_f(1.0f - dot3(mean_direction, mean_direction), (vf)(0.0f));
  const vf ahead = positive_part(-dot3(mean_direction, d), isotropic * d2 + variance);
  LightEstimate e = {above * ahead, d2 + variance};
  return e;
}

// Probability of the left side of a node.
EK_FN vf left_probability(v3 p, v3 n, vi both_sides, LightNodeLanes r) {
  const LightEstimate left = light_estimate(p, n, both_sides, r.left_centroid, r.left_variance, r.left_mean_direction);
  const LightEstimate right = light_estimate(p, n, both_sides, r.right_centroid, r.right_variance, r.right_mean_direction);
  const vf nearer = div_f(left.distance2, right.distance2);
  const vf a = left.numerator * r.left_share, b = (right.numerator * (1.0f - r.left_share)) * (nearer * nearer);
  const vf share = div_f(a, a + b);
  const vf bounded = min_f(max_f(share, (vf)(LIGHT_TREE_LEAST)), (vf)(1.0f - LIGHT_TREE_LEAST));
  return share == share ? bounded : (vf)(0.5f);
}

// State of a walk: the node, the first of its lights, the remaining range of words, and the range's
// unit, a power of two.
typedef struct {
  vi open;  // mask: not yet at a light
  vu node, first, range;
  vf unit;
} LightWalk;

EK_FN LightWalk light_walk(vi wanted, uint light_count) {
  LightWalk w = {light_count > 1u ? wanted : (vi)(0), (vu)(0u), (vu)(0u), (vu)(0xffffffffu), (vf)(0x1p-32f)};
  return w;
}

// Words of the range that lead to the left.
EK_FN vu light_walk_split(vu range, vf share) { return mul_hi(range, AS_U(TO_I(share * 0x1p30f)) << 2); }

// Goes to the chosen side.
// link  of the node: the number of lights on its left, and a flag for a single light on its right
EK_FN void light_walk_go(LightWalk* w, vi left, vu split, vu link) {
  const vu left_count = link & ~LIGHT_TREE_RIGHT_IS_LIGHT;
  const vi arrived = left ? left_count == 1u : (link & LIGHT_TREE_RIGHT_IS_LIGHT) != 0u;
  const vi move = w->open;
  w->range = move ? (left ? split : w->range - split) : w->range;
  w->first = (move & !left) ? w->first + left_count : w->first;
  w->open = move & !arrived;
  w->node = w->open ? w->node + (left ? (vu)(1u) : left_count) : w->node;
}

// A range below this is widened by 16 bits; no split leaves less than 2^5 of it.
#define LIGHT_WALK_NARROW 0x10000u

EK_FN void light_walk_widen(LightWalk* w, vi narrow) {
  w->range = narrow ? w->range << 16 : w->range;
  w->unit = narrow ? w->unit * 0x1p-16f : w->unit;
}

/// One of the tree's lights, by its position in the order of leaves.
typedef struct {
  vu light;
  vf probability;
  vf u;  // the rest of the random word, uniform again, [0, 1)
} TreeChoice;

// A walk that chooses at each node by the rest of a random word.
typedef struct {
  v3 p, n;
  vi both_sides;
  vu rest, more;
  LightWalk walk;
} TreeSearch;

/// Search for a light for each wanted lane.
/// word  random word
/// more  seed of further random bits, for when those of `word` are used up
EK_FN TreeSearch tree_search(uint light_count, float scale, LightSampleContext lit, vi wanted, vu word, vu more) {
  const TreeSearch t = {scale3(lit.p, (vf)(scale)), unpack_normal(lit.packed_normal), (lit.packed_normal & PACKED_NORMAL_BOTH_SIDES) != 0u,
                        word == 0xffffffffu ? word - 1u : word, more, light_walk(wanted, light_count)};
  return t;
}

EK_FN void tree_search_step(global const LightNode* nodes, TreeSearch* t) {
  LightWalk* w = &t->walk;
  const vi walked = w->open;  // lanes that have arrived must not change while others walk on
  const LightNodeLanes r = load_light_node(nodes, w->node);
  const vu split = light_walk_split(w->range, left_probability(t->p, t->n, t->both_sides, r));
  const vi left = t->rest < split;
  t->rest = (walked & !left) ? t->rest - split : t->rest;
  light_walk_go(w, left, split, r.link);
  const vi narrow = walked & (w->range < LIGHT_WALK_NARROW);
  t->more = narrow ? hash_bits(t->more + 0x9e3779b9u) : t->more;
  t->rest = narrow ? (t->rest << 16) | (t->more & 0xffffu) : t->rest;
  light_walk_widen(w, narrow);
}

EK_FN TreeChoice tree_search_end(TreeSearch t) {
  const vf range = word_to_float(t.walk.range);
  TreeChoice c = {t.walk.first, range * t.walk.unit, min_f(div_f(word_to_float(t.rest), range), (vf)(1.0f - 0x1p-24f))};
  return c;
}

/// Probability that a search ends at `light`.
EK_FN vf light_tree_probability(global const LightNode* nodes, uint light_count, float scale, LightSampleContext lit, vi wanted, vu light) {
  const v3 p = scale3(lit.p, (vf)(scale)), n = unpack_normal(lit.packed_normal);
  const vi both_sides = (lit.packed_normal & PACKED_NORMAL_BOTH_SIDES) != 0u;
  LightWalk w = light_walk(wanted, light_count);
  while (ANY(w.open)) {
    const vi walked = w.open;  // lanes that have arrived must not change while others walk on
    const LightNodeLanes r = load_light_node(nodes, w.node);
    const vu split = light_walk_split(w.range, left_probability(p, n, both_sides, r));
    light_walk_go(&w, light < w.first + (r.link & ~LIGHT_TREE_RIGHT_IS_LIGHT), split, r.link);
    light_walk_widen(&w, walked & (w.range < LIGHT_WALK_NARROW));
  }
  return word_to_float(w.range) * w.unit;
}

#endif
