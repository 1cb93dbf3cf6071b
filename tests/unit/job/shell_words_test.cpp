// SPDX-License-Identifier: Apache-2.0
#include "job/batch/shell_words.h"

#include <gtest/gtest.h>

#include <random>

namespace eikon::test {
namespace {

using Words = std::vector<std::string>;

JobLine only(const std::string& text) {
  const std::vector<JobLine> jobs = split_jobs(text);
  EXPECT_EQ(jobs.size(), 1U) << text;
  return jobs.empty() ? JobLine{} : jobs.front();
}

TEST(ShellWords, words_are_those_of_a_shell) {
  const std::vector<std::pair<std::string, Words>> cases = {
      {"render a.gltf -o b.exr", {"render", "a.gltf", "-o", "b.exr"}},
      {"  a\t b  ", {"a", "b"}},
      {"'two words' \"and two\" more\\ words", {"two words", "and two", "more words"}},
      {"a'b'\"c\"d", {"abcd"}},
      {"'' \"\" x", {"", "", "x"}},
      {R"('$HOME *' "\$ \` \" \\ \n" \$ \* \')", {"$HOME *", "$ ` \" \\ \\n", "$", "*", "'"}},
      {"a#b '#' \\# # the rest $x", {"a#b", "#", "#"}},
      {"a~b --look-at 0,1,2:3,4,5", {"a~b", "--look-at", "0,1,2:3,4,5"}},
      {"stra\xc3\x9f"
       "e\\\xe2\x82\xac",
       {"stra\xc3\x9f"
        "e\xe2\x82\xac"}},
      {"a\\\nb c\\\n d", {"ab", "c", "d"}},
      {"\"a\\\nb\"", {"ab"}},
  };
  for (const auto& [text, words] : cases) {
    const JobLine job = only(text);
    EXPECT_EQ(job.error, "") << text;
    EXPECT_EQ(job.words, words) << text;
  }
}

TEST(ShellWords, lines_are_counted_and_empty_ones_and_comments_are_none) {
  const std::vector<JobLine> jobs = split_jobs("\xef\xbb\xbf# first\n\n  \na\r\n\tb # c\r\n'c'\\\nd\n\nlast");
  ASSERT_EQ(jobs.size(), 4U);
  EXPECT_EQ(jobs[0].line, 4U);
  EXPECT_EQ(jobs[0].words, Words{"a"});
  EXPECT_EQ(jobs[1].line, 5U);
  EXPECT_EQ(jobs[1].words, Words{"b"});
  EXPECT_EQ(jobs[2].line, 6U);
  EXPECT_EQ(jobs[2].words, Words{"cd"});
  EXPECT_EQ(jobs[3].line, 9U);
  EXPECT_TRUE(split_jobs("").empty());
  EXPECT_TRUE(split_jobs("#").empty());
}

TEST(ShellWords, an_error_is_its_line_s_alone) {
  for (const std::string bad : {"a 'b", "a \"b", "a $b", "a \"$b\"", "a `b`", "a*", "a?", "[ab]", "~/a", "a > b",
                                "a | b", "a; b", "a & b", "(a)", "a < b"}) {
    const std::vector<JobLine> jobs = split_jobs("before\n" + bad + "\nafter 'x'\n");
    ASSERT_EQ(jobs.size(), 3U) << bad;
    EXPECT_EQ(jobs[0].words, Words{"before"});
    EXPECT_EQ(jobs[1].line, 2U);
    EXPECT_FALSE(jobs[1].error.empty()) << bad;
    EXPECT_TRUE(jobs[1].words.empty()) << bad;
    EXPECT_EQ(jobs[2].line, 3U);
    EXPECT_EQ(jobs[2].words, (Words{"after", "x"})) << bad;
  }
  EXPECT_FALSE(only("a\\").error.empty());
  EXPECT_FALSE(only(std::string("a\0b", 3)).error.empty());
}

TEST(ShellWords, what_is_quoted_is_read_again) {
  std::mt19937 random(1);
  const std::string letters = "ab '\"\\$`*?[]~|&;<>()#\t-=\xc3\xa4";
  for (int i = 0; i < 2000; ++i) {
    Words words(1 + random() % 4);
    for (std::string& word : words)
      for (std::size_t n = random() % 6; n > 0; --n) word += letters[random() % letters.size()];
    const JobLine job = only(quote(words));
    EXPECT_EQ(job.error, "") << quote(words);
    EXPECT_EQ(job.words, words) << quote(words);
  }
}

TEST(ShellWords, any_text_gives_words_or_errors) {
  std::mt19937 random(2);
  const std::string letters = std::string("a '\"\\#\n\r\t$*;", 13) + '\0' + '\xff';
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (std::size_t n = random() % 40; n > 0; --n) text += letters[random() % letters.size()];
    const auto lines = std::size_t(std::count(text.begin(), text.end(), '\n')) + 1;
    std::size_t last = 0;
    for (const JobLine& job : split_jobs(text)) {
      EXPECT_NE(job.words.empty(), job.error.empty());
      EXPECT_GT(job.line, last);
      EXPECT_LE(job.line, lines);
      last = job.line;
    }
  }
}

}  // namespace
}  // namespace eikon::test
