// SPDX-License-Identifier: Apache-2.0
#include "view/view_engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/clock.h"
#include "film/exr/film_file.h"
#include "image/denoise.h"
#include "view/scene_outline.h"
#include "view/traced_path.h"
#include "view/view_frame.h"

namespace eikon {
namespace {

constexpr double kWake_s = 0.005;        // until a render sees that somebody asked for another picture
constexpr double kLongestRound_s = 0.1;  // of samples, unless one sample takes longer: units end with their round
constexpr double kPublish_s = 0.2;       // between two pictures that refine
constexpr double kFastSmall_s = 0.02, kSlowSmall_s = 0.06;  // for a small picture
constexpr std::uint64_t kMinSmall = 2, kMaxSmall = 16;      // pixels along the side that one of it stands for

/// The same picture with one sample for each block of pixels.
Settings reduced(const Settings& settings, std::uint64_t side) {
  Settings small = settings;
  small.width = std::uint32_t(std::max<std::uint64_t>(1, settings.width / side));
  small.height = std::uint32_t(std::max<std::uint64_t>(1, settings.height / side));
  small.crop = {0, 0, small.width, small.height};
  small.sample_end = small.sample_begin + 1;
  if (settings.light_path_count > 0)
    small.light_path_count = std::max<std::uint64_t>(1, settings.light_path_count / (side * side));
  small.guiding = Guiding::off;  // a pilot would take longer than the picture
  small.pilot_paths = small.light_trial_paths = 0;
  return small;
}

Json number_or_null(bool is_known, double value) {
  return is_known && std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace

ViewEngine::ViewEngine(std::shared_ptr<ViewBoard> board, std::shared_ptr<EngineOrders> orders,
                       std::unique_ptr<SceneryLoader> scenery_loader, DevicePool pool)
    : board_(std::move(board)),
      orders_(std::move(orders)),
      scenery_loader_(std::move(scenery_loader)),
      pool_(std::move(pool)) {}

void ViewEngine::run() {
  while (const std::optional<ViewBoard::Task> task = board_->next_task(*orders_)) {
    std::string wrong;
    try {
      serve(*task);
      continue;
    } catch (const Error& error) {
      wrong = error.what();
    } catch (const std::bad_alloc&) {
      wrong = "out of memory; try a smaller picture or scene";
    } catch (const std::exception& error) {
      wrong = fmt::format("internal error: {}", error.what());
    }
    scenery_.reset();
    say("failed", wrong);
  }
}

void ViewEngine::say(const std::string& state, const std::string& error) {
  board_->say(*orders_, state, shown_number_, error);
}

void ViewEngine::serve(const ViewBoard::Task& task) {
  if (task.request) return answer(*task.request);
  if (task.look) shown_number_ = task.number;
  const bool is_outdated = scenery_loader_->is_outdated();
  if (is_outdated) scenery_.reset();
  if (task.look || is_outdated) show(task.look.value_or(shown_));
  if (scenery_ && task.renders && !shown_.moving && !is_finished()) render();
}

bool ViewEngine::is_finished() const {
  if (!scenery_->film) return false;
  const Settings& settings = scenery_->prepared.settings;
  return scenery_->film->sample_set.missing(settings.crop, settings.sample_begin, settings.sample_end).empty();
}

/// Shows at once what there is to be shown of a look.
void ViewEngine::show(const ViewLook& look) {
  const bool renders_same = scenery_ && look.flags == shown_.flags && (scenery_->has_layers || !look.needs_layers());
  const bool looks_same = look.layer == shown_.layer && look.mix == shown_.mix;
  shown_ = look;
  if (!renders_same || !looks_same) {
    if (denoiser_) denoiser_->forget();
    denoised_ = std::make_shared<std::atomic<bool>>(false);
  }
  if (!renders_same) load();
  if (look.layer == "lights" && scenery_->kept->scene->light_groups.size() < 2)
    throw UsageError("the scene has no light groups; choose another layer");
  const Settings& settings = scenery_->prepared.settings;
  if (!renders_same || (!looks_same && !scenery_->film)) {
    show_small();
  } else if (!looks_same) {
    const FilmState& done = *scenery_->film;
    const std::uint64_t end = done.sample_set.complete_until(settings.crop, settings.sample_begin, settings.sample_end);
    publish(done.film, {.settings = settings, .samples = end - settings.sample_begin}, is_finished());
  }
  say(look.moving ? "moving" : is_finished() ? "done" : "rendering");
}

void ViewEngine::load() {
  scenery_.reset();
  // Loading and packing say so only where they are done: most looks need neither.
  scenery_ = scenery_loader_->load(shown_, [this](const char* phase) { say(phase); });
  board_->describe(*orders_, scenery_->words, scenery_->notes,
                   scene_outline(*scenery_->kept->scene, scenery_->bounds, scenery_->prepared.settings));
}

RenderHooks ViewEngine::usual_hooks() {
  RenderHooks hooks;
  hooks.devices = &pool_;
  hooks.devices_stay_ready = true;
  hooks.wake_s = kWake_s;
  return hooks;
}

/// A picture of few pixels with one sample each, which a new look does not interrupt: somebody who
/// keeps moving the camera sees something, too.
void ViewEngine::show_small() {
  const Settings small = reduced(scenery_->prepared.settings, small_);
  const std::string program = scenery_->features.summary();
  const bool compiles = std::exchange(compiled_, program) != program;
  RenderHooks hooks = usual_hooks();
  if (compiles) hooks.opening = [this] { say("compiling"); };
  const double begin_s = host_seconds();
  const RenderOutput done =
      render_packed(scenery_->packed, scenery_->features, small, scenery_->execution, orders_->over, std::move(hooks));
  const double took_s = host_seconds() - begin_s;
  begin_s_ = host_seconds();
  predicting_.rest();
  error_ = {};
  if (done.sample_set.empty()) return;
  publish(done.film, {.settings = small, .samples = 1, .small = true}, false);
  if (compiles) return;
  if (took_s > kSlowSmall_s) small_ = std::min(2 * small_, kMaxSmall);
  if (took_s < kFastSmall_s) small_ = std::max(small_ / 2, kMinSmall);
}

void ViewEngine::render() {
  const Settings& settings = scenery_->prepared.settings;
  RenderHooks hooks = usual_hooks();
  std::uint64_t step = 1, published = 0;
  double round_begin_s = host_seconds(), published_s = 0;
  hooks.next_round = [&](const RoundEnd& now) -> Round {
    const double now_s = host_seconds(), took_s = now_s - round_begin_s;
    const bool is_last = now.done == settings.sample_end;
    if (now.exact && now.done > settings.sample_begin && now.done > published &&
        (is_last || now_s - published_s > kPublish_s)) {
      published = now.done;
      published_s = now_s;
      predict_error(now.film, is_last);
      publish(now.film, {.settings = settings, .samples = now.done - settings.sample_begin}, is_last);
    }
    // Rounds grow while that makes them no longer than somebody who moves the camera likes to wait.
    if (took_s < 0.5 * kLongestRound_s) step *= 2;
    if (took_s > kLongestRound_s) step = std::max<std::uint64_t>(step / 2, 1);
    round_begin_s = host_seconds();
    return {.end = std::min(now.done + step, settings.sample_end)};
  };
  hooks.progress = [&](const Progress&, const Film&) {
    if (scenery_loader_->is_outdated()) orders_->stop = true;
  };
  hooks.pilot = [&] { return scenery_->pilot; };
  hooks.pilot_done = [&](const Pilot& pilot) { scenery_->pilot = pilot; };
  hooks.begin_with = std::exchange(scenery_->film, std::nullopt);
  RenderOutput done = render_packed(scenery_->packed, scenery_->features, settings, scenery_->execution, orders_->stop,
                                    std::move(hooks));
  scenery_->film = std::move(static_cast<FilmState&>(done));
  if (is_finished()) say("done");
}

/// Predicts the error anew if it is time for that, or the picture is done.
void ViewEngine::predict_error(const Film& film, bool is_last) {
  if (is_last || predicting_.is_due()) predicting_.run([&] { error_ = film.predicted_error(); });
}

void ViewEngine::publish(const Film& film, const Shown& shown, bool is_last) {
  const double seconds = host_seconds() - begin_s_;
  const Settings& whole = scenery_->prepared.settings;
  const std::uint64_t pixels = shown.settings.crop.pixel_count();
  Json about = {{"width", shown.settings.width},
                {"height", shown.settings.height},
                {"layer", shown_.layer},
                {"small", shown.small},
                {"samples", shown.samples},
                {"samples_total", whole.sample_end - whole.sample_begin},
                {"rate", number_or_null(seconds > 0 && !shown.small, double(shown.samples * pixels) / seconds)},
                {"error", number_or_null(error_.known, error_.relmse)},
                {"error_low", number_or_null(error_.known, error_.lo)},
                {"error_high", number_or_null(error_.known, error_.hi)}};
  if (shown_.layer == "denoised") {
    if (!shown.small) denoise(film, about, shown.samples, is_last);
    about["layer"] = "picture";  // until there is one without noise
    if (*denoised_) return;
  }
  board_->publish(*orders_, about, view_pixels(film, shown_));
}

void ViewEngine::denoise(const Film& film, const Json& about, std::uint64_t samples, bool is_last) {
  if (!denoiser_)
    denoiser_ = std::make_unique<ViewDenoiser>(
        scenery_->execution.threads, [board = board_](const std::string& problem) { board->set_denoiser(problem); });
  if (!is_last && !denoiser_->pays(samples)) return;
  denoiser_->begin(to_image(film, Denoiser::kAuxiliary), samples,
                   [board = board_, orders = orders_, about, shown = denoised_](const Image& picture) {
                     *shown = true;
                     board->publish(*orders, about, view_pixels(picture));
                   });
}

void ViewEngine::answer(ViewBoard::PathRequest& request) {
  std::string text, wrong;
  try {
    if (!scenery_) throw UsageError("view: there is no picture of which a path could be traced");
    text = traced_path(*scenery_, pool_, request.at).dump();
  } catch (const std::exception& error) {
    wrong = error.what();
  }
  board_->answer(request, std::move(text), std::move(wrong));
}

}  // namespace eikon
