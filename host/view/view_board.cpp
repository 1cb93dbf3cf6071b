// SPDX-License-Identifier: Apache-2.0
#include "view/view_board.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "io/json_dump.h"
#include "job/batch/shell_words.h"

namespace eikon {
namespace {

constexpr double kWatch_s = 0.5;         // between two looks at the files
constexpr std::size_t kMaxWaiting = 4;   // paths

std::chrono::duration<double> seconds(double s) { return std::chrono::duration<double>(s); }

}  // namespace

ViewBoard::ViewBoard(ViewLook look) : wanted_(std::move(look)) { write_status(); }

void ViewBoard::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  orders_->over = orders_->stop = true;
  changed_.notify_all();
}

void ViewBoard::set_engine(std::shared_ptr<EngineOrders> orders, bool is_other_scene) {
  const std::lock_guard lock(mutex_);
  orders_->over = orders_->stop = true;
  orders_ = std::move(orders);
  if (ended_) orders_->over = orders_->stop = true;
  paths_.clear();  // of the picture of the engine before
  if (is_other_scene) {
    ViewLook first{.flags = {{"--size", wanted_.flags.at("--size")}}, .png = wanted_.png};
    wanted_ = std::move(first);
    status_.state = "loading";
    status_.error.clear();
    status_.words.clear();
    ask_anew();
    status_.look = look_number_;
  }
  write_status();
}

std::uint64_t ViewBoard::look(const ViewLook& look) {
  const std::lock_guard lock(mutex_);
  if (look == wanted_) return look_number_;
  wanted_ = look;
  ask_anew();
  return look_number_;
}

void ViewBoard::ask_anew() {
  ++look_number_;
  is_new_ = true;
  orders_->stop = true;
  write_status();
}

void ViewBoard::pause(bool is_paused) {
  const std::lock_guard lock(mutex_);
  paused_ = is_paused;
  orders_->stop = true;
  changed_.notify_all();
}

ViewNews ViewBoard::news(std::uint64_t version, double most_s) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, seconds(most_s), [&] { return ended_ || version_ != version; });
  return {version_, status_text_, frame_};
}

std::vector<std::string> ViewBoard::words() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> words = status_.words;
  if (words.empty()) return words;
  for (const auto& [name, value] : wanted_.png) words.push_back(fmt::format("{}={}", name, value));
  return words;
}

Json ViewBoard::path(const PixelSample& at, double most_s) {
  const auto request = std::make_shared<PathRequest>(PathRequest{.at = at});
  std::unique_lock lock(mutex_);
  if (paths_.size() >= kMaxWaiting) throw InputError("view: other paths are traced first; try again");
  const std::shared_ptr<EngineOrders> asked = orders_;
  paths_.push_back(request);
  asked->stop = true;
  changed_.notify_all();
  changed_.wait_for(lock, seconds(most_s), [&] { return ended_ || request->over || orders_ != asked; });
  if (!request->over) {
    std::erase(paths_, request);
    throw InputError("view: the path was not traced in time; try again");
  }
  if (!request->error.empty()) throw InputError(request->error);
  return Json::parse(request->answer);
}

std::optional<ViewBoard::Task> ViewBoard::next_task(const EngineOrders& orders) {
  std::unique_lock lock(mutex_);
  const bool renders = status_.state == "rendering" && !paused_;
  if (!renders) changed_.wait_for(lock, seconds(kWatch_s), [&] { return orders.over || is_new_ || !paths_.empty(); });
  if (orders.over) return std::nullopt;
  Task task;
  if (std::exchange(is_new_, false)) {
    task.look = wanted_;
  } else if (!paths_.empty()) {
    task.request = paths_.front();
    paths_.pop_front();
  }
  task.number = look_number_;
  task.renders = !paused_;
  orders_->stop = !paths_.empty();
  return task;
}

void ViewBoard::say(const EngineOrders& orders, const std::string& state, std::uint64_t number,
                    const std::string& error) {
  const std::lock_guard lock(mutex_);
  if (!has(orders)) return;
  status_.state = state;
  status_.look = number;
  status_.error = error;
  write_status();
}

void ViewBoard::describe(const EngineOrders& orders, const std::vector<std::string>& words,
                         const std::vector<std::string>& notes, const Json& outline) {
  const std::lock_guard lock(mutex_);
  if (!has(orders)) return;
  status_.words = words;
  status_.notes = notes;
  status_.scene = dump_json(outline);
}

void ViewBoard::publish(const EngineOrders& orders, const Json& about, std::vector<unsigned char> pixels) {
  auto frame = std::make_shared<ViewFrame>();
  frame->about = about.dump();
  frame->pixels = std::move(pixels);
  const std::lock_guard lock(mutex_);
  if (!has(orders)) return;
  frame->number = frame_ ? frame_->number + 1 : 1;
  frame_ = std::move(frame);
  ++version_;
  changed_.notify_all();
}

void ViewBoard::answer(PathRequest& request, std::string answer, std::string error) {
  const std::lock_guard lock(mutex_);
  request.answer = std::move(answer);
  request.error = std::move(error);
  request.over = true;
  changed_.notify_all();
}

void ViewBoard::set_denoiser(const std::string& problem) {
  const std::lock_guard lock(mutex_);
  status_.denoiser = problem;
  write_status();
}

void ViewBoard::write_status() {
  std::vector<std::string> words = status_.words;
  words.insert(words.begin(), {"eikon", "render"});
  for (const auto& [name, value] : wanted_.png) words.push_back(fmt::format("{}={}", name, value));
  words.insert(words.end(), {"--output=picture.exr", "--png=picture.png"});
  const Json texts = {{"state", status_.state},     {"state_of", status_.look},
                      {"error", status_.error},     {"command", status_.words.empty() ? "" : quote(words)},
                      {"notes", status_.notes},     {"denoiser", status_.denoiser},
                      {"look", look_json(wanted_)}, {"look_number", look_number_}};
  status_text_ = fmt::format("{{\"scene\":{},{}", status_.scene, dump_json(texts).substr(1));
  ++version_;
  changed_.notify_all();
}

}  // namespace eikon
