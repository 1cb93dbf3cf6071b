// SPDX-License-Identifier: Apache-2.0
#include "job/sequence/frames.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/error.h"
#include "job/batch/batch_job.h"
#include "support/messages.h"

namespace eikon::test {
namespace {

TEST(Frames, names_have_the_number_as_printf_would_write_it) {
  EXPECT_EQ(numbered("walk_%04d.exr", 7), "walk_0007.exr");
  EXPECT_EQ(numbered("walk_%4d.exr", 7), "walk_0007.exr") << "blanks in names help nobody";
  EXPECT_EQ(numbered("%d/%02d.png", 123), "123/123.png");
  EXPECT_EQ(numbered("100%.exr", 1), "100%.exr");
  EXPECT_EQ(numbered("%s%x%%d", 5), "%s%x%5");
  for (const char* with : {"%d", "a%1d", "a%12d.exr"}) EXPECT_TRUE(has_number(with)) << with;
  for (const char* without : {"", "a", "%", "%4", "%x", "% d", "%123d", "d%"})
    EXPECT_FALSE(has_number(without)) << without;
}

TEST(Frames, a_range_has_its_last_frame) {
  EXPECT_EQ((FrameRange{3, 3, 1}).count(), 1U);
  EXPECT_EQ((FrameRange{0, 10, 1}).count(), 11U);
  EXPECT_EQ((FrameRange{0, 10, 3}).count(), 4U);
  EXPECT_EQ((FrameRange{5, 6, 100}).count(), 1U);
}

TEST(Frames, every_name_needs_a_place_for_the_number) {
  RenderOptions options;
  options.output = "a_%d.exr";
  EXPECT_NO_THROW(require_numbers(options));
  for (std::string* name : {&options.output, &options.png.file, &options.stats, &options.profile, &options.report,
                            &options.checkpoint.file, &options.pilot}) {
    const std::string before = std::exchange(*name, "still.x");
    const std::string message = test::message_of<UsageError>([&] { require_numbers(options); });
    EXPECT_TRUE(test::contains(message, "write"));
    EXPECT_TRUE(test::contains(message, "still.%04d.x"));
    *name = before;
  }
  options.output = "../d/wheel";
  const std::string message = test::message_of<UsageError>([&] { require_numbers(options); });
  EXPECT_TRUE(test::contains(message, "write -o ../d/wheel.%04d"));
}

/// Reads "SCENE -o=NAME [--frames=FIRST:LAST] [--frame=N]", enough of the words of a render.
RenderOptions parse(const std::vector<std::string>& words) {
  RenderOptions options;
  for (const std::string& word : words) {
    if (word.starts_with("--frames="))
      options.frames = FrameRange{std::stoul(word.substr(9)), std::stoul(word.substr(word.find(':') + 1)), 1};
    else if (word.starts_with("--frame="))
      options.scene.animation.frame = std::stoul(word.substr(8));
    else if (word.starts_with("--output="))
      options.output = word.substr(9);
    else
      options.scene.scene = word;
    if (!word.starts_with("--frames=")) options.words_without_frames.push_back(word);
  }
  number_outputs(options);
  return options;
}

TEST(Frames, a_line_with_frames_is_a_job_for_each) {
  const std::vector<BatchJob> jobs = read_jobs(
      "render a.gltf --output=a_%03d.exr --frames=8:10\nb.gltf --output=b.exr\nc.gltf --output=c.exr --frames=0:4\n"
      "walk.gltf --frames=0:1\n",
      parse);
  ASSERT_EQ(jobs.size(), 7U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(jobs[i].line, 1U);
    EXPECT_EQ(jobs[i].frame, 8 + i);
    EXPECT_EQ(jobs[i].options->output, i == 2 ? "a_010.exr" : i == 0 ? "a_008.exr" : "a_009.exr");
    EXPECT_DOUBLE_EQ(jobs[i].options->scene.animation.choice().time_s, (8.0 + double(i)) / 24);
  }
  EXPECT_EQ(label_of(jobs[1], "jobs.txt"), "jobs.txt:1, frame 9");
  EXPECT_EQ(jobs[1].text, "render a.gltf --output=a_%03d.exr --frame=9");
  EXPECT_EQ(label_of(jobs[3], "jobs.txt"), "jobs.txt:2");
  EXPECT_EQ(jobs[4].state, JobState::failed) << "no place for the number";
  EXPECT_FALSE(jobs[4].options);
  EXPECT_EQ(jobs[6].options->output, "walk.0001.exr") << "the usual name of a frame";
}

}  // namespace
}  // namespace eikon::test
