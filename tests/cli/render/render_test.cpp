// SPDX-License-Identifier: Apache-2.0
// `eikon render` as a user runs it: what it writes, what it says, and that its bits do not depend
// on how it ran.
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "accel/accel.h"
#include "cli/command.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "instruments/analytic_scenes.h"
#include "support/comma_locale.h"

namespace eikon::test {
namespace {

using nlohmann::json;

// With a crop, even of everything, the file carries the exact sums.
constexpr const char* kWithSums = "--size 8x8 --crop 0,0,8,8 --spp 4 --quiet ";

Film sums_of(const Workplace& here, const std::string& arguments, const std::string& before = "") {
  std::filesystem::remove(here / "out.exr");
  const Outcome outcome = here.eikon(arguments, before);
  EXPECT_TRUE(succeeded(outcome)) << arguments;
  return read_film(here / "out.exr");
}

TEST(Render, writes_the_picture_and_says_how_wrong_it_is) {
  const Workplace here;
  const Outcome outcome = here.eikon(cornell("--size 16x12 --spp 16"));
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "predicted relMSE"));
  for (const char* stage : {"generate", "intersect", "shade", "shadow", "film"})
    EXPECT_TRUE(contains(outcome.out, stage));
  const Image image = read_exr(here / "out.exr");
  EXPECT_EQ(image.width, 16U);
  EXPECT_EQ(image.height, 12U);
  const Metadata metadata = read_metadata(here / "out.exr");
  EXPECT_EQ(metadata.strings.at("scene"), "cornell.gltf");
  EXPECT_EQ(metadata.strings.at("sampleRange"), "0:16");
  EXPECT_EQ(metadata.strings.at("sceneHash").size(), 16U);
  EXPECT_EQ(metadata.strings.count("version"), 1U);
  EXPECT_FALSE(metadata.strings.at("devices").empty());
  EXPECT_FALSE(metadata.strings.at("features").empty());
  EXPECT_EQ(metadata.numbers.at("replicates"), 2);
  EXPECT_EQ(metadata.numbers.at("rejectedSamples"), 0);
  EXPECT_GT(metadata.numbers.at("relmsePredicted"), 0);
  EXPECT_LT(metadata.numbers.at("relmsePredictedLow"), metadata.numbers.at("relmsePredicted"));
  EXPECT_EQ(metadata.matrices.at("worldToCamera").size(), 16U);
  EXPECT_EQ(metadata.matrices.at("worldToNDC").size(), 16U);
  EXPECT_EQ(here.files(), std::vector<std::string>{"out.exr"});
}

TEST(Render, N14_a_locale_with_decimal_comma_changes_no_byte) {
  const CommaLocale comma;
  if (!comma.made()) GTEST_SKIP() << "no locale with a decimal comma can be made";
  const Workplace place;
  const std::string flags = "render " + scene("textured.gltf") + " --size 24x16 --spp 2 --exposure -0.5 --quiet";
  const std::string german = "LOCPATH='" + comma.folder() + "' LC_ALL=" + CommaLocale::name();
  const Outcome plain = place.eikon(flags + " -o a.exr --png a.png --stats a.json"),
                with_comma = place.eikon(flags + " -o b.exr --png b.png --stats b.json", german);
  ASSERT_EQ(with_comma.code, plain.code) << with_comma.err;
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_EQ(read_bytes(place / "a.png"), read_bytes(place / "b.png"));
  EXPECT_EQ(place.eikon("compare a.exr b.exr --fail-above 1e-9", german).code, 0);
  EXPECT_TRUE(json::accept(read_bytes(place / "b.json")));
}

TEST(Render, without_an_output_name_takes_the_scene_s) {
  const Workplace here;
  EXPECT_TRUE(succeeded(here.eikon("render " + scene("furnace.gltf") + " --size 4x4 --spp 1 --quiet")));
  EXPECT_EQ(here.files(), std::vector<std::string>{"furnace.exr"});
}

TEST(Render, quiet_is_quiet_and_a_pipe_sees_no_progress) {
  const Workplace here;
  const Outcome loud = here.eikon("render " + scene("sphere_in_sky.gltf") + " -o out.exr --size 256x256 --spp 64");
  EXPECT_TRUE(loud.err.empty()) << loud.err;
  EXPECT_FALSE(contains(loud.out, "\r") || contains(loud.out, "\x1b"));
  const Outcome quiet = here.eikon(cornell());
  EXPECT_TRUE(quiet.err.empty()) << quiet.err;
  EXPECT_FALSE(contains(quiet.out, "intersect"));
}

TEST(Render, a_terminal_sees_progress) {
  if (std::system("script -qec true /dev/null >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "`script` cannot make a terminal here";
  const Workplace here;
  here.shell("script -qec \"" + Workplace::binary() + " " + cornell("--size 128x128 --spp 1024") + "\" typescript");
  const std::string seen = read_bytes(here / "typescript");
  EXPECT_TRUE(contains(seen, "Msamples/s") && contains(seen, "s left") && contains(seen, "relMSE") &&
              contains(seen, "\r"))
      << seen;
}

TEST(Render, stats_have_what_is_promised) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 16x12 --spp 16 --quiet --stats stats.json"))));
  const json stats = read_json(here / "stats.json");
  double parts = 0;
  for (const char* part : {"load", "build", "compile", "upload", "render"}) {
    EXPECT_GE(stats.at("seconds").at(part).get<double>(), 0) << part;
    parts += stats.at("seconds").at(part).get<double>();
  }
  EXPECT_LE(parts, stats.at("seconds").at("total").get<double>());
  EXPECT_EQ(stats.at("samples").get<int>(), 16 * 12 * 16);
  EXPECT_GT(stats.at("samples_per_second").get<double>(), 0);
  EXPECT_EQ(stats.at("rays").at("camera").get<int>(), 16 * 12 * 16);
  EXPECT_GT(stats.at("rays").at("shadow").get<int>(), 0);
  EXPECT_EQ(stats.at("rays").at("total").get<int>(), stats.at("rays").at("camera").get<int>() +
                                                         stats.at("rays").at("scattered").get<int>() +
                                                         stats.at("rays").at("shadow").get<int>());
  EXPECT_GT(stats.at("relmse_predicted").get<double>(), 0);
  EXPECT_EQ(stats.at("rejected_samples").get<int>(), 0);
  ASSERT_GE(stats.at("devices").size(), 1U);
  EXPECT_EQ(stats.at("devices")[0].at("samples").get<int>(), 16 * 12 * 16);
  std::vector<std::string> stages;
  for (const json& stage : stats.at("stages")) {
    stages.push_back(stage.at("stage"));
    const bool within = stage.at("launches").get<int>() == 0;  // another stage's launch
    EXPECT_GT(within ? stage.at("items").get<int>() : stage.at("launches").get<int>(), 0) << stage;
    EXPECT_GE(stage.at("seconds").get<double>(), 0);
  }
  for (const char* stage : {"generate", "intersect", "shade", "shadow", "film"})
    EXPECT_NE(std::find(stages.begin(), stages.end(), stage), stages.end()) << stage;
}

TEST(Render, png_half_and_layers_are_written_as_asked) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(
      cornell("--size 24x10 --spp 4 --quiet --half --png out.png --aov albedo,normal,depth,id,variance,samples"))));
  const std::string png = read_bytes(here / "out.png");
  ASSERT_GT(png.size(), 40U);
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(png.substr(16, 8), std::string("\0\0\0\x18\0\0\0\x0a", 8));
  const Image half = read_exr(here / "out.exr");
  for (const char* channel : {"R", "G", "B", "albedo.R", "normal.Z", "depth.Z", "id", "variance.G", "samples"})
    EXPECT_NE(half.plane(channel), nullptr) << channel;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 24x10 --spp 4 --quiet"))));
  const Image full = read_exr(here / "out.exr");
  EXPECT_EQ(full.planes.size(), 3U);
  bool rounded = false;
  for (std::size_t i = 0; i < 240; ++i) {
    const float exact = (*full.plane("R"))[i], found = (*half.plane("R"))[i];
    EXPECT_NEAR(found, exact, 0.0005F * exact);
    rounded = rounded || found != exact;
  }
  EXPECT_TRUE(rounded);
}

TEST(Render, exposure_changes_the_png_alone) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 16x12 --spp 4 --quiet --png a.png"))));
  const std::string exr = read_bytes(here / "out.exr"), png = read_bytes(here / "a.png");
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 16x12 --spp 4 --quiet --png b.png --exposure 1"))));
  EXPECT_NE(read_bytes(here / "b.png"), png);
  const Image once = read_exr(here / "out.exr");
  here.write("before.exr", exr);
  EXPECT_EQ(once.planes, read_exr(here / "before.exr").planes);
}

TEST(Render, N4_crops_and_parts_carry_sums_that_add_up) {
  const Workplace here;
  const Film whole = sums_of(here, cornell(kWithSums));
  const Film part = sums_of(here, cornell("--size 8x8 --crop 3,2,7,5 --spp 4 --quiet"));
  EXPECT_EQ(part.layout().crop, (Crop{3, 2, 7, 5}));
  EXPECT_EQ(part.total(4, 3, 1), whole.total(4, 3, 1));
  Film sum = sums_of(here, cornell("--size 8x8 --samples 0:1 --quiet"));
  sum.add(sums_of(here, cornell("--size 8x8 --samples 1:4 --quiet")));
  EXPECT_TRUE(same_bits(whole, sum));
  EXPECT_FALSE(same_bits(whole, sums_of(here, cornell(std::string(kWithSums) + "--seed 1"))));
}

TEST(Render, direct_is_depth_two_to_the_bit) {
  const Workplace here;
  const Film direct = sums_of(here, cornell(std::string(kWithSums) + "--integrator direct"));
  EXPECT_TRUE(same_bits(direct, sums_of(here, cornell(std::string(kWithSums) + "--max-depth 2"))));
  EXPECT_FALSE(same_bits(direct, sums_of(here, cornell(kWithSums))));
}

TEST(Render, N5_two_devices_share_the_work_and_give_the_bits_of_one) {
  const Workplace here;
  const std::string image =
      cornell("--size 384x384 --crop 0,0,384,384 --spp 64 --quiet --aov normal,id --stats stats.json");
  const Film one = sums_of(here, image);
  const Film two = sums_of(here, image + " --devices 0,1", "POCL_DEVICES='pthread pthread'");
  const json devices = read_json(here / "stats.json").at("devices");
  ASSERT_EQ(devices.size(), 2U);
  for (const json& device : devices) EXPECT_GT(device.at("units").get<int>(), 0);
  EXPECT_TRUE(same_bits(one, two));
}

TEST(Render, a_probe_takes_the_fastest_layout_and_says_what_it_measured) {
  const Workplace here;
  const Film expected = sums_of(here, cornell(kWithSums));
  const std::string probing = cornell(std::string(kWithSums) + "--layout probe --stats stats.json");
  EXPECT_TRUE(same_bits(expected, sums_of(here, probing, "EIKON_LANES=1")));
  const json device = read_json(here / "stats.json").at("devices").at(0);
  const json& rates = device.at("layout_mrays_per_s");
  ASSERT_EQ(rates.size(), 3U);
  double best = 0;
  for (const auto& [layout, rate] : rates.items()) {
    EXPECT_GT(rate.get<double>(), 0) << layout;
    EXPECT_TRUE(contains(device.at("layout_reason").get<std::string>(), layout));
    best = std::max(best, rate.get<double>());
  }
  EXPECT_GE(1.03 * rates.at(device.at("layout").get<std::string>()).get<double>(), best);
}

TEST(Render, the_same_bits_from_every_width_layout_and_from_oclgrind) {
  const Workplace here;
  const Film expected = sums_of(here, cornell(kWithSums));
  for (const char* lanes : {"1", "8", "16"})
    EXPECT_TRUE(same_bits(expected, sums_of(here, cornell(kWithSums), std::string("EIKON_LANES=") + lanes))) << lanes;
  EXPECT_TRUE(same_bits(expected, sums_of(here, cornell(kWithSums), "EIKON_NO_OPTIMISE=1")));
  if (std::system("command -v oclgrind >/dev/null") != 0) GTEST_SKIP() << "Oclgrind is not installed";
  for (const char* lanes : {"1", "8", "16"})
    for (const std::string& layout : tree_layouts())
      EXPECT_TRUE(same_bits(expected, sums_of(here, cornell(std::string(kWithSums) + "--layout " + layout),
                                              std::string("EIKON_NO_OPTIMISE=1 EIKON_LANES=") + lanes + " oclgrind")))
          << "Oclgrind, " << lanes << " lanes, " << layout;
  const Film sky =
      sums_of(here, "render " + scene("window_room.gltf") +
                        " -o out.exr --size 4x4 --crop 0,0,4,4 --spp 2 --quiet --aov albedo,normal,depth,id");
  EXPECT_TRUE(
      same_bits(sky, sums_of(here,
                             "render " + scene("window_room.gltf") +
                                 " -o out.exr --size 4x4 --crop 0,0,4,4 --spp 2 --quiet --aov albedo,normal,depth,id",
                             "EIKON_NO_OPTIMISE=1 oclgrind")));
}

TEST(Render, replays_one_sample) {
  const Workplace here;
  const Outcome outcome = here.eikon(cornell("--size 16x12 --pixel 7,5 --sample 3"));
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.out, "pixel 7,5 sample 3") && contains(outcome.out, "edge  1") &&
              contains(outcome.out, "hits triangle") && contains(outcome.out, "radiance"))
      << outcome.out;
  EXPECT_TRUE(here.files().empty());
}

TEST(Render, replays_only_samples_that_the_image_has_and_writes_none_of_its_files) {
  const Workplace here;
  for (const char* flags : {"--spp 4 --sample 4", "--samples 2:4 --sample 1", "--crop 0,0,7,12 --sample 0",
                            "--crop 0,0,16,5 --sample 0", "--crop 8,0,16,12 --sample 0"})
    EXPECT_TRUE(refused(here.eikon(cornell("--size 16x12 --pixel 7,5 ") + flags), kUsage)) << flags;
  EXPECT_TRUE(
      succeeded(here.eikon(cornell("--size 16x12 --crop 7,5,8,6 --samples 3:4 --pixel 7,5 --sample 3 --png a.png "
                                   "--stats s.json --checkpoint c.exr --resume"))));
  EXPECT_TRUE(here.files().empty());
}

// A lamp so bright that what it gives leaves the film's range, in a room where few scattered rays
// meet it.
std::string glaring(const Workplace& here) {
  std::string text = read_bytes(scene("cornell.gltf"));
  const std::size_t at = text.find("\"emissiveStrength\"");
  EXPECT_NE(at, std::string::npos);
  const std::size_t colon = text.find(':', at), end = text.find_first_of(",}\n", colon);
  text.replace(colon + 1, end - colon - 1, " 1e25");
  here.write("glaring.gltf", text);
  return "render glaring.gltf -o out.exr --size 16x16 --spp 16 --quiet --light-sampling cosine ";
}

TEST(Render, N12_rejected_samples_are_said_and_replayed_and_fail_under_strict) {
  const Workplace here;
  const std::string arguments = glaring(here);
  const Outcome loose = here.eikon(arguments + "--stats stats.json");
  EXPECT_TRUE(succeeded(loose));
  EXPECT_EQ(loose.err.rfind("eikon: ", 0), 0U);
  EXPECT_TRUE(contains(loose.err, "samples were rejected"));
  EXPECT_FALSE(contains(loose.err, "nothing that the camera sees gives or gets light"));
  EXPECT_GT(read_json(here / "stats.json").at("rejected_samples").get<int>(), 0);
  EXPECT_GT(read_metadata(here / "out.exr").numbers.at("rejectedSamples"), 0);
  const Image image = read_exr(here / "out.exr");
  for (float value : *image.plane("R")) EXPECT_TRUE(std::isfinite(value));
  EXPECT_EQ(here.eikon(arguments + "--strict").code, 1);
  const std::size_t advice = loose.err.find("--pixel");
  ASSERT_NE(advice, std::string::npos);
  const Outcome again = here.eikon(arguments + loose.err.substr(advice, loose.err.find('\n') - advice));
  EXPECT_TRUE(succeeded(again));
  EXPECT_TRUE(contains(again.out, "e+2") || contains(again.out, "inf")) << again.out;
}

/// Waits until the process has worked for a while: it renders by then, however busy the machine is.
void wait_for_work(pid_t process) {
  const double ticks_per_second = static_cast<double>(sysconf(_SC_CLK_TCK));
  for (int i = 0; i < 1200; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::ifstream file("/proc/" + std::to_string(process) + "/stat");
    std::string word;
    double user_ticks = 0;
    for (int field = 0; field < 13; ++field) file >> word;  // "(eikon)" has no space
    if (file >> user_ticks && user_ticks / ticks_per_second > 1) return;
  }
  ADD_FAILURE() << "nothing is rendered";
}

void expect_clean_end(int signal) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell(kWithSums))));  // compiled
  std::filesystem::remove(here / "out.exr");
  const pid_t child = here.start(cornell("--size 64x64 --crop 0,0,64,64 --spp 100000000 --quiet --stats stats.json"));
  wait_for_work(child);
  kill(child, signal);
  const Outcome outcome = here.wait(child);
  EXPECT_EQ(outcome.code, 128 + signal) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "eikon: interrupted"));
  const json stats = read_json(here / "stats.json");
  EXPECT_TRUE(stats.at("interrupted").get<bool>());
  const Film film = read_film(here / "out.exr");
  std::uint64_t samples = 0;
  for (std::uint32_t i = 0; i < 64 * 64; ++i) samples += film.samples(i % 64, i / 64);
  EXPECT_EQ(samples, stats.at("samples").get<std::uint64_t>());
  EXPECT_GT(samples, 0U);
  // What is there is what an undisturbed render has.
  const std::uint64_t spp = film.samples(9, 9);
  const Film same = sums_of(here, cornell("--size 64x64 --crop 9,9,10,10 --quiet --spp " + std::to_string(spp)));
  EXPECT_EQ(same.total(9, 9, 0), film.total(9, 9, 0));
}

TEST(Render, N9_interrupted_by_the_user_keeps_what_is_done) { expect_clean_end(SIGINT); }
TEST(Render, N9_terminated_keeps_what_is_done) { expect_clean_end(SIGTERM); }

TEST(Render, killed_leaves_no_picture_that_is_not_whole) {
  const Workplace here;
  const pid_t child = here.start(cornell("--size 64x64 --spp 100000000 --quiet"));
  wait_for_work(child);
  kill(child, SIGKILL);
  EXPECT_EQ(here.wait(child).code, 1000 + SIGKILL);
  EXPECT_TRUE(here.files().empty());
}

/// square_light.gltf with a change to its JSON, as dark.gltf.
template <class Change>
void write_dark(const Workplace& here, const Change& change) {
  json gltf = read_json(scene("square_light.gltf"));
  change(gltf);
  here.write("dark.gltf", gltf.dump());
}

TEST(Render, a_scene_without_light_gets_the_neutral_studio_and_says_so) {
  const Workplace here;
  // An emitting material that no triangle has is no light.
  write_dark(here, [](json& gltf) {
    for (json& mesh : gltf.at("meshes"))
      for (json& primitive : mesh.at("primitives")) primitive["material"] = 0;
  });
  const std::string render = "render dark.gltf --size 4x4 --spp 4 --look-at 5,3,5:5,0,0 --fov 1 -o ";
  const Outcome outcome = here.eikon(render + "out.exr");
  EXPECT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.err, "no light") && contains(outcome.err, "--env none, neutral")) << outcome.err;
  EXPECT_GT((*read_exr(here / "out.exr").plane("R"))[5], 0.2F);
  const Outcome asked = here.eikon(render + "asked.exr --env neutral");
  EXPECT_TRUE(succeeded(asked));
  EXPECT_FALSE(contains(asked.err, "neutral"));
  EXPECT_EQ(*read_exr(here / "out.exr").plane("R"), *read_exr(here / "asked.exr").plane("R"));
  const Outcome black = here.eikon(render + "black.exr --env none");
  EXPECT_TRUE(succeeded(black));
  EXPECT_TRUE(contains(black.err, "black all over"));
  EXPECT_EQ((*read_exr(here / "black.exr").plane("R"))[5], 0);
}

TEST(Render, light_that_does_not_reach_what_is_seen_is_joined_by_the_neutral_studio) {
  const Workplace here;
  write_dark(here, [](json& gltf) {  // a hundred thousandth of its strength
    for (json& material : gltf.at("materials"))
      if (material.contains("emissiveFactor")) {
        material["emissiveFactor"] = {1e-5, 1e-5, 1e-5};
        if (material.contains("extensions")) material["extensions"].erase("KHR_materials_emissive_strength");
      }
  });
  const Outcome dark = here.eikon("render dark.gltf --size 4x4 --spp 1 -o out.exr");
  EXPECT_TRUE(succeeded(dark));
  EXPECT_TRUE(contains(dark.err, "own lights") && contains(dark.err, "neutral studio is added")) << dark.err;
  EXPECT_FALSE(contains(dark.err, "black all over"));
  const Outcome lit = here.eikon("render " + scene("square_light.gltf") + " --size 4x4 --spp 1 -o lit.exr");
  EXPECT_TRUE(succeeded(lit));
  EXPECT_FALSE(contains(lit.err, "neutral"));
}

TEST(Render, look_at_and_env_replace_the_camera_and_the_sky) {
  const Workplace here;
  EXPECT_TRUE(
      succeeded(here.eikon("render " + scene("sphere_in_sky.gltf") +
                           " -o out.exr --size 9x9 --spp 4 --quiet --look-at 0,0,5:0,0,0:0,1,0 --fov 5 --env 2,2,2")));
  EXPECT_NEAR((*read_exr(here / "out.exr").plane("G"))[40], 2 * 0.5F, 1e-5F);
  EXPECT_TRUE(succeeded(here.eikon("render " + scene("sphere_in_sky.gltf") +
                                   " -o out.exr --size 9x9 --spp 4 --quiet --look-at 0,0,5:0,0,9 --env 2,3,4")));
  EXPECT_EQ((*read_exr(here / "out.exr").plane("G"))[40], 3);
}

}  // namespace
}  // namespace eikon::test
