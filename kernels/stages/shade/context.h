// SPDX-License-Identifier: Apache-2.0
// What the steps of stage `shade` are given, and what they hand to each other. A step is an inlined
// function; its arguments are pointers so that nothing is copied before the compiler has inlined
// it.
#ifndef EK_SHADE_CONTEXT_H
#define EK_SHADE_CONTEXT_H
#include "lights/light.h"
#include "stages/wavefront.h"
#include "surface/material.h"
#include "surface/surface.h"
#if EK_HAS_shape
#include "shapes/shape_surface.h"
#endif

/// The same for all vectors of paths.
typedef struct {
  StageContext stage;
  SceneData scene;
  LightData lights;
  uint depth;
} ShadeContext;

/// A vector of paths, and the point of a surface that each has hit.
typedef struct {
  vi live;         // mask of the lanes that hit something
  PathState path;  // as it arrives
  vf t, u, v;      // distance along path.dir, and the hit's weights of corners p1 and p2
  vu triangle;     // some valid one where a lane hit nothing
  TriangleLanes corners;
  Surface surface;
  vi front;        // mask: the front side was hit
  vi is_flat_lambert;  // mask: the surface is of class SHADING_FLAT_LAMBERT
  // 0: all live lanes hit class SHADING_FLAT_LAMBERT, so that attributes and shading normals change
  // nothing.
  int needs_attributes;
  HitAttributes attributes;
#if EK_HAS_shape
  ShapePoint on_shape;
#endif
} PathHit;

/// The media at a hit; 0 where no solid of the scene absorbs or overlaps another. A medium is
/// 1 + the index of a material, or a list of ranks (medium.h, nested_media.h); 0 is the vacuum.
typedef struct {
  vu medium;                // on the side that the path comes from
  vu transmitted_medium;    // on the other side
  vi is_null;               // mask: the path passes straight on (nested_media.h, alpha.h)
  vi skips_depth;           // mask: a null interface that does not count towards max_depth
  vu null_interface_count;  // of the path so far
#if EK_HAS_open_solid
  vi is_opening;            // mask: it is the opening of a solid, beyond which the medium is another
#endif
} MediumInterface;

/// The point of a hit as direct light and scattering see it; all lies on the viewer's side of the
/// surface.
typedef struct {
  vi live;         // mask of the lanes whose path may scatter here
  vi is_flat_lambert;
  int needs_attributes;  // as PathHit's
  vi both_sides;   // mask: light from below the horizon of n_shade counts too
  vu path, key, index, triangle;
#if EK_HAS_moving_surface | EK_HAS_moving_light
  vf time;         // as PathState's
#endif
  v3 beta;         // throughput up to this point
  v3 p, p_error, n_geom, n_shade;  // world; bound of p's error per axis
  Basis basis;     // around n_shade
  v3 wo;           // to the viewer, local
  MaterialLanes material;
  MediumInterface interface;
  LightSampleContext light_context;  // the point as the light tree knows it
#if EK_HAS_light_paths
  vi faces_away;   // mask: the shading normal faced away from the viewer before usable_normal bent it
  vf sampled_light_ratio;  // by which light sampling shares its light with light paths (light_ratio.h)
#endif
#if EK_USES_GUIDE
  vi is_guided;      // mask: the guide's tables apply to the surface,
  vi is_diffuse;     // and what leaves it is their mean light times the albedo
  CellKey cell_key;
  vf expected;       // luminance that the pilot expects of the path; 0: not known yet
#endif
#if EK_HAS_path_log
  vf transmitted;    // share of the luminance that the medium on the way here leaves
#endif
} ShadingPoint;

#endif
