// SPDX-License-Identifier: Apache-2.0
#include "job/pilot_keeper.h"

#include <fmt/format.h>

#include <utility>

#include "core/error.h"
#include "io/atomic_file.h"
#include "job/file_identity.h"
#include "pack/features.h"
#include "render/pilot/pilot_file.h"

namespace eikon {
namespace {

constexpr std::size_t kMaxKept = 16;  // of some megabytes each

bool exists(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::exists(file, ignored);
}

}  // namespace

std::optional<Pilot> PilotCache::find(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto found = pilots_.find(key);
  if (found == pilots_.end()) return std::nullopt;
  Pilot pilot = found->second;
  pilot.report.loaded = true;
  pilot.report.seconds = 0;
  return pilot;
}

void PilotCache::put(const std::string& key, const Pilot& pilot) {
  const std::lock_guard lock(mutex_);
  if (pilots_.size() >= kMaxKept) pilots_.clear();
  pilots_.insert_or_assign(key, pilot);
}

PilotKeeper::PilotKeeper(std::string file, const std::vector<std::filesystem::path>& outputs, Log log)
    : file_(std::move(file)), log_(std::move(log)) {
  if (file_.empty()) return;
  if (file_ == kStandardOutput) throw UsageError("--pilot: takes the name of a file, not standard output");
  for (const std::filesystem::path& output : outputs)
    if (!output.empty() && is_same_file(file_, output))
      throw UsageError(fmt::format("--pilot {}: an output has that name; choose another one", file_));
  if (!exists(file_)) const AtomicFile probe(file_);  // made under its temporary name, and removed again
}

void PilotKeeper::begin(const Prepared& prepared, const Execution& execution, bool quiet) {
  const Scene& scene = *prepared.scene;
  const Features features(scene, prepared.settings);
  settings_ = pilot_settings_of(scene, prepared.settings, film_layout(features, prepared.settings));
  key_ = execution.devices + "\n";  // one of other arithmetic learns other things
  for (const ImageSetting& setting : settings_) key_ += setting.name + ": " + setting.value + "\n";
  if (file_.empty()) return;
  const bool wanted = wants_pilot(features, prepared.settings);
  if (!wanted && !quiet)
    log_(fmt::format("--pilot: this image has no pilot, so {} is neither read nor written", file_));
  if (wanted && exists(file_)) read_ = read_pilot(file_, settings_);
}

void PilotKeeper::attach(RenderHooks& hooks, PilotCache* cache) {
  hooks.pilot = [this, cache] { return read_ || cache == nullptr ? read_ : cache->find(key_); };
  hooks.pilot_done = [this, cache](const Pilot& pilot) {
    if (cache != nullptr) cache->put(key_, pilot);
    if (!file_.empty()) write(pilot);
  };
}

/// Another render may have written the file meanwhile, such as a job of the same batch. It stays,
/// and where it is no pilot of this image, that is said.
void PilotKeeper::write(const Pilot& pilot) {
  try {
    if (exists(file_))
      (void)read_pilot(file_, settings_);
    else
      write_pilot(file_, pilot, settings_);
  } catch (const InputError& error) {
    log_(fmt::format("--pilot: {}; the render goes on", error.what()));
    as_asked_ = false;
  }
}

}  // namespace eikon
