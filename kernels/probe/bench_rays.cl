// SPDX-License-Identifier: Apache-2.0
// The rays of `bench rays`, made by the functions that render. A work-item makes EK_WIDTH of them.
#include "film/camera.h"
#include "surface/instance_surface.h"
#include "lights/light.h"
#include "lanes/sampler.h"
#if EK_HAS_shape
#include "shapes/shape_surface.h"
#endif
#include "surface/surface.h"
#include "traverse/ray.h"
#include "lanes/warp.h"

/// Rays as arrays of `stride` words (trace_rays.cl).
typedef struct {
  global float* words;
  uint stride;
} RayTable;

typedef struct {
  v3 origin, dir;
  vf t_max;
  RayEnds ends;
} BenchRay;

/// Stores EK_WIDTH rays from row i on.
EK_FN void store_ray(RayTable table, uint i, BenchRay ray) {
  global float* row = table.words + i;
  const uint stride = table.stride;
  store_f(row, ray.origin.x);
  store_f(row + stride, ray.origin.y);
  store_f(row + 2 * stride, ray.origin.z);
  store_f(row + 3 * stride, ray.dir.x);
  store_f(row + 4 * stride, ray.dir.y);
  store_f(row + 5 * stride, ray.dir.z);
  store_f(row + 6 * stride, ray.t_max);
  store_f(row + 7 * stride, AS_F(ray.ends.origin_prim));
  store_f(row + 8 * stride, AS_F(ray.ends.target_prim));
  store_f(row + 9 * stride, (vf)(0.0f));
}

/// Blocks of 4 x 4 pixels, 16 rays each, spread over the whole picture however many rays there are.
typedef struct {
  uint per_row, count;
} PixelBlocks;

/// Camera rays. i: first row of EK_WIDTH
EK_FN_ONCE void bench_camera_run(constant Frame* frame, RayTable rays, uint ray_count, PixelBlocks blocks, uint i) {
  const uint groups = (ray_count + 15u) / 16u, block = (uint)((ulong)(i / 16u) * blocks.count / groups);
  const vu ray = (vu)(i) + LANE_INDEX;
  const vu x = (block % blocks.per_row) * 4u + (ray & 3u), y = (block / blocks.per_row) * 4u + ((ray >> 2) & 3u);
  FilmPoint point = {.x = TO_F(AS_I(x)), .y = TO_F(AS_I(y))};
  sample_2d(hash_bits(ray), (vu)(0u), DIM_FILTER, &point.u, &point.v);
  const CameraRay camera = camera_ray(frame, still_camera(frame), point, hash_bits(ray), (vu)(0u));
  const BenchRay out = {camera.origin, camera.dir, EK_INFINITY, unknown_ends()};
  store_ray(rays, i, out);
}

kernel void bench_camera(constant Frame* frame, global float* rays, uint ray_count, uint stride, uint blocks_x,
                         uint blocks) {
  const RayTable table = {rays, stride};
  const PixelBlocks all = {blocks_x, blocks};
  bench_camera_run(frame, table, ray_count, all, (uint)get_global_id(0) * EK_WIDTH);
}

/// Rays with their hits, and the rays that leave there; all tables have one stride.
typedef struct {
  global const float* rays;
  global const float* hits;
  RayTable diffuse, shadow;
} ScatterTables;

typedef struct {
  vi live;
  v3 p, p_error, n;  // n: to the ray's side
} BenchHit;

EK_FN BenchHit bench_hit(SceneData scene, ScatterTables tables, uint i) {
  const uint stride = tables.diffuse.stride;
  global const float* ray = tables.rays + i;
  global const float* row = tables.hits + i;
  const vu triangle = load_u((global const uint*)row + 3 * stride);
  BenchHit hit;
  hit.live = triangle != EK_NO_HIT;
  const v3 dir = V3(load_f(ray + 3 * stride), load_f(ray + 4 * stride), load_f(ray + 5 * stride));
  TriangleLanes corners = load_triangle(scene.triangles, hit.live ? triangle : (vu)(0u));
#if EK_HAS_instance
  const vu instance = load_u((global const uint*)row + 4 * stride);
  corners = instance_triangle(hit_instance(scene, hit.live ? instance : (vu)(0u)), corners);
#endif
  const vf t = load_f(row), u = load_f(row + stride), v = load_f(row + 2 * stride);
  Surface surface = surface_at(corners, u, v, scale3(dir, t));
#if EK_HAS_shape
  const v3 from = V3(load_f(ray), load_f(ray + stride), load_f(ray + 2 * stride));
  shape_surface(scene, corners, u, from, dir, t, &surface);
#endif
  hit.p = surface.p;
  hit.p_error = surface.p_error;
  hit.n = select3(dot3(surface.n_geom, dir) < 0.0f, surface.n_geom, neg3(surface.n_geom));
  return hit;
}

/// A ray that leaves a hit in direction dir, not towards a known surface; t_max 0 where nothing was
/// hit, which is no ray.
EK_FN BenchRay bench_leaving(BenchHit hit, v3 dir, RayEnds ends) {
  const vf t_max = hit.live ? EK_INFINITY : (vf)(0.0f);
  const BenchRay ray = {offset_ray_origin(hit.p, hit.p_error, hit.n, dir), dir, t_max, ends};
  return ray;
}

/// From each hit a cosine-distributed ray, and a shadow ray to a light, or in any direction where
/// the scene has no lights.
EK_FN_ONCE void bench_scatter_run(constant Frame* frame, SceneData scene, LightData light_data, ScatterTables tables,
                                  uint i) {
  const BenchHit hit = bench_hit(scene, tables, i);
  RayEnds ends = unknown_ends();
  if (!EK_HAS_instance) ends.origin_prim = load_u((global const uint*)tables.hits + 3 * tables.diffuse.stride + i);
  const Basis basis = basis_around(hit.n);
  const vu key = hash_bits((vu)(i) + LANE_INDEX);
  vf u, v;
  sample_2d(key, (vu)(0u), bounce_dimension(1, DIM_SCATTER), &u, &v);
  store_ray(tables.diffuse, i, bench_leaving(hit, to_world(basis, warp_cosine_hemisphere(u, v)), ends));
  if (frame->light_count == 0) {
    store_ray(tables.shadow, i, bench_leaving(hit, warp_uniform_sphere(u, v), ends));
    return;
  }
  const v3 above = offset_ray_origin(hit.p, hit.p_error, hit.n, hit.n);
  const LightWords words = light_words(key, (vu)(0u), 1, 0);
  const LightQuery query = {
      .context = {above, pack_normal(hit.n, (vi)(0))}, .wanted = hit.live, .words = words};
  const PickedLight picked = pick_light(frame, light_data, query);
  const LightViewer viewer = {.basis = basis, .both_sides = (vi)(0)};
  const LightSample light = light_sample(frame, light_data, picked, viewer, words);
  const LightRay path = light_ray(light, hit.p, hit.p_error, hit.n);
  const vi arrives = hit.live & (path.pdf > 0.0f) & (dot3(path.wi, hit.n) > 0.0f);
  if (!EK_HAS_instance) ends.target_prim = path.target_prim;
  const BenchRay shadow = {path.origin, path.dir, arrives ? path.t_max : (vf)(0.0f), ends};
  store_ray(tables.shadow, i, shadow);
}

kernel void bench_scatter(constant Frame* frame, global const Triangle* triangles EK_SHAPE_ARGUMENTS,
                          EK_LIGHT_ARGUMENTS, global const float* rays, global const float* hits, global float* diffuse_rays,
                          global float* shadow_rays, uint stride) {
  const LightData light_data = EK_LIGHT_DATA;
  const SceneData scene = {.triangles = triangles EK_SHAPE_DATA};
  const ScatterTables tables = {rays, hits, {diffuse_rays, stride}, {shadow_rays, stride}};
  bench_scatter_run(frame, scene, light_data, tables, (uint)get_global_id(0) * EK_WIDTH);
}
