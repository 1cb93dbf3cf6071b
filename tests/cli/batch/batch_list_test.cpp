// SPDX-License-Identifier: Apache-2.0
// `eikon batch --list`: the jobs as JSON lines, for programs that share them between machines.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/batch/batch_outcome.h"
#include "io/text.h"

namespace eikon::test {
namespace {

using nlohmann::json;

std::vector<json> listed(const Outcome& outcome) {
  std::vector<json> lines;
  for (const std::string& line : split(outcome.out, '\n'))
    if (!line.empty()) lines.push_back(json::parse(line));
  return lines;
}

TEST(BatchList, a_job_has_the_key_that_the_ledger_will_have_and_nothing_is_rendered) {
  const Workplace here;
  here.write("jobs", fmt::format("render {} -o 'a b.exr' --png b.png --size 16x8 --spp 4\n", scene("cornell.gltf")));
  const Outcome outcome = here.eikon("batch jobs --list");
  ASSERT_TRUE(succeeded(outcome));
  const std::vector<json> jobs = listed(outcome);
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_EQ(jobs[0].at("size"), (json{16, 8}));
  EXPECT_EQ(jobs[0].at("samples"), (json{0, 4}));
  EXPECT_EQ(jobs[0].at("results"), (json{"a b.exr", "b.png"}));
  EXPECT_FALSE(std::filesystem::exists(here / "jobs.ledger") || std::filesystem::exists(here / "a b.exr"));
  ASSERT_TRUE(succeeded(here.eikon("batch jobs")));
  EXPECT_EQ(entries(here / "jobs.ledger").back().at("key"), jobs[0].at("key"));
}

TEST(BatchList, words_of_a_part_render_samples_that_merge_to_the_job) {
  const Workplace here;
  const std::string line = fmt::format(
      "render {} --aov depth --transparent --size 16x8 --spp 4 --half --tonemap agx --depth-series 0,1 --quiet",
      scene("cornell.gltf"));
  here.write("jobs", line + " -o whole.exr --png whole.png --stats s.json\n" + line + " -o smooth.exr --denoise\n");
  const std::vector<json> jobs = listed(here.eikon("batch jobs --list"));
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_TRUE(contains(jobs[1].at("part").dump(), "--aov=depth,albedo,normal")) << jobs[1].at("part");
  std::string words;
  for (const json& word : jobs[0].at("part")) words += fmt::format(" '{}'", word.get<std::string>());
  for (const char* left_out : {"--png", "--half", "--spp", "--stats", "--tonemap", "--output"})
    EXPECT_FALSE(contains(words, left_out));
  ASSERT_TRUE(succeeded(here.eikon("render" + words + " --samples 0:2 -o p0.exr --quiet")));
  ASSERT_TRUE(succeeded(here.eikon("render" + words + " --samples 2:4 -o p1.exr --quiet")));
  ASSERT_TRUE(succeeded(here.eikon("merge p0.exr p1.exr -o merged.exr --quiet")));
  ASSERT_TRUE(succeeded(here.eikon(line + " -o single.exr")));
  ASSERT_TRUE(succeeded(here.eikon(line + " -o finished.exr --checkpoint merged.exr --resume")));
  for (const char* file : {"{}.exr", "{}.depth0.exr", "{}.depth1.exr"})
    EXPECT_TRUE(same_picture(here / fmt::format(fmt::runtime(file), "single"),
                             here / fmt::format(fmt::runtime(file), "finished")));
}

TEST(BatchList, lines_that_are_wrong_and_scenes_that_are_gone_are_named) {
  const Workplace here;
  here.write("jobs", "render absent.gltf --size 16x8\nrender --wrong\n");
  const Outcome outcome = here.eikon("batch jobs --list");
  EXPECT_EQ(outcome.code, 1);
  const std::vector<json> jobs = listed(outcome);
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_TRUE(jobs[0].at("key").is_null() &&
              contains(jobs[0].at("error").get<std::string>(), "absent.gltf: no such file"));
  EXPECT_TRUE(jobs[1].at("key").is_null() && !jobs[1].contains("scene"));
}

}  // namespace
}  // namespace eikon::test
