// SPDX-License-Identifier: Apache-2.0
#include "wavefront/photons/photon_stage.h"

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "pack/seeds.h"

namespace eikon {

PhotonStage::PhotonStage(Device& device, Arguments& arguments) : device_(&device) {
  map_ = make_photon_map({}, 1, 1);
  share(arguments);
}

void PhotonStage::share(Arguments& arguments) {
  const auto set = [&](const char* name, std::vector<std::uint32_t>& words, std::size_t least) {
    if (words.size() < least)
      words.resize(least, 0);  // kernels read the first ones before they know that there are none
    arguments.set(name, device_->share(words.data(), 4 * words.size()));
  };
  set("photons", map_.photons, PHOTON_WORDS);
  set("photon_places", map_.places, 1);
  set("photon_buckets", map_.buckets, 2);
}

void PhotonStage::restart(const PhotonPlan& plan, const Frame& frame) {
  plan_ = frame.light_path_count > 0 ? plan : PhotonPlan{};  // else there is nowhere that they could start
  first_radius2_ = frame.photon_radius2;
  generation_.reset();
}

bool PhotonStage::prepare(LightStages& lights, std::size_t which, const WorkUnit& unit, Frame& frame,
                          Arguments& arguments, RayCounts& rays) {
  const std::uint64_t generation = unit.sample_begin / plan_.samples;
  if (unit.sample_begin < unit.sample_end && (unit.sample_end - 1) / plan_.samples != generation)
    throw InternalError("a unit has samples of several photon maps");
  if (generation_ == generation) return false;
  generation_.reset();
  const double radius2 = photon_radius2(double(first_radius2_), generation);
  frame.photon_radius2 = float(radius2);
  frame.photon_cell_scale = float(0.5 / std::sqrt(radius2));
  frame.photon_weight = float(1 / (std::numbers::pi * double(frame.photon_radius2) * double(plan_.paths)));
  Frame emitting = frame;
  emitting.seed ^= kPhotonSeed;
  emitting.light_path_count = std::uint32_t(plan_.paths);
  // Light paths know their replicate and generation by a number of the same form as that of a
  // sample.
  const std::uint64_t replicates = std::uint64_t{1} << frame.replicate_bits;
  found_ = {};
  lights.find_photons(found_, which, {generation * replicates, (generation + 1) * replicates}, emitting);
  rays += found_.rays;
  device_->finish();  // units under way read the maps before
  map_ = make_photon_map(std::move(found_.splats), frame.photon_radius2, frame.photon_cell_scale);
  frame.photon_bucket_mask = std::uint32_t(map_.buckets.size() - 2);
  found_ = {};
  share(arguments);
  generation_ = generation;
  return true;
}

std::uint64_t PhotonStage::bytes() const {
  return 4 * (map_.photons.size() + map_.places.size() + map_.buckets.size());
}

}  // namespace eikon
