// SPDX-License-Identifier: Apache-2.0
// The board holds what pages ask for and what they are shown. Threads of pages and of a ViewEngine
// meet here, and nowhere else.
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "io/json_text.h"
#include "view/view_look.h"
#include "wavefront/wavefront.h"

namespace eikon {

/// A picture as a page shows it.
struct ViewFrame {
  std::uint64_t number = 0;           // grows by one with each
  std::string about;                  // JSON: width, height, layer, small, samples, samples_total, rate, error
  std::vector<unsigned char> pixels;  // view_pixels()
};

/// The status, and the latest picture if it is new to whoever asks.
struct ViewNews {
  std::uint64_t version = 0;
  std::string status;  // JSON: state and of which look, error, notes, denoiser, command, scene, look, look_number
  std::shared_ptr<const ViewFrame> frame;  // null: none yet
};

/// The orders of a board to one engine. They also tell engines apart: a board takes pictures and
/// states only from the engine whose orders it was given last, because one that still loads or
/// compiles for an earlier scene cannot be interrupted.
struct EngineOrders {
  std::atomic<bool> stop{false};  // ends the render that is under way
  std::atomic<bool> over{false};  // ends the engine
};

/// Stands between the pages of a view and the engine that renders for them. Any thread may call it.
class ViewBoard {
 public:
  struct PathRequest {
    PixelSample at{};
    bool over = false;
    std::string answer{}, error{};  // JSON, or what is wrong
  };
  /// The next thing that an engine does; at most one of `look` and `request` is set.
  struct Task {
    std::optional<ViewLook> look{};          // another one than before
    std::uint64_t number = 0;                // of the look
    std::shared_ptr<PathRequest> request{};  // a path to be traced; null: none
    bool renders = false;                    // goes on with the picture after that
  };

  explicit ViewBoard(ViewLook look);

  // ---- for pages

  /// Asks for another picture.
  /// returns  the number of the look, which grows with each
  std::uint64_t look(const ViewLook& look);
  /// While it is paused, only what is asked for anew is rendered, and only small.
  void pause(bool is_paused);
  /// Waits until there is something that a page with this version does not know, but at most for so
  /// many seconds.
  [[nodiscard]] ViewNews news(std::uint64_t version, double most_s);
  /// The words behind `eikon render` that make the picture which is shown; empty while none is
  /// known.
  [[nodiscard]] std::vector<std::string> words();
  /// Waits until the engine has answered, but at most for so long. throws InputError
  [[nodiscard]] Json path(const PixelSample& at, double most_s);
  /// From now on the board listens to the engine with these orders, and tells the one before it to
  /// end. The engine begins with the look in force, or, for another scene, with the view that its
  /// file has.
  void set_engine(std::shared_ptr<EngineOrders> orders, bool is_other_scene);
  /// Ends every wait and the engine. Any number of times.
  void end();

  // ---- for engines; what an engine says whose orders are not the board's any more has no effect

  /// Waits for a task, but for half a second at most: the engine then looks whether files of the
  /// scene have changed. Nothing means that the engine is to end.
  [[nodiscard]] std::optional<Task> next_task(const EngineOrders& orders);
  /// Tells pages a state (Status::state).
  /// number  of the look that is in that state
  void say(const EngineOrders& orders, const std::string& state, std::uint64_t number, const std::string& error = "");
  /// words    behind `eikon render`, without names of output files
  /// outline  scene_outline()
  void describe(const EngineOrders& orders, const std::vector<std::string>& words,
                const std::vector<std::string>& notes, const Json& outline);
  /// Shows a picture. about, pixels: as ViewFrame has them
  void publish(const EngineOrders& orders, const Json& about, std::vector<unsigned char> pixels);
  /// Answers the request for a path. answer: JSON; error: empty, or what is wrong
  void answer(PathRequest& request, std::string answer, std::string error);
  /// Says why there are no pictures without noise; empty: there are.
  void set_denoiser(const std::string& problem);

 private:
  struct Status {
    /// "loading", "building", "compiling", "moving" or "rendering", "done"; or "failed".
    std::string state = "loading";
    std::uint64_t look = 0;         // number of the look of which that is the state
    std::string error{};            // why it failed
    std::vector<std::string> words{}, notes{};
    std::string scene = "null";  // JSON of scene_outline()
    std::string denoiser{};
  };

  void ask_anew();  // with mutex_ held, as the next
  void write_status();
  [[nodiscard]] bool has(const EngineOrders& orders) const { return orders_.get() == &orders; }

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::shared_ptr<EngineOrders> orders_ = std::make_shared<EngineOrders>();
  ViewLook wanted_;
  std::uint64_t look_number_ = 1;
  bool is_new_ = true, paused_ = false, ended_ = false;
  std::deque<std::shared_ptr<PathRequest>> paths_{};
  std::uint64_t version_ = 1;
  Status status_{};
  std::string status_text_{};
  std::shared_ptr<const ViewFrame> frame_{};
};

}  // namespace eikon
