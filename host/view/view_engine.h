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

/// Renders what a board asks for, as long as it has a seat there.
class ViewEngine {
 public:
  ViewEngine(std::shared_ptr<ViewBoard> board, std::shared_ptr<ViewSeat> seat, std::unique_ptr<Sceneries> sceneries,
             DevicePool pool);
  void run();

 private:
  static constexpr double kErrorShare = 0.05;  // of the time goes into predicting the error

  /// Says of which samples a picture is, and of what size.
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
  const std::shared_ptr<ViewSeat> seat_;
  const std::unique_ptr<Sceneries> sceneries_;
  DevicePool pool_;
  std::optional<Scenery> scenery_{};  // none: it could not be loaded, or rendered
  ViewLook shown_{};                  // by scenery_
  std::uint64_t shown_number_ = 0;    // of that look
  std::string compiled_{};            // features of the last picture
  std::uint64_t small_ = 4;           // side of the block that a pixel of the small picture stands for
  double begin_s_ = 0;                // of the samples that are shown
  TimeShare predicting_{kErrorShare};
  PredictedError error_{};            // as it was predicted last, for the picture that is shown
  std::unique_ptr<ViewDenoiser> denoiser_{};
  std::shared_ptr<std::atomic<bool>> denoised_{};  // such a picture is shown, which the noisy one must not replace
};

}  // namespace eikon
