// SPDX-License-Identifier: Apache-2.0
// Parts of pages: escaping, pictures that can be exposed anew, and timelines.
#include "page/page.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/text.h"
#include "page/page_picture.h"
#include "page/timeline.h"
#include "support/messages.h"

namespace eikon {
namespace {

using test::contains;

TEST(Page, text_is_shown_as_it_is) {
  EXPECT_EQ(html_text(R"(<script>"a" & 'b'</script>)"), "&lt;script&gt;&quot;a&quot; &amp; &#39;b&#39;&lt;/script&gt;");
}

TEST(Page, no_text_of_the_data_ends_its_element) {
  const Json data = {{"</script><!--", "<script>\xff"}};
  const std::string text = script_json(data);
  EXPECT_FALSE(contains(text, "<"));
  EXPECT_EQ(Json::parse(text).at("</script><!--"), "<script>\xEF\xBF\xBD");  // what is no UTF-8 is replaced
}

TEST(Page, unknown_page_files_are_an_error_of_the_program) {
  EXPECT_THROW((void)make_page("no such.html", {.title = "", .styles = {}, .scripts = {}, .data = Json()}),
               InternalError);
}

TEST(PagePicture, mantissas_and_exponent_give_the_value_back_to_one_part_in_256) {
  for (const float most : {1e-30F, 1e-5F, 0.2F, 1.0F, 1.5F, 77.0F, 1e6F, 1e30F}) {
    std::vector<unsigned char> bytes;
    append_rgbe(bytes, {most, 0.5F * most, 0.03F * most});
    ASSERT_EQ(bytes.size(), 4U);
    const float wanted[3] = {most, 0.5F * most, 0.03F * most};
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(std::ldexp((bytes[c] + 0.5) / 256, bytes[3] - 128), double(wanted[c]), double(most) / 256) << most;
  }
}

TEST(PagePicture, negative_and_non_finite_values_are_black) {
  std::vector<unsigned char> bytes;
  append_rgbe(bytes, {-1.0F, NAN, 0.0F});
  append_rgbe(bytes, {INFINITY, 0.0F, 1.0F});
  EXPECT_EQ(std::vector(bytes.begin(), bytes.begin() + 4), std::vector<unsigned char>(4, 0));
  EXPECT_EQ(bytes[4], 0);
  EXPECT_EQ(bytes[6], 128);  // 1 is 0.5 * 2^1
}

Image grey(std::uint32_t width, std::uint32_t height, float value, float variance) {
  Image image{.width = width, .height = height, .channels = {}, .planes = {}, .metadata = {}};
  for (const char* name : kRgb) {
    image.channels.emplace_back(name);
    image.planes.emplace_back(std::size_t{width} * height, value);
    image.channels.push_back(std::string("variance.") + name);
    image.planes.emplace_back(std::size_t{width} * height, variance);
  }
  return image;
}

TEST(PagePicture, large_pictures_are_averaged_over_blocks) {
  const Json picture = page_picture(grey(3 * kMaxPageSide - 1, 5, 1, 0));
  EXPECT_EQ(picture.at("width"), kMaxPageSide);
  EXPECT_EQ(picture.at("height"), 2);
  EXPECT_EQ(picture.at("reduced"), 3);
}

TEST(PagePicture, the_error_map_is_there_where_the_variance_is_known) {
  EXPECT_TRUE(page_picture(grey(2, 2, 1, NAN)).at("error").is_null());
  Image bare = grey(2, 2, 1, 0);
  for (std::string& channel : bare.channels)
    if (channel.starts_with("variance")) channel = "other";
  EXPECT_TRUE(page_picture(bare).at("error").is_null());
  EXPECT_TRUE(page_picture(grey(2, 2, 1, 0)).at("error").is_string());
}

TEST(PagePicture, images_without_colour_are_refused) {
  const Image depth{.width = 1, .height = 1, .channels = {"Z"}, .planes = {{1}}, .metadata = {}};
  EXPECT_THROW((void)page_picture(depth), InputError);
}

Json span(double ts, double dur, const char* name) {
  return {{"ph", "X"}, {"pid", 1}, {"tid", 0}, {"name", name}, {"ts", ts}, {"dur", dur}};
}

TEST(PageTimeline, spans_within_others_stand_in_rows_below_them) {
  const Json timeline = page_timeline({span(1e6, 4e6, "render"), span(1e6, 1e6, "unit"), span(2e6, 1e6, "unit")});
  EXPECT_EQ(timeline.at("end_s"), 4);
  const Json& rows = timeline.at("tracks").at(0).at("rows");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0], Json({{0, 4, 0}}));
  EXPECT_EQ(rows[1], Json({{0, 1, 1}, {1, 2, 1}}));
}

TEST(PageTimeline, spans_that_are_too_short_are_joined_under_the_longest) {
  Json events = {span(0, 1e6, "whole")};
  for (int i = 0; i < 100'000; ++i) events.push_back(span(10.0 * i, i % 2 == 0 ? 3 : 6, i % 2 == 0 ? "short" : "long"));
  const Json timeline = page_timeline(events);
  const Json& row = timeline.at("tracks").at(0).at("rows").at(1);
  EXPECT_LT(row.size(), 2000U);
  EXPECT_GT(row.size(), 500U);
  for (const Json& joined : row) EXPECT_EQ(timeline.at("names").at(joined.at(2).get<std::size_t>()), "long");
}

TEST(PageTimeline, counters_are_thinned_and_keep_their_last_value) {
  Json events = Json::array();
  for (int i = 0; i < 5000; ++i)
    events.push_back({{"ph", "C"}, {"name", "error"}, {"ts", i}, {"args", {{"value", 5000 - i}}}});
  const Json points = page_timeline(events).at("counters").at("error");
  EXPECT_LE(points.size(), 402U);
  EXPECT_EQ(points.front(), Json({0.0, 5000}));
  EXPECT_EQ(points.back().at(1), 1);
}

TEST(PageTimeline, what_is_no_trace_is_refused) {
  for (const Json& wrong : {Json(nullptr), Json::array(), Json({1}), Json({{{"ph", "X"}}}),
                            Json({{{"ph", "X"}, {"name", "a"}, {"ts", "b"}}}), Json({{{"ph", 3}, {"name", "a"}}})})
    EXPECT_THROW((void)page_timeline(wrong), InputError) << wrong;
}

TEST(Text, base64_is_that_of_the_standard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string_view("\xff\xff\xff", 3)), "////");
}

}  // namespace
}  // namespace eikon
