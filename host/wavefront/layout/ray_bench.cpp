// SPDX-License-Identifier: Apache-2.0
#include "wavefront/layout/ray_bench.h"

#include <algorithm>

#include "device/kernel_sources.h"
#include "pack/frame.h"
#include "wavefront/buffers.h"

namespace eikon {
namespace {

constexpr std::size_t kChunk = 4096;  // rays per work-item on CPU devices, as in a render
constexpr std::size_t kArrays = 10;   // of a ray (RayArrays)

/// Drops rays with t_max 0, which mean that there is none, and pads for full vectors.
RayArrays packed(const std::vector<float>& words, std::size_t count) {
  const std::size_t from = words.size() / kArrays;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < count; ++i) {
    if (words[6 * from + i] > 0) kept.push_back(i);
  }
  RayArrays rays;
  rays.count = kept.size();
  rays.stride = (rays.count + 31) / 16 * 16;
  rays.words.resize(kArrays * rays.stride, 0.0F);
  for (std::size_t k = 0; k < kArrays; ++k) {
    for (std::size_t i = 0; i < kept.size(); ++i) rays.words[k * rays.stride + i] = words[k * from + kept[i]];
  }
  return rays;
}

const char* kernel_of(const RayKind& kind) { return kind.any_hit ? "trace_any" : "trace_closest"; }

}  // namespace

RayBench::RayBench(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
                   const Execution& execution, const RayProgram& of)
    : device_(device), config_(configure(device.info(), execution)) {
  const Accel& accel = scene.accels.at(of.layout);
  ProgramOptions options;
  options.defines = features.defines();
  // Every surface is opaque and has two sides, as it is for Embree.
  options.defines["EK_HAS_opacity"] = options.defines["EK_HAS_culling"] = "0";
  options.defines["EK_WIDTH"] = std::to_string(config_.lanes);
  options.defines["EK_CHUNKED"] = config_.chunked ? "1" : "0";
  options.defines["EK_CHUNK"] = std::to_string(chunk());
  options.defines.merge(accel.defines());
  for (const auto& [name, value] : of.defines) options.defines[name] = value;
  const Program program = device.build(kernel_text({"probe/trace_rays.cl", "probe/bench_rays.cl"}) + features.formula_code(), options);
  for (const char* name : {"trace_closest", "trace_any", "bench_camera", "bench_scatter"}) {
    kernels_[name] = program.kernel(name);
  }
  arguments_.set("frame", device.upload(std::vector<Frame>{pack_frame(scene, settings)}));
  arguments_.set("diagnostics", device.upload(std::vector<Diagnostics>(1)));
  upload_tree_and_lights(device, scene, accel, arguments_);
}

std::vector<RayKind> RayBench::make_rays(const Settings& settings, std::uint32_t count) {
  const std::size_t stride = (count + 31) / 16 * 16;
  const std::uint32_t blocks_x = std::max(settings.width / 4, 1U), blocks_y = std::max(settings.height / 4, 1U);
  const std::size_t bytes = kArrays * sizeof(float) * stride;
  const Buffer camera = device_.allocate(bytes), diffuse = device_.allocate(bytes), shadow = device_.allocate(bytes),
               hits = device_.allocate(20 * stride);
  for (const Buffer& buffer : {camera, diffuse, shadow, hits}) device_.fill_zero(buffer);
  arguments_.set("rays", camera);
  arguments_.set("hits", hits);
  arguments_.set("diffuse_rays", diffuse);
  arguments_.set("shadow_rays", shadow);
  arguments_.set("stride", std::uint32_t(stride));
  arguments_.set("ray_count", count);
  arguments_.set("coherent", 1U);
  arguments_.set("blocks_x", blocks_x);
  arguments_.set("blocks", blocks_x * blocks_y);
  launch("bench_camera", divide_up(count, config_.lanes));
  launch("trace_closest", divide_up(count, chunk()));
  launch("bench_scatter", divide_up(count, config_.lanes));
  std::vector<RayKind> kinds;
  kinds.push_back({"camera", false, true, packed(device_.read_all<float>(camera), count)});
  kinds.push_back({"shadow", true, true, packed(device_.read_all<float>(shadow), count)});
  kinds.push_back({"diffuse", false, false, packed(device_.read_all<float>(diffuse), count)});
  return kinds;
}

void RayBench::load(const RayKind& kind) {
  arguments_.set("rays", device_.upload(kind.rays.words));
  hits_ = device_.allocate(20 * kind.rays.stride);
  arguments_.set("hits", hits_);
  arguments_.set("stride", std::uint32_t(kind.rays.stride));
  arguments_.set("ray_count", std::uint32_t(kind.rays.count));
  arguments_.set("coherent", kind.coherent ? 1U : 0U);
  kernels_.at(kernel_of(kind)).bind(arguments_);
}

double RayBench::trace(const RayKind& kind) {
  device_.finish();
  const double begin = host_seconds();
  run(kernel_of(kind), divide_up(kind.rays.count, chunk()));
  device_.finish();
  return host_seconds() - begin;
}

RayBench::Counts RayBench::count(const RayKind& kind) {
  trace(kind);
  const std::vector<float> words = device_.read_all<float>(hits_);
  Counts sum;
  for (std::size_t i = 0; i < kind.rays.count; ++i) {
    sum.tests += double{words[kind.rays.stride + i]};
    sum.steps += double{words[2 * kind.rays.stride + i]};
  }
  const double rays = std::max<double>(double(kind.rays.count), 1);
  return {sum.tests / rays, sum.steps / rays};
}

std::size_t RayBench::chunk() const { return config_.chunked ? kChunk : 1; }

void RayBench::run(const std::string& kernel, std::size_t items) {
  if (config_.chunked)
    device_.run(kernels_.at(kernel), items, 1);
  else
    device_.run(kernels_.at(kernel), divide_up(items, kWorkGroup), kWorkGroup);
}

void RayBench::launch(const std::string& kernel, std::size_t items) {
  kernels_.at(kernel).bind(arguments_);
  run(kernel, items);
  device_.finish();
}

}  // namespace eikon
