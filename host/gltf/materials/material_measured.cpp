// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/material_measured.h"

#include <fmt/format.h>

#include <cmath>
#include <new>
#include <numbers>
#include <utility>

#include "core/error.h"
#include "scene/merl.h"
#include "io/source_file.h"

namespace eikon {
namespace {

constexpr double kMostReflected = 1.01;  // beyond what the midpoint rule is wrong by

void note_light(const Place& place, const MeasuredTable& table, Notes& notes) {
  if (table.holes > 0)
    notes.warn(fmt::format("{}: {} of the {} entries of {} have no measurement and reflect nothing", place.label(),
                           table.holes, EK_MEASURED_CELLS, table.name));
  const std::size_t view = table.brightest_view();
  const glm::dvec3& rgb = table.albedos[view];
  const double most = std::max({rgb.x, rgb.y, rgb.z});
  if (most > kMostReflected)
    notes.clamped(fmt::format("{}: {} reflects {:.3g} times the light that arrives at {:.0f} degrees; kept as it is",
                              place.label(), table.name, most,
                              std::acos(MeasuredTable::cosine(view)) * 180 / std::numbers::pi));
}

}  // namespace

bool check_measured(const Place& extension) {
  if (extension.kind != kMeasuredExtension) return false;
  check_string(extension, "uri");
  if (member(extension.value, "uri") == nullptr) extension.refuse(R"(needs "uri", the name of a MERL table)");
  return true;
}

void read_measured(const Place& place, Material& material) {
  if (extension_of(place, kMeasuredExtension) == nullptr) return;
  if (material.conductor || material.phong)
    place.refuse(fmt::format("it has {} and another of EIKON's materials; leave one out", kMeasuredExtension));
  material.metallic = material.roughness = material.specular = 0.0F;
  material.transmission = material.diffuse_transmission = 0.0F;
}

std::shared_ptr<const MeasuredTable> MeasuredReader::read(const std::filesystem::path& file) {
  std::error_code unknown;
  // A name that a huge file has by mistake costs no time and no memory.
  if (const std::uintmax_t size = std::filesystem::file_size(file, unknown); !unknown && size > kMerlBytes)
    throw InputError(fmt::format("has {} bytes; a MERL table has {}", size, kMerlBytes));
  const Bytes bytes = read_regular_file(file, kMerlBytes);
  MeasuredTable table = make_measured_table(read_merl(bytes.span()));
  table.name = in_quotes(file.filename().string());
  digest_.add(bytes.span());
  return std::make_shared<const MeasuredTable>(std::move(table));
}

void MeasuredReader::complete(const Place& material_place, Material& material) {
  const Json* extension = extension_of(material_place, kMeasuredExtension);
  if (extension == nullptr || material.unlit) return;
  const auto& uri = member(*extension, "uri")->get_ref<const std::string&>();
  try {
    const std::filesystem::path file = resolve_uri(folder_, uri);
    std::shared_ptr<const MeasuredTable>& known = of_file_[file];
    if (!known) {
      known = read(file);
      note_light(material_place, *known, notes_);
    }
    material.measured = known;
  } catch (const InputError& e) {
    material_place.refuse(fmt::format("{} {}: {}", kMeasuredExtension, in_quotes(uri), e.what()));
  } catch (const std::bad_alloc&) {
    material_place.refuse(fmt::format("{} {}: needs more memory than there is", kMeasuredExtension, in_quotes(uri)));
  }
}

}  // namespace eikon
