// SPDX-License-Identifier: Apache-2.0
// Embree as an outside opinion on hits and on the quality of trees.
#ifdef EIKON_EMBREE
#include <embree3/rtcore.h>
#include <gtest/gtest.h>

#include <memory>

#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

using fixtures::Soup;

/// A committed Embree scene in its robust mode.
class EmbreeScene {
 public:
  explicit EmbreeScene(const Soup& soup) : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    const std::size_t vertices = soup.size() / 3;
    auto* positions = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(unsigned), vertices / 3));
    std::copy(soup.begin(), soup.end(), positions);
    for (std::size_t i = 0; i < vertices; ++i) indices[i] = static_cast<unsigned>(i);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  [[nodiscard]] ProbeHit closest(const ProbeRay& ray) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit query{};
    query.ray.org_x = ray.o[0], query.ray.org_y = ray.o[1], query.ray.org_z = ray.o[2];
    query.ray.dir_x = ray.d[0], query.ray.dir_y = ray.d[1], query.ray.dir_z = ray.d[2];
    query.ray.tfar = INFINITY;
    query.ray.mask = ~0U;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {INFINITY, 0, 0, EK_NO_HIT};
    return {query.ray.tfar, query.hit.u, query.hit.v, query.hit.primID};
  }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

TEST(TraverseEmbree, hits_are_those_of_embree_within_its_precision) {
  Device& device = *test::devices().front();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (const Soup& soup : {fixtures::scattered(3000, 1.0F, 2), fixtures::bumpy_sphere(40)}) {
    std::vector<ProbeRay> rays(100'000);
    for (ProbeRay& ray : rays) {
      for (float& x : ray.o) x = 1.5F * unit(random);
      for (float& x : ray.d) x = unit(random);
    }
    const EmbreeScene scene(soup);
    TraverseProbe probe(device, soup, {"bvh8"});
    const auto hits = probe.closest(rays);
    std::size_t agree = 0, hit_count = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const ProbeHit other = scene.closest(rays[i]);
      hit_count += other.triangle != EK_NO_HIT ? 1 : 0;
      const bool same_place = other.triangle != EK_NO_HIT && std::abs(hits[i].t - other.t) <= 1e-5F * (1.0F + other.t);
      const bool same_weights = std::abs(hits[i].u - other.u) + std::abs(hits[i].v - other.v) < 1e-2F;
      agree += hits[i].triangle == other.triangle ? (other.triangle == EK_NO_HIT || (same_place && same_weights))
                                                  : same_place;
    }
    EXPECT_GT(hit_count, rays.size() / 10);
    EXPECT_GE(static_cast<double>(agree), 0.9999 * static_cast<double>(rays.size()));
  }
}

/// SAH cost of Embree's binary tree with one triangle per leaf, relative to the root's area: sum of
/// the nodes' areas.
struct EmbreeNode {
  RTCBounds bounds[2];
  EmbreeNode* child[2];
};
double half_area(const RTCBounds& b) {
  const double x = double(b.upper_x) - b.lower_x, y = double(b.upper_y) - b.lower_y, z = double(b.upper_z) - b.lower_z;
  return x * y + y * z + z * x;
}
double inner_area(const EmbreeNode* node) {
  double sum = 0;
  for (int i = 0; i < 2; ++i) {
    if (node->child[i] != nullptr) sum += half_area(node->bounds[i]) + inner_area(node->child[i]);
  }
  return sum;
}

/// The same of ours, from the bvh2 layout with leaves of one triangle and more alike.
double our_inner_area(const Accel& accel, std::uint32_t index) {
  double sum = 0;
  const std::uint32_t* node = accel.nodes.data() + std::size_t{index} * 16;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto plane = [&](std::size_t i) { return std::bit_cast<float>(node[6 * side + i]); };
    if ((node[12 + side] & 0x80000000U) != 0) continue;
    sum += half_area({plane(0), plane(1), plane(2), 0, plane(3), plane(4), plane(5), 0}) +
           our_inner_area(accel, node[12 + side]);
  }
  return sum;
}

TEST(TraverseEmbree, trees_are_as_good_as_those_of_its_builder) {
  for (const Soup& soup : {fixtures::scattered(20'000, 1.0F, 3), fixtures::bumpy_sphere(60)}) {
    std::vector<RTCBuildPrimitive> primitives;
    for (std::size_t i = 0; i < soup.size(); i += 9) {
      const float* p = &soup[i];
      const auto lo = [&](std::size_t k) { return std::min({p[k], p[3 + k], p[6 + k]}); };
      const auto hi = [&](std::size_t k) { return std::max({p[k], p[3 + k], p[6 + k]}); };
      primitives.push_back({lo(0), lo(1), lo(2), 0, hi(0), hi(1), hi(2), static_cast<unsigned>(i / 9)});
    }
    const std::unique_ptr<RTCDeviceTy, void (*)(RTCDevice)> device(rtcNewDevice(nullptr), rtcReleaseDevice);
    const std::unique_ptr<RTCBVHTy, void (*)(RTCBVH)> bvh(rtcNewBVH(device.get()), rtcReleaseBVH);
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.bvh = bvh.get();
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = 2;
    arguments.maxDepth = 1024;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = 4;
    arguments.primitives = primitives.data();
    arguments.primitiveCount = arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = [](RTCThreadLocalAllocator allocator, unsigned, void*) -> void* {
      return new (rtcThreadLocalAlloc(allocator, sizeof(EmbreeNode), 16)) EmbreeNode{};
    };
    arguments.setNodeChildren = [](void* node, void** children, unsigned, void*) {
      for (int i = 0; i < 2; ++i) static_cast<EmbreeNode*>(node)->child[i] = static_cast<EmbreeNode*>(children[i]);
    };
    arguments.setNodeBounds = [](void* node, const RTCBounds** bounds, unsigned, void*) {
      for (int i = 0; i < 2; ++i) static_cast<EmbreeNode*>(node)->bounds[i] = *bounds[i];
    };
    arguments.createLeaf = [](RTCThreadLocalAllocator, const RTCBuildPrimitive*, size_t, void*) -> void* {
      return nullptr;
    };
    const auto* root = static_cast<const EmbreeNode*>(rtcBuildBVH(&arguments));
    AccelOptions options;
    options.layout = "bvh2";
    const Accel ours = build_accel({soup}, options);
    EXPECT_LT(our_inner_area(ours, 0), 1.1 * inner_area(root));
    options.rays = 1e12;
    const Accel better = build_accel({soup}, options);
    EXPECT_LE(our_inner_area(better, 0), our_inner_area(ours, 0));
  }
}

}  // namespace
}  // namespace eikon
#endif
