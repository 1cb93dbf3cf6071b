// SPDX-License-Identifier: Apache-2.0
// Sampling of cylinders, cones and capsules by area: a part by its area in the world, where the
// side counts with what is visible of it from outside.
#ifndef EK_LIGHT_SHAPE_ROUND_H
#define EK_LIGHT_SHAPE_ROUND_H
#include "lights/shape_view.h"

// A side of radius a + b y between low and high. `seen`: the visible angle about the Y axis, in
// turns, to each side of the direction to the viewpoint.
typedef struct {
  vf a, b, low, high, seen;
} SideView;

// The tangent plane at the angle phi faces the viewpoint where distance * cos phi > a + b y, with y
// of the viewpoint.
EK_FN vf side_seen(ShapeView view, vf a, vf b) {
  const vf radius = a + b * view.from.y;
  const vf distance = sqrt_f(view.from.x * view.from.x + view.from.z * view.from.z);
  const vf beyond = max_f((distance - radius) * (distance + radius), (vf)(0.0f));
  return atan2_turns(sqrt_f(beyond), radius);
}

EK_FN vi side_holds(ShapeView view, vf a, vf b, vf low, vf high) {
  const vf distance = sqrt_f(view.from.x * view.from.x + view.from.z * view.from.z), slack = view.slack.x + view.slack.z;
  return (distance <= a + b * view.from.y + slack) & (view.from.y >= low - view.slack.y) & (view.from.y <= high + view.slack.y);
}

// Uniform by area: the squared radius is uniform between those of the ends.
EK_FN v3 side_choose(ShapeView view, SideView side, vf u, vf v) {
  const vf first = max_f(side.a + side.b * side.low, (vf)(0.0f)), last = max_f(side.a + side.b * side.high, (vf)(0.0f));
  const vf radius = sqrt_f((first * first) * (1.0f - v) + (last * last) * v), sum = radius + first;
  const vf y = sum > 0.0f ? side.low + div_f(v * (side.high - side.low) * (first + last), sum) : side.low;
  const vf distance = sqrt_f(view.from.x * view.from.x + view.from.z * view.from.z);
  const vi off_axis = distance > 0.0f;
  const vf x = off_axis ? div_f(view.from.x, distance) : (vf)(1.0f), z = off_axis ? div_f(view.from.z, distance) : (vf)(0.0f);
  vf s, c;
  sincos_2pi((2.0f * u - 1.0f) * side.seen, &s, &c);
  return V3(radius * (x * c - z * s), y, radius * (z * c + x * s));
}

EK_FN vf side_density(SideView side) {
  const vf ends = (side.a + side.b * side.low) + (side.a + side.b * side.high);
  return div_f(EK_INV_2PI, side.seen * ends * (side.high - side.low) * sqrt_f(1.0f + side.b * side.b));
}

// The one of three parts that u selects by their shares. u: rescaled to [0, 1) for reuse
EK_FN vf part_chosen(v3 share, vf* u) {
  const vf at = *u * ((share.x + share.y) + share.z), two = share.x + share.y;
  const vi first = (at < share.x) | !((share.y > 0.0f) | (share.z > 0.0f));
  const vi second = (at < two) | !(share.z > 0.0f);
  *u = first ? rest_of(at, (vf)(0.0f), share.x) : second ? rest_of(at, share.x, share.y) : rest_of(at, two, share.z);
  return first ? (vf)(0.0f) : second ? (vf)(1.0f) : (vf)(2.0f);
}
EK_FN vf part_share(v3 share, vf part) {
  const vf mine = part == 0.0f ? share.x : part == 1.0f ? share.y : share.z;
  const vf all = (share.x + share.y) + share.z;
  return all > 0.0f ? div_f(mine, all) : (vf)(0.0f);
}

EK_FN v3 cylinder_shares(ShapeView view, SideView* side) {
  const vf a = view.shape.a, b = view.shape.b, zero = (vf)(0.0f), most = 1.0f + view.slack.y;
  const vi inside = side_holds(view, a, b, (vf)(-1.0f), (vf)(1.0f));
  const SideView all = {a, b, (vf)(-1.0f), (vf)(1.0f), inside ? (vf)(0.5f) : side_seen(view, a, b)};
  *side = all;
  return V3(view.part_m2.x * (2.0f * side->seen), (inside | (view.from.y < -most)) ? view.part_m2.y : zero,
            (inside | (view.from.y > most)) ? view.part_m2.z : zero);
}

EK_FN ShapeChoice cylinder_choose(ShapeView view, vf u, vf v) {
  SideView side;
  const v3 shares = cylinder_shares(view, &side);
  ShapeChoice choice;
  choice.part = part_chosen(shares, &u);
  const vf y = choice.part == 2.0f ? (vf)(1.0f) : (vf)(-1.0f), radius = side.a + side.b * y;
  const DiskPoint disk = warp_disk(u, v);
  choice.p = select3(choice.part == 0.0f, side_choose(view, side, u, v), V3(radius * disk.x, y, radius * disk.y));
  return choice;
}

EK_FN vf cylinder_density(ShapeView view, ShapePoint at, vf part) {
  SideView side;
  const v3 shares = cylinder_shares(view, &side);
  const vf radius = side.a + (part == 2.0f ? side.b : -side.b);
  const vf density = part == 0.0f ? side_density(side) : div_f(EK_INV_PI, radius * radius);
  const vf mine = part_share(shares, part);
  return mine > 0.0f ? density_sr_from_area(view, at.p, at.out, mine * density) : (vf)(0.0f);
}

// Normals on the upper sphere's cap have y above this, those on the lower one's cap below it. Where
// one sphere contains the other, the smaller has no cap.
EK_FN vf capsule_rim(ShapeLanes s, CapsuleSide side) {
  return side.there ? side.tilt : s.b > s.c ? (vf)(-1.0f) : (vf)(1.0f);
}

EK_FN vi ball_holds(ShapeView view, vf y, vf radius) {
  const v3 d = V3(view.from.x, view.from.y - y, view.from.z);
  const vf most = radius + 2.0f * max_component(view.slack);
  return dot3(d, d) < most * most;
}

EK_FN v3 capsule_shares(ShapeView view, CapsuleSide cone, SideView* side) {
  const ShapeLanes s = view.shape;
  const vi inside = side_holds(view, cone.a, cone.b, cone.low, cone.high) | ball_holds(view, s.a, s.b) | ball_holds(view, -s.a, s.c);
  const SideView all = {cone.a, cone.b, cone.low, cone.high, inside ? (vf)(0.5f) : side_seen(view, cone.a, cone.b)};
  *side = all;
  return V3(view.part_m2.x * (2.0f * side->seen), view.part_m2.y, view.part_m2.z);
}

EK_FN ShapeChoice capsule_choose(ShapeView view, vf u, vf v) {
  const ShapeLanes s = view.shape;
  const CapsuleSide cone = capsule_side(s);
  SideView side;
  const v3 shares = capsule_shares(view, cone, &side);
  ShapeChoice choice;
  choice.part = part_chosen(shares, &u);
  const vi upper = choice.part == 2.0f;
  const vf rim = capsule_rim(s, cone), y = upper ? rim + (1.0f - rim) * v : (1.0f + rim) * v - 1.0f;
  const vf radius = upper ? s.b : s.c, round = radius * sqrt_f(max_f((1.0f - y) * (1.0f + y), (vf)(0.0f)));
  vf sine, cosine;
  sincos_2pi(u, &sine, &cosine);
  const v3 ball = V3(round * cosine, (upper ? s.a : -s.a) + radius * y, round * sine);
  choice.p = select3(choice.part == 0.0f, side_choose(view, side, u, v), ball);
  return choice;
}

EK_FN vf capsule_density(ShapeView view, ShapePoint at, vf part) {
  const ShapeLanes s = view.shape;
  const CapsuleSide cone = capsule_side(s);
  SideView side;
  const v3 shares = capsule_shares(view, cone, &side);
  const vf rim = capsule_rim(s, cone), radius = part == 2.0f ? s.b : s.c;
  const vf ball = div_f(EK_INV_2PI, (radius * radius) * (part == 2.0f ? 1.0f - rim : 1.0f + rim));
  const vf mine = part_share(shares, part);
  return mine > 0.0f ? density_sr_from_area(view, at.p, at.out, mine * (part == 0.0f ? side_density(side) : ball)) : (vf)(0.0f);
}

#endif
