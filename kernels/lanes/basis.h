// SPDX-License-Identifier: Apache-2.0
// Orthonormal bases around a direction.
#ifndef EK_BASIS_H
#define EK_BASIS_H
#include "lanes/math.h"

typedef struct { v3 x, y, z; } Basis;  // orthonormal, right-handed, world

/// A basis whose z is n (unit). source  [Duff et al. 2017, "Building an Orthonormal Basis,
/// Revisited", JCGT 6(1)]
EK_FN Basis basis_around(v3 n) {
  const vf sign = copysign_f((vf)(1.0f), n.z);
  const vf a = div_f(-1.0f, sign + n.z);
  const vf b = (n.x * n.y) * a;
  Basis basis = {V3(1.0f + (sign * n.x) * (n.x * a), sign * b, -sign * n.x), V3(b, sign + n.y * (n.y * a), -n.y), n};
  return basis;
}
/// The same basis turned about z until x lies in the direction of `along`; as it is where that has
/// none across z.
EK_FN Basis basis_along(Basis basis, v3 along) {
  const vf x = dot3(basis.x, along), y = dot3(basis.y, along);
  const vf length2 = x * x + y * y;
  const vi usable = length2 > 0x1p-40f;
  const vf inverse = div_f(1.0f, sqrt_f(usable ? length2 : (vf)(1.0f)));
  const vf c = x * inverse, s = y * inverse;
  Basis turned = basis;
  turned.x = select3(usable, add3(scale3(basis.x, c), scale3(basis.y, s)), basis.x);
  turned.y = select3(usable, sub3(scale3(basis.y, c), scale3(basis.x, s)), basis.y);
  return turned;
}
EK_FN v3 to_local(Basis basis, v3 a) { return V3(dot3(basis.x, a), dot3(basis.y, a), dot3(basis.z, a)); }
EK_FN v3 to_world(Basis basis, v3 a) {
  return add3(add3(scale3(basis.x, a.x), scale3(basis.y, a.y)), scale3(basis.z, a.z));
}

#endif
