// SPDX-License-Identifier: Apache-2.0
#include "render/rounds.h"

#include "core/clock.h"

namespace eikon {

Rounds::Rounds(const RenderHooks& hooks, const Settings& settings, const FilmState& begin, double pilot_s)
    : hooks_(hooks),
      settings_(settings),
      pilot_s_(pilot_s),
      done_(begin.sample_set.complete_until(settings.crop, settings.sample_begin, settings.sample_end)) {
  const std::uint64_t below = settings.crop.pixel_count() * (done_ - settings.sample_begin);
  decide({done_, begin.sample_set.sample_count() == below, 0, begin.film});
}

bool Rounds::is_out_of_time() const { return host_seconds() >= round_.latest_s; }

void Rounds::open(DeviceSessions& sessions) const {
  if (over()) return;
  sessions.set_latest(round_.latest_s);
  sessions.open(sessions.film().missing(settings_.crop, done_, round_.end));
}

void Rounds::close(DeviceSessions& sessions) {
  if (over()) return;
  done_ = round_.end;
  sessions.film().read([&](const Film& film) { decide({done_, true, sessions.totals().render_s + pilot_s_, film}); });
}

void Rounds::decide(const RoundEnd& now) {
  round_ = hooks_.next_round ? hooks_.next_round(now) : Round{.end = settings_.sample_end};
  if (round_.end < done_ || round_.end > settings_.sample_end)
    throw InternalError("a round ends before it begins, or beyond the samples");
}

}  // namespace eikon
