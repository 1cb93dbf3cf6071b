// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/time_share.h"
#include "render/render.h"
#include "view/scenery.h"
#include "view/view_board.h"
#include "view/view_denoiser.h"

namespace eikon {

/// Renders what a board asks for, until its orders end it. run() is the body of a thread of its
/// own, which nothing can interrupt while it loads or compiles, so the engine owns or shares all
/// that it uses.
class ViewEngine {
 public:
  ViewEngine(std::shared_ptr<ViewBoard> board, std::shared_ptr<EngineOrders> orders,
             std::unique_ptr<SceneryLoader> scenery_loader, DevicePool pool);
  /// Returns when `orders` end the engine. Errors become a state of the board.
  void run();

 private:
  static constexpr double kErrorShare = 0.05;  // of the time goes into predicting the error

  /// The size of a picture, and how many samples it shows.
  struct Shown {
    const Settings& settings;
    std::uint64_t samples = 0;  // per pixel
    bool small = false;
  };

  void serve(const ViewBoard::Task& task);
  void show(const ViewLook& look);
  [[nodiscard]] bool is_finished() const;
  void load();
  void show_small();
  void render();
  [[nodiscard]] RenderHooks usual_hooks();
  void publish(const Film& film, const Shown& shown, bool is_last);
  void denoise(const Film& film, const Json& about, std::uint64_t samples, bool is_last);
  void predict_error(const Film& film, bool is_last);
  void answer(ViewBoard::PathRequest& request);
  void say(const std::string& state, const std::string& error = "");

  const std::shared_ptr<ViewBoard> board_;
  const std::shared_ptr<EngineOrders> orders_;
  const std::unique_ptr<SceneryLoader> scenery_loader_;
  DevicePool pool_;
  std::optional<Scenery> scenery_{};  // none: it could not be loaded, or rendered
  ViewLook shown_{};                  // by scenery_
  std::uint64_t shown_number_ = 0;    // of that look
  std::string compiled_{};            // features of the programs that were compiled last
  std::uint64_t small_ = 4;           // a pixel of the small picture stands for a block of so many pixels squared
  double begin_s_ = 0;                // of the samples that are shown
  TimeShare predicting_{kErrorShare};
  PredictedError error_{};  // as it was predicted last, for the picture that is shown
  std::unique_ptr<ViewDenoiser> denoiser_{};
  /// True once the look has a picture without noise, which noisy ones must not replace. Each look
  /// has its own, because the denoiser's thread sets it.
  std::shared_ptr<std::atomic<bool>> denoised_{};
};

}  // namespace eikon
