// SPDX-License-Identifier: Apache-2.0
// `eikon batch` and what its jobs read: files that earlier jobs write, files that none may write,
// the environment's.
#include <fmt/format.h>

#include "cli/batch/batch_outcome.h"
#include "support/comma_locale.h"

namespace eikon::test {
namespace {

using nlohmann::json;

void copy_textured(const Workplace& here) {
  for (const char* file : {"cornell.gltf", "textured.gltf", "tiles_color.png", "tiles_metallic_roughness.png",
                           "tiles_normal.png", "sky.hdr"})
    copy_scene(here, file);
}

TEST(BatchInputs, a_texture_that_an_earlier_job_writes_is_waited_for) {
  const Workplace here;
  copy_textured(here);
  const auto jobs = [&](int seed) {
    here.write("jobs", fmt::format("render cornell.gltf -o 1.exr --png tiles_color.png {0} --seed {1}\n"
                                   "render textured.gltf -o 2.exr {0}\n",
                                   kSmall, seed));
  };
  const auto expect_current = [&] {
    ASSERT_TRUE(succeeded(here.eikon(fmt::format("render textured.gltf -o single.exr {} --quiet", kSmall))));
    EXPECT_TRUE(same_picture(here / "single.exr", here / "2.exr"));
  };
  for (const int seed : {1, 2}) {
    jobs(seed);
    const Outcome outcome = here.eikon(fmt::format("batch jobs --jobs-parallel {}", seed));
    EXPECT_TRUE(succeeded(outcome));
    EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "done"}})) << seed << outcome.out;
    expect_current();
  }
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{1, "skipped"}, {2, "skipped"}}));
}

TEST(BatchInputs, a_job_that_reads_what_a_failed_one_should_have_written_is_not_rendered) {
  const Workplace here;
  copy_scene(here, "cornell.gltf");
  copy_scene(here, "cornell.gltf", "first.gltf");
  here.write("jobs", fmt::format("render first.gltf -o 1.exr {0}\n"
                                 "render cornell.gltf --env 1.exr -o 2.exr {0}\n"
                                 "render cornell.gltf -o 3.exr {0}\n"
                                 "render cornell.gltf --env 2.exr -o 4.exr {0}\n",
                                 kSmall));
  ASSERT_TRUE(succeeded(here.eikon("batch jobs")));
  const std::string before = read_bytes(here / "2.exr");
  here.write("first.gltf", "no scene");
  const Outcome outcome = here.eikon("batch jobs --retry 1 --force");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(states(outcome), (States{{1, "failed"}, {2, "failed"}, {3, "done"}, {4, "failed"}})) << outcome.out;
  EXPECT_TRUE(contains(outcome.err, "jobs:2: not rendered: it reads what jobs:1 writes, which failed") &&
              contains(outcome.err, "jobs:4: not rendered: it reads what jobs:2 writes, which failed"))
      << outcome.err;
  EXPECT_EQ(read_bytes(here / "2.exr"), before);
  copy_scene(here, "cornell.gltf", "first.gltf");
  EXPECT_EQ(states(here.eikon("batch jobs")), (States{{1, "done"}, {2, "done"}, {3, "skipped"}, {4, "done"}}));
}

TEST(BatchInputs, a_job_waits_for_the_second_try_of_what_it_reads) {
  const Workplace here;
  copy_scene(here, "cornell.gltf");
  here.write("jobs", fmt::format("render cornell.gltf -o 1.exr {0}\n"
                                 "render cornell.gltf --env 1.exr -o 2.exr {0}\n"
                                 "render cornell.gltf -o 3.exr {0}\n",
                                 std::string(kSmall) + " --devices cpu"));
  const Outcome outcome = here.eikon("batch jobs --retry 1", "EIKON_FAULT=device:0:times=3");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.err, "jobs:1: ") && contains(outcome.err, "tried again")) << outcome.err;
  EXPECT_EQ(states(outcome), (States{{1, "done"}, {2, "done"}, {3, "done"}})) << outcome.out;
}

TEST(BatchInputs, no_job_writes_what_it_or_an_earlier_one_reads) {
  const Workplace here;
  copy_textured(here);
  std::filesystem::create_symlink("tiles_normal.png", here / "link.png");
  std::filesystem::create_hard_link(here / "sky.hdr", here / "other");
  const std::vector<std::string> before = here.files();
  const auto refuse = [&](const std::string& second, const std::string& why) {
    here.write("jobs", fmt::format("render textured.gltf -o a.exr {0}\nrender {1} {0}\n", kSmall, second));
    const Outcome outcome = here.eikon("batch jobs");
    EXPECT_TRUE(refused(outcome, 2)) << second;
    EXPECT_TRUE(contains(outcome.err, "jobs:2:") && contains(outcome.err, why)) << outcome.err;
    std::filesystem::remove(here / "jobs");
    EXPECT_EQ(here.files(), before);
  };
  refuse("textured.gltf -o b.exr --png tiles_normal.png", "an input of that line");
  refuse("textured.gltf -o b.exr --png link.png", "an input of that line");
  refuse("cornell.gltf -o b.exr --png tiles_normal.png", "line 1 reads it");
  refuse("cornell.gltf -o textured.gltf", "line 1 reads it");
  refuse("cornell.gltf --env sky.hdr -o other", "an input of that line");
  refuse("cornell.gltf --env sky.hdr -o b.exr --checkpoint other", "an input of that line");
}

TEST(RenderInputs, are_never_replaced) {
  const Workplace here;
  copy_textured(here);
  std::filesystem::create_symlink("tiles_color.png", here / "link.png");
  std::filesystem::create_hard_link(here / "tiles_color.png", here / "hard.png");
  std::filesystem::create_hard_link(here / "textured.gltf", here / "hard.gltf");
  std::filesystem::create_symlink("sky.hdr", here / "sky");
  std::map<std::string, std::string> before;
  for (const std::string& file : here.files()) before[file] = read_bytes(here / file);
  for (const char* flags :
       {"textured.gltf -o o.exr --png tiles_color.png", "textured.gltf -o o.exr --png link.png",
        "textured.gltf -o o.exr --png hard.png", "textured.gltf -o o.exr --stats ./tiles_normal.png",
        "textured.gltf -o textured.gltf", "textured.gltf -o hard.gltf", "cornell.gltf --env sky.hdr -o sky",
        "cornell.gltf --env sky.hdr -o o.exr --checkpoint sky.hdr"}) {
    const Outcome outcome = here.eikon(fmt::format("render {} {} --quiet", flags, kSmall));
    EXPECT_TRUE(refused(outcome, 2)) << flags;
    EXPECT_TRUE(contains(outcome.err, "input"));
  }
  std::map<std::string, std::string> after;
  for (const std::string& file : here.files()) after[file] = read_bytes(here / file);
  EXPECT_EQ(after, before);
  // Of another render they are no inputs.
  EXPECT_TRUE(succeeded(here.eikon(fmt::format("render cornell.gltf -o o.exr --png link.png {} --quiet", kSmall))));
}

TEST(BatchInputs, paths_of_the_environment_stay_where_they_were) {
  const Workplace here;
  std::filesystem::create_directory(here / "vendors");
  for (const auto& entry : std::filesystem::directory_iterator("/etc/OpenCL/vendors"))
    std::filesystem::copy(entry.path(), here / "vendors" / entry.path().filename());
  std::filesystem::create_directory(here / "jobs");
  copy_scene(here, "cornell.gltf", "jobs/cornell.gltf");
  here.write("jobs/list", fmt::format("render cornell.gltf -o 1.exr {}\n", kSmall));
  for (const char* folder : {"vendors", "./vendors"}) {
    const Outcome outcome = here.eikon("batch --force jobs/list", fmt::format("OCL_ICD_VENDORS={}", folder));
    EXPECT_EQ(states(outcome), (States{{1, "done"}})) << outcome.err;
  }
  here.write("jobs/list", fmt::format("render cornell.gltf -o 1.exr {} --denoise\n", kSmall));
  here.write("library.so", "none");
  const Outcome outcome = here.eikon("batch jobs/list", "EIKON_OIDN=./library.so");
  EXPECT_TRUE(contains(outcome.err, (here / "library.so").string()));
}

TEST(BatchInputs, a_locale_with_decimal_comma_changes_nothing) {
  const CommaLocale comma;
  if (!comma.made()) GTEST_SKIP() << "no locale with a decimal comma can be made";
  const Workplace here;
  here.write("jobs", fmt::format("render {} -o 1.exr {} --exposure -0.5 --png 1.png --stats 1.json\n",
                                 scene("textured.gltf"), kSmall));
  const Outcome outcome =
      here.eikon("batch jobs", fmt::format("LOCPATH='{}' LC_ALL={}", comma.folder(), CommaLocale::name()));
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_EQ(states(outcome), (States{{1, "done"}}));
  const std::vector<json> told = entries(here / "jobs.ledger");
  ASSERT_EQ(told.size(), 2U) << "lines that are JSON";
  EXPECT_GT(told.back().at("relmse_predicted").get<double>(), 0);
  EXPECT_TRUE(json::accept(read_bytes(here / "1.json")));
  EXPECT_FALSE(contains(outcome.out, ","));
  const std::string png = read_bytes(here / "1.png");
  ASSERT_TRUE(succeeded(here.eikon("batch jobs --force")));
  EXPECT_EQ(read_bytes(here / "1.png"), png);
}

}  // namespace
}  // namespace eikon::test
