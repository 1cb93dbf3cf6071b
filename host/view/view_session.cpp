// SPDX-License-Identifier: Apache-2.0
#include "view/view_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/clock.h"
#include "job/batch/job_lines.h"
#include "view/scene_outline.h"
#include "view/view_frame.h"

namespace eikon {
namespace {

constexpr double kWatch_s = 0.5;         // between two looks at the files
constexpr double kWake_s = 0.005;        // until a render sees that somebody asked for another picture
constexpr double kLongestRound_s = 0.1;  // of samples, unless one sample takes longer: units end with their round
constexpr double kPublish_s = 0.2;       // between two pictures that refine
constexpr double kFastSmall_s = 0.02, kSlowSmall_s = 0.06;  // for a small picture
constexpr std::uint64_t kLeastSmall = 2, kMostSmall = 16;   // pixels along the side that one of it stands for
constexpr double kErrorShare = 0.05;                        // of the time goes into predicting the error
constexpr double kLongestPath_s = 60;    // until a path is traced again: its program may have to be compiled
constexpr std::size_t kMostWaiting = 4;  // paths

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

/// A point far along a ray that leaves the scene, nearer if the far one is behind the camera.
glm::dvec3 end_in_front(const Settings& settings, const glm::dvec3& from, const glm::dvec3& along, double radius_m) {
  double distance_m = 4 * radius_m;
  while (distance_m > 1e-3 * radius_m && pixel_of(settings, from + distance_m * along).is_null()) distance_m *= 0.8;
  return from + distance_m * along;
}

/// JSON as text; what is not UTF-8, as names of files may be, is replaced.
std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

ViewSession::ViewSession(std::vector<std::string> given, ParseRender parse, ViewLook look)
    : sceneries_(std::move(given), std::move(parse)), wanted_(std::move(look)) {
  write_status();
  thread_ = std::thread([this] { run(); });
}

ViewSession::~ViewSession() {
  end();
  thread_.join();
}

void ViewSession::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  over_ = stop_ = true;
  changed_.notify_all();
}

std::uint64_t ViewSession::look(const ViewLook& look) {
  const std::lock_guard lock(mutex_);
  if (look == wanted_) return look_number_;
  wanted_ = look;
  ask_anew();
  return look_number_;
}

void ViewSession::ask_anew() {
  ++look_number_;
  is_new_ = true;
  stop_ = true;
  write_status();
}

void ViewSession::open(const std::string& scene) {
  const std::lock_guard lock(mutex_);
  wanted_scene_ = scene;
  ViewLook first{.flags = {{"--size", wanted_.flags.at("--size")}}, .png = wanted_.png};
  wanted_ = std::move(first);
  ask_anew();
}

void ViewSession::pause(bool is_paused) {
  const std::lock_guard lock(mutex_);
  paused_ = is_paused;
  stop_ = true;
  changed_.notify_all();
}

ViewNews ViewSession::news(std::uint64_t version, double most_s) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(most_s), [&] { return ended_ || version_ != version; });
  return {version_, status_text_, frame_};
}

std::vector<std::string> ViewSession::words() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> words = status_.words;
  if (words.empty()) return words;
  for (const auto& [name, value] : wanted_.png) words.push_back(fmt::format("{}={}", name, value));
  return words;
}

Json ViewSession::path(const PixelSample& at) {
  const auto request = std::make_shared<PathRequest>(PathRequest{.at = at});
  std::unique_lock lock(mutex_);
  if (paths_.size() >= kMostWaiting) throw InputError("view: other paths are traced first; try again");
  paths_.push_back(request);
  stop_ = true;
  changed_.notify_all();
  changed_.wait_for(lock, std::chrono::duration<double>(kLongestPath_s), [&] { return ended_ || request->over; });
  if (!request->over) throw InputError("view: the path was not traced in time; try again");
  if (!request->error.empty()) throw InputError(request->error);
  return Json::parse(request->answer);
}

void ViewSession::run() {
  while (const std::optional<Task> task = next_task()) {
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

/// Waits for it, a while; none at the end.
std::optional<ViewSession::Task> ViewSession::next_task() {
  std::unique_lock lock(mutex_);
  const bool renders = status_.state == "rendering" && !paused_;
  if (!renders)
    changed_.wait_for(lock, std::chrono::duration<double>(kWatch_s),
                      [&] { return ended_ || is_new_ || !paths_.empty(); });
  if (ended_) return std::nullopt;
  Task task;
  if (std::exchange(is_new_, false)) {
    task.look = wanted_;
    task.scene = std::exchange(wanted_scene_, {});
  } else if (!paths_.empty()) {
    task.request = paths_.front();
    paths_.pop_front();
  }
  task.number = look_number_;
  task.renders = !paused_;
  stop_ = !paths_.empty();
  return task;
}

void ViewSession::serve(const Task& task) {
  if (task.request) return answer(*task.request);
  if (task.look) shown_number_ = task.number;
  if (!task.scene.empty()) {
    sceneries_.open(task.scene);
    scenery_.reset();
  }
  const bool is_outdated = sceneries_.is_outdated();
  if (is_outdated) scenery_.reset();
  if (task.look || is_outdated) show(task.look.value_or(shown_));
  if (scenery_ && task.renders && !shown_.moving && !is_finished()) render();
}

bool ViewSession::is_finished() const {
  if (!scenery_->film) return false;
  const Settings& settings = scenery_->prepared.settings;
  return scenery_->film->done.missing(settings.crop, settings.sample_begin, settings.sample_end).empty();
}

/// Shows at once what there is to be shown of a look.
void ViewSession::show(const ViewLook& look) {
  const bool renders_same = scenery_ && look.flags == shown_.flags && (scenery_->has_layers || !look.needs_layers());
  const bool looks_same = look.layer == shown_.layer && look.mix == shown_.mix;
  shown_ = look;
  if (!renders_same) load();
  if (look.layer == "lights" && scenery_->kept->scene->light_groups.size() < 2)
    throw UsageError("the scene has no light groups; choose another layer");
  const Settings& settings = scenery_->prepared.settings;
  if (!renders_same || (!looks_same && !scenery_->film))
    show_small();
  else if (!looks_same)
    publish(scenery_->film->film, settings,
            scenery_->film->done.complete_until(settings.crop, settings.sample_begin, settings.sample_end) -
                settings.sample_begin,
            false);
  say(look.moving ? "moving" : is_finished() ? "done" : "rendering");
}

void ViewSession::load() {
  if (!scenery_) say("loading");
  scenery_.reset();
  scenery_ = sceneries_.load(shown_);
  const Json outline = scene_outline(*scenery_->kept->scene, scenery_->bounds, scenery_->prepared.settings);
  const std::lock_guard lock(mutex_);
  status_.words = scenery_->words;
  status_.notes = scenery_->notes;
  status_.scene = dumped(outline);
}

RenderHooks ViewSession::usual_hooks() {
  RenderHooks hooks;
  hooks.devices = &pool_;
  hooks.devices_stay_ready = true;
  hooks.keep = scenery_->kept->scene;
  hooks.wake_s = kWake_s;
  return hooks;
}

/// A picture of few pixels with one sample each, which a new look does not interrupt: somebody who keeps moving the camera
/// sees something, too.
void ViewSession::show_small() {
  const Settings small = reduced(scenery_->prepared.settings, small_);
  const std::string program = scenery_->features.summary();
  const bool compiles = std::exchange(compiled_, program) != program;
  if (compiles) say("compiling");
  const double begin_s = host_seconds();
  const RenderOutput done =
      render_packed(scenery_->packed, scenery_->features, small, scenery_->execution, over_, usual_hooks());
  const double took_s = host_seconds() - begin_s;
  begin_s_ = error_at_s_ = host_seconds();
  error_ = {};
  if (done.done.empty()) return;
  publish(done.film, small, 1, true);
  if (compiles) return;
  if (took_s > kSlowSmall_s) small_ = std::min(2 * small_, kMostSmall);
  if (took_s < kFastSmall_s) small_ = std::max(small_ / 2, kLeastSmall);
}

void ViewSession::render() {
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
      publish(now.film, settings, now.done - settings.sample_begin, false);
    }
    // Rounds grow while that makes them no longer than somebody who moves the camera likes to wait.
    if (took_s < 0.5 * kLongestRound_s) step *= 2;
    if (took_s > kLongestRound_s) step = std::max<std::uint64_t>(step / 2, 1);
    round_begin_s = host_seconds();
    return {.end = std::min(now.done + step, settings.sample_end)};
  };
  hooks.progress = [&](const Progress&, const Film&) {
    if (sceneries_.is_outdated()) stop_ = true;
  };
  hooks.pilot = [&] { return scenery_->pilot; };
  hooks.pilot_done = [&](const Pilot& pilot) { scenery_->pilot = pilot; };
  hooks.begin_with = std::exchange(scenery_->film, std::nullopt);
  RenderOutput done =
      render_packed(scenery_->packed, scenery_->features, settings, scenery_->execution, stop_, std::move(hooks));
  scenery_->film = std::move(static_cast<FilmState&>(done));
  if (is_finished()) say("done");
}

/// Predicts it anew if that took little of the time so far, or the picture is done.
void ViewSession::predict_error(const Film& film, bool is_last) {
  const double begin_s = host_seconds();
  if (!is_last && begin_s - error_at_s_ < error_took_s_ / kErrorShare) return;
  error_ = film.predicted_error();
  error_at_s_ = host_seconds();
  error_took_s_ = error_at_s_ - begin_s;
}

void ViewSession::publish(const Film& film, const Settings& settings, std::uint64_t samples, bool small) {
  const double seconds = host_seconds() - begin_s_;
  const Settings& whole = scenery_->prepared.settings;
  const Json about = {
      {"width", settings.width},
      {"height", settings.height},
      {"layer", shown_.layer},
      {"small", small},
      {"samples", samples},
      {"samples_total", whole.sample_end - whole.sample_begin},
      {"rate", number_or_null(seconds > 0 && !small, double(samples * settings.crop.pixel_count()) / seconds)},
      {"error", number_or_null(error_.known, error_.relmse)},
      {"error_low", number_or_null(error_.known, error_.lo)},
      {"error_high", number_or_null(error_.known, error_.hi)}};
  auto frame = std::make_shared<ViewFrame>();
  frame->pixels = view_pixels(film, shown_);
  const std::lock_guard lock(mutex_);
  frame->number = frame_ ? frame_->number + 1 : 1;
  frame->about = about.dump();
  frame_ = std::move(frame);
  ++version_;
  changed_.notify_all();
}

void ViewSession::answer(PathRequest& request) {
  std::string text, wrong;
  try {
    text = trace(request.at).dump();
  } catch (const std::exception& error) {
    wrong = error.what();
  }
  const std::lock_guard lock(mutex_);
  request.answer = std::move(text);
  request.error = std::move(wrong);
  request.over = true;
  changed_.notify_all();
}

Json ViewSession::trace(const PixelSample& at) {
  if (!scenery_) throw UsageError("view: there is no picture of which a path could be traced");
  const Settings& settings = scenery_->prepared.settings;
  if (at.x >= settings.width || at.y >= settings.height)
    throw UsageError(fmt::format("view: the picture has {} x {} pixels", settings.width, settings.height));
  Json vertices = Json::array();
  const auto add = [&](const glm::dvec3& point, const Json& distance) {
    vertices.push_back(
        {{"point", {point.x, point.y, point.z}}, {"pixel", pixel_of(settings, point)}, {"distance", distance}});
  };
  const double radius_m = radius_of(scenery_->bounds);
  const ReadyScene scene{.packed = scenery_->packed,
                         .features = scenery_->features,
                         .devices = pool_,
                         .keep = scenery_->kept->scene,
                         .pilot = scenery_->pilot};
  const ReplayedSample replayed = replay_path(scene, settings, scenery_->execution, at, [&](const PathVertex& v) {
    const glm::dvec3 from(v.origin), along(v.dir);
    if (vertices.empty()) add(from, nullptr);
    if (v.triangle != EK_NO_HIT)
      add(from + double(v.t) * along, v.t);
    else
      add(end_in_front(settings, from, along, radius_m), nullptr);
  });
  glm::vec3 light_paths(0.0F);
  for (const ReplayedSample::Splat& splat : replayed.splats) light_paths += splat.radiance;
  const glm::vec3& r = replayed.radiance;
  return {{"vertices", std::move(vertices)},
          {"radiance", {r.x, r.y, r.z}},
          {"light_paths", {light_paths.x, light_paths.y, light_paths.z}}};
}

void ViewSession::say(const std::string& state, const std::string& error) {
  const std::lock_guard lock(mutex_);
  status_.state = state;
  status_.look = shown_number_;
  status_.error = error;
  write_status();
}

void ViewSession::write_status() {
  std::vector<std::string> words = status_.words;
  words.insert(words.begin(), {"eikon", "render"});
  for (const auto& [name, value] : wanted_.png) words.push_back(fmt::format("{}={}", name, value));
  words.insert(words.end(), {"--output=picture.exr", "--png=picture.png"});
  const Json texts = {{"state", status_.state},     {"state_of", status_.look},
                      {"error", status_.error},     {"command", status_.words.empty() ? "" : quote(words)},
                      {"notes", status_.notes},     {"look", look_json(wanted_)},
                      {"look_number", look_number_}};
  status_text_ = fmt::format("{{\"scene\":{},{}", status_.scene, dumped(texts).substr(1));
  ++version_;
  changed_.notify_all();
}

}  // namespace eikon
