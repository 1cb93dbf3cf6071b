// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "render/device_sessions.h"
#include "render/render.h"

namespace eikon {

/// The rounds of a render (RenderHooks::next_round), one after the other.
class Rounds {
 public:
  /// Decides on the first round. begin: the film that the render begins with; pilot_s: seconds of
  /// its pilot, which count as rendering throws InternalError if a round ends before it begins, or
  /// beyond the samples
  Rounds(const RenderHooks& hooks, const Settings& settings, const FilmState& begin, double pilot_s);
  /// No round is left.
  [[nodiscard]] bool over() const { return round_.end == done_; }
  [[nodiscard]] bool is_out_of_time() const;
  void open(DeviceSessions& sessions) const;
  /// The devices have done the round: decides on the next. throws as the constructor
  void close(DeviceSessions& sessions);

 private:
  void decide(const RoundEnd& now);

  const RenderHooks& hooks_;
  const Settings& settings_;
  double pilot_s_;
  std::uint64_t done_;
  Round round_;
};

}  // namespace eikon
