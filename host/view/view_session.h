// SPDX-License-Identifier: Apache-2.0
// One scene that is rendered anew whenever somebody asks to see it otherwise. A thread of its own renders, from a small
// picture to one with all samples; any thread may ask and look.
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "render/render.h"
#include "view/scenery.h"

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
  std::string status;  // JSON: state and of which look, error, notes, command, scene, look, look_number
  std::shared_ptr<const ViewFrame> frame;  // null: none yet
};

class ViewSession {
 public:
  /// given  the words behind `eikon view` that `eikon render` knows, too
  /// parse  reads such words
  /// Begins at once, as `look` has it.
  ViewSession(std::vector<std::string> given, ParseRender parse, ViewLook look);
  ~ViewSession();
  ViewSession(const ViewSession&) = delete;
  ViewSession& operator=(const ViewSession&) = delete;

  /// Asks for another picture. What is wrong with it shows in the status.
  /// returns  the number of the look, which grows with each
  std::uint64_t look(const ViewLook& look);
  /// Shows another scene, from where its file has the camera.
  void open(const std::string& scene);
  /// Paused: only what is asked for anew is rendered, and only small.
  void pause(bool is_paused);
  /// Waits until there is something newer than `version`, at most for so long.
  [[nodiscard]] ViewNews news(std::uint64_t version, double most_s);
  /// The words behind `eikon render` for the picture in force, without names of output files; none before it is loaded.
  [[nodiscard]] std::vector<std::string> words();
  /// Traces the path of a sample of the picture in force again:
  ///   "vertices"  [{"pixel", "point", "distance"}]: where the path was, from the camera on; pixel and distance may be null
  ///   "radiance"  that it brings, "light_paths" that light paths of the same sample bring to the pixel
  /// throws UsageError, DeviceError; InputError if there is no answer in time
  [[nodiscard]] Json path(const PixelSample& at);
  /// Ends the thread, and every wait. Any number of times.
  void end();

 private:
  struct PathRequest {
    PixelSample at{};
    bool over = false;
    std::string answer{}, error{};  // JSON, or what is wrong
  };
  struct Status {
    std::string state = "loading";  // or compiling, moving, rendering, done, failed
    std::uint64_t look = 0;         // number of the look of which that is the state
    std::string error{};            // why it failed
    std::vector<std::string> words{}, notes{};
    std::string scene = "null";  // JSON of scene_outline()
  };
  /// The next thing that the thread does.
  struct Task {
    std::optional<ViewLook> look{};          // another one than before
    std::uint64_t number = 0;                // of the look
    std::string scene{};                     // another one is to be opened; empty: none
    std::shared_ptr<PathRequest> request{};  // a path to be traced; null: none
    bool renders = false;                    // goes on with the picture after that
  };

  void run();
  [[nodiscard]] std::optional<Task> next_task();
  void serve(const Task& task);
  void show(const ViewLook& look);
  [[nodiscard]] bool is_finished() const;
  void load();
  void show_small();
  void render();
  [[nodiscard]] RenderHooks usual_hooks();
  void publish(const Film& film, const Settings& settings, std::uint64_t samples, bool small);
  void predict_error(const Film& film, bool is_last);
  void answer(PathRequest& request);
  [[nodiscard]] Json trace(const PixelSample& at);
  void say(const std::string& state, const std::string& error = "");
  void ask_anew();  // with mutex_ held, as the next
  void write_status();

  Sceneries sceneries_;
  DevicePool pool_;

  // Only the thread uses these.
  std::optional<Scenery> scenery_{};  // none: it could not be loaded, or rendered
  ViewLook shown_{};                  // by scenery_
  std::uint64_t shown_number_ = 0;    // of that look
  std::string compiled_{};            // features of the last picture
  std::uint64_t small_ = 4;           // side of the block that a pixel of the small picture stands for
  double begin_s_ = 0, error_at_s_ = 0, error_took_s_ = 0;
  PredictedError error_{};

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  ViewLook wanted_;
  std::uint64_t look_number_ = 1;
  std::string wanted_scene_{};
  bool is_new_ = true, paused_ = false, ended_ = false;
  std::deque<std::shared_ptr<PathRequest>> paths_{};
  std::uint64_t version_ = 1;
  Status status_{};
  std::string status_text_{};
  std::shared_ptr<const ViewFrame> frame_{};

  std::atomic<bool> stop_{false};  // the render that is under way
  std::atomic<bool> over_{false};  // everything
  std::thread thread_;
};

}  // namespace eikon
