// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>

#include "scene/scene.h"

namespace eikon {

/// Makes the tangents of a primitive from its positions, normals and set `uv_set` of texture
/// coordinates, as the bakers of normal maps do. A vertex at which they differ becomes several; the
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
/// image_from_uv  rows of the linear map from the texture coordinates to the image whose axes the
///                tangents follow; it has an inverse
/// throws InputError above 2^32 corners
void make_tangents(Primitive& primitive, std::size_t uv_set, const std::array<float, 4>& image_from_uv = {1, 0, 0, 1});

/// Refuses what make_tangents refuses, and sets tangents of 0: for those who only want to know that
/// there are some.
void mark_tangents(Primitive& primitive);

}  // namespace eikon
