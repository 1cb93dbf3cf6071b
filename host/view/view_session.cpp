// SPDX-License-Identifier: Apache-2.0
#include "view/view_session.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/clock.h"
#include "core/lost_threads.h"
#include "image/denoise.h"
#include "view/view_engine.h"

namespace eikon {
namespace {

constexpr double kPatience_s = 0.3;      // with threads, at the end
constexpr double kLongestPath_s = 60;    // until a path is traced again: its program may have to be compiled
constexpr std::size_t kMaxThreads = 3;   // one that is listened to, and others that load what nobody wants any more

}  // namespace

ViewSession::ViewSession(std::vector<std::string> given, ParseRender parse, ViewLook look)
    : board_(std::make_shared<ViewBoard>(std::move(look))), parse_(std::move(parse)), given_(std::move(given)) {
  start(false);
  board_->set_denoiser(Denoiser::problem());
}

ViewSession::~ViewSession() {
  end();
  const double begin_s = host_seconds();
  for (join_ended(); !threads_.empty() && host_seconds() - begin_s < kPatience_s; join_ended())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  for (EngineThread& left : threads_) {
    thread_is_lost();
    left.thread.detach();
  }
}

void ViewSession::open(const std::string& scene) {
  const std::lock_guard lock(mutex_);
  join_ended();
  if (threads_.size() >= kMaxThreads)
    throw InputError("view: the scenes that were opened before are still being loaded; try again in a while");
  given_ = words_of_other_scene(scene, given_);
  start(true);
}

Json ViewSession::path(const PixelSample& at) { return board_->path(at, kLongestPath_s); }

void ViewSession::start(bool is_other_scene) {
  const auto orders = std::make_shared<EngineOrders>();
  const auto ended = std::make_shared<std::atomic<bool>>(false);
  auto engine = std::make_unique<ViewEngine>(board_, orders,
                                             std::make_unique<SceneryLoader>(given_, parse_, is_other_scene), pool_);
  board_->set_engine(orders, is_other_scene);
  threads_.push_back({std::thread([engine = std::move(engine), ended]() mutable {
                        engine->run();
                        engine.reset();
                        *ended = true;
                      }),
                      ended});
}

void ViewSession::join_ended() {
  std::erase_if(threads_, [](EngineThread& one) {
    if (!*one.ended) return false;
    one.thread.join();
    return true;
  });
}

}  // namespace eikon
