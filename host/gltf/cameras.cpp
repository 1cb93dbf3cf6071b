// SPDX-License-Identifier: Apache-2.0
#include "gltf/cameras.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "core/error.h"
#include "gltf/document/document_check.h"
#include "gltf/extensions.h"
#include "io/text.h"
#include "scene/limits.h"

namespace eikon {
namespace {

// A camera's pose. The scale of its node is ignored [glTF 2.0, section 3.10.2], and so is a mirror
// image, which would show the picture reversed. There is none if the node leaves no direction of
// view or no up.
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

/// Returns a length or ratio of the extension, or 0 if it is absent.
double positive(const JsonView& place, const char* key) {
  const std::optional<double> value = as_number(place, key);
  if (!value) return 0;
  if (!(*value > 0 && *value <= kMaxCoordinate))
    place.refuse(
        fmt::format("'{}' {:g} is not between 0 and 2^40; leave the extension out for a pinhole", key, *value));
  return *value;
}

Lens read_lens(const JsonView& place) {
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

void read_extensions(const JsonView& source, Camera& camera, Notes& notes) {
  const Json* extensions = member(source.value, "extensions");
  if (extensions == nullptr) return;
  note_unsupported_extensions(source.value, ExtensionOwner::camera, source.label(), notes);
  const JsonView place{.value = *extensions, .kind = "extensions", .parent = &source};
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

double orthographic_aspect(const JsonView& lens) {
  const double aspect =
      std::abs(to_number(*member(lens.value, "xmag"))) / std::abs(to_number(*member(lens.value, "ymag")));
  if (!(aspect >= kMinAspect && aspect <= kMaxAspect))
    lens.refuse(fmt::format("its picture of aspect {:g} is a line; bring xmag and ymag within {:g} of each other",
                            aspect, kMaxAspect));
  return aspect;
}

void add_camera(const Json& document, const PlacedNode& placed, Scene& scene, Notes& notes) {
  const std::size_t index = *placed.node.camera;
  const Json& source = element(items(document, "cameras"), index);
  const JsonView view{.value = source, .kind = "camera", .index = static_cast<std::int64_t>(index)};
  const auto pose = camera_pose(placed.world_from_object);
  if (!pose)
    return notes.warn(view.label() + ": left out, " + placed.node.view.label() +
                      " scales its direction of view to nothing");
  check_position(view, placed);
  const Json* name = member(source, "name");
  const bool named = name != nullptr && !to_string(*name).empty();
  Camera camera{.name = named ? to_string(*name) : placed.node.name, .world_from_camera = *pose};
  if (const Json* lens = member(source, "perspective"); equals(member(source, "type"), "perspective")) {
    camera.yfov_rad = to_number(*member(lens, "yfov"));
    const Json* aspect = member(lens, "aspectRatio");
    camera.aspect = aspect == nullptr ? 0.0 : to_number(*aspect);
  } else {
    const Json* size = member(source, "orthographic");
    const double xmag = to_number(*member(size, "xmag")), ymag = to_number(*member(size, "ymag"));
    if (xmag < 0 || ymag < 0) notes.warn(view.label() + ": negative xmag or ymag taken as positive");
    camera.projection = Projection::orthographic;
    camera.ymag_m = std::abs(ymag);
    // Animations may have moved both numbers since the document was checked.
    camera.aspect = orthographic_aspect({.value = *size, .kind = "orthographic", .parent = &view});
  }
  read_extensions(view, camera, notes);
  scene.cameras.push_back(std::move(camera));
}

}  // namespace eikon
