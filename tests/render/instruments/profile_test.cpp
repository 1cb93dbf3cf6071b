// SPDX-License-Identifier: Apache-2.0
// Counts of the profile against the rays that were traced, and its times against the clock.
#include <algorithm>
#include <cstdlib>

#include "core/trace.h"
#include "render/scene_builder.h"
#include "wavefront/stages/stage_sampler.h"

namespace eikon::test {
namespace {

RenderOutput render_cornell(Execution execution, std::uint32_t size = 96, std::uint32_t spp = 16, int pool = 0) {
  const Scene scene = load_shipped("cornell.gltf");
  if (pool > 0) execution.unit_paths = std::uint32_t(pool);
  execution.extra_flags = kAsShipped;  // times are those of the code that users run
  return output_of(scene, settings_of(scene, size, spp), execution);
}

Bounce sum_of(const Bounces& bounces) {
  Bounce sum;
  for (const Bounce& bounce : bounces) {
    sum.paths += bounce.paths, sum.shadow_rays += bounce.shadow_rays;
    sum.lanes += bounce.lanes, sum.slots += bounce.slots;
  }
  return sum;
}

bool was_late(const RenderReport& report, const DeviceReport& device) {
  const auto index = std::size_t(&device - report.devices.data());
  return std::ranges::any_of(report.events, [&](const DeviceEvent& event) {
    return event.device == index && event.kind == DeviceEvent::Kind::late;
  });
}

void expect_counts_agree(const RenderReport& report) {
  RayCounts rays;
  std::uint64_t samples = 0;
  for (const DeviceReport& device : report.devices) {
    rays += device.rays;
    samples += device.samples;
    if (device.units == 0) continue;
    EXPECT_EQ(device.rays.camera, device.samples);
    // A device that has nothing left to do may repeat what another one is late with, and only one
    // of them counts. One that was too late with it tells nothing of its work.
    if (was_late(report, device)) continue;
    const RayCounts& repeated = device.repeated_rays;
    const std::uint64_t hits = device.rays.camera + device.rays.scattered + repeated.camera + repeated.scattered;
    const std::uint64_t shadow_rays = device.rays.shadow + repeated.shadow;
    const std::uint64_t paths = device.samples + repeated.camera;
    EXPECT_EQ(device.stages.at("generate").items, paths);
    EXPECT_EQ(device.stages.at("intersect").items, hits);
    EXPECT_EQ(device.stages.at("shade").items, hits);
    EXPECT_EQ(device.stages.at("shadow").items, shadow_rays);
    EXPECT_EQ(device.stages.at("film").items, paths);
    EXPECT_EQ(device.bounces[0].paths, paths);
    const Bounce all = sum_of(device.bounces);
    EXPECT_EQ(all.paths, hits) << "paths of all depths are all rays but the shadow rays";
    EXPECT_EQ(all.shadow_rays, shadow_rays);
    EXPECT_GE(all.lanes, all.paths);
    EXPECT_GE(all.slots, all.lanes);
  }
  EXPECT_EQ(rays.total(), report.rays.total());
  EXPECT_EQ(rays.shadow, report.rays.shadow);
  EXPECT_EQ(samples, report.samples);
}

void expect_times_agree(const RenderReport& report) {
  for (const DeviceReport& device : report.devices) {
    if (device.units == 0) continue;
    double stages_s = 0;
    for (const auto& [name, stage] : device.stages) {
      EXPECT_GE(stage.seconds, -1e-9) << name;
      EXPECT_LE(stage.seconds_min, stage.seconds_max) << name;
      stages_s += stage.seconds;
    }
    // The queue is in order, so nothing is counted twice; the gaps are within the render, what is
    // before and after is not theirs.
    EXPECT_LE(stages_s + device.gaps.seconds, device.busy_s * 1.001 + 1e-4);
    EXPECT_LE(device.busy_s, device.end_s - device.begin_s + 1e-9);
  }
}

TEST(Profile, counts_are_those_of_the_rays_whichever_way_stages_are_launched) {
  Execution fused, unfused, queued;
  fused.chunked = unfused.chunked = true;
  fused.fused = true, unfused.fused = false;
  queued.chunked = false, queued.lanes = 1;
  std::vector<Bounces> bounces;
  for (const Execution& execution : {fused, unfused, queued}) {
    const RenderOutput output = render_cornell(execution, 64, 4);
    expect_counts_agree(output.report);
    expect_times_agree(output.report);
    bounces.push_back(output.report.devices.at(0).bounces);
  }
  for (std::size_t depth = 0; depth < bounces[0].size(); ++depth) {
    EXPECT_EQ(bounces[0][depth].paths, bounces[1][depth].paths) << depth;
    EXPECT_EQ(bounces[0][depth].paths, bounces[2][depth].paths) << depth;
    EXPECT_EQ(bounces[0][depth].shadow_rays, bounces[2][depth].shadow_rays) << depth;
  }
}

TEST(Profile, most_of_the_time_is_that_of_stages) {
  // On a busy machine any share of the time may pass while the device waits for a core, but not in
  // every attempt.
  double share = 0;
  for (int attempt = 0; attempt < 20 && share <= 0.2; ++attempt) {
    const RenderOutput output = render_cornell({}, 96, 64);
    const DeviceReport& device = output.report.devices.at(0);
    double stages_s = 0;
    for (const auto& [name, stage] : device.stages) stages_s += stage.seconds;
    share = stages_s / device.busy_s;
  }
  EXPECT_GT(share, 0.2);
}

TEST(Profile, of_two_devices_adds_up) {
  Execution execution;
  execution.devices = "cpu:2x1";
  const RenderOutput output = render_cornell(execution, 96, 16, 4096);
  ASSERT_EQ(output.report.devices.size(), 2U);
  expect_counts_agree(output.report);
  expect_times_agree(output.report);
}

TEST(Profile, without_a_counter_stages_are_sampled_and_the_bits_stay) {
  Execution ticks, none;
  ticks.chunked = none.chunked = ticks.fused = none.fused = true;
  none.ticks = false;
  const RenderOutput with = render_cornell(ticks, 128, 64), without = render_cornell(none, 128, 64);
  EXPECT_TRUE(same_bits(with.film, without.film));
  expect_counts_agree(without.report);
  const DeviceReport& device = without.report.devices.at(0);
  EXPECT_NEAR(device.stages.at("paths").seconds, 0, 1e-6) << "all of it is somebody's";
  ASSERT_EQ(device.stages.count("sampling"), 1U);
  EXPECT_EQ(with.report.devices.at(0).stages.count("sampling"), 0U);
  // As in stage_profile_test.cpp: a stage on its neighbour's account would be 0.2 to 0.6 off, in
  // every render. Other work on the machine disturbs samples of milliseconds now and then, and then
  // both are rendered again.
  const auto share = [](const DeviceReport& of, const std::string& stage) {
    double sum = 0;
    for (const char* name : {"generate", "intersect", "shade", "shadow"}) sum += of.stages.at(name).seconds;
    return of.stages.at(stage).seconds / sum;
  };
  double least = 1;
  for (int attempt = 0; attempt < 30 && least > 0.15; ++attempt) {
    const RenderOutput sampled = render_cornell(none, 128, 64), told = render_cornell(ticks, 128, 64);
    double most = 0;
    for (const char* stage : {"intersect", "shade", "shadow"})
      most = std::max(most,
                      std::abs(share(sampled.report.devices.at(0), stage) - share(told.report.devices.at(0), stage)));
    least = std::min(least, most);
  }
  EXPECT_LE(least, 0.15);
}

/// Seconds that one span and one point of a counter take to record, best of several.
double cost_of_recording() {
  double best = 1;
  constexpr int count = 2000;
  for (int round = 0; round < 10; ++round) {
    Trace trace;
    const double begin = host_seconds();
    for (int i = 0; i < count; ++i) {
      const TraceScope scope(&trace, Trace::kMain, "span");
      trace.count("counter", begin, begin, i);
    }
    best = std::min(best, (host_seconds() - begin) / count);
  }
  return best;
}

// Two renders on a shared machine differ by more than a hundredth, so what is recorded is counted,
// and the cost of that is measured. A trace that recorded chunks, bounces or samples would have
// thousands of spans for each launch.
TEST(Profile, recording_takes_less_than_a_hundredth_of_the_time_and_gives_the_device_nothing_more_to_do) {
  const auto shared = std::make_shared<Trace>();
  Trace& trace = *shared;
  Execution execution;
  execution.trace = shared;
  const RenderOutput output = render_cornell(execution, 128, 64);
  std::uint64_t recorded = 0;
  for (const Trace::TrackRecord& track : trace.tracks())
    for (const Trace::Level& level : track.levels)
      for (const Trace::Entry& entry : level.entries)
        for (const Trace::Part& part : entry.parts) recorded += part.count;
  for (const auto& [name, points] : trace.counters()) recorded += points.size();
  execution.trace = nullptr;
  const RenderOutput untold = render_cornell(execution, 128, 64);
  std::uint64_t launches = 0;
  for (const auto& [name, stage] : output.report.devices.at(0).stages) launches += stage.launches;
  const DeviceReport& device = output.report.devices.at(0);
  EXPECT_GT(recorded, device.units);
  EXPECT_LT(recorded, 20 * (launches + device.units))
      << "for " << launches << " launches in " << device.units << " units";
  EXPECT_LT(double(recorded) * cost_of_recording(), 0.01 * output.report.render_s);
  const DeviceReport& unwatched = untold.report.devices.at(0);  // how many units it had hangs on how fast it was
  ASSERT_EQ(device.stages.size(), unwatched.stages.size());
  for (const auto& [name, stage] : device.stages)
    EXPECT_EQ(stage.launches * unwatched.units, unwatched.stages.at(name).launches * device.units) << name;
}

TEST(Profile, of_a_long_render_has_a_bounded_timeline_with_all_of_its_time) {
  constexpr std::size_t most = 64;
  const auto shared = std::make_shared<Trace>(most, most);
  Trace& trace = *shared;
  Execution execution;
  execution.trace = shared;
  execution.chunked = true, execution.fused = false;
  const RenderOutput output = render_cornell(execution, 32, 32, 64);
  const DeviceReport& device = output.report.devices.at(0);
  double told_s = 0, drawn_s = 0;
  std::uint64_t commands = 0;
  for (const auto& [name, stage] : device.stages) told_s += stage.seconds, commands += stage.launches;
  EXPECT_GT(commands, 20 * most);
  for (const Trace::TrackRecord& track : trace.tracks())
    for (const Trace::Level& level : track.levels) {
      EXPECT_LE(level.entries.size(), most) << track.name;
      EXPECT_EQ(level.left_out, 0U) << track.name;
      for (const Trace::Entry& entry : level.entries)
        if (track.name.find("queue") != std::string::npos)
          for (const Trace::Part& part : entry.parts) drawn_s += part.seconds;
    }
  for (const auto& [name, points] : trace.counters()) EXPECT_LE(points.size(), most) << name;
  EXPECT_GE(drawn_s, told_s * 0.999);
}

TEST(StageSampler, takes_neighbours_from_all_over_the_unit) {
  std::vector<std::uint32_t> pixels(1000);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = std::uint32_t(i);
  const std::vector<std::uint32_t> chosen = StageSampler::choose_pixels(pixels, 128);
  ASSERT_EQ(chosen.size(), 128U);
  for (std::size_t run = 0; run < 8; ++run) {
    EXPECT_EQ(chosen[16 * run] % 16, 0U);
    EXPECT_EQ(chosen[16 * run] / 125, run) << "an eighth of the unit each";
    for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(chosen[16 * run + i], chosen[16 * run] + i);
  }
  EXPECT_EQ(StageSampler::choose_pixels(pixels, 1000).size(), 1000U);
  EXPECT_EQ(StageSampler::choose_pixels({pixels.data(), 5}, 5).size(), 5U);
}

}  // namespace
}  // namespace eikon::test
