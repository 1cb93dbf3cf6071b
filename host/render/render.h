// SPDX-License-Identifier: Apache-2.0
// Renders a loaded scene to a film: one thread per device, each of which takes work units from one
// schedule. host/README.md describes how a render goes.
#pragma once
#include <array>
#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "device/device_pool.h"
#include "pack/features.h"
#include "pack/settings.h"
#include "render/device_report.h"
#include "render/film_store.h"
#include "render/pilot/pilot.h"

namespace eikon {

/// Why a render ended.
enum class RenderEnd {
  all_samples,   // every sample of the settings is in the film
  target_error,  // RenderHooks::next_round ended it, as the picture is good enough
  time_limit,    // the time of Round::latest_s came
  interrupted,   // it was stopped, or no device was left
};

[[nodiscard]] inline const char* name_of(RenderEnd end) {  // as --stats has it
  return std::array{"spp", "target-error", "time", "interruption"}.at(std::size_t(end));
}

/// Tells what a render did and how it ended, for --stats, headers and messages.
struct RenderReport : RenderTotals {
  /// The arithmetic classes of the devices that took part in this run, "exact" or "exact,
  /// other-1a2b3c4d".
  [[nodiscard]] std::string arithmetic() const;

  std::vector<DeviceReport> devices;
  std::vector<DeviceEvent> events;   // in the order of time; empty when all went well
  std::vector<std::string> notes;    // for the user, on the choice of devices and the pilot; a line each
  std::uint64_t samples_before = 0;  // samples that the render began with (RenderHooks::begin_with)
  RenderEnd end = RenderEnd::all_samples;
  [[nodiscard]] bool interrupted() const { return end == RenderEnd::interrupted; }
  std::string features;                       // of the kernels: Features::summary()
  std::vector<FeatureEntry> feature_entries;  // each with the reason why the kernels have it or not
  void set_features(const Features& of_kernels) {
    features = of_kernels.summary();
    feature_entries = of_kernels.entries();
  }
  std::uint64_t triangles = 0;       // with each instance counted
  std::uint64_t geometry_bytes = 0;  // of the packed scene, with the tree of the first device
  bool reinserted = false;           // that tree was improved by reinsertion, because many rays were expected
  PilotReport pilot;
  double pack_s = 0, build_s = 0;      // build_s: of the trees
  double compile_s = 0, upload_s = 0;  // of the slowest device
};

/// Tells how far a render is.
struct Progress {
  // Both include the samples that the render began with.
  std::uint64_t samples = 0, samples_total = 0;
  double seconds = 0;             // since the first unit of this run was in the film
  double samples_per_second = 0;  // of this run
  double share = 0;               // of the work that is done, 0 to 1
  double left_s = 0;              // seconds until the render is likely to end
};

/// Called about four times a second from the calling thread; the callback may read the film during
/// the call.
using ProgressCallback = std::function<void(const Progress&, const Film&)>;

/// The film between two rounds, while the devices rest.
struct RoundEnd {
  std::uint64_t done = 0;  // sample index: every pixel has all samples of the settings' range below it
  bool exact = true;       // and no pixel has others; false only before the first round of a render that was resumed
  double render_s = 0;     // seconds of rendering so far, the pilot included; 0 before the first round
  const Film& film;
};

/// The part of a render that is done next.
struct Round {
  std::uint64_t end = 0;  // sample index: beyond RoundEnd::done; RoundEnd::done itself ends the render
  /// Units are sized to end by this time, on the clock of host_seconds(); the render then ends with
  /// what is done.
  double latest_s = std::numeric_limits<double>::infinity();
};

/// The input and the callbacks of a render. All calls come from the calling thread.
struct RenderHooks {
  ProgressCallback progress = {};
  /// Divides the render into rounds: called before the first and after each. Its own time does not
  /// count as rendering. Unset: one round.
  std::function<Round(const RoundEnd&)> next_round = {};
  /// If the pilot has not ended by then, on the clock of host_seconds(), the render ends without a
  /// sample. Round::latest_s is for what comes after the pilot.
  double latest_s = std::numeric_limits<double>::infinity();
  /// Returns the pilot of this image if it is known; it is rendered if not. Called at most once, if
  /// the image has one.
  std::function<std::optional<Pilot>()> pilot = {};
  /// Called with the pilot, if it was rendered for this image. An exception ends the render.
  std::function<void(const Pilot&)> pilot_done = {};
  /// A film of the same scene and settings that the render continues; samples outside the settings'
  /// range stay in it.
  std::optional<FilmState> begin_with = {};
  /// Called once the trees are built, before devices are opened and programs compiled.
  std::function<void()> opening = {};
  /// Called once no device is being opened any more, unless the render ends before.
  std::function<void()> under_way = {};
  /// Called with what is done so far: after every checkpoint_every_s seconds in which there was
  /// progress, soon after *checkpoint_now was set (the call clears it), and at the end, however the
  /// render ends, if anything was done since the last call. It gets a copy, and the devices go on
  /// meanwhile. An exception ends the render.
  std::function<void(const FilmState&)> checkpoint = {};
  double checkpoint_every_s = 60;
  std::atomic<bool>* checkpoint_now = nullptr;
  /// The most of the time that goes into predicting the error for Execution::trace.
  double error_share = 1.0 / 200;
  /// The pool that devices come from and go back to; null: they are opened for this render alone.
  DevicePool* devices = nullptr;
  /// The most seconds until the calling thread sees that `stop` is set.
  double wake_s = 0.05;
  /// Programs and buffers for this packed scene stay on the devices, for another render of it.
  bool devices_stay_ready = false;
  /// The owner of a scene that render() or render_and_release() packs. It is kept until the last
  /// thread of the render has ended, which may be after the render, because a thread that hangs in
  /// a driver is not waited for.
  std::shared_ptr<const void> scene_owner = {};
};

/// The film of a render, also of one that was stopped, and the report about it.
struct RenderOutput : FilmState {
  RenderReport report;
};

/// The film that an image of these settings needs.
FilmLayout film_layout(const Features& features, const Settings& settings);

/// Renders `scene` as `settings` say on the devices of `execution`. Stops early, with what is done,
/// once `stop` is set; `next_round` is not called then. A device that fails loses the units that it
/// has, which others do; the report says so.
/// throws DeviceError when no device is left, after the last checkpoint; UsageError, InputError
RenderOutput render(const Scene& scene, const Settings& settings, const Execution& execution,
                    const std::atomic<bool>& stop, RenderHooks hooks = {});

/// The same, but frees the meshes as soon as devices have them: only the materials of their
/// primitives are left.
RenderOutput render_and_release(Scene& scene, const Settings& settings, const Execution& execution,
                                const std::atomic<bool>& stop, RenderHooks hooks = {});

/// The same for a scene that is packed already. `packed` gets the trees that devices need and it
/// lacks; it can be rendered again.
/// features  of the scene with `settings`, as it was packed
RenderOutput render_packed(std::shared_ptr<PackedScene> packed, const Features& features, const Settings& settings,
                           const Execution& execution, const std::atomic<bool>& stop, RenderHooks hooks = {});

/// A scene that is packed already, and the devices that may be open.
struct ReadyScene {
  std::shared_ptr<PackedScene> packed;
  Features features;             // of the scene with the settings, as it was packed
  DevicePool devices{};          // a replay's program stays on the device of the pool, for the next one
  std::optional<Pilot> pilot{};  // of the image; none: it is rendered if the image has one
};

/// Traces the path of one sample again, on the first device, and reports its vertices.
/// sample  pixels of the full image, whatever Settings::crop is
/// returns  the light that the path brings, and what light paths of the same sample index bring to
///          the pixel
/// throws DeviceError
ReplayedSample replay_path(const ReadyScene& scene, const Settings& settings, const Execution& execution,
                           const PixelSample& sample, const std::function<void(const PathVertex&)>& report);
/// The same for a scene that is packed for this.
ReplayedSample replay_path(const Scene& scene, const Settings& settings, const Execution& execution,
                           const PixelSample& sample, const std::function<void(const PathVertex&)>& report);

/// render() throws this when no device is left but some samples are done; `output` is that of an
/// interrupted render.
struct NoDeviceLeft : DeviceError {
  NoDeviceLeft(const std::string& why, RenderOutput rendered)
      : DeviceError(why), output(std::make_shared<RenderOutput>(std::move(rendered))) {}
  std::shared_ptr<RenderOutput> output;  // shared, because exceptions are copied
};

}  // namespace eikon
