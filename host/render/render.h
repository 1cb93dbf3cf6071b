// SPDX-License-Identifier: Apache-2.0
// A render from a loaded scene to a film: one thread per device, each pulling work units from one queue.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "device/device_pool.h"
#include "render/device_report.h"
#include "render/film_store.h"
#include "pack/settings.h"

namespace eikon {

struct RenderReport {
  /// The arithmetic classes of the devices that took part in this run, "exact" or "exact, other-1a2b3c4d".
  [[nodiscard]] std::string arithmetic() const;

  std::vector<DeviceReport> devices;
  std::vector<DeviceEvent> events;  // in the order of time; empty when all went well
  std::vector<std::string> notes;   // on the choice of devices, a line each
  RayCounts rays;
  std::uint64_t samples = 0;                   // finished, rejected ones included
  std::uint64_t samples_before = 0;            // those that the render began with
  std::uint64_t given_up = 0;  // rays whose search for an implicit surface took too many steps, before their hit: they went on
  std::uint32_t given_up_surfaces = 0;  // for which shapes: bit i of Scene::shapes[i], bit 31 of [31] and all behind it
  std::uint64_t nonfinite = 0, saturated = 0;  // left out of the film
  std::vector<RejectedSample> rejected;        // the first few
  bool interrupted = false;
  std::string features;
  std::uint64_t triangles = 0, geometry_bytes = 0;  // tree and triangles, of the first device
  bool reinserted = false;                          // its tree was improved, since so many rays were expected
  double pack_s = 0, build_s = 0, compile_s = 0, upload_s = 0, render_s = 0, first_sample_s = 0;
};

struct Progress {
  std::uint64_t samples = 0, samples_total = 0;  // of all that was asked for; those that the render began with are done
  double seconds = 0;                            // of rendering
  double samples_per_second = 0;                 // of this run
};

/// Called about four times a second from the calling thread; the film may be looked at during the call.
using ProgressCallback = std::function<void(const Progress&, const Film&)>;

/// Places at which the devices stop, so that the film can be looked at when it holds exactly the samples below at[i] of every
/// pixel. at: increasing, within the settings' range. look(at[i], seconds of rendering so far, film); what it takes does not
/// count as rendering.
struct Looks {
  std::vector<std::uint64_t> at;
  std::function<void(std::uint64_t, double, const Film&)> look;
};

/// What a render starts with and hands out as it goes. All calls come from the calling thread.
struct RenderHooks {
  ProgressCallback progress = {};
  Looks looks = {};
  /// What is done already, with the same scene and settings; samples outside the settings' range may be there too and stay.
  std::optional<FilmState> begin_with = {};
  /// Called once no device is being opened any more, unless the render ends before.
  std::function<void()> under_way = {};
  /// Called with what is done so far: after every checkpoint_every_s seconds in which there was progress, soon after
  /// *checkpoint_now was set (which is cleared), and at the end, however the render ends, if anything was done since the last call.
  /// The devices go on meanwhile: what is given is a copy. What it throws ends the render.
  std::function<void(const FilmState&)> checkpoint = {};
  double checkpoint_every_s = 60;
  std::atomic<bool>* checkpoint_now = nullptr;
  /// Where devices come from, and go back to; null: they are opened for this render alone.
  DevicePool* devices = nullptr;
  /// Whether what is ready on them for this packed scene stays there, for another render of the same.
  bool devices_stay_ready = false;
  /// What the scene belongs to. It is kept until the last of the render's threads has ended, which may be after the render: one that
  /// hangs in a driver is not waited for.
  std::shared_ptr<const void> keep = {};
};

struct RenderOutput {
  Film film;
  RenderReport report;
  SampleLedger done;                 // the samples that the film holds
  std::set<std::string> arithmetic;  // the classes of the devices that they are from
};

/// The film that an image of these settings needs.
FilmLayout film_layout(const Features& features, const Settings& settings);

/// Renders `scene` as `settings` say on the devices of `execution`. Stops early, with what is done, once `stop` is set;
/// looks are left out then. A device that fails loses the units that it has, which others do; the report says so.
/// throws DeviceError when no device is left, after the last checkpoint; UsageError, InputError
RenderOutput render(const Scene& scene, const Settings& settings, const Execution& execution,
                    const std::atomic<bool>& stop, RenderHooks hooks = {});

/// The same, but frees what the meshes hold as soon as devices have it: of their primitives only the materials are left.
RenderOutput render_and_release(Scene& scene, const Settings& settings, const Execution& execution,
                                const std::atomic<bool>& stop, RenderHooks hooks = {});

/// The same of a scene that is packed already; `packed` gets the trees that devices need and it lacks, and can be rendered again.
/// features  of the scene with `settings`, as it was packed
RenderOutput render_packed(std::shared_ptr<PackedScene> packed, const Features& features, const Settings& settings,
                           const Execution& execution, const std::atomic<bool>& stop, RenderHooks hooks = {});

/// Traces one path and reports its vertices; returns its radiance.
glm::vec3 replay_path(const Scene& scene, const Settings& settings, const Execution& execution, std::uint32_t x,
                      std::uint32_t y, std::uint64_t sample, const std::function<void(const PathVertex&)>& report);

}  // namespace eikon
