// SPDX-License-Identifier: Apache-2.0
#include "wavefront/wavefront.h"

#include <bit>

#include "core/error.h"
#include "wavefront/wavefront_impl.h"

namespace eikon {

Wavefront::Wavefront(Device& device, const PackedScene& scene, const Features& features, const Settings& settings,
                     const Execution& execution)
    : impl_(std::make_unique<Impl>(device, scene, features, settings, execution)) {}
Wavefront::~Wavefront() = default;

void Wavefront::compile_ahead(Device& device, const PackedScene& scene, const Features& features,
                              const Execution& execution) {
  const WavefrontProgram source(device.info(), configure(device.info(), execution), scene, features, execution);
  (void)device.build(source.text, source.options);
}
const WavefrontConfig& Wavefront::config() const { return impl_->config; }
ArithmeticClass Wavefront::arithmetic() const { return impl_->arithmetic; }
double Wavefront::upload_s() const { return impl_->upload_s; }
std::uint64_t Wavefront::device_bytes() const {
  return impl_->scene_bytes + impl_->texel_bytes + impl_->work.bytes +
         (impl_->has_light_stages ? LightStages::bytes(impl_->config) : 0) + impl_->photons.bytes();
}
const Bounces& Wavefront::bounces() const { return impl_->counters.bounces(); }
void Wavefront::restart(const Settings& settings, const Execution& execution) { impl_->restart(settings, execution); }
bool Wavefront::fits(const PackedScene& scene, const Features& features, const Execution& execution) const {
  return impl_->fits(scene, features, execution);
}
void Wavefront::change_scene(const PackedScene& scene, const Features& features, const Settings& settings,
                             const Execution& execution) {
  impl_->change_scene(scene, features, settings, execution);
}
void Wavefront::trace_light_paths(bool on) { impl_->light_paths_enabled = on; }
void Wavefront::set_guide(std::shared_ptr<const GuideTable> guide) { impl_->set_guide(std::move(guide)); }
PathLog Wavefront::path_log() {
  Impl& w = *impl_;
  const std::size_t stride = w.frame.film_stride, words = EK_LOG_DEPTHS * LOG_WORDS * stride, colours = 3 * stride;
  w.logged = w.device.map(w.work.path_log, sizeof(std::uint32_t) * words);
  w.radiance = w.device.map(w.work.film_slots, sizeof(std::uint32_t) * colours);
  return {.words = {static_cast<const std::uint32_t*>(w.logged.get()), words},
          .radiance = {static_cast<const std::uint32_t*>(w.radiance.get()), colours},
          .paths = w.last_unit().frame.path_count,
          .stride = stride};
}
void Wavefront::begin(const WorkUnit& unit) {
  impl_->logged = impl_->radiance = nullptr;
  impl_->begin(unit);
}
void Wavefront::launch_rest() { impl_->launch_rest(); }
UnitResult Wavefront::finish() { return impl_->finish(); }
ReplayedSample Wavefront::replay(std::uint32_t x, std::uint32_t y, std::uint64_t sample,
                                 const std::function<void(const PathVertex&)>& report) {
  Impl& w = *impl_;
  if (w.config.fused) throw InternalError("a path can be replayed only where each stage has a launch of its own");
  const auto number = [&](auto... of) { return std::bit_cast<float>(w.path_word(of...)); };
  const auto vector = [&](const char* field) { return glm::vec3(number(field), number(field, 1U), number(field, 2U)); };
  w.depths.replays_one_path = true;
  w.depths.after_intersect = [&](std::uint32_t depth) {
    report({depth, glm::dvec3(vector("origin")) + w.scene->origin, vector("dir"), vector("beta"), number("hit_t"),
            w.path_word("hit_triangle")});
  };
  const WorkUnit unit{{x, y, x + 1, y + 1}, sample, sample + 1};
  w.begin(unit);
  (void)w.finish();
  w.depths.replays_one_path = false;
  w.depths.after_intersect = nullptr;
  ReplayedSample result;
  for (int c = 0; c < 3; ++c)
    w.device.read(w.work.film_slots, &result.radiance[c], sizeof(float), 4 * std::size_t(c) * w.frame.film_stride);
  if (!w.has_light_stages) return result;
  w.begin(unit);  // again, with its light paths
  (void)w.finish();
  result.splats = replayed_splats(w.last_unit().lights.splats, w.light_paths.count);
  return result;
}

}  // namespace eikon
