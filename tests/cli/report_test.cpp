// SPDX-License-Identifier: Apache-2.0
// Pages about renders: --report of a render and of a batch, and `eikon report`.
#include "cli/command.h"

#include <nlohmann/json.hpp>

#include "support/gltf_builder.h"

namespace eikon::test {
namespace {

using nlohmann::json;

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

/// The data of a page that is whole, and needs nothing but itself.
json data_of(const std::string& page) {
  EXPECT_TRUE(page.starts_with("<!doctype html>"));
  EXPECT_TRUE(page.ends_with("</html>\n"));
  // The elements of the page itself, and no others.
  EXPECT_EQ(count_of(page, "<script"), 2U);
  EXPECT_EQ(count_of(page, "</script"), 2U);
  EXPECT_TRUE(contains(page, "default-src 'none'"));
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const std::size_t begin = page.find(open) + open.size(), end = page.find("</script", begin);
  const std::string around = page.substr(0, begin) + page.substr(end);
  for (const char* outside : {"src=", "href=", "@import", "url(", "https://", "fetch(", "XMLHttpRequest"})
    EXPECT_FALSE(contains(around, outside)) << outside;
  EXPECT_EQ(count_of(around, "http://"), count_of(around, "http://www.w3.org/2000/svg"));  // the name of SVG
  return json::parse(page.substr(begin, end - begin));
}

TEST(Report, a_page_of_a_render_has_picture_error_time_and_facts) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(
      cornell("--size 40x30 --spp 16 --quiet --stats stats.json --report page.html --exposure 1.5 --tonemap agx"))));
  const json data = data_of(read_bytes(here / "page.html"));
  EXPECT_EQ(data.at("kind"), "render");
  EXPECT_EQ(data.at("stats"), read_json(here / "stats.json"));
  EXPECT_EQ(data.at("picture").at("width"), 40);
  EXPECT_TRUE(data.at("picture").at("rgbe").get<std::string>().starts_with("data:image/png;base64,iVBOR"));
  EXPECT_TRUE(data.at("picture").at("error").get<std::string>().starts_with("data:image/png;base64,iVBOR"));
  EXPECT_EQ(data.at("display"), json({{"exposure", 1.5}, {"tone", "agx"}}));
  for (const char* counter : {"predicted relMSE", "predicted relMSE, low", "predicted relMSE, high"})
    EXPECT_GE(data.at("timeline").at("counters").at(counter).size(), 1U) << counter;
  EXPECT_TRUE(contains(data.at("stats").at("command"), "--spp=16"));
  const auto& features = data.at("stats").at("ledger");
  EXPECT_TRUE(std::any_of(features.begin(), features.end(),
                          [](const json& entry) { return entry.at("name") == "area" && entry.at("on") == true; }));
}

TEST(Report, a_page_is_not_what_changes_the_picture) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 20x16 --spp 8 --quiet --png a.png"))));
  ASSERT_TRUE(succeeded(here.eikon(cornell("--size 20x16 --spp 8 --quiet --png b.png --report page.html"))));
  EXPECT_EQ(read_bytes(here / "a.png"), read_bytes(here / "b.png"));
}

TEST(Report, names_that_are_markup_stay_text) {
  const Workplace here;
  const std::string evil = "</script><script>alert(1)</script><img src=x onerror=alert(2)>";
  scene_test::Builder builder;
  for (const char* kind : {"materials", "nodes", "meshes"})
    for (json& one : builder.json[kind]) one["name"] = evil;
  here.write("a<script>b&c'.glb", builder.glb_bytes());
  ASSERT_TRUE(succeeded(here.eikon(
      "render 'a<script>b&c'\\''.glb' -o out.exr --size 8x8 --spp 2 --quiet --report page.html --aov object_id")));
  const std::string page = read_bytes(here / "page.html");
  const json data = data_of(page);
  EXPECT_FALSE(contains(page, "<img"));
  EXPECT_TRUE(contains(page, "<title>a&lt;script&gt;b&amp;c&#39;.glb - eikon report</title>"));
  EXPECT_TRUE(contains(data.dump(), "<script>alert(1)"));  // the name is there, as text
}

TEST(Report, a_page_is_made_afterwards_of_the_files) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon(
      cornell("--size 24x16 --spp 8 --quiet --stats s.json --profile p.json --aov variance --report a.html"))));
  ASSERT_TRUE(succeeded(here.eikon("report s.json --profile p.json --image out.exr -o b.html")));
  const json at_once = data_of(read_bytes(here / "a.html")), later = data_of(read_bytes(here / "b.html"));
  for (const char* part : {"stats", "picture", "timeline"}) EXPECT_EQ(at_once.at(part), later.at(part)) << part;
  ASSERT_TRUE(succeeded(here.eikon("report s.json -o c.html")));
  const json bare = data_of(read_bytes(here / "c.html"));
  EXPECT_EQ(bare.at("stats"), at_once.at("stats"));
  EXPECT_TRUE(bare.at("picture").is_null());
  EXPECT_TRUE(bare.at("timeline").is_null());
}

TEST(Report, a_page_of_a_batch_has_a_row_for_each_job) {
  const Workplace here;
  here.write("jobs.txt", "render " + scene("cornell.gltf") + " -o a.exr --size 8x6 --spp 2\n" +
                             "render missing.gltf -o b.exr\nrender --nonsense\n");
  EXPECT_EQ(here.eikon("batch jobs.txt --quiet --report page.html").code, 1);
  const json batch = data_of(read_bytes(here / "page.html")).at("batch");
  ASSERT_EQ(batch.at("jobs").size(), 3U);
  EXPECT_EQ(batch.at("jobs")[0].at("state"), "done");
  EXPECT_EQ(batch.at("jobs")[0].at("samples"), 8 * 6 * 2);
  EXPECT_GT(batch.at("jobs")[0].at("relmse").get<double>(), 0);
  EXPECT_EQ(batch.at("jobs")[1].at("state"), "failed");
  EXPECT_TRUE(contains(batch.at("jobs")[1].at("message"), "missing.gltf"));
  EXPECT_TRUE(batch.at("jobs")[2].at("output").is_null());
  EXPECT_TRUE(contains(batch.at("command"), "eikon batch jobs.txt"));
}

TEST(Report, each_frame_of_a_sequence_has_its_page) {
  const Workplace here;
  ASSERT_TRUE(succeeded(here.eikon("render " + scene("bending_arm.gltf") +
                                   " -o f_%d.exr --report f_%d.html --frames 0:1 --size 8x6 --spp 2 --quiet")));
  EXPECT_NE(data_of(read_bytes(here / "f_0.html")), data_of(read_bytes(here / "f_1.html")));
  EXPECT_TRUE(refused(here.eikon("render " + scene("bending_arm.gltf") +
                                 " -o f_%d.exr --report f.html --frames 0:1 --size 8x6 --spp 2 --quiet"),
                      kUsage));
}

TEST(Report, what_cannot_be_written_is_refused_before_the_render) {
  const Workplace here;
  EXPECT_TRUE(refused(here.eikon(cornell("--size 8x6 --spp 2 --quiet --report no/page.html")), kInput));
  EXPECT_TRUE(refused(here.eikon(cornell("--size 8x6 --spp 2 --quiet --report out.exr")), kUsage));
  EXPECT_TRUE(here.files().empty());
  here.write("jobs.txt", "render " + scene("cornell.gltf") + " -o a.exr --size 8x6 --spp 2\n");
  EXPECT_TRUE(refused(here.eikon("batch jobs.txt --report a.exr"), kUsage));
  EXPECT_TRUE(refused(here.eikon("batch jobs.txt --report jobs.txt"), kUsage));
  EXPECT_EQ(here.files(), std::vector<std::string>{"jobs.txt"});
}

TEST(Report, files_of_another_kind_are_refused_in_a_line) {
  const Workplace here;
  here.write("text", "no JSON");
  here.write("other.json", "{\"schema_version\": 1}");
  here.write("empty.json", "{}");
  here.write("good.json", "{\"schema_version\": 2}");
  here.write("trace.json", "{\"traceEvents\": [{\"ph\": \"X\", \"name\": \"a\", \"ts\": \"now\"}]}");
  for (const char* wrong : {"missing.json", "text", "other.json", "empty.json", "good.json --profile empty.json",
                            "good.json --profile trace.json", "good.json --image text"})
    EXPECT_TRUE(refused(here.eikon(std::string("report ") + wrong + " -o page.html"), kInput)) << wrong;
  EXPECT_TRUE(refused(here.eikon("report good.json -o good.json"), kUsage));
  EXPECT_TRUE(refused(here.eikon("report good.json --profile trace.json -o trace.json"), kUsage));
  EXPECT_TRUE(refused(here.eikon("report good.json"), kUsage));
  EXPECT_FALSE(std::filesystem::exists(here / "page.html"));
  EXPECT_TRUE(succeeded(here.eikon("report good.json -o page.html")));  // a page of what is there
}

}  // namespace
}  // namespace eikon::test
