// SPDX-License-Identifier: Apache-2.0
// `bench rays`: rays per second by layout and kind of ray, beside Embree in the same run. Every surface counts as opaque.
// --json: an array of {accel, layout, default, rays: camera|shadow|diffuse, mrays_per_s, embree_mrays_per_s, build_s,
// embree_build_s, bytes}; `default`: what a render on this device would use; bytes: tree and geometry on the device.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/bench_embree.h"
#include "cli/commands.h"
#include "cli/execution_options.h"
#include "cli/report.h"
#include "cli/scene_options.h"
#include "device/device.h"
#include "device/kernel_sources.h"
#include "render/frame.h"
#include "render/pack.h"
#include "render/wavefront.h"

namespace eikon {
namespace {

struct BenchOptions {
  SceneOptions scene;
  Execution execution;
  std::string versus, json;
  std::uint32_t rays = 1U << 20, rounds = 5;
};

struct Kind {
  const char* name;
  bool any_hit, coherent;
  RayArrays rays;
  double seconds = 1e300, embree_seconds = 1e300;  // best round
};

constexpr std::size_t kChunk = 1024;  // rays per work-item on CPU devices, as in a render

/// Drops rays with t_max 0, which stand for none, and pads for full vectors.
RayArrays packed(const std::vector<float>& words, std::size_t count) {
  const std::size_t from = words.size() / 7;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < count; ++i) {
    if (words[6 * from + i] > 0) kept.push_back(i);
  }
  RayArrays rays;
  rays.count = kept.size();
  rays.stride = (rays.count + 31) / 16 * 16;
  rays.words.resize(7 * rays.stride, 0.0F);
  for (std::size_t k = 0; k < 7; ++k) {
    for (std::size_t i = 0; i < kept.size(); ++i) rays.words[k * rays.stride + i] = words[k * from + kept[i]];
  }
  return rays;
}

class RayBench {
 public:
  RayBench(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
           const Execution& execution, const std::string& layout)
      : device_(device), config_(configure(device.info(), execution)) {
    const Accel& accel = scene.accels.at(layout);
    ProgramOptions options;
    options.defines = features.defines();
    options.defines["EK_HAS_opacity"] = "0";  // as opaque: the same question as Embree's
    options.defines["EK_WIDTH"] = std::to_string(config_.lanes);
    options.defines["EK_CHUNKED"] = config_.chunked ? "1" : "0";
    options.defines["EK_CHUNK"] = std::to_string(chunk());
    options.defines.merge(accel.defines());
    const Program program = device.build(kernel_text({"trace_rays.cl", "bench_rays.cl"}), options);
    for (const char* name : {"trace_closest", "trace_any", "bench_camera", "bench_scatter"}) {
      kernels_[name] = program.kernel(name);
    }
    arguments_.set("frame", device.upload(std::vector<Frame>{pack_frame(scene, settings)}));
    const auto upload = [&](const char* name, const auto& values) {
      using Record = typename std::decay_t<decltype(values)>::value_type;
      arguments_.set(name, device.upload(values.empty() ? std::vector<Record>(1) : values));
    };
    upload("accel_nodes", accel.nodes);
    upload("accel_leaves", accel.leaves);
    upload("triangles", scene.triangles);
    upload("lights", scene.lights);
    upload("light_buckets", scene.light_buckets);
    upload("environment_texels", scene.environment_texels);
    upload("environment_buckets", scene.environment_buckets);
  }

  /// Camera rays, and from their hits diffuse and shadow rays; the same for every layout, since hits are.
  std::vector<Kind> make_rays(const Settings& settings, std::uint32_t count) {
    const std::size_t stride = (count + 31) / 16 * 16;
    const std::uint32_t blocks_x = std::max(settings.width / 4, 1U), blocks_y = std::max(settings.height / 4, 1U);
    const Buffer camera = device_.allocate(28 * stride), diffuse = device_.allocate(28 * stride),
                 shadow = device_.allocate(28 * stride), hits = device_.allocate(16 * stride);
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
    launch("bench_camera", (count + config_.lanes - 1) / config_.lanes);
    launch("trace_closest", (count + chunk() - 1) / chunk());
    launch("bench_scatter", (count + config_.lanes - 1) / config_.lanes);
    std::vector<Kind> kinds;
    kinds.push_back({"camera", false, true, packed(device_.read_all<float>(camera), count)});
    kinds.push_back({"shadow", true, true, packed(device_.read_all<float>(shadow), count)});
    kinds.push_back({"diffuse", false, false, packed(device_.read_all<float>(diffuse), count)});
    return kinds;
  }

  /// Puts the rays of a kind on the device.
  void load(const Kind& kind) {
    arguments_.set("rays", device_.upload(kind.rays.words));
    arguments_.set("hits", device_.allocate(16 * kind.rays.stride));
    arguments_.set("stride", std::uint32_t(kind.rays.stride));
    arguments_.set("ray_count", std::uint32_t(kind.rays.count));
    arguments_.set("coherent", kind.coherent ? 1U : 0U);
    kernels_.at(name(kind)).bind(arguments_);
  }

  /// Seconds from launch to finish.
  double trace(const Kind& kind) {
    device_.finish();
    const double begin = host_seconds();
    run(name(kind), (kind.rays.count + chunk() - 1) / chunk());
    device_.finish();
    return host_seconds() - begin;
  }

 private:
  [[nodiscard]] std::size_t chunk() const { return config_.chunked ? kChunk : 1; }
  static const char* name(const Kind& kind) { return kind.any_hit ? "trace_any" : "trace_closest"; }
  void run(const std::string& kernel, std::size_t items) {
    constexpr std::size_t group = 64;
    if (config_.chunked)
      device_.run(kernels_.at(kernel), items, 1);
    else
      device_.run(kernels_.at(kernel), (items + group - 1) / group, group);
  }
  void launch(const std::string& kernel, std::size_t items) {
    kernels_.at(kernel).bind(arguments_);
    run(kernel, items);
    device_.finish();
  }

  Device& device_;
  WavefrontConfig config_;
  Arguments arguments_;
  std::map<std::string, Kernel> kernels_;
};

ExitCode bench_rays_command(const BenchOptions& options) {
  if (!options.versus.empty() && options.versus != "embree") {
    throw UsageError(fmt::format("--versus {}: takes embree", options.versus));
  }
  require_writable({options.json}, options.scene.scene);
  const Prepared prepared = prepare(options.scene, true);
  const Features features(prepared.scene, prepared.settings);
  PackedScene scene = pack_scene(prepared.scene, features, prepared.settings);
  if (scene.triangles.empty()) throw InputError(options.scene.scene + ": there is no triangle to trace rays against");

  nlohmann::json results = nlohmann::json::array();
  fmt::print("{:<24} {:<6} {:<8} {:>9} {:>9} {:>7} {:>9} {:>9} {:>12}\n", "device", "layout", "rays", "Mrays/s",
             "Embree", "ratio", "build s", "Embree s", "bytes");
  for (const DeviceInfo& info : select_devices(options.execution.devices)) {
    Device device(info);
    const std::string chosen = configure(info, options.execution).layout;
    Execution plain = options.execution;
    plain.accel = "bvh";
    plain.layout.clear();
    const std::string usual = configure(info, plain).layout;
    const bool all = options.execution.layout.empty() && options.execution.accel == "bvh";
    std::optional<EmbreeYardstick> embree;
    if (!options.versus.empty()) embree.emplace(scene.triangles, std::max(info.compute_units, 1U));
    std::vector<std::string> layouts = all ? tree_layouts() : std::vector<std::string>{chosen};
    for (const std::string& layout : layouts) {
      add_accel(scene, options.execution.accel, layout, options.execution.threads);
      RayBench bench(device, scene, features, prepared.settings, options.execution, layout);
      for (Kind& kind : bench.make_rays(prepared.settings, options.rays)) {
        bench.load(kind);
        bench.trace(kind);  // compiles
        for (std::uint32_t round = 0; round < options.rounds; ++round) {
          kind.seconds = std::min(kind.seconds, bench.trace(kind));
          if (embree) kind.embree_seconds = std::min(kind.embree_seconds, embree->trace(kind.rays, kind.any_hit));
        }
        const double millions = 1e-6 * double(kind.rays.count);
        const Accel& accel = scene.accels.at(layout);
        nlohmann::json row = {
            {"device", info.name},           {"accel", accel.name},      {"layout", layout},
            {"default", layout == usual},    {"rays", kind.name},        {"mrays_per_s", millions / kind.seconds},
            {"embree_mrays_per_s", nullptr}, {"build_s", accel.build_s}, {"embree_build_s", nullptr},
            {"bytes", scene.bytes(layout)}};
        if (embree) {
          row["embree_mrays_per_s"] = millions / kind.embree_seconds;
          row["embree_build_s"] = embree->build_s();
        }
        const auto number = [&](const char* key, int digits) {
          return row[key].is_null() ? std::string("-") : fmt::format("{:.{}f}", row[key].get<double>(), digits);
        };
        fmt::print("{:<24.24} {:<6} {:<8} {:>9} {:>9} {:>7} {:>9} {:>9} {:>12}\n", info.name, layout, kind.name,
                   number("mrays_per_s", 2), number("embree_mrays_per_s", 2),
                   embree ? fmt::format("{:.2f}", kind.embree_seconds / kind.seconds) : "-", number("build_s", 3),
                   number("embree_build_s", 3), scene.bytes(layout));
        results.push_back(std::move(row));
      }
    }
  }
  if (!options.json.empty()) write_text(options.json, results.dump(2) + "\n");
  return ExitCode::done;
}

}  // namespace

void add_bench(CLI::App& app, Command& chosen) {
  CLI::App* bench = app.add_subcommand("bench", "how fast this machine's devices are");
  bench->require_subcommand(1);
  bench->footer("Example:\n  eikon bench rays scenes/cornell.gltf --versus embree");

  auto options = std::make_shared<BenchOptions>();
  CLI::App* rays = bench->add_subcommand(
      "rays", "camera, shadow and diffuse-bounce rays per second, by layout of the tree; surfaces as opaque");
  options->scene.add_to(*rays);
  add_execution_options(*rays, options->execution);
  rays->add_option("--versus", options->versus,
                   "embree: its rtcIntersect1 and rtcOccluded1 on the same rays, as many threads");
  rays->add_option("--json", options->json, "write the results to a file");
  rays->add_option("--rays", options->rays, "of each kind")->check(CLI::Range(16U, 1U << 26))->capture_default_str();
  rays->add_option("--rounds", options->rounds, "the best of which counts")
      ->check(CLI::Range(1U, 1000U))
      ->capture_default_str();
  rays->footer("Example:\n  eikon bench rays scenes/cornell.gltf --versus embree --json rays.json");
  rays->callback([options, &chosen] { chosen = [options] { return bench_rays_command(*options); }; });
}

}  // namespace eikon
