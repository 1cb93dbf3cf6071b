// SPDX-License-Identifier: Apache-2.0
// Devices for renders one after the other: while one renders, the next is made ready (compiled, uploaded) on devices of its own. Two
// pools take turns.
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
#include "render/ready_wavefronts.h"
#include "pack/settings.h"

namespace eikon {

class ReadyAhead {
 public:
  struct Image {
    std::shared_ptr<PackedScene> packed;  // gets the trees that devices need and it lacks
    std::shared_ptr<const void> keep;     // what `packed` refers to
    Features features;
    Settings settings;
    Execution execution;
  };

  /// What a render has of it: where it is to take its devices from.
  class Turn {
   public:
    Turn(ReadyAhead& of, DevicePool pool) : pool_(std::move(pool)), of_(of) {}
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn() { under_way(); }
    [[nodiscard]] DevicePool& pool() { return pool_; }
    /// It has opened its devices, or is over. Until then nothing is made ready for the next one: drivers compile one program at a time.
    void under_way();

   private:
    DevicePool pool_;
    ReadyAhead& of_;
    bool told_ = false;
  };

  /// pool: what is known of its devices is shared, as with DevicePool::sibling()
  explicit ReadyAhead(const DevicePool& pool = DevicePool());
  /// The turn of a render; it must not outlive this. Called once for each, in their order, when the one before it has its turn and may be
  /// rendering, but the one before that has ended.
  ///
  /// Where the devices of the other pool could do with it, they are made ready before this returns: unless that would take memory or
  /// threads that a limit does not grant, or faults are planned, which count what a device does. Nothing is thrown: what cannot
  /// be made ready is tried again by the render, which says why. A device that hangs meanwhile is given up, see
  /// DevicePool::give_up(). Once `stop` is set it is not waited for.
  [[nodiscard]] std::unique_ptr<Turn> turn(const Image& image, const std::atomic<bool>& stop);
  /// The same for a render that nothing is known of yet.
  [[nodiscard]] std::unique_ptr<Turn> turn();
  /// Of both pools.
  void close_idle();

 private:
  struct Lane {
    DevicePool pool;
    std::deque<std::string> ready;  // what its devices have, as far as is known: keys of images
  };
  std::mutex mutex_;
  std::condition_variable changed_;
  std::array<Lane, 2> lanes_;
  std::size_t last_ = 0;                // the lane of the last turn
  std::uint64_t turns_ = 0, told_ = 0;  // turns so far, and those whose renders are under way, or over
  const void* packed_ = nullptr;        // of the last turn; null: not known

  [[nodiscard]] std::size_t choose(const Image& image, const std::string& key, bool& prepare);
};

}  // namespace eikon
