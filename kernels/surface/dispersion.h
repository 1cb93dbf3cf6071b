// SPDX-License-Identifier: Apache-2.0
// Glass whose index differs between R, G and B [KHR_materials_dispersion]. A path that meets it
// goes on in one channel, chosen with a probability in proportion to what it carries there, and
// divided by that: exact in the mean. From there on it has only that channel, so that the next
// choice is the same.
#ifndef EK_DISPERSION_H
#define EK_DISPERSION_H
#include "surface/material.h"

/// Leaves one channel of beta where the surface disperses, and gives the material its index there.
/// u  [0, 1); front: the surface's front was hit
EK_FN void disperse(HitMaterial hit, vi front, vf u, MaterialLanes* m, v3* beta) {
  const vi disperses = (hit.spread > 0.0f) | (hit.other_spread > 0.0f);
  const v3 carried = abs3(*beta);
  const vf sum = (carried.x + carried.y) + carried.z, place = u * sum;
  // Rounding must not choose a channel that carries nothing.
  const vi blue = (place >= carried.x + carried.y) & (carried.z > 0.0f);
  const vi green = (place >= carried.x) & !blue & (carried.y > 0.0f);
  const vi red = !(blue | green);
  const vf zero = (vf)(0.0f);
  const v3 one_channel = V3(red ? copysign_f(sum, beta->x) : zero, green ? copysign_f(sum, beta->y) : zero,
                            blue ? copysign_f(sum, beta->z) : zero);
  const vf ior = hit.ior + (blue ? hit.spread : red ? -hit.spread : zero);
  const vf other = hit.other_ior + (blue ? hit.other_spread : red ? -hit.other_spread : zero);
  *beta = select3(disperses, one_channel, *beta);
  m->eta = disperses ? (front ? div_f(ior, other) : div_f(other, ior)) : m->eta;
}

#endif
