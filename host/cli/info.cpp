// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "cli/commands.h"
#include "cli/execution_options.h"
#include "cli/scene_options.h"
#include "render/pack.h"
#include "render/render.h"
#include "render/wavefront.h"

namespace eikon {
namespace {

struct InfoOptions {
  SceneOptions scene;
};

ExitCode info_command(const InfoOptions& options) {
  const Prepared prepared = prepare(options.scene, false);
  const Scene& scene = prepared.scene;
  const Features features(scene, prepared.settings);
  PackedScene packed = pack_scene(scene, features, prepared.settings);

  fmt::print("{}: {} bytes, hash {}\n", scene.path.string(), scene.file_bytes, scene.hash);
  fmt::print("  {} triangles in {} nodes, {} meshes, {} materials, {} cameras\n", packed.triangles.size(),
             scene.nodes.size(), scene.meshes.size(), scene.materials.size(), scene.cameras.size());
  if (!packed.bounds.empty())
    fmt::print("  bounds ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}) m\n", packed.bounds.lo.x, packed.bounds.lo.y,
               packed.bounds.lo.z, packed.bounds.hi.x, packed.bounds.hi.y, packed.bounds.hi.z);
  fmt::print("  image {} x {}, camera '{}'\n", prepared.settings.width, prepared.settings.height, prepared.camera_name);
  fmt::print("lights\n");
  for (const PackedLight& light : packed.light_summary)
    fmt::print("  {}: {:.6g} W (mean of R, G, B), chosen with probability {:.4f}\n", light.user, light.power,
               light.probability);
  if (packed.light_summary.empty()) fmt::print("  none\n");

  fmt::print("features\n");
  for (const Feature& feature : features.ledger())
    fmt::print("  {:<7} {:<16} {:<3}  {}\n", feature.kind, feature.name, feature.on ? "in" : "out", feature.who);

  fmt::print("memory, of each device and of the host\n");
  for (const char* layout : {"bvh8", "bvh2"}) {
    add_accel(packed, "bvh", layout, 0);
    const std::uint64_t bytes = packed.bytes(layout);
    fmt::print("  {}: tree {} bytes, scene {} bytes{}\n", layout, packed.accels.at(layout).bytes(), bytes,
               packed.triangles.empty()
                   ? ""
                   : fmt::format(" ({:.0f} per triangle)", double(bytes) / double(packed.triangles.size())));
  }
  Execution execution;
  read_execution_environment(execution);
  for (const DeviceInfo& info : list_devices()) {
    const WavefrontConfig config = configure(info, execution);
    fmt::print("  device {}: {} bytes for {} paths in flight, beside the scene as {}\n", info.index,
               path_pool_bytes(config, features), config.capacity(), config.layout);
  }
  const FilmLayout film = film_layout(features, prepared.settings);
  fmt::print("  film: {} bytes\n", film.crop.pixel_count() * film.replicates * (16 * film.channels.size() + 8));
  return ExitCode::done;
}

}  // namespace

void add_info(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* command = app.add_subcommand("info", "what a scene contains, which features it needs, the memory it takes");
  options->scene.add_to(*command);
  command->footer("Example:\n  eikon info scenes/cornell.gltf");
  command->callback([options, &chosen] { chosen = [options] { return info_command(*options); }; });
}

}  // namespace eikon
