// SPDX-License-Identifier: Apache-2.0
// Probes of light paths that start from shapes, behind the text of probes.cl.
#include "lights/light_path.h"
#include "traverse/ray.h"
#include "traverse/shape_hit.h"

#if EK_HAS_light_paths
// Inputs: two words that choose the light and the place on it, three random numbers. Outputs: the
// record of the surface that the light path leaves, its origin, its direction, and the first
// component of its throughput.
EK_FN_ONCE void probe_emitted_path_run(PROBE_ITEMS, constant Frame* frame, SceneData scene, LightData lights) {
  const AliasSample choice =
      alias_table_sample(lights.light_paths.emission_alias_table, frame->emission_light_count, IN_U(0), IN_U(1));
  const LightWords unused = {(vu)(0u), (vu)(0u), (vu)(0u), (vu)(0u), 0u};
  const EmittedPath path = emit_light_path(frame, scene, lights, choice, IN_3(2), unused);
  OUT_U(0, path.triangle);
  OUT_3(1, path.origin);
  OUT_3(4, path.dir);
  OUT_F(7, path.throughput.x);
}
kernel void probe_emitted_path(PROBE_ARGUMENTS, constant Frame* frame, EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  const LightData light_data = EK_LIGHT_DATA;
  probe_emitted_path_run(PROBE_PASSED, frame, scene, light_data);
}

// Inputs: the record of a shape, origin and direction of a ray. Outputs: whether the ray meets the
// shape, where, the normal there, and the density per m^2 with which light paths start there, as a
// path from the camera that meets it takes it.
EK_FN_ONCE void probe_start_density_run(PROBE_ITEMS, constant Frame* frame, SceneData scene, LightData lights) {
  const vu record = IN_U(0);
  const v3 origin = IN_3(1), dir = IN_3(4);
  const OpacityKey key = {(vu)(0u), (vu)(0u)};
  const RayLanes ray = ray_lanes(frame, origin, dir, key);
  const TriangleLanes corners = load_triangle(scene.triangles, record);
  const vu index = AS_U(corners.n.x);
  const ShapeHit hit = shape_hit(scene, &ray, ALL_LANES, record, index, corners.p0, corners.p1, EK_INFINITY);
  Surface surface = {origin, origin, origin};
  const ShapePoint at = shape_surface(scene, corners, hit.part, origin, dir, hit.t, &surface);
  const ShapeView view = shape_view_of_all(load_shape(scene.shapes, index), load_shape_world(scene.shapes, index));
  OUT_U(0, hit.hit ? (vu)(1u) : (vu)(0u));
  OUT_3(1, surface.p);
  OUT_3(4, surface.n_geom);
  OUT_F(7, start_pdf_m2(lights, corners.flags >> EK_TRIANGLE_LIGHT_SHIFT, shape_pdf_m2(view, at, hit.part)));
}
kernel void probe_start_density(PROBE_ARGUMENTS, constant Frame* frame, EK_SCENE_ARGUMENTS, EK_LIGHT_ARGUMENTS) {
  const SceneData scene = EK_SCENE_DATA;
  const LightData light_data = EK_LIGHT_DATA;
  probe_start_density_run(PROBE_PASSED, frame, scene, light_data);
}
#endif
