// SPDX-License-Identifier: Apache-2.0
// The rays of `bench rays`, made by the functions that render: one work-item for EK_WIDTH of them. Arrays as in trace_rays.cl.
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

EK_FN void store_ray(global float* rays, uint stride, uint i, v3 origin, v3 dir, vf t_max, RayEnds ends) {
  store_f(rays + i, origin.x);
  store_f(rays + stride + i, origin.y);
  store_f(rays + 2 * stride + i, origin.z);
  store_f(rays + 3 * stride + i, dir.x);
  store_f(rays + 4 * stride + i, dir.y);
  store_f(rays + 5 * stride + i, dir.z);
  store_f(rays + 6 * stride + i, t_max);
  store_f(rays + 7 * stride + i, AS_F(ends.origin_prim));
  store_f(rays + 8 * stride + i, AS_F(ends.target_prim));
}

// Camera rays, 16 for a block of 4 x 4 pixels; the blocks are spread over the whole picture, however many rays there are.
// blocks_x: blocks per row; blocks: in all; i: of the first ray of EK_WIDTH.
EK_FN_ONCE void bench_camera_run(constant Frame* frame, global float* rays, uint ray_count, uint stride, uint blocks_x, uint blocks,
                                 uint i) {
  const uint groups = (ray_count + 15u) / 16u, block = (uint)((ulong)(i / 16u) * blocks / groups);
  const vu ray = (vu)(i) + LANE_INDEX;
  const vu x = (block % blocks_x) * 4u + (ray & 3u), y = (block / blocks_x) * 4u + ((ray >> 2) & 3u);
  vf u, v;
  sample_2d(hash_bits(ray), (vu)(0u), DIM_FILTER, &u, &v);
  const CameraRay camera = camera_ray(frame, TO_F(AS_I(x)), TO_F(AS_I(y)), u, v, hash_bits(ray), (vu)(0u));
  store_ray(rays, stride, i, camera.origin, camera.dir, EK_INFINITY, unknown_ends());
}

kernel void bench_camera(constant Frame* frame, global float* rays, uint ray_count, uint stride, uint blocks_x, uint blocks) {
  bench_camera_run(frame, rays, ray_count, stride, blocks_x, blocks, (uint)get_global_id(0) * EK_WIDTH);
}

// From each hit a ray by the cosine, and a shadow ray to a light; in a scene without lights in any direction. A shadow ray with
// t_max 0 is none; where nothing was hit, neither is one.
EK_FN_ONCE void bench_scatter_run(constant Frame* frame, SceneData scene, LightData light_data, global const float* rays,
                                  global const float* hits, global float* diffuse_rays, global float* shadow_rays, uint stride, uint i) {
  const vu hit = load_u((global const uint*)hits + 3 * stride + i);
  const vi live = hit != EK_NO_HIT;
  RayEnds ends = unknown_ends();
  if (!EK_HAS_instance) ends.origin_prim = hit;
  const v3 dir = V3(load_f(rays + 3 * stride + i), load_f(rays + 4 * stride + i), load_f(rays + 5 * stride + i));
  TriangleLanes corners = load_triangle(scene.triangles, live ? hit : (vu)(0u));
#if EK_HAS_instance
  corners = placed_triangle(hit_place(scene, live ? load_u((global const uint*)hits + 4 * stride + i) : (vu)(0u)), corners);
#endif
  Surface surface =
      surface_at(corners, load_f(hits + stride + i), load_f(hits + 2 * stride + i), scale3(dir, load_f(hits + i)));
#if EK_HAS_shape
  const v3 from = V3(load_f(rays + i), load_f(rays + stride + i), load_f(rays + 2 * stride + i));
  shape_surface(scene, corners, load_f(hits + stride + i), from, dir, load_f(hits + i), &surface);
#endif
  const v3 n = select3(dot3(surface.n_geom, dir) < 0.0f, surface.n_geom, neg3(surface.n_geom));
  const Basis basis = basis_around(n);

  const vu key = hash_bits((vu)(i) + LANE_INDEX);
  vf u, v;
  sample_2d(key, (vu)(0u), bounce_dimension(1, DIM_SCATTER), &u, &v);
  const v3 scattered = to_world(basis, warp_cosine_hemisphere(u, v));
  store_ray(diffuse_rays, stride, i, offset_ray_origin(surface.p, surface.p_error, n, scattered), scattered,
            live ? EK_INFINITY : (vf)(0.0f), ends);

  if (frame->light_count > 0) {
    const LightWords words = light_words(key, (vu)(0u), 1, 0);
    const LightQuery query = {.context = {offset_ray_origin(surface.p, surface.p_error, n, n), pack_normal(n, (vi)(0))},
                              .wanted = live,
                              .words = words};
    const LightSample light = light_sample(frame, light_data, pick_light(frame, light_data, query), basis, (vi)(0), words);
    const LightPath path = light_path(light, surface.p, surface.p_error, n);
    const vi arrives = live & (path.pdf > 0.0f) & (dot3(path.wi, n) > 0.0f);
    if (!EK_HAS_instance) ends.target_prim = path.goal;
    store_ray(shadow_rays, stride, i, path.origin, path.dir, arrives ? path.t_max : (vf)(0.0f), ends);
  } else {
    const v3 away = warp_uniform_sphere(u, v);
    store_ray(shadow_rays, stride, i, offset_ray_origin(surface.p, surface.p_error, n, away), away,
              live ? EK_INFINITY : (vf)(0.0f), ends);
  }
}

kernel void bench_scatter(constant Frame* frame, global const Triangle* triangles EK_SHAPE_ARGUMENTS, EK_LIGHT_ARGUMENTS,
                          global const float* rays, global const float* hits, global float* diffuse_rays,
                          global float* shadow_rays, uint stride) {
  const LightData light_data = EK_LIGHT_DATA;
  const SceneData scene = {.triangles = triangles EK_SHAPE_DATA};
  bench_scatter_run(frame, scene, light_data, rays, hits, diffuse_rays, shadow_rays, stride, (uint)get_global_id(0) * EK_WIDTH);
}
