// SPDX-License-Identifier: Apache-2.0
// Whatever is wrong: one line that says what, an exit code of its kind, and no file left behind.
#include "cli/command.h"
#include "image/image.h"
#include "support/paths.h"

namespace eikon::test {
namespace {

TEST(BadInput, scenes_that_cannot_be_read_are_refused_by_name) {
  const Workplace here;
  const std::string cornell = read_bytes(scene("cornell.gltf"));
  here.write("empty.gltf", "");
  here.write("empty.glb", "");
  here.write("half.gltf", cornell.substr(0, cornell.size() / 2));
  here.write("magic.glb", "glTX\x02\0\0\0 nothing of the kind");
  here.write("notes.gltf", "this is no JSON\n");
  here.write("picture.png", "\x89PNG");
  std::filesystem::create_directory(here / "folder.gltf");
  const std::vector<std::string> before = here.files();
  for (const char* name : {"missing.gltf", "empty.gltf", "empty.glb", "half.gltf", "magic.glb", "notes.gltf",
                           "picture.png", "folder.gltf"}) {
    const Outcome outcome = here.eikon(std::string("render ") + name + " -o out.exr");
    EXPECT_TRUE(refused(outcome, kInput)) << name;
    EXPECT_TRUE(contains(outcome.err, name));
    EXPECT_TRUE(refused(here.eikon(std::string("info ") + name), kInput)) << name;
  }
  EXPECT_EQ(here.files(), before);
}

TEST(BadInput, data_that_lies_is_refused) {
  const Workplace here;
  const std::string cornell = read_bytes(scene("cornell.gltf"));
  const auto edited = [&](const std::string& from, const std::string& to) {
    std::string text = cornell;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  here.write("extension.gltf",
             edited("{", "{\"extensionsRequired\": [\"EXT_of_another_world\"], \"extensionsUsed_\": 0, "));
  here.write("version.gltf", edited("\"2.0\"", "\"3.0\""));
  const std::vector<std::string> before = here.files();
  EXPECT_TRUE(contains(here.eikon("render extension.gltf -o out.exr").err, "EXT_of_another_world"));
  EXPECT_TRUE(refused(here.eikon("render extension.gltf -o out.exr"), kInput));
  EXPECT_TRUE(refused(here.eikon("render version.gltf -o out.exr"), kInput));
  EXPECT_EQ(here.files(), before);
}

TEST(BadInput, surfaces_by_formula_that_are_none_are_refused_by_name) {
  const Workplace here;
  const std::string torus = read_bytes(scene("implicit_torus.gltf"));
  const std::size_t at = torus.find("\"f\": \""), bounds = torus.find("\"bounds\": [");
  ASSERT_NE(at, std::string::npos);
  ASSERT_NE(bounds, std::string::npos);
  const auto with = [&](const std::string& f, const std::string& limits) {
    std::string text = torus;
    if (!limits.empty()) text.replace(bounds, text.find(']', bounds) + 1 - bounds, limits);
    const std::size_t from = text.find("\"f\": \"") + 6;
    if (!f.empty()) text.replace(from, text.find('"', from) - from, f);
    here.write("surface.gltf", text);
  };
  const std::vector<std::pair<std::string, std::string>> formulas = {{"x^2 +", "column 6"},
                                                                     {"x + radius", "unknown name 'radius'"},
                                                                     {std::string(5000, 'x'), "too long"},
                                                                     {"3", "does not depend on x, y or z"},
                                                                     {"x/0", "division by zero"}};
  const std::vector<std::pair<std::string, std::string>> limits = {
      {"\"boundaries\": [-1, -1, -1, 1, 1, 1]", "'bounds' is missing"},
      {"\"bounds\": [1, -1, -1, 1, 1, 1]", "'bounds' are empty: x from 1 to 1"},
      {"\"bounds\": [-1, -1, -1, 1, 1, 1e400]", ""},  // infinite: no JSON number
      {"\"bounds\": [-1, -1, -1, 1, 1, 1e39]", "'bounds' reach z = 1e+39"},
      {"\"bounds\": [-1, -1, -1, 1, 1, NaN]", ""},
      {"\"bounds\": [-1, -1, -1, 1, 1, null]", "'bounds'"}};
  with("x^2+y^2+z^2-1", "");
  EXPECT_EQ(here.eikon("info surface.gltf").code, 0);
  const std::vector<std::string> before = here.files();
  const auto expect_refused = [&](const std::string& says) {
    const Outcome outcome = here.eikon("render surface.gltf -o out.exr --png out.png");
    EXPECT_TRUE(refused(outcome, kInput)) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, says));
    if (!says.empty()) {
      EXPECT_TRUE(contains(outcome.err, "node '"));
      EXPECT_TRUE(contains(outcome.err, "EIKON_implicit_surface"));
    }
    EXPECT_EQ(here.files(), before);
  };
  for (const auto& [f, says] : formulas) with(f, ""), expect_refused(says);
  for (const auto& [limit, says] : limits) with("", limit), expect_refused(says);
}

TEST(BadInput, more_memory_than_there_is_names_what_would_reduce_it) {
  const Workplace here;
  const Outcome outcome = here.eikon("render " + scene("cornell.gltf") + " -o out.exr --memory 100K");
  EXPECT_TRUE(refused(outcome, kDevice)) << outcome.err;
  for (const char* part : {"it needs", "MB", "--memory is 0.1 MB", "--size", "--devices"})
    EXPECT_TRUE(contains(outcome.err, part));
  EXPECT_TRUE(here.files().empty());
}

TEST(BadInput, flags_that_make_no_sense_are_usage_errors) {
  const Workplace here;
  for (const char* flags : {"--crop 0,0,17,12",
                            "--crop 5,5,5,6",
                            "--crop 1,2,3",
                            "--crop a,b,c,d",
                            "--samples 5:5",
                            "--samples 6:5",
                            "--samples 5",
                            "--samples :",
                            "--samples 0:281474976710657",
                            "--spp 0",
                            "--spp -1",
                            "--spp many",
                            "--memory 4x",
                            "--no-such-flag",
                            "--aov beauty",
                            "--env 1,2",
                            "--env 1,2,nan",
                            "--env -1,0,0",
                            "--look-at 0,0,0:0,0,0",
                            "--look-at 0,0,0",
                            "--look-at 0,0,0:0,1,0",
                            "--look-at 1e300,0,0:0,0,0",
                            "--fov 180",
                            "--fov 0",
                            "--fov nan",
                            "--f-number 2",
                            "--f-number 0 --focus-distance 1",
                            "--f-number wide --focus-distance 1",
                            "--focus-distance 2",
                            "--focus-distance -1 --f-number 2",
                            "--f-number 2 --focus-distance 1 --panorama",
                            "--panorama --fov 30",
                            "--ev100 nan",
                            "--ev100 3 --exposure 1",
                            "--camera nobody",
                            "--camera 1",
                            "--light-sampling sun",
                            "--integrator none",
                            "--accel quadtree",
                            "--layout bvh3",
                            "--max-depth -1",
                            "--seed -1",
                            "--seed 4294967296",
                            "--seed 0.5",
                            "--exposure nan",
                            "--depth-series 31",
                            "--depth-series 1,-1",
                            "--depth-series all",
                            "--roulette 0",
                            "--roulette 1",
                            "--roulette nan",
                            "--aov glow",
                            "--light-sampling cosine --integrator whitted",
                            "--light-sampling hemisphere --integrator raycast",
                            "--light-samples 0 --integrator direct",
                            "--light-samples 17 --integrator direct",
                            "--light-samples 2",
                            "--light-samples 2 --integrator whitted",
                            "--light-samples 2 --integrator raycast",
                            "--light-samples 2 --integrator direct --light-sampling cosine",
                            "--exposure 65",
                            "--pixel 1,1",
                            "--sample 3",
                            "--pixel 16,0 --sample 0",
                            "--pixel 1 --sample 0",
                            "extra",
                            "--png"}) {
    const Outcome outcome = here.eikon(cornell("--size 16x12 ") + flags);
    EXPECT_TRUE(refused(outcome, kUsage)) << flags;
    // It names the flag, or the word that it does not know.
    const std::string flag = std::string(flags).substr(0, std::string(flags).find(' '));
    EXPECT_TRUE(contains(outcome.err, flag.substr(flag.find_first_not_of('-')))) << flags << ": " << outcome.err;
  }
  EXPECT_TRUE(contains(here.eikon(cornell("--spp 0")).err, "--spp: '0' is not a number from 1 to 281474976710656\n"));
  for (const char* size : {"0x5", "5", "70000x2", "16x", "x", "16x12x3", "1e2x5", "-1x5"}) {
    const Outcome outcome = here.eikon(cornell("--size ") + size);
    EXPECT_TRUE(refused(outcome, kUsage)) << size;
    EXPECT_TRUE(contains(outcome.err, "--size"));
  }
  EXPECT_TRUE(refused(here.eikon(cornell("--size 8x8 --size 9x9")), kUsage));
  EXPECT_TRUE(refused(here.eikon("render"), kUsage));
  EXPECT_TRUE(refused(here.eikon("paint " + scene("cornell.gltf")), kUsage));
  EXPECT_TRUE(refused(here.eikon(""), kUsage));
  EXPECT_TRUE(refused(here.eikon("compare one.exr"), kUsage));
  EXPECT_TRUE(here.files().empty());
}

// A script's "$OUT" with nothing in OUT.
TEST(BadInput, empty_values_are_refused_rather_than_taken_for_defaults) {
  const Workplace here;
  const std::string render = "render " + scene("cornell.gltf") + " --size 4x4 --spp 1 ";
  for (const char* flag : {"-o", "--png", "--checkpoint", "--stats", "--profile", "--camera", "--samples", "--crop",
                           "--env", "--aov", "--variant", "--devices"}) {
    const Outcome outcome = here.eikon(render + flag + " ''");
    EXPECT_TRUE(refused(outcome, kUsage)) << flag;
    EXPECT_TRUE(contains(outcome.err, flag) && contains(outcome.err, "empty")) << flag << ": " << outcome.err;
  }
  for (const char* command : {"render ''", "info ''", "info one.gltf --size ''", "batch ''", "compare '' one.exr",
                              "merge one.exr '' -o two.exr", "merge one.exr -o ''", "bench rays ''"}) {
    const Outcome outcome = here.eikon(command);
    EXPECT_TRUE(refused(outcome, kUsage)) << command;
    EXPECT_TRUE(contains(outcome.err, "empty")) << command << ": " << outcome.err;
  }
  here.write("jobs.txt", render + "-o ''\n");
  const Outcome batch = here.eikon("batch jobs.txt --quiet");
  EXPECT_EQ(batch.code, 1);
  EXPECT_TRUE(contains(batch.err, "jobs.txt:1: --output: its value is empty"));
  EXPECT_EQ(here.files(), (std::vector<std::string>{"jobs.txt", "jobs.txt.ledger"}));
}

TEST(BadInput, a_name_of_several_lines_makes_a_message_of_one) {
  const Workplace here;
  for (const char* command : {"compare 'a\nb.exr' c.exr", "render 'a\nb.gltf' -o c.exr", "merge 'a\nb' -o c.exr"})
    EXPECT_TRUE(refused(here.eikon(command), kInput)) << command;
  EXPECT_TRUE(refused(here.eikon("render " + scene("cornell.gltf") + " -o 'a\nb/c.exr'"), kInput));
  EXPECT_TRUE(here.files().empty());
}

TEST(BadInput, a_view_from_beyond_the_largest_coordinate_is_told_so) {
  const Workplace here;
  for (const char* view : {"1e300,0,0:1,1,1", "0,0,0:0,0,-1e13", "0,0,0:0,0,1:0,1e200,0"}) {
    const Outcome outcome = here.eikon("info " + scene("cornell.gltf") + " --look-at " + view);
    EXPECT_TRUE(refused(outcome, kUsage)) << view;
    EXPECT_TRUE(contains(outcome.err, "2^40"));
  }
}

TEST(BadInput, devices_that_are_not_there_are_refused) {
  const Workplace here;
  const Outcome unknown = here.eikon(cornell("--size 16x12 --devices voodoo"));
  EXPECT_TRUE(refused(unknown, kDevice));
  EXPECT_TRUE(contains(unknown.err, "voodoo"));
  EXPECT_TRUE(contains(unknown.err, "0: ")) << "does not say what there is: " << unknown.err;
  EXPECT_TRUE(refused(here.eikon(cornell("--size 16x12 --devices 7")), kDevice));
  EXPECT_TRUE(refused(here.eikon(cornell("--size 16x12 --devices 0,,0")), kDevice));
  EXPECT_TRUE(here.files().empty());
}

TEST(BadInput, without_a_platform_a_line_says_what_to_install) {
  const Workplace here;
  std::filesystem::create_directory(here / "vendors");
  for (const std::string& vendors :
       {"OCL_ICD_VENDORS=" + (here / "vendors").string(), std::string("OCL_ICD_VENDORS=/nonexistent")}) {
    const Outcome outcome = here.eikon(cornell(), vendors);
    EXPECT_TRUE(refused(outcome, kDevice));
    EXPECT_TRUE(contains(outcome.err, "pocl")) << "does not say what to install: " << outcome.err;
    EXPECT_EQ(here.eikon("devices", vendors).code, kDevice);
    EXPECT_TRUE(succeeded(here.eikon("info " + scene("cornell.gltf"), vendors))) << "info needs no device";
  }
  EXPECT_EQ(here.files(), std::vector<std::string>{"vendors"});
}

TEST(BadInput, kernels_that_do_not_compile_end_a_render_at_once) {
  const Workplace here;
  std::filesystem::copy(std::string(EIKON_SOURCE_DIR) + "/kernels", here / "kernels",
                        std::filesystem::copy_options::recursive);
  std::ofstream(here / "kernels/stages/shade.h", std::ios::app) << "\nthis is not OpenCL;\n";
  for (const char* size : {"128x128", "16x16"}) {  // with a pilot, and without one
    const Outcome outcome = here.eikon("render " + scene("cornell.gltf") + " -o out.exr --spp 1 --size " + size,
                                       "EIKON_KERNEL_DIR=" + (here / "kernels").string());
    EXPECT_EQ(outcome.code, kDevice);
    ASSERT_TRUE(contains(outcome.err, "eikon: "));
    const auto ours = outcome.err.begin() + static_cast<std::ptrdiff_t>(outcome.err.find("eikon: "));
    EXPECT_EQ(std::count(ours, outcome.err.end(), '\n'), 1) << outcome.err;
    // Before it PoCL counts the errors, in the text without comments and in the whole one.
    EXPECT_LE(std::count(outcome.err.begin(), ours, '\n'), 2) << "it was tried again: " << outcome.err;
    EXPECT_TRUE(contains(outcome.err, "shade.h:"));
    EXPECT_EQ(outcome.err.find("do not compile"), outcome.err.rfind("do not compile")) << outcome.err;
    EXPECT_TRUE(contains(outcome.err, " -DEK_HAS_next_event=1 "));
    EXPECT_FALSE(contains(outcome.err, "=0 ")) << "of features that are out: " << outcome.err;
  }
  EXPECT_EQ(here.files(), std::vector<std::string>{"kernels"});
}

TEST(BadInput, outputs_that_cannot_be_written_are_refused) {
  const Workplace here;
  std::filesystem::create_directory(here / "taken");
  here.write("file", "x");
  const std::vector<std::string> before = here.files();
  for (const char* output : {"-o nowhere/out.exr", "-o taken", "-o file/out.exr", "-o /proc/out.exr", "-o /dev/null"}) {
    const Outcome outcome = here.eikon("render " + scene("cornell.gltf") + " --size 8x8 --spp 1 --quiet " + output);
    EXPECT_EQ(outcome.code, kInput) << output << outcome.out;
    EXPECT_EQ(outcome.err.rfind("eikon: ", 0), 0U) << output << ": " << outcome.err;
  }
  for (const char* more : {"--png nowhere/x.png", "--stats nowhere/x.json", "--profile taken"})
    EXPECT_TRUE(refused(here.eikon(cornell("--size 8x8 --spp 1 ") + more), kInput)) << more;
  EXPECT_EQ(here.files(), before);
}

TEST(BadInput, outputs_take_no_other_s_place) {
  const Workplace here;
  const std::string text = read_bytes(scene("furnace.gltf"));
  here.write("furnace.gltf", text);
  const std::string render = "render furnace.gltf --size 4x4 --spp 1 --quiet -o ";
  EXPECT_TRUE(refused(here.eikon(render + "furnace.gltf"), kUsage));
  EXPECT_TRUE(refused(here.eikon(render + "out.exr --png ./furnace.gltf"), kUsage));
  EXPECT_TRUE(refused(here.eikon(render + "out.exr --stats ./out.exr"), kUsage));
  EXPECT_EQ(read_bytes(here / "furnace.gltf"), text);
  EXPECT_EQ(here.files(), std::vector<std::string>{"furnace.gltf"});
}

TEST(BadInput, a_read_only_folder_is_refused) {
  const Workplace here;
  const auto folder = here / "closed";
  std::filesystem::create_directory(folder);
  std::filesystem::permissions(folder, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  if (access(folder.c_str(), W_OK) == 0) GTEST_SKIP() << "this user may write everywhere";
  EXPECT_TRUE(refused(here.eikon("render " + scene("cornell.gltf") + " -o closed/out.exr"), kInput));
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
}

TEST(BadInput, a_full_disk_leaves_no_half_written_file) {
  const Workplace here;
  const std::string noisy = cornell("--size 1024x1024 --spp 1 --quiet");
  ASSERT_TRUE(succeeded(here.eikon(noisy)));  // what it compiles is kept before the limit falls
  ASSERT_GT(std::filesystem::file_size(here / "out.exr"), 12288U * 512U);
  std::filesystem::remove(here / "out.exr");
  // No file may be longer than 12288 blocks of 512 bytes: 6 MiB, which the driver needs itself.
  const Outcome outcome = here.eikon(noisy, "ulimit -f 12288; trap '' XFSZ;");
  EXPECT_EQ(outcome.code, kInput) << outcome.err;
  EXPECT_EQ(outcome.err.rfind("eikon: ", 0), 0U) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "out.exr"));
  EXPECT_TRUE(here.files().empty());
}

TEST(BadInput, results_that_reach_nobody_are_an_error_and_closed_streams_hit_no_file) {
  const Workplace here;
  const std::string info = Workplace::binary() + " info " + scene("cornell.gltf");
  const Outcome full = here.shell(info + " > /dev/full");
  EXPECT_EQ(full.code, kInput);
  EXPECT_TRUE(contains(full.err, "eikon: cannot write to standard output"));
  EXPECT_TRUE(succeeded(here.shell("yes '# nothing' | head -3 > jobs; echo render absent.gltf >> jobs; " +
                                   Workplace::binary() + " batch jobs 2> /dev/full; test $? = 1")))
      << "a log on a full disk stops no batch";
  const std::string render = Workplace::binary() + " " + cornell("--size 16x12 --spp 4 --checkpoint c.exr");
  ASSERT_TRUE(succeeded(here.shell(render + " --progress openjd <&- >&- 2>&-")));
  std::filesystem::rename(here / "out.exr", here / "first.exr");
  ASSERT_TRUE(succeeded(here.shell(render)));
  EXPECT_EQ(read_exr(here / "first.exr").planes, read_exr(here / "out.exr").planes);
}

TEST(BadInput, compare_refuses_what_is_no_picture_or_another_size) {
  const Workplace here;
  here.write("no.exr", "no picture");
  ASSERT_TRUE(succeeded(here.eikon(cornell())));
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("furnace.gltf") + " -o other.exr --size 8x8 --spp 1 --quiet")));
  std::string whole = read_bytes(here / "out.exr");
  here.write("half.exr", whole.substr(0, whole.size() / 2));
  EXPECT_TRUE(refused(here.eikon("compare no.exr out.exr"), kInput));
  EXPECT_TRUE(refused(here.eikon("compare out.exr missing.exr"), kInput));
  EXPECT_TRUE(refused(here.eikon("compare out.exr other.exr"), kInput));
  EXPECT_TRUE(refused(here.eikon("compare out.exr half.exr"), kInput));
}

TEST(BadInput, strict_refuses_what_is_not_supported) {
  const Workplace here;
  std::string text = read_bytes(scene("sphere_in_sky.gltf"));
  const std::string from = "\"KHR_materials_specular\"";
  const std::size_t at = text.find("\"extensionsUsed\"");
  ASSERT_NE(at, std::string::npos);
  const std::size_t used = text.find(from, at);
  text.insert(used, "\"VENDOR_paint\", ");
  const std::size_t material = text.find("\"extensions\"", text.find("\"materials\""));
  const std::size_t brace = text.find('{', material);
  text.insert(brace + 1, "\"VENDOR_paint\": {\"gloss\": 1}, ");
  here.write("painted.gltf", text);
  const Outcome loose = here.eikon("render painted.gltf -o out.exr --size 4x4 --spp 1");
  EXPECT_TRUE(succeeded(loose));
  EXPECT_TRUE(contains(loose.err, "VENDOR_paint") && contains(loose.err, "'body'")) << loose.err;
  std::filesystem::remove(here / "out.exr");
  EXPECT_TRUE(refused(here.eikon("render painted.gltf -o out.exr --size 4x4 --spp 1 --strict"), kInput));
  EXPECT_EQ(here.files(), std::vector<std::string>{"painted.gltf"});
}

TEST(BadInput, M24_strict_refuses_numbers_out_of_range_and_names_the_material) {
  const Workplace here;
  std::string text = read_bytes(scene("sphere_in_sky.gltf"));
  const std::size_t material = text.find("\"extensions\"", text.find("\"materials\""));
  ASSERT_NE(material, std::string::npos);
  text.insert(text.find('{', material) + 1, "\"KHR_materials_sheen\": {\"sheenRoughnessFactor\": 2}, ");
  here.write("painted.gltf", text);
  const Outcome loose = here.eikon("render painted.gltf -o out.exr --size 4x4 --spp 1");
  EXPECT_TRUE(succeeded(loose));
  EXPECT_TRUE(contains(loose.err, "'body': sheenRoughnessFactor 2 clamped to 1"));
  std::filesystem::remove(here / "out.exr");
  const Outcome strict = here.eikon("render painted.gltf -o out.exr --size 4x4 --spp 1 --strict");
  EXPECT_TRUE(refused(strict, kInput) && contains(strict.err, "'body': sheenRoughnessFactor 2")) << strict.err;
  EXPECT_EQ(here.files(), std::vector<std::string>{"painted.gltf"});
}

TEST(BadInput, a_variant_that_the_file_has_not_is_refused_in_a_line) {
  const Workplace here;
  EXPECT_TRUE(refused(here.eikon("render " + scene("cornell.gltf") + " -o out.exr --variant red"), kInput));
  EXPECT_TRUE(here.files().empty());
}

}  // namespace
}  // namespace eikon::test
