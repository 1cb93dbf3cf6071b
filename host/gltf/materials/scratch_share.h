// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace eikon {

/// The memory that decoders on several threads may take beside their images. A decoder waits while
/// those at work leave too little of it; one that needs more than there is works alone.
class ScratchShare {
 public:
  explicit ScratchShare(std::uint64_t bytes) : bytes_(bytes), left_(bytes) {}

  /// Calls `work`, which takes up to `bytes` of the memory while it runs and waits for no other
  /// caller.
  template <class Work>
  void with(std::uint64_t bytes, const Work& work) {
    const Part part(*this, std::min(bytes, bytes_));
    work();
  }

 private:
  struct Part {
    Part(ScratchShare& of, std::uint64_t bytes) : share(of), size(bytes) {
      std::unique_lock lock(share.mutex_);
      share.returned_.wait(lock, [&] { return size <= share.left_; });
      share.left_ -= size;
    }
    ~Part() {
      {
        const std::lock_guard lock(share.mutex_);
        share.left_ += size;
      }
      share.returned_.notify_all();
    }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

    ScratchShare& share;
    std::uint64_t size;
  };

  const std::uint64_t bytes_;
  std::mutex mutex_;
  std::condition_variable returned_;
  std::uint64_t left_;
};

}  // namespace eikon
