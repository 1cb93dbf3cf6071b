// SPDX-License-Identifier: Apache-2.0
// `eikon bench scene`: that its errors are those of `compare`, and what it refuses. How fast it is,
// no test says.
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/command.h"

namespace eikon::test {
namespace {

const std::string kSize = " --size 24x16 ";

/// "bench scene" of the Cornell box, with these flags more.
std::string bench(const std::string& flags) { return "bench scene " + scene("cornell.gltf") + kSize + flags; }

void make_reference(const Workplace& here) {
  ASSERT_TRUE(
      succeeded(here.eikon("render " + scene("cornell.gltf") + kSize + "--spp 256 --seed 7 --quiet -o ref.exr")));
}

/// The slope of a least-squares line through the logarithms of the errors over those of `amount`.
double slope(const nlohmann::json& points, const char* amount) {
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  for (const auto& point : points) {
    mean_x += std::log(point.at(amount).get<double>()) / double(points.size());
    mean_y += std::log(point.at("relmse").get<double>()) / double(points.size());
  }
  for (const auto& point : points) {
    const double x = std::log(point.at(amount).get<double>()) - mean_x;
    xx += x * x;
    xy += x * (std::log(point.at("relmse").get<double>()) - mean_y);
  }
  return xy / xx;
}

TEST(BenchScene, errors_are_those_of_compare_on_renders_of_as_many_samples) {
  const Workplace here;
  make_reference(here);
  const auto begin = std::chrono::steady_clock::now();
  const Outcome outcome = here.eikon(bench("--spp 11 --seed 3 --ref ref.exr --json e.json"));
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ASSERT_TRUE(succeeded(outcome));
  const nlohmann::json result = read_json(here / "e.json");
  std::vector<std::uint64_t> counts;
  double alone = 0, from_start = 0;
  for (const auto& point : result.at("points")) {
    const auto spp = point.at("spp").get<std::uint64_t>();
    counts.push_back(spp);
    ASSERT_TRUE(succeeded(here.eikon("render " + scene("cornell.gltf") + kSize + "--seed 3 --quiet -o test.exr --spp " +
                                     std::to_string(spp))));
    const nlohmann::json expected = nlohmann::json::parse(here.eikon("compare test.exr ref.exr --json").out);
    const double relmse = point.at("relmse");
    EXPECT_GT(relmse, 0);
    EXPECT_NEAR(relmse, expected.at("relmse").get<double>(), 1e-12 * relmse) << spp;
    EXPECT_NEAR(point.at("ratio_of_means").get<double>(), expected.at("ratio_of_means").get<double>(), 1e-12) << spp;
    EXPECT_EQ(point.at("relmse_predicted").is_null(), spp == 1);  // takes a sample of each replicate
    const double seconds = point.at("seconds"), start = point.at("seconds_from_start");
    EXPECT_GT(seconds, alone);
    EXPECT_GE(start, from_start);
    EXPECT_GE(start + 0.02, seconds);  // the clock of processes has steps of 10 ms
    EXPECT_LE(start, wall_s + 0.02);
    EXPECT_NEAR(point.at("samples_per_second").get<double>(), double(spp) * 24 * 16 / seconds,
                1e-6 * double(spp) * 384 / seconds);
    EXPECT_NEAR(point.at("efficiency").get<double>() * relmse * seconds, 1, 1e-12);
    alone = seconds;
    from_start = start;
  }
  EXPECT_EQ(counts, (std::vector<std::uint64_t>{1, 2, 4, 8, 11}));
  EXPECT_GT(result.at("reference").at("relmse_predicted").get<double>(), 0);
  // A head, a line per point, and two exponents.
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 8);
  const nlohmann::json exponents = result.at("exponents");
  EXPECT_NEAR(exponents.at("samples").at("value").get<double>(), slope(result.at("points"), "spp"), 1e-9);
  EXPECT_NEAR(exponents.at("seconds").at("value").get<double>(), slope(result.at("points"), "seconds"), 1e-9);
}

TEST(BenchScene, without_a_reference_the_error_is_the_predicted_one_and_that_is_said) {
  const Workplace here;
  const Outcome outcome = here.eikon(bench("--spp 64 --json e.json"));
  ASSERT_TRUE(succeeded(outcome));
  EXPECT_TRUE(contains(outcome.err, "no --ref"));
  const nlohmann::json result = read_json(here / "e.json");
  EXPECT_TRUE(result.at("reference").is_null());
  // An error without an upper end gives no efficiency.
  for (const nlohmann::json& point : result.at("points"))
    EXPECT_EQ(point.at("efficiency").is_null(),
              point.at("relmse_interval").is_null() || point.at("relmse_interval")[1].is_null());
  const nlohmann::json& last = result.at("points").back();
  EXPECT_TRUE(last.at("relmse").is_null());
  EXPECT_NEAR(last.at("efficiency").get<double>() * last.at("relmse_predicted").get<double>() *
                  last.at("seconds").get<double>(),
              1, 1e-12);
}

TEST(BenchScene, time_ends_it) {
  const Workplace here;
  constexpr double kTime_s = 0.2;
  ASSERT_TRUE(succeeded(here.eikon(bench("--time 0.2 --json e.json"))));
  const nlohmann::json points = read_json(here / "e.json").at("points");
  ASSERT_FALSE(points.empty());
  // The next point takes as long again as all before it, so the first that used more than half of
  // the time is the last.
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_EQ(2 * points[i].at("seconds").get<double>() > kTime_s, i + 1 == points.size()) << "point " << i;
  ASSERT_TRUE(succeeded(here.eikon(bench("--time 1e6 --spp 4 --json e.json"))));
  EXPECT_EQ(read_json(here / "e.json").at("points").size(), 3U) << "samples end it before the time does";
}

TEST(BenchScene, a_reference_of_another_picture_is_refused_in_one_line) {
  const Workplace here;
  make_reference(here);
  const auto with = [&](const std::string& flags) {
    return here.eikon("bench scene " + scene("cornell.gltf") + " --ref ref.exr --spp 1 " + flags);
  };
  ASSERT_TRUE(succeeded(with(kSize)));
  const std::pair<const char*, const char*> others[] = {{"--size 24x17", "24 x 16"},
                                                        {"--size 24x16 --max-depth 3", "maxDepth"},
                                                        {"--size 24x16 --filter gaussian", "filter"},
                                                        {"--size 24x16 --env 1,1,1", "environment"},
                                                        {"--size 24x16 --fov 20", "camera"}};
  for (const auto& [flags, reason] : others) {
    const Outcome outcome = with(flags);
    EXPECT_TRUE(refused(outcome, 3)) << flags;
    EXPECT_TRUE(contains(outcome.err, reason));
  }
  ASSERT_TRUE(succeeded(
      here.eikon("render " + scene("cornell.gltf") + " -o crop.exr --crop 12,8,24,16 --seed 9 --spp 4" + kSize)));
  const Outcome window_differs =
      here.eikon("bench scene " + scene("cornell.gltf") + kSize + "--crop 0,0,12,8 --ref crop.exr --spp 1");
  EXPECT_TRUE(refused(window_differs, 3));
  EXPECT_TRUE(contains(window_differs.err, "begins at 12,8, that of the render at 0,0"));
  const Outcome scene_differs =
      here.eikon("bench scene " + scene("cornell_spheres.gltf") + kSize + "--ref ref.exr --spp 1");
  EXPECT_TRUE(refused(scene_differs, 3));
  EXPECT_TRUE(contains(scene_differs.err, "sceneHash"));
}

TEST(BenchScene, a_reference_of_the_same_samples_is_refused) {
  const Workplace here;
  make_reference(here);
  EXPECT_TRUE(refused(here.eikon(bench("--spp 1 --seed 7 --ref ref.exr")), 2));
  EXPECT_TRUE(succeeded(here.eikon(bench("--samples 256:258 --seed 7 --ref ref.exr"))));  // those it does not have
}

TEST(BenchScene, files_that_cannot_be_are_refused_before_the_work) {
  const Workplace here;
  make_reference(here);
  here.write("text.exr", "no picture");
  std::string bytes = read_bytes(here / "ref.exr");
  bytes.at(bytes.find("0:256", bytes.find("sampleRange"))) = 'x';
  here.write("range.exr", bytes);
  const Outcome range = here.eikon(bench("--spp 1 --ref range.exr"));
  EXPECT_TRUE(refused(range, 3));
  EXPECT_TRUE(contains(range.err, "sampleRange is 'x:256'"));
  EXPECT_TRUE(refused(here.eikon(bench("--spp 1 --ref none.exr")), 3));
  EXPECT_TRUE(refused(here.eikon(bench("--spp 1 --ref text.exr")), 3));
  EXPECT_TRUE(refused(here.eikon(bench("--spp 1 --ref ref.exr --json no/such/e.json")), 3));
  EXPECT_TRUE(refused(here.eikon(bench("--spp 1 --ref ref.exr --json ref.exr")), 2));
  EXPECT_TRUE(refused(here.eikon(bench("--spp 1 --time 0")), 2));
}

}  // namespace
}  // namespace eikon::test
