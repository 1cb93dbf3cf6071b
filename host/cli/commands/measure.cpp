// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/flags.h"
#include "job/log.h"
#include "job/file_identity.h"
#include "device/device.h"
#include "instruments/measure.h"
#include "pack/materials/material_traits.h"
#include "scene/measured_table.h"
#include "scene/merl.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr double kFarthest = 1e9;  // on a texture

struct MeasureOptions {
  SceneOptions scene;
  std::string material, output, uv, devices = "all";
};

/// The material of that name, or else of that number, if some node shows it: others are not read.
std::uint32_t choose_material(const std::string& wanted, const Scene& scene) {
  const std::vector<bool> shown = shown_materials(scene);
  const auto number = number_in<std::uint32_t>(wanted);
  std::string known;
  for (std::uint32_t i = 0; i < shown.size(); ++i) {
    if (!shown[i]) continue;
    if (scene.materials[i].name == wanted) return i;
    known += (known.empty() ? "" : ", ") + label("material", i, scene.materials[i].name);
  }
  if (number && *number < shown.size() && shown[*number]) return *number;
  throw UsageError(fmt::format("--material {}: no node shows such a material; there is {}", in_quotes(wanted),
                               known.empty() ? "none" : known));
}

glm::vec2 place_on_textures(const MeasureOptions& options, const Material& material) {
  if (!options.uv.empty()) {
    const std::vector<double> uv = parse_numbers("--uv", options.uv, 2);
    for (const double x : uv)
      if (std::abs(x) > kFarthest) throw UsageError(fmt::format("--uv {}: takes numbers of 1e9 at most", options.uv));
    return {float(uv[0]), float(uv[1])};
  }
  const auto is = [](const TextureUse& use, const std::optional<Texture>& one) { return one && use.texture == &*one; };
  for (const TextureUse& use : textures_of(material))
    if (!is(use, material.normal_texture) && !is(use, material.clearcoat_normal_texture) &&
        !is(use, material.emissive_texture))
      throw UsageError(fmt::format("material {} has a texture ({}): say by --uv U,V where to measure it",
                                   in_quotes(material.name), use.name));
  return glm::vec2(0);
}

void print_summary(const MeasureOptions& options, const std::string& name, std::vector<float> rgb) {
  const MeasuredTable table = make_measured_table(std::move(rgb));
  fmt::print("{}: material {}, {} x {} x {} cells\n", printable(options.output), in_quotes(name), EK_MEASURED_THETA_H,
             EK_MEASURED_THETA_D, EK_MEASURED_PHI_D);
  const std::size_t brightest = table.brightest_view();
  for (const std::size_t view : {std::size_t{EK_MEASURED_VIEWS - 1}, brightest}) {
    const glm::dvec3& albedo = table.albedos[view];
    fmt::print("  reflects ({:.3f}, {:.3f}, {:.3f}) of the light at {:.0f} degrees{}\n", albedo.x, albedo.y, albedo.z,
               std::acos(MeasuredTable::cosine(view)) * 180 / std::numbers::pi, view == brightest ? ", the most" : "");
    if (view == brightest) break;
  }
}

ExitCode measure_command(const MeasureOptions& options) {
  Execution execution;
  read_execution_environment(execution);
  require_writable({options.output}, {.scene = options.scene.scene});
  Scene scene = load_scene(options.scene.scene, options.scene.choice());
  for (const std::string& warning : scene.warnings) log_unless(false)(warning);
  if (options.scene.strict && !scene.out_of_range.empty())
    throw InputError(fmt::format("{}: {} (--strict)", options.scene.scene, scene.out_of_range.front()));
  const std::uint32_t material = choose_material(options.material, scene);
  const glm::vec2 uv = place_on_textures(options, scene.materials[material]);
  Device device(select_devices(options.devices).front());
  std::vector<float> rgb = measure(scene, material, uv, device, execution.optimise);
  write_merl(options.output, rgb);
  print_summary(options, scene.materials[material].name, std::move(rgb));
  return ExitCode::done;
}

}  // namespace

void add_measure(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<MeasureOptions>();
  CommandFlags flags =
      root.command("measure", "write a material of a scene as a MERL table, as a gonioreflectometer would",
                   "Example:\n  eikon measure scenes/brushed_metal.gltf --material aluminium -o aluminium.binary");
  add_scene_flags(flags, options->scene);
  flags.text({"--material", "NAME|INDEX", "the material to measure (required)"}, options->material);
  flags.text({"--uv", "U,V", "where on its textures"}, options->uv);
  flags.group("Devices");
  flags.text({"--devices", "LIST", "as in `eikon render`; the first one measures [all]"}, options->devices);
  flags.group("Output (- is standard output)");
  flags.text({"-o,--output", "FILE", "the table, 35 MB, for EIKON_materials_measured (required)"}, options->output);
  flags.require("--material");
  flags.require("--output");
  flags.run(chosen, [options] { return measure_command(*options); });
}

}  // namespace eikon
