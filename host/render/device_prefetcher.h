// SPDX-License-Identifier: Apache-2.0
// Prepares devices for the renders of a batch: while one image is rendered, programs and buffers of
// the next are made ready on devices of another pool. Two pools take turns, unless the next image
// needs nothing but trees.
#pragma once
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "device/device_pool.h"
#include "pack/settings.h"
#include "render/ready_wavefronts.h"

namespace eikon {

/// Prepares the devices of a batch's next render while another thread renders.
class DevicePrefetcher {
 public:
  struct Image {
    std::shared_ptr<PackedScene> packed;  // gets the trees that devices need and it lacks
    Features features;
    Settings settings;
    Execution execution;
  };

  /// The turn of one render: the pool from which it is to take its devices.
  class Turn {
   public:
    Turn(DevicePrefetcher& owner, DevicePool pool) : pool_(std::move(pool)), owner_(owner) {}
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn() { under_way(); }
    [[nodiscard]] DevicePool& pool() { return pool_; }
    /// The render has opened its devices, or is over. Nothing is prepared for the next render
    /// before that, because drivers compile one program at a time.
    void under_way();

   private:
    DevicePool pool_;
    DevicePrefetcher& owner_;
    bool told_ = false;
  };

  /// pool: what is known of its devices is shared, as with DevicePool::sibling()
  explicit DevicePrefetcher(const DevicePool& pool = DevicePool());
  /// The turn of a render; it must not outlive this. To be called once per render, in their order,
  /// when the render before has its turn (it may be under way) and the one before that has ended.
  ///
  /// Prepares the devices of the other pool for the image before it returns, where that helps. It
  /// does not where that would take memory or threads beyond a limit, nor under planned faults,
  /// which count what a device does. It throws nothing: the render tries again what failed here,
  /// and reports the error. A device that hangs meanwhile is abandoned (DevicePool::abandon()).
  /// Once `stop` is set it waits no longer.
  [[nodiscard]] std::unique_ptr<Turn> turn(const Image& image, const std::atomic<bool>& stop);
  /// The same for a render of which nothing is known yet.
  [[nodiscard]] std::unique_ptr<Turn> turn();
  /// Closes idle devices of both pools.
  void close_idle();

 private:
  struct PreparedPool {
    DevicePool pool;
    // Keys of the images that its devices are ready for, as far as is known.
    std::deque<std::string> ready;
    std::string program{};  // tells which program its last image needs; empty: not known
  };
  std::mutex mutex_;
  std::condition_variable changed_;
  std::array<PreparedPool, 2> pools_;
  std::size_t last_ = 0;  // index of the pool of the last turn
  std::uint64_t turns_ = 0;       // that were given so far
  std::uint64_t under_way_ = 0;   // those whose renders have opened their devices, or are over
  const void* packed_ = nullptr;  // scene of the last turn; null: not known

  struct Choice {
    std::size_t pool;
    bool prepare;  // the image is to be made ready there
  };
  [[nodiscard]] Choice choose(const Image& image, const std::string& key) const;
  [[nodiscard]] bool has_only_cpus(const Image& image);
};

}  // namespace eikon
