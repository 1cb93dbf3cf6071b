// SPDX-License-Identifier: Apache-2.0
#include "gltf/cameras.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/error.h"
#include "gltf/geometry/attributes.h"

namespace eikon {
namespace {

// A camera's pose: the scale of its node is ignored [glTF 2.0, section 3.10.2], so is a mirror image, which would show
// the picture reversed. Nothing where the node leaves no direction of view or no up.
std::optional<glm::dmat4> camera_pose(const glm::dmat4& world_from_object) {
  const glm::dvec3 up(world_from_object[1]), back(world_from_object[2]);
  if (!(glm::length(back) > 0) || !(glm::length(up) > 0)) return std::nullopt;
  const glm::dvec3 z = back / glm::length(back);
  const glm::dvec3 x = glm::cross(up / glm::length(up), z);
  if (!(glm::length(x) > 1e-9)) return std::nullopt;
  const glm::dvec3 x_unit = x / glm::length(x);
  return glm::dmat4{glm::dvec4(x_unit, 0.0), glm::dvec4(glm::cross(z, x_unit), 0.0), glm::dvec4(z, 0.0),
                    world_from_object[3]};
}

/// A length or ratio that the extension may or must have. 0: absent.
double positive(const Place& place, const char* key) {
  const std::optional<double> value = as_number(place, key);
  if (!value) return 0;
  if (!(*value > 0 && *value <= kMaxCoordinate))
    place.refuse(
        fmt::format("'{}' {:g} is not between 0 and 2^40; leave the extension out for a pinhole", key, *value));
  return *value;
}

Lens read_lens(const Place& place) {
  Lens lens;
  lens.radius_m = positive(place, "radius");
  lens.f_number = positive(place, "fNumber");
  if ((lens.radius_m > 0) == (lens.f_number > 0))
    place.refuse("has to say how wide it opens, by 'radius' in metres or by 'fNumber', and not by both");
  if (const double height = positive(place, "sensorHeight"); height > 0) lens.sensor_height_m = height;
  lens.focus_distance_m = positive(place, "focusDistance");
  if (!(lens.focus_distance_m > 0)) place.refuse("'focusDistance' is missing: metres along the axis to what is sharp");
  return lens;
}

void read_extensions(const Place& source, Camera& camera, Notes& notes) {
  const Json* extensions = member(source.value, "extensions");
  if (extensions == nullptr) return;
  for (const auto& entry : extensions->items())
    if (entry.key() != kLensExtension && entry.key() != kPanoramaExtension)
      notes.unsupported(one_line(entry.key()), source.label());
  const Place place{.value = *extensions, .kind = "extensions", .parent = &source};
  if (as_object(place, kPanoramaExtension) != nullptr) {
    camera.projection = Projection::panorama;
    camera.aspect = 2;
  }
  const Json* lens = as_object(place, kLensExtension);
  if (lens == nullptr) return;
  const Lens read = read_lens({.value = *lens, .kind = kLensExtension, .parent = &place});
  if (camera.projection == Projection::perspective)
    camera.lens = read;
  else
    notes.warn(fmt::format("{}: its {} is left out, as only a perspective has a lens", source.label(), kLensExtension));
}

}  // namespace

double lens_radius_m(const Camera& camera) {
  if (!camera.lens || camera.projection != Projection::perspective) return 0;
  if (camera.lens->radius_m > 0) return camera.lens->radius_m;
  const double focal_length_m = 0.5 * camera.lens->sensor_height_m / std::tan(0.5 * camera.yfov_rad);
  return 0.5 * focal_length_m / camera.lens->f_number;
}

void add_camera(const Json& document, std::size_t index, const glm::dmat4& world_from_node, const Place& node,
                const std::string& node_name, Scene& scene, Notes& notes) {
  const Json& source = document["cameras"][index];
  const Place place{.value = source, .kind = "camera", .index = static_cast<std::int64_t>(index)};
  const auto pose = camera_pose(world_from_node);
  if (!pose)
    return notes.warn(place.label() + ": left out, " + node.label() + " scales its direction of view to nothing");
  const Json* name = member(source, "name");
  const std::string own_name = name == nullptr ? "" : name->get<std::string>();
  Camera camera{.name = own_name.empty() ? node_name : own_name, .world_from_camera = *pose};
  if (source["type"] == "perspective") {
    const Json& lens = source["perspective"];
    camera.yfov_rad = lens["yfov"].get<double>();
    camera.aspect = lens.value("aspectRatio", 0.0);
  } else {
    const double xmag = source["orthographic"]["xmag"].get<double>(),
                 ymag = source["orthographic"]["ymag"].get<double>();
    if (xmag < 0 || ymag < 0) notes.warn(place.label() + ": negative xmag or ymag taken as positive");
    camera.projection = Projection::orthographic;
    camera.ymag_m = std::abs(ymag);
    camera.aspect = std::abs(xmag) / std::abs(ymag);
  }
  read_extensions(place, camera, notes);
  scene.cameras.push_back(std::move(camera));
}

}  // namespace eikon
