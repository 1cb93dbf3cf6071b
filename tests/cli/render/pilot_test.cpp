// SPDX-License-Identifier: Apache-2.0
// The pilot of a render, as a user meets it: --pilot, faults, signals and clocks while it runs.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

#include "cli/batch/batch_outcome.h"
#include "cli/render/checkpoint_files.h"
#include "support/signed_pilot.h"

namespace eikon::test {
namespace {

using nlohmann::json;

const std::string kRoom = "render " + scene("window_room.gltf") + " --size 32x24 --guiding 4096 --quiet ";
/// A pilot that takes hours: its device is as slow as that.
const std::string kLong =
    "render " + scene("window_room.gltf") + " --size 64x48 --guiding 262144 --spp 1 --quiet -o out.exr ";
const char* const kSlow = "EIKON_FAULT=device:0:slow=1000";

std::string whole(const std::string& more) { return kRoom + "--spp 8 " + more; }

bool same(const Workplace& here, const std::string& a, const std::string& b) {
  return read_exr(here / a).planes == read_exr(here / b).planes;
}

TEST(PilotOption, the_first_render_writes_it_and_others_have_the_same_bits_by_it) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(whole("-o none.exr"))));
  ASSERT_TRUE(succeeded(here.eikon(whole("-o first.exr --pilot p --stats first.json"))));
  const auto written = identity(here / "p");
  ASSERT_NE(written, 0U);
  ASSERT_TRUE(succeeded(here.eikon(whole("-o second.exr --pilot p --stats second.json"))));
  EXPECT_EQ(identity(here / "p"), written) << "it was written again";
  EXPECT_TRUE(same(here, "first.exr", "none.exr"));
  EXPECT_TRUE(same(here, "second.exr", "none.exr"));
  for (const char* stats : {"first.json", "second.json"}) {  // of the kernels as they are after the pilot
    const json features = read_json(here / stats).at("ledger");
    EXPECT_TRUE(std::ranges::any_of(features, [](const json& entry) {
      return entry.at("name") == "guiding" && entry.at("on") == true;
    })) << stats;
  }
  const json first = read_json(here / "first.json").at("pilot"), second = read_json(here / "second.json").at("pilot");
  EXPECT_FALSE(first.at("loaded").get<bool>());
  EXPECT_TRUE(second.at("loaded").get<bool>());
  EXPECT_EQ(second.at("seconds"), 0);
  EXPECT_GT(second.at("roulette_depth"), 0);
  for (const char* figure : {"paths", "cells", "gain", "roulette_depth"})
    EXPECT_EQ(first.at(figure), second.at(figure)) << figure;
  EXPECT_EQ(read_exr(here / "first.exr").metadata.at("guiding"), read_exr(here / "second.exr").metadata.at("guiding"));
  // Parts of the image by samples and by pixels, and an image of another seed.
  ASSERT_TRUE(succeeded(here.eikon(kRoom + "--pilot p --samples 0:3 -o a.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kRoom + "--pilot p --samples 3:8 --crop 0,0,10,24 -o b.exr")));
  ASSERT_TRUE(succeeded(here.eikon(kRoom + "--samples 3:8 --crop 10,0,32,24 -o c.exr")));
  ASSERT_TRUE(succeeded(here.eikon("merge a.exr b.exr c.exr -o merged.exr --quiet")));
  EXPECT_TRUE(same(here, "merged.exr", "none.exr"));
  ASSERT_TRUE(succeeded(here.eikon(whole("--pilot p --seed 1 -o seed.exr"))));
  ASSERT_TRUE(succeeded(here.eikon(whole("--seed 1 -o seed_alone.exr"))));
  EXPECT_TRUE(same(here, "seed.exr", "seed_alone.exr"));
}

TEST(PilotOption, a_decision_not_to_guide_is_kept_too) {
  const Workplace here;
  const std::string flat = "render " + scene("square_light.gltf") + " --size 128x128 --spp 2 --quiet ";
  ASSERT_TRUE(succeeded(here.eikon(flat + "-o none.exr")));
  for (const char* name : {"first", "second"}) {
    ASSERT_TRUE(succeeded(here.eikon(flat + fmt::format("-o {0}.exr --pilot p --stats {0}.json", name))));
    EXPECT_EQ(read_json(here / (std::string(name) + ".json")).at("pilot").at("roulette_depth"), 0);
    EXPECT_TRUE(same(here, std::string(name) + ".exr", "none.exr"));
  }
  EXPECT_TRUE(read_json(here / "second.json").at("pilot").at("loaded").get<bool>());
}

TEST(PilotOption, a_file_of_something_else_or_that_is_damaged_is_refused) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(whole("-o out.exr --pilot p"))));
  std::filesystem::remove(here / "out.exr");
  const std::string bytes = read_bytes(here / "p");
  const auto refused_with = [&](const std::string& command, int code, const std::string& why) {
    const Outcome outcome = here.eikon(command);
    EXPECT_TRUE(refused(outcome, code)) << command;
    EXPECT_TRUE(contains(outcome.err, why));
  };
  const std::string p = "--pilot p -o out.exr ";
  refused_with(whole(p + "--max-depth 5"), kInput, "its depth limit (--max-depth) is 0, not 5");
  refused_with("render " + scene("window_room.gltf") + " --size 32x24 --guiding 8192 --quiet " + p, kInput,
               "its guiding (--guiding) is on, by 4096 paths, not on, by 8192 paths");
  refused_with("render " + scene("cornell.gltf") + " --size 32x24 --guiding 4096 --quiet " + p, kInput, "scene's hash");
  refused_with(whole(p + "--fov 30"), kInput, "field of view");
  here.write("cut", bytes.substr(0, bytes.size() / 2));
  refused_with(whole("--pilot cut -o out.exr"), kInput, "it is damaged, or not all of it was copied");
  here.write("other", "PNG");
  refused_with(whole("--pilot other -o out.exr"), kInput, "it is no file of --pilot");
  here.write("empty", "");
  refused_with(whole("--pilot empty -o out.exr"), kInput, "\"empty\"");
  refused_with(whole("--pilot . -o out.exr"), kInput, "\".\"");
  refused_with(whole("--pilot nowhere/p -o out.exr"), kInput, "nowhere/p");
  refused_with(whole("--pilot - -o out.exr"), kUsage, "standard output");
  refused_with(whole("--pilot out.exr -o out.exr"), kUsage, "an output has that name");
  EXPECT_EQ(here.files(), (std::vector<std::string>{"cut", "empty", "other", "p"}));
}

TEST(PilotOption, a_pilot_of_another_arithmetic_class_is_refused) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(whole("-o out.exr --pilot p"))));
  std::filesystem::remove(here / "out.exr");
  std::string bytes = read_bytes(here / "p");
  const std::size_t at = bytes.find("arithmetic: exact\n");
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 17, "arithmetic: other-12345678");
  here.write("p", signed_again(bytes));
  const Outcome outcome = here.eikon(whole("-o out.exr --pilot p"));
  EXPECT_TRUE(refused(outcome, kInput));
  EXPECT_TRUE(contains(outcome.err, "other-12345678"));
  EXPECT_EQ(here.files(), std::vector<std::string>{"p"});
}

TEST(PilotOption, renders_that_begin_at_once_are_all_right) {
  const Workplace here, there;
  ASSERT_TRUE(succeeded(here.eikon(whole("-o none.exr"))));
  here.write("run.sh", "for i in 1 2 3 4; do " + Workplace::binary() + " " + whole("-o $i.exr --pilot p") +
                           " || echo failed > failed & done; wait");
  ASSERT_TRUE(succeeded(here.shell("sh run.sh")));
  for (const char* file : {"1.exr", "2.exr", "3.exr", "4.exr"}) EXPECT_TRUE(same(here, file, "none.exr")) << file;
  EXPECT_EQ(here.files(), (std::vector<std::string>{"1.exr", "2.exr", "3.exr", "4.exr", "none.exr", "p", "run.sh"}));
  ASSERT_TRUE(succeeded(there.eikon(whole("-o none.exr --pilot p"))));
  EXPECT_EQ(read_bytes(here / "p"), read_bytes(there / "p")) << "which does not depend on who wrote it";
}

TEST(PilotOption, a_job_of_another_scene_leaves_the_pilot_as_it_is) {
  const Workplace here;
  here.write("jobs", whole("-o a.exr --pilot p\n") + "render " + scene("cornell.gltf") +
                         " --size 32x24 --guiding 4096 --spp 8 --quiet -o b.exr --pilot p\n");
  EXPECT_NE(here.eikon("batch jobs --quiet").code, 0);  // the second job does not get what it asks for
  EXPECT_TRUE(succeeded(here.eikon(whole("-o c.exr --pilot p"))));
}

TEST(PilotOption, jobs_of_a_batch_share_the_pilot_of_a_scene) {
  const Workplace here;
  std::string jobs;
  for (int i = 0; i < 3; ++i) jobs += whole(fmt::format("--seed {0} -o {0}.exr --stats {0}.json\n", i));
  jobs += kRoom + "--spp 8 --max-depth 3 -o other.exr --stats other.json\n";
  here.write("jobs", jobs);
  ASSERT_TRUE(succeeded(here.eikon("batch jobs --quiet")));
  const auto loaded = [&](const std::string& name) {
    return read_json(here / (name + ".json")).at("pilot").at("loaded").get<bool>();
  };
  EXPECT_FALSE(loaded("0"));
  EXPECT_TRUE(loaded("1"));
  EXPECT_TRUE(loaded("2"));
  EXPECT_FALSE(loaded("other"));
  ASSERT_TRUE(succeeded(here.eikon(whole("--seed 2 -o alone.exr"))));
  EXPECT_TRUE(same(here, "2.exr", "alone.exr"));
}

TEST(PilotUnderWay, a_device_that_hangs_in_it_is_given_up) {
  const Workplace here;
  for (const char* fault : {"device:0:hang", "device:0:hang:after=4"}) {
    const Outcome outcome = here.eikon(whole("-o out.exr"), std::string("EIKON_WATCHDOG=0.5 EIKON_FAULT=") + fault);
    EXPECT_TRUE(refused(outcome, kDevice)) << fault;
    EXPECT_TRUE(contains(outcome.err, "a unit of the pilot did not end within"));
  }
  EXPECT_TRUE(here.files().empty());
}

TEST(PilotUnderWay, a_device_that_hangs_between_its_units_is_given_up) {
  const Workplace here;
  const Outcome outcome =
      here.eikon(whole("-o out.exr"), "EIKON_WATCHDOG=0.5 EIKON_FAULT=device:0:stall:after=4 timeout 60");
  EXPECT_TRUE(refused(outcome, kDevice)) << outcome.code << outcome.out;
  EXPECT_TRUE(contains(outcome.err, "the pilot's work beside its units did not end within"));
  EXPECT_TRUE(here.files().empty());
}

TEST(PilotUnderWay, another_device_takes_over_from_one_that_hangs_or_is_lost) {
  const Workplace here;
  const std::string cores = "POCL_MAX_PTHREAD_COUNT=2 EIKON_WATCHDOG=2 ";
  ASSERT_TRUE(succeeded(here.eikon(whole("-o none.exr"))));
  for (const char* fault :
       {"hang", "hang:after=3", "lost:after=2", "after=2", "after=1:times=1", "above=400:times=2"}) {
    const Outcome outcome = here.eikon(whole("-o out.exr --devices cpu:2x1"), cores + "EIKON_FAULT=device:0:" + fault);
    ASSERT_TRUE(succeeded(outcome)) << fault;
    EXPECT_TRUE(contains(outcome.err, "the pilot failed on device ")) << fault << ": " << outcome.err;
    EXPECT_TRUE(same(here, "out.exr", "none.exr")) << fault;
  }
}

TEST(PilotUnderWay, an_interrupt_ends_it_and_leaves_nothing) {
  const Workplace here;
  for (const int signal : {SIGINT, SIGTERM}) {
    const pid_t child = here.start(kLong + "--pilot p", kSlow);
    for (int i = 0; i < 6000 && !listens_to(child, signal) && !has_ended(child); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    EXPECT_FALSE(has_ended(child));
    const auto asked = std::chrono::steady_clock::now();
    kill(child, signal);
    const Outcome outcome = here.wait(child);
    EXPECT_LT(std::chrono::steady_clock::now() - asked, std::chrono::seconds(5));
    EXPECT_EQ(outcome.code, 128 + signal);
    EXPECT_EQ(outcome.err, "eikon: interrupted before the first sample: nothing was written\n");
  }
  EXPECT_TRUE(here.files().empty());
}

TEST(PilotUnderWay, the_time_of_a_render_is_also_that_of_its_pilot) {
  const Workplace here;
  const auto begin = std::chrono::steady_clock::now();
  const Outcome outcome = here.eikon(kLong + "--time 3", kSlow);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20)) << "on a machine that is busy";
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(contains(outcome.err, "the time was over before the first sample"));
  // In a batch seconds are of rendering, and the pilot's are.
  here.write("jobs", kLong + "--time 2\n");
  const Outcome batch = here.eikon("batch jobs --quiet", kSlow);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(40));
  EXPECT_EQ(batch.code, 1);
  EXPECT_TRUE(contains(batch.err, "the time was over before the first sample"));
  EXPECT_FALSE(std::filesystem::exists(here / "out.exr"));
}

}  // namespace
}  // namespace eikon::test
