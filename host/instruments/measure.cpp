// SPDX-License-Identifier: Apache-2.0
#include "instruments/measure.h"

#include <bit>
#include <fmt/format.h>

#include "core/error.h"
#include "device/kernel_sources.h"
#include "pack/features.h"
#include "pack/pack_parts.h"
#include "io/text.h"
#include "shared/measured.h"
#include "wavefront/buffers.h"

namespace eikon {
namespace {

constexpr std::size_t kGroup = 64;

[[noreturn]] void refuse(const Scene& scene, std::uint32_t material, const char* why) {
  throw InputError(fmt::format("{}: {}", label("material", material, scene.materials[material].name), why));
}

void check_findings(std::uint32_t found, const Scene& scene, std::uint32_t material) {
  if ((found & EK_FOUND_TRANSMISSION) != 0)
    refuse(scene, material,
           "lets light through, of which a table of reflection says nothing; measure one that is opaque");
  if ((found & EK_FOUND_DELTA) != 0)
    refuse(scene, material,
           "is a perfect mirror in part, which no table holds; give it (and its coat) a roughness of 0.02 or more");
  if ((found & EK_FOUND_NOT_FINITE) != 0) refuse(scene, material, "reflects what is not finite");
}

}  // namespace

std::vector<float> measure(Scene& scene, std::uint32_t material, const glm::vec2& uv, Device& device, bool optimise) {
  const Material& m = scene.materials.at(material);
  if (m.unlit) refuse(scene, material, "is unlit: it shows its base colour and reflects nothing");
  // One triangle of the material makes the program have the features that it needs and no other.
  scene.shapes.clear();
  scene.meshes.assign(1, {});
  scene.meshes.front().primitives.emplace_back().material = material;
  scene.nodes.assign(1, {});
  const Settings settings;
  const Features features(scene, settings);
  if (features.has(Feature::anisotropy))
    refuse(scene, material, "is anisotropic, and a table of three angles is not; measure it with anisotropyStrength 0");
  PackedScene packed;
  pack_materials(scene, features, packed);

  ProgramOptions options;
  options.optimise = optimise;
  options.defines = features.defines();
  options.defines["EK_WIDTH"] = "1";
  Kernel kernel = device.build(kernel_text({"probe/measure.cl"}), options).kernel("measure");
  Arguments arguments;
  upload_scene(device, packed, Accel{}, {}, {}, arguments);
  upload_texels(device, packed, arguments);
  const Buffer values = device.allocate(sizeof(float) * 3 * EK_MEASURED_CELLS);
  const Buffer findings = device.upload(std::vector<std::uint32_t>(1));
  arguments.set("measured_values", values);
  arguments.set("measured_findings", findings);
  arguments.set("measured_material", material);
  arguments.set("measured_u", std::bit_cast<std::uint32_t>(uv.x));
  arguments.set("measured_v", std::bit_cast<std::uint32_t>(uv.y));
  kernel.bind(arguments);
  device.run(kernel, (EK_MEASURED_CELLS + kGroup - 1) / kGroup, kGroup, EK_MEASURED_CELLS);
  std::vector<float> rgb = device.read_all<float>(values);
  check_findings(device.read_all<std::uint32_t>(findings).front(), scene, material);
  return rgb;
}

}  // namespace eikon
