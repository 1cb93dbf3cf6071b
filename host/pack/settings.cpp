// SPDX-License-Identifier: Apache-2.0
#include "pack/settings.h"

#include <algorithm>

namespace eikon {

const char* name_of(Integrator integrator) {
  switch (integrator) {
    case Integrator::path:
      return "path";
    case Integrator::whitted:
      return "whitted";
    case Integrator::raycast:
      return "raycast";
  }
  return "";
}

const char* name_of(LightSampling sampling) {
  switch (sampling) {
    case LightSampling::mis:
      return "mis";
    case LightSampling::light:
      return "light";
    case LightSampling::bsdf:
      return "bsdf";
    case LightSampling::hemisphere:
      return "hemisphere";
  }
  return "";
}

double expected_rays(const Settings& settings) {
  const auto samples = double(settings.sample_end - settings.sample_begin);
  // A path has about five edges, if max_depth allows, and each edge a shadow ray.
  const std::uint32_t edges = settings.max_depth == 0 ? 5 : std::min(settings.max_depth, 5U);
  return double(settings.crop.pixel_count()) * samples * 2 * edges;
}

}  // namespace eikon
