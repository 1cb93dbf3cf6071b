// SPDX-License-Identifier: Apache-2.0
// Choosing among many lights by what each may give to a point: a binary tree over them (host/pack/lights/light_tree.h), from whose
// root a path leads to one light, at every node to that side with the probability of its share of the estimated light.
//   An estimate is of the energy of a side times the cosines at both ends over the squared distance, from three moments: the
//   middle of its energy, the mean square of the distance from it, and the mean of the directions that it is emitted to. Each is
//   smoothed by what the moments leave open, so that no light has an estimate of zero, near, behind, or below the horizon.
//   Paths are walked in integers [arithmetic coding]: a node splits a range of random words, and what is left of the range over
//   all words is the probability, exactly; asking for a light's probability splits the same ranges.
//   source  after Conty Estevez and Kulla ["Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018], with
//           moments instead of bounds and cones: as cheap, and closer to the mean
#ifndef EK_LIGHT_TREE_H
#define EK_LIGHT_TREE_H
#include "lanes/math.h"
#include "lanes/record_lanes.h"
#include "lights/light_choice.h"

/// The point that light arrives at.
typedef struct {
  v3 p;      // world, metres
  vu facing;  // its normal (pack_facing)
} LitPoint;

#define FACING_BOTH_SIDES 0x40000000u  // light from below counts as that from above

/// A unit normal in ten bits per axis, and whether light from both sides counts: whoever asks for a probability must know the
/// same normal as who chose by it, bit for bit, and a path has to carry it.
EK_FN vu pack_facing(v3 n, vi both_sides) {
  const vu x = AS_U(TO_I(n.x * 511.0f + 512.0f)), y = AS_U(TO_I(n.y * 511.0f + 512.0f)), z = AS_U(TO_I(n.z * 511.0f + 512.0f));
  const vu facing = (x & 1023u) | ((y & 1023u) << 10) | ((z & 1023u) << 20);
  return both_sides ? facing | FACING_BOTH_SIDES : facing;
}

// Of nearly unit length.
EK_FN v3 facing_normal(vu facing) {
  const float unit = 1.0f / 511.0f;
  return V3((TO_F(AS_I(facing & 1023u)) - 512.0f) * unit, (TO_F(AS_I((facing >> 10) & 1023u)) - 512.0f) * unit,
            (TO_F(AS_I((facing >> 20) & 1023u)) - 512.0f) * unit);
}

// What a side of a node is estimated to give, times the square of `distance2`.
typedef struct { vf numerator, distance2; } LightEstimate;

// What x may be on average, where it is off by an unknown amount of mean square spread2, if less than 0 counts as 0; twice that.
EK_FN vf positive_part(vf x, vf spread2) {
  const vf root = sqrt(x * x + spread2);
  return max_f(x + root, root * 0x1p-10f);
}

// middle, spread2, flow  moments of the side, in units of the lights' extent, as p
EK_FN LightEstimate light_estimate(v3 p, v3 n, vi both_sides, v3 middle, vf spread2, v3 flow) {
  const v3 d = sub3(middle, p);
  const vf d2 = dot3(d, d);
  const vf height = dot3(n, d);
  const vf above = positive_part(both_sides ? abs_f(height) : height, spread2);
  // Light that flows evenly to all sides is a quarter of what the same energy gives ahead of a surface.
  const vf even = 0.25f * max_f(1.0f - dot3(flow, flow), (vf)(0.0f));
  const vf ahead = positive_part(-dot3(flow, d), even * d2 + spread2);
  LightEstimate e = {above * ahead, d2 + spread2};
  return e;
}

// Probability of the left side of a node.
EK_FN vf left_share(v3 p, v3 n, vi both_sides, LightNodeLanes r) {
  const LightEstimate left = light_estimate(p, n, both_sides, r.left, r.left_spread2, r.left_flow);
  const LightEstimate right = light_estimate(p, n, both_sides, r.right, r.right_spread2, r.right_flow);
  const vf nearer = left.distance2 / right.distance2;
  const vf a = left.numerator * r.left_share, b = (right.numerator * (1.0f - r.left_share)) * (nearer * nearer);
  const vf share = a / (a + b);
  const vf bounded = min_f(max_f(share, (vf)(LIGHT_TREE_LEAST)), (vf)(1.0f - LIGHT_TREE_LEAST));
  return share == share ? bounded : (vf)(0.5f);
}

// What a walk knows: the node, the first of its lights, the range of words left, and its unit as a power of two.
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

// To the side that was chosen; the node's record says how many lights are on its left, and whether one is on its right.
EK_FN void light_walk_go(LightWalk* w, vi left, vu split, vu link) {
  const vu left_count = link & ~LIGHT_TREE_RIGHT_IS_LIGHT;
  const vi arrived = left ? left_count == 1u : (link & LIGHT_TREE_RIGHT_IS_LIGHT) != 0u;
  const vi move = w->open;
  w->range = move ? (left ? split : w->range - split) : w->range;
  w->first = (move & !left) ? w->first + left_count : w->first;
  w->open = move & !arrived;
  w->node = w->open ? w->node + (left ? (vu)(1u) : left_count) : w->node;
}

#define LIGHT_WALK_NARROW 0x10000u  // below, a range is widened by 16 bits; no split leaves less than 2^5 of it

EK_FN void light_walk_widen(LightWalk* w, vi narrow) {
  w->range = narrow ? w->range << 16 : w->range;
  w->unit = narrow ? w->unit * 0x1p-16f : w->unit;
}

/// One of the tree's lights, by its place in the order of leaves.
typedef struct {
  vu light;
  vf probability;
  vf u;  // what is left of the random word, [0, 1)
} TreeChoice;

// A walk that chooses: at each node by what is left of a random word.
typedef struct {
  v3 p, n;
  vi both_sides;
  vu rest, more;
  LightWalk walk;
} TreeSearch;

/// Search for a light for each wanted lane.
/// word  random; more: random bits, independent of it as far as these reach
EK_FN TreeSearch tree_search(uint light_count, float scale, LitPoint lit, vi wanted, vu word, vu more) {
  const TreeSearch t = {scale3(lit.p, (vf)(scale)), facing_normal(lit.facing), (lit.facing & FACING_BOTH_SIDES) != 0u,
                        word == 0xffffffffu ? word - 1u : word, more, light_walk(wanted, light_count)};
  return t;
}

EK_FN void tree_search_step(global const LightNode* nodes, TreeSearch* t) {
  LightWalk* w = &t->walk;
  const vi walked = w->open;  // lanes that have arrived must not change: others walk on, or none do
  const LightNodeLanes r = load_light_node(nodes, w->node);
  const vu split = light_walk_split(w->range, left_share(t->p, t->n, t->both_sides, r));
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
  TreeChoice c = {t.walk.first, range * t.walk.unit, min_f(word_to_float(t.rest) / range, (vf)(1.0f - 0x1p-24f))};
  return c;
}

/// Chooses a light for each wanted lane, as tree_search.
EK_FN TreeChoice choose_in_tree(global const LightNode* nodes, uint light_count, float scale, LitPoint lit, vi wanted, vu word,
                                vu more) {
  TreeSearch t = tree_search(light_count, scale, lit, wanted, word, more);
  while (ANY(t.walk.open)) tree_search_step(nodes, &t);
  return tree_search_end(t);
}

/// Probability that choose_in_tree takes that light.
EK_FN vf probability_in_tree(global const LightNode* nodes, uint light_count, float scale, LitPoint lit, vi wanted, vu light) {
  const v3 p = scale3(lit.p, (vf)(scale)), n = facing_normal(lit.facing);
  const vi both_sides = (lit.facing & FACING_BOTH_SIDES) != 0u;
  LightWalk w = light_walk(wanted, light_count);
  while (ANY(w.open)) {
    const vi walked = w.open;  // lanes that have arrived must not change: others walk on, or none do
    const LightNodeLanes r = load_light_node(nodes, w.node);
    const vu split = light_walk_split(w.range, left_share(p, n, both_sides, r));
    light_walk_go(&w, light < w.first + (r.link & ~LIGHT_TREE_RIGHT_IS_LIGHT), split, r.link);
    light_walk_widen(&w, walked & (w.range < LIGHT_WALK_NARROW));
  }
  return word_to_float(w.range) * w.unit;
}

#endif
