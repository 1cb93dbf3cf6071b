// SPDX-License-Identifier: Apache-2.0

#ifdef EIKON_EMBREE
#include <embree3/rtcore.h>
#endif
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "cli/commands/bench.h"
#include "core/error.h"
#include "core/clock.h"

namespace eikon {

#ifdef EIKON_EMBREE

struct EmbreeYardstick::Impl {
  RTCDevice device;
  RTCScene scene;
  mutable tbb::task_arena arena;
  double build_s = 0;

  Impl(std::span<const Triangle> triangles, unsigned threads)
      : device(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())),
        scene(rtcNewScene(device)),
        arena(static_cast<int>(threads)) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* positions = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * triangles.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(unsigned), triangles.size()));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      std::copy_n(&triangles[i].p0_x, 9, positions + 9 * i);
      for (std::size_t k = 3 * i; k < 3 * i + 3; ++k) indices[k] = static_cast<unsigned>(k);
    }
    const double begin = host_seconds();
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    build_s = host_seconds() - begin;
  }
  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
};

EmbreeYardstick::EmbreeYardstick(std::span<const Triangle> triangles, unsigned threads)
    : impl_(std::make_unique<Impl>(triangles, threads)) {}

double EmbreeYardstick::build_s() const { return impl_->build_s; }

double EmbreeYardstick::trace(const RayArrays& rays, bool any_hit) const {
  const auto fill = [&](RTCRay& ray, std::size_t i) {
    const float* p = rays.words.data() + i;
    ray.org_x = p[0], ray.org_y = p[rays.stride], ray.org_z = p[2 * rays.stride];
    ray.dir_x = p[3 * rays.stride], ray.dir_y = p[4 * rays.stride], ray.dir_z = p[5 * rays.stride];
    ray.tnear = 0, ray.tfar = p[6 * rays.stride];
    ray.time = 0, ray.mask = ~0U, ray.id = 0, ray.flags = 0;
  };
  const double begin = host_seconds();
  impl_->arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.count, 4096), [&](const auto& range) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        if (any_hit) {
          RTCRay ray;
          fill(ray, i);
          rtcOccluded1(impl_->scene, &context, &ray);
        } else {
          RTCRayHit query;
          fill(query.ray, i);
          query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
          query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
          rtcIntersect1(impl_->scene, &context, &query);
        }
      }
    });
  });
  return host_seconds() - begin;
}

#else

struct EmbreeYardstick::Impl {};
EmbreeYardstick::EmbreeYardstick(std::span<const Triangle>, unsigned) {
  throw UsageError("--versus embree: this eikon was built without Embree; install libembree-dev and configure again");
}
double EmbreeYardstick::build_s() const { return 0; }
double EmbreeYardstick::trace(const RayArrays&, bool) const { return 0; }

#endif

EmbreeYardstick::~EmbreeYardstick() = default;

}  // namespace eikon
