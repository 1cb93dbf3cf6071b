// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>

#include "scene/scene.h"

namespace eikon {

/// The texture coordinates that tangents are made from.
struct TangentSource {
  std::size_t uv_set = 0;
  // Rows of the linear map from them to the image whose axes the tangents follow; it has an
  // inverse.
  std::array<float, 4> image_from_uv{1, 0, 0, 1};
};

/// Makes the tangents of a primitive from its positions, normals and texture coordinates, as the
/// bakers of normal maps do. A vertex at which they differ becomes several; the
/// order of the triangles stays. Without normals the tangents lie in the triangles.
///
/// The frame at a corner is the mean, weighted by the angle there, over the triangles that share
/// its position, normal and texture coordinates, hang together by edges and do not mirror the
/// texture against each other. w is 1 where the texture is seen from its front: the bitangent
/// cross(normal, tangent) w points to the top of the image.
///
/// source: [Mikkelsen 2008, "Simulation of wrinkled surfaces revisited", section 4.4 and appendix
/// A] with the choices of his reference code (MikkTSpace), at its default that no angle between
/// tangents splits a group. Triangles whose texture coordinates are degenerate take the frame of
/// their neighbours, those whose corners coincide that of a good corner there. Where nothing is
/// left to take, the tangent is the x axis brought into the plane of the normal (in his code the x
/// axis itself, which may be the normal), and w is 1.
/// at_rest  positions, normals and triangles as they are in the file, if morph targets or joints
///          have moved `primitive`; null: it stands as it is there. Which triangles share a tangent
///          is decided at rest, so a vertex becomes the same ones in every pose. A triangle of
///          `primitive` may have its last two corners exchanged.
/// throws InputError above 2^32 corners
void make_tangents(Primitive& primitive, const TangentSource& source, const Primitive* at_rest = nullptr);

/// Refuses what make_tangents refuses, and sets tangents of 0: for those who only want to know that
/// there are some.
void mark_tangents(Primitive& primitive);

}  // namespace eikon
