// SPDX-License-Identifier: Apache-2.0
#include "job/tev/tev_viewer.h"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "core/clock.h"
#include "core/error.h"
#include "core/lost_threads.h"

namespace eikon {
namespace {

// Seconds without a byte that the viewer takes: while the render goes on, and when only the last
// picture is left.
constexpr double kPatience_s = 10, kLastPatience_s = 5;
constexpr double kMaxAtEnd_s = 60;   // that the end of a render waits for a viewer that reads slowly
constexpr double kReserve_s = 1;     // for the thread to notice that the time is over
constexpr std::chrono::milliseconds kPollInterval{50};
constexpr double kCopyingShare = 1.0 / 50;  // of the time of the devices, which wait for it

}  // namespace

struct TevViewer::Picture {
  Image image;
  std::uint32_t width = 0, height = 0;  // of the whole image
  TevPlace at;                          // of the window that was rendered

  Picture(const Film& film, const ExrOptions& exr)
      : image(image_part(film, exr)),
        width(film.layout().width),
        height(film.layout().height),
        at{film.layout().crop.x0, film.layout().crop.y0} {}
};

struct TevViewer::Shared {
  std::mutex mutex;  // guards all below
  std::condition_variable changed;
  std::optional<Picture> picture;  // the next one
  bool wants = false;              // the thread waits for one
  bool last = false;               // none follows
  bool connected = false, ended = false, lost = false;
  double last_s = 0, most_s = 0;  // on the clock of host_seconds(): when `last` was set; the end of all patience
  std::string failure;

  /// The time to give up, if no byte is taken any more or not.
  [[nodiscard]] double latest_s() const {
    if (!last) return std::numeric_limits<double>::infinity();
    return connected ? most_s : std::min(most_s, last_s + kLastPatience_s);
  }

  // ---- for the thread that sends

  void run(const TevTarget& target) {
    std::string why;
    try {
      send_all(target);
    } catch (const InputError& error) {
      why = error.what();
    } catch (const std::bad_alloc&) {
      why = "out of memory";
    }
    const std::lock_guard lock(mutex);
    failure = why;
    ended = true;
    wants = false;
    picture.reset();
    if (lost) lost_thread_ended();
    changed.notify_all();
  }

  [[nodiscard]] std::unique_ptr<TcpSender> connect_to(const NetworkAddress& address) {
    try {
      return std::make_unique<TcpSender>(address, [this](double stalled_s) {
        const std::lock_guard lock(mutex);
        return stalled_s > (last ? kLastPatience_s : kPatience_s) || host_seconds() >= latest_s();
      });
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("{}; start tev first, which listens at 127.0.0.1:14158 or its own --hostname", error.what()));
    }
  }

  void send_all(const TevTarget& target) {
    const std::unique_ptr<TcpSender> sender = connect_to(target.address);
    {
      const std::lock_guard lock(mutex);
      connected = true;
    }
    bool created = false;
    while (const std::optional<Picture> next = wait_for_picture()) {
      if (!std::exchange(created, true)) {
        TevImage image{
            .name = target.name, .width = next->width, .height = next->height, .channels = next->image.channels};
        for (const char* colour : kRgb) {
          const std::string channel = fmt::format("denoised.{}", colour);
          if (target.denoised && next->image.plane(channel) == nullptr) image.channels.push_back(channel);
        }
        sender->send(tev_create(image));
      }
      tev_update(target.name, next->image, next->at, [&](const std::string& message) { sender->send(message); });
    }
  }

  std::optional<Picture> wait_for_picture() {
    std::unique_lock lock(mutex);
    wants = !last;
    changed.wait(lock, [this] { return picture.has_value() || last; });
    wants = false;
    return std::exchange(picture, std::nullopt);
  }

  // ---- for the thread of the render

  [[nodiscard]] bool is_waiting() {
    const std::lock_guard lock(mutex);
    return wants;
  }
  [[nodiscard]] bool is_over() {
    const std::lock_guard lock(mutex);
    return ended;
  }
  void put(Picture next) {
    const std::lock_guard lock(mutex);
    if (ended) return;
    picture = std::move(next);
    wants = false;
    changed.notify_all();
  }
  /// No picture follows the one that waits, and all is to be over in so many seconds.
  void end_within(double seconds) {
    const std::lock_guard lock(mutex);
    last = true;
    last_s = host_seconds();
    most_s = last_s + seconds;
    changed.notify_all();
  }
  /// Returns false, once the time is over, if the thread is lost.
  [[nodiscard]] bool wait_for_end() {
    std::unique_lock lock(mutex);
    while (!ended && host_seconds() < latest_s() + kReserve_s) changed.wait_for(lock, kPollInterval);
    if (ended) return true;
    lost = true;
    failure = "its name is still being looked up";
    thread_is_lost();
    return false;
  }
};

TevViewer::TevViewer(TevTarget target, Log log)
    : target_(std::move(target)), log_(std::move(log)), shared_(std::make_shared<Shared>()), copying_(kCopyingShare) {
  thread_ = std::thread([shared = shared_, to = target_] { shared->run(to); });
}

TevViewer::~TevViewer() { end_within(0); }

void TevViewer::attach(RenderHooks& hooks) {
  hooks.progress = [this, usual = std::move(hooks.progress)](const Progress& progress, const Film& film) {
    if (progress.samples > 0) offer(film);
    if (usual) usual(progress, film);
  };
}

void TevViewer::offer(const Film& film) {
  tell_failure();
  if (!copying_.is_due() || !shared_->is_waiting()) return;
  copying_.run([&] { shared_->put(Picture(film, target_.exr)); });
}

void TevViewer::show_last(const Film& film, const ExrOptions& exr) {
  if (!shared_->is_over()) shared_->put(Picture(film, exr));
}

void TevViewer::close() {
  end_within(kMaxAtEnd_s);
  tell_failure();
}

void TevViewer::end_within(double seconds) {
  if (!thread_.joinable()) return;
  shared_->end_within(seconds);
  if (shared_->wait_for_end())
    thread_.join();
  else
    thread_.detach();
}

void TevViewer::tell_failure() {
  std::string why;
  {
    const std::lock_guard lock(shared_->mutex);
    why = std::exchange(shared_->failure, {});
  }
  if (!why.empty())
    log_(fmt::format("--tev {}: {}; nothing more is shown there; the image is not affected",
                     target_.address.text(), why));
}

}  // namespace eikon
