// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/material_measured.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "gltf/extensions.h"
#include "gltf/materials/material_extensions.h"
#include "scene/merl.h"
#include "io/source_file.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr double kMaxReflected = 1.01;  // the midpoint rule is wrong by less than this

void note_light(const JsonView& material, const MeasuredTable& table, Notes& notes) {
  if (table.holes > 0)
    notes.warn(fmt::format("{}: {} of the {} entries of {} have no measurement and reflect nothing", material.label(),
                           table.holes, EK_MEASURED_CELLS, table.name));
  const std::size_t view = table.brightest_view();
  const glm::dvec3& rgb = table.albedos[view];
  const double most = std::max({rgb.x, rgb.y, rgb.z});
  if (most > kMaxReflected)
    notes.mended(fmt::format("{}: {} reflects {:.3g} times the light that arrives at {:.0f} degrees; kept as it is",
                             material.label(), table.name, most,
                             std::acos(MeasuredTable::cosine(view)) * 180 / std::numbers::pi));
}

void check_measured(const JsonView& extension, std::size_t) {
  if (as_string(extension, "uri") == nullptr) extension.refuse(R"(needs "uri", the name of a MERL table)");
}

// The table stands in the place of all that it takes away here.
void read_measured(const JsonView&, const Factors& factors, Material& material) {
  if (material.lobe)
    factors.material().refuse(
        fmt::format("it has {} and another of EIKON's materials; leave one out", kMeasuredExtension));
  material.metallic = material.roughness = material.specular = 0.0F;
  material.transmission = material.diffuse_transmission = 0.0F;
}

constexpr MaterialExtensionReader kMeasuredExtensions[] = {{.name = kMeasuredExtension, .check = check_measured, .read = read_measured}};

}  // namespace

std::span<const MaterialExtensionReader> measured_extensions() { return kMeasuredExtensions; }

std::shared_ptr<const MeasuredTable> MeasuredReader::read(const std::filesystem::path& file) {
  std::error_code unknown;
  // The size is checked first, so that a huge file named by mistake costs no time and no memory.
  if (const std::uintmax_t size = std::filesystem::file_size(file, unknown); !unknown && size > kMerlBytes)
    throw InputError(fmt::format("has {} bytes; a MERL table has {}", size, kMerlBytes));
  const Bytes bytes = read_regular_file(file, kMerlBytes);
  MeasuredTable table = make_measured_table(read_merl(bytes.span()));
  table.name = in_quotes(file.filename().string());
  digest_.add(bytes.span());
  return std::make_shared<const MeasuredTable>(std::move(table));
}

void MeasuredReader::complete(const JsonView& view, Material& material) {
  const Json* extension = extension_of(view.value, kMeasuredExtension);
  if (extension == nullptr || material.unlit) return;
  const std::string& uri = to_string(*member(extension, "uri"));
  try {
    const std::filesystem::path file = resolve_uri(folder_, uri);
    std::shared_ptr<const MeasuredTable>& known = of_file_[file];
    if (!known) {
      known = read(file);
      note_light(view, *known, notes_);
    }
    material.measured = known;
    material.lobe = Lobe::measured;
  } catch (const InputError& e) {
    view.refuse(fmt::format("{} {}: {}", kMeasuredExtension, in_quotes(uri), e.what()));
  } catch (const std::bad_alloc&) {
    view.refuse(fmt::format("{} {}: needs more memory than there is", kMeasuredExtension, in_quotes(uri)));
  }
}

}  // namespace eikon
