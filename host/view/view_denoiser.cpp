// SPDX-License-Identifier: Apache-2.0
#include "view/view_denoiser.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

#include "core/clock.h"
#include "core/lost_threads.h"
#include "image/denoise.h"

namespace eikon {
namespace {

constexpr double kMaxShare = 0.2;  // of the time goes into denoising
constexpr double kLongAgo_s = 1e9;
constexpr double kMoreSamples = 1.5;  // times those of the picture before

}  // namespace

struct ViewDenoiser::Work {
  struct Job {
    Image picture;
    std::uint64_t number;  // of forget() calls before it
    Done done;
  };

  Work(unsigned most_threads, Problem tell) : threads(most_threads), problem(std::move(tell)) {}

  const unsigned threads;
  const Problem problem;
  std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  std::optional<Job> next{};
  std::uint64_t forgotten = 0, samples = 0;
  double began_s = -kLongAgo_s, took_s = 0;
  bool busy = false, over = false, lost = false;

  void run() {
    std::unique_ptr<Denoiser> denoiser;
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [&] { return over || next; });
      if (over) return;
      Job job = std::move(*next);
      next.reset();
      busy = true;
      began_s = host_seconds();
      lock.unlock();
      const std::string wrong = denoise(denoiser, job.picture);
      lock.lock();
      took_s = host_seconds() - began_s;
      busy = false;
      if (lost) lost_thread_ended();
      if (over) return;
      try {
        if (!wrong.empty())
          problem(wrong);
        else if (job.number == forgotten)
          job.done(job.picture);
      } catch (const std::exception&) {
        // There is no memory to show it; the next picture is tried again.
      }
    }
  }

  /// Returns what is wrong.
  [[nodiscard]] std::string denoise(std::unique_ptr<Denoiser>& denoiser, Image& picture) const {
    try {
      if (!denoiser) denoiser = std::make_unique<Denoiser>(threads);
      denoiser->denoise(picture);
      return "";
    } catch (const std::exception& error) {
      return error.what();
    }
  }
};

ViewDenoiser::ViewDenoiser(unsigned threads, Problem problem)
    : work_(std::make_shared<Work>(threads, std::move(problem))), thread_([work = work_] { work->run(); }) {}

ViewDenoiser::~ViewDenoiser() {
  bool lost = false;
  {
    const std::lock_guard lock(work_->mutex);
    work_->over = true;
    lost = work_->lost = work_->busy;
    if (lost) thread_is_lost();
    work_->changed.notify_all();
  }
  lost ? thread_.detach() : thread_.join();
}

bool ViewDenoiser::pays(std::uint64_t samples) const {
  const std::lock_guard lock(work_->mutex);
  const bool waits = work_->busy || work_->next;
  return !waits && double(samples) >= kMoreSamples * double(work_->samples) &&
         host_seconds() - work_->began_s > work_->took_s / kMaxShare;
}

void ViewDenoiser::begin(Image picture, std::uint64_t samples, Done done) {
  const std::lock_guard lock(work_->mutex);
  work_->next.emplace(Work::Job{std::move(picture), work_->forgotten, std::move(done)});
  work_->samples = samples;
  work_->changed.notify_all();
}

void ViewDenoiser::forget() {
  const std::lock_guard lock(work_->mutex);
  ++work_->forgotten;
  work_->next.reset();
  work_->samples = 0;
  work_->began_s = -kLongAgo_s;
}

}  // namespace eikon
