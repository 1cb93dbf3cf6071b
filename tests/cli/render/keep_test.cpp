// SPDX-License-Identifier: Apache-2.0
// What is done when a render cannot go on is kept, and said where: without --checkpoint too.
#include <fmt/format.h>

#include "cli/render/checkpoint_files.h"

namespace eikon::test {
namespace {

const std::string kImage = "--size 64x64 --spp 400 --quiet --devices cpu ";
constexpr std::uint64_t kAll = 64 * 64 * 400;

void expect_goes_on(const Workplace& here, const std::string& from, const std::string& flags = "") {
  const std::uint64_t before = read_checkpoint(here / from).record.sample_set.sample_count();
  EXPECT_GT(before, 0U);
  EXPECT_LT(before, kAll);
  const Outcome rest = here.eikon("render " + scene("cornell.gltf") + " -o whole.exr " + kImage + flags +
                                  "--checkpoint '" + (here / from).string() + "' --resume --stats stats.json");
  ASSERT_TRUE(succeeded(rest));
  EXPECT_TRUE(contains(rest.out, fmt::format("{} samples before and ", before)));
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("cornell.gltf") + " -o undisturbed.exr " + kImage + flags)));
  EXPECT_EQ(read_exr(here / "whole.exr").planes, read_exr(here / "undisturbed.exr").planes);
}

TEST(Keep, a_device_that_disappears_leaves_the_picture_so_far_to_go_on_from) {
  for (const char* flags : {"", "--half --aov albedo "}) {
    const Workplace here;
    const Outcome lost = here.eikon(cornell(kImage + flags), "EIKON_FAULT=device:0:after=4:lost");
    EXPECT_TRUE(refused(lost, 4)) << lost.out;
    EXPECT_TRUE(contains(lost.err, "no device is left") && contains(lost.err, "CL_DEVICE_NOT_AVAILABLE") &&
                contains(lost.err, "what is done is in out.exr: --checkpoint out.exr --resume"))
        << lost.err;
    EXPECT_EQ(here.files(), std::vector<std::string>{"out.exr"});
    const Image picture = read_exr(here / "out.exr");
    EXPECT_EQ(picture.metadata.at("interrupted"), "1");
    EXPECT_EQ(picture.metadata.at("samples"),
              std::to_string(read_checkpoint(here / "out.exr").record.sample_set.sample_count()));
    expect_goes_on(here, "out.exr", flags);
  }
}

TEST(Keep, a_device_that_hangs_leaves_the_picture_so_far_too) {
  const Workplace here;
  const Outcome hung = here.eikon(cornell(kImage), "EIKON_WATCHDOG=0.5 EIKON_FAULT=device:0:after=4:hang");
  EXPECT_TRUE(refused(hung, 4)) << hung.out;
  EXPECT_TRUE(contains(hung.err, "did not end within") && contains(hung.err, "what is done is in out.exr")) << hung.err;
  expect_goes_on(here, "out.exr");
}

TEST(Keep, a_device_that_fails_before_the_first_sample_leaves_nothing) {
  const Workplace here;
  EXPECT_TRUE(refused(here.eikon(cornell(kImage), "EIKON_FAULT=device:0"), 4));
  EXPECT_TRUE(here.files().empty());
}

/// Runs a script where `disk` is a file system of that size.
Outcome on_small_disk(const Workplace& here, const std::string& size, const std::string& script) {
  here.write("run.sh", "mount -t tmpfs -o size=" + size + " none disk && " + script);
  return here.shell("unshare -m sh run.sh");
}

TEST(Keep, a_picture_that_does_not_fit_on_its_disk_is_kept_where_it_does) {
  const Workplace here;
  std::filesystem::create_directory(here / "disk");
  std::filesystem::create_directory(here / "temporary");
  if (on_small_disk(here, "8k", "true").code != 0) GTEST_SKIP() << "not allowed to mount a file system";
  const std::string render = "exec " + Workplace::binary() + " render " + scene("cornell.gltf") + " -o disk/out.exr " +
                             kImage + "--samples 0:100";
  const Outcome full = on_small_disk(here, "8k", "TMPDIR=$PWD/temporary " + render);
  EXPECT_TRUE(refused(full, 3)) << full.out;
  std::vector<std::filesystem::path> kept;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(here / "temporary"))
    if (entry.is_regular_file()) kept.push_back(entry.path());
  ASSERT_EQ(kept.size(), 1U);
  // Others can write into the folder of temporary files, where a name that they guess may be a link
  // of theirs.
  const std::filesystem::path folder = kept[0].parent_path();
  EXPECT_NE(folder, here / "temporary");
  EXPECT_EQ(std::filesystem::status(folder).permissions(), std::filesystem::perms::owner_all);
  EXPECT_TRUE(contains(full.err, "disk/out.exr") && contains(full.err, "No space left") &&
              contains(full.err, "kept in \"" + kept[0].string() + "\""))
      << full.err;
  std::filesystem::rename(kept[0], here / "kept.exr");
  expect_goes_on(here, "kept.exr");
  std::filesystem::remove(folder);

  // Nowhere: a line, and nothing is left.
  const Outcome nowhere = on_small_disk(here, "8k", "TMPDIR=$PWD/disk " + render);
  EXPECT_TRUE(refused(nowhere, 3)) << nowhere.out;
  EXPECT_FALSE(contains(nowhere.err, "kept"));
  // Where there is a checkpoint, that is named.
  const Outcome saved = on_small_disk(here, "8k", "TMPDIR=$PWD/temporary " + render + " --checkpoint c.exr");
  EXPECT_TRUE(refused(saved, 3)) << saved.out;
  EXPECT_TRUE(contains(saved.err, "c.exr holds what is done"));
  EXPECT_TRUE(std::filesystem::is_empty(here / "temporary"));
}

}  // namespace
}  // namespace eikon::test
