// SPDX-License-Identifier: Apache-2.0
// --tev: the growing image in a viewer, of which nothing depends.
#include "cli/render/tev_server.h"

#include <signal.h>

#include "cli/command.h"
#include "image/image.h"

namespace eikon::test {
namespace {

bool equal_bits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Compares what the viewer has with the image of a file that lies in it at (x0, y0).
void expect_same(const ShownImage& shown, const Image& file, std::int32_t x0 = 0, std::int32_t y0 = 0) {
  ASSERT_EQ(shown.channels.size(), file.channels.size());
  for (const std::string& name : file.channels) {
    ASSERT_TRUE(shown.channels.contains(name)) << name;
    const std::vector<float>&plane = *file.plane(name), &values = shown.channels.at(name);
    std::size_t differing = 0;
    for (std::int32_t y = 0; y < shown.height; ++y)
      for (std::int32_t x = 0; x < shown.width; ++x) {
        const bool within =
            x >= x0 && y >= y0 && x < x0 + std::int32_t(file.width) && y < y0 + std::int32_t(file.height);
        const float value = values[std::size_t(y * shown.width + x)];
        if (within)
          differing += equal_bits(value, plane[std::size_t(y - y0) * file.width + std::size_t(x - x0)]) ? 0 : 1;
        else
          differing += std::isnan(value) ? 0 : 1;
      }
    EXPECT_EQ(differing, 0U) << name;
  }
}

/// One line on stderr, which has all of these words.
::testing::AssertionResult warned(const Outcome& outcome, const std::vector<std::string>& words) {
  const bool one = std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1;
  const bool all = std::ranges::all_of(words, [&](const std::string& word) { return contains(outcome.err, word); });
  if (outcome.code == 0 && one && all) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "exit code " << outcome.code << ", stderr '" << outcome.err << "'";
}

TEST(Tev, the_last_picture_is_that_of_the_file_with_all_its_layers) {
  const Workplace here;
  TevServer server;
  // More than one message, since each has about a megabyte.
  ASSERT_TRUE(succeeded(here.eikon(
      cornell("--size 320x200 --spp 2 --quiet --aov albedo,depth,samples,object_id,cryptomatte_object,variance") +
      server.flag())));
  server.end();
  EXPECT_EQ(server.error, "");
  ASSERT_EQ(server.images.size(), 1U);
  ASSERT_TRUE(server.images.contains("out.exr"));
  const ShownImage& shown = server.images.at("out.exr");
  EXPECT_EQ(shown.width, 320);
  EXPECT_EQ(shown.height, 200);
  EXPECT_TRUE(shown.channels.contains("albedo.R"));
  expect_same(shown, read_exr(here / "out.exr"));
}

TEST(Tev, a_crop_is_shown_at_its_place) {
  const Workplace here;
  TevServer server;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 40x30 --spp 2 --quiet --crop 5,7,21,29") + server.flag())));
  server.end();
  EXPECT_EQ(server.error, "");
  const ShownImage& shown = server.images.at("out.exr");
  EXPECT_EQ(shown.width, 40);
  EXPECT_EQ(shown.height, 30);
  expect_same(shown, read_exr(here / "out.exr"), 5, 7);
}

TEST(Tev, pictures_come_while_the_render_goes_on_and_after_it_was_interrupted) {
  const Workplace here;
  TevServer server;
  const pid_t eikon = here.start(cornell("--size 32x24 --spp 100000000 --quiet") + server.flag());
  while (server.pictures() < 3 && waitpid(eikon, nullptr, WNOHANG) == 0) usleep(10000);
  ASSERT_GE(server.pictures(), 3);
  kill(eikon, SIGINT);
  EXPECT_EQ(here.wait(eikon).code, 130);
  server.end();
  EXPECT_EQ(server.error, "");
  expect_same(server.images.at("out.exr"), read_exr(here / "out.exr"));
}

TEST(Tev, no_viewer_changes_a_bit_and_each_that_fails_is_told_in_a_line) {
  const Workplace here;
  // A picture that does not fit into what the system keeps for a viewer that does not read.
  const std::string flags = "--size 400x300 --spp 1 --quiet --half --png ";
  ASSERT_TRUE(succeeded(here.eikon(cornell(flags + "alone.png"))));
  const Image image = read_exr(here / "out.exr");
  const std::string png = read_bytes(here / "alone.png");
  const auto expect_same_files = [&](const std::string& case_name) {
    EXPECT_EQ(read_bytes(here / (case_name + ".png")), png) << case_name;
    EXPECT_TRUE(read_exr(here / "out.exr").planes == image.planes) << case_name;
  };

  std::string flag;
  {
    TevServer silent(TevServer::Reads::nothing);
    flag = silent.flag();
    EXPECT_TRUE(warned(here.eikon(cornell(flags + "silent.png") + flag), {"--tev 127.0.0.1:", "does not read"}));
    expect_same_files("silent");
  }
  EXPECT_TRUE(warned(here.eikon(cornell(flags + "absent.png") + flag), {"--tev 127.0.0.1:", "start tev first"}));
  expect_same_files("absent");
  {
    TevServer closing(TevServer::Reads::one_message);
    EXPECT_TRUE(warned(here.eikon(cornell(flags + "closing.png") + closing.flag()), {"--tev 127.0.0.1:", "closed"}));
    EXPECT_EQ(closing.connections(), 1);
    expect_same_files("closing");
  }
  EXPECT_TRUE(warned(here.eikon(cornell(flags + "nameless.png --tev no-such-host.invalid:14158")),
                     {"--tev no-such-host.invalid:14158: "}));
  expect_same_files("nameless");
}

TEST(Tev, each_frame_is_an_image_and_a_missing_viewer_is_told_once) {
  const Workplace here;
  const std::string frames = "render " + scene("bending_arm.gltf") + " --frames 0:2 --size 16x12 --spp 1 --quiet";
  std::string flag;
  {
    TevServer server;
    flag = server.flag();
    ASSERT_TRUE(succeeded(here.eikon(frames + " -o f_%d.exr" + flag)));
    server.end();
    EXPECT_EQ(server.error, "");
    ASSERT_EQ(server.images.size(), 3U);
    for (const char* name : {"f_0.exr", "f_1.exr", "f_2.exr"})
      expect_same(server.images.at(name), read_exr(here / name));
  }
  EXPECT_TRUE(warned(here.eikon(frames + " -o g_%d.exr" + flag), {"--tev 127.0.0.1:", "start tev first"}));
}

TEST(Tev, is_no_reason_to_render_a_job_of_a_batch_again) {
  const Workplace here;
  TevServer server;
  const std::string job = "render " + scene("cornell.gltf") + " -o a.exr --size 8x6 --spp 2";
  here.write("jobs.txt", job + "\n");
  ASSERT_TRUE(succeeded(here.eikon("batch jobs.txt")));
  here.write("jobs.txt", job + server.flag() + "\n");
  ASSERT_TRUE(succeeded(here.eikon("batch jobs.txt")));
  EXPECT_EQ(server.connections(), 0);
}

TEST(Tev, what_is_no_address_is_refused) {
  const Workplace here;
  for (const char* wrong :
       {"localhost", "localhost:", ":14158", "localhost:0", "localhost:65536", "localhost:-1", "localhost:http",
        "localhost:1:2", "::1:14158", "[::1]", "[]:1", "'[a]b:1'", "'local host:1 '"})
    EXPECT_TRUE(refused(here.eikon(cornell("--size 8x6 --spp 1 --quiet --tev ") + wrong), kUsage)) << wrong;
  EXPECT_TRUE(here.files().empty());
}

}  // namespace
}  // namespace eikon::test
