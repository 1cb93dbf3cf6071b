// SPDX-License-Identifier: Apache-2.0
// JSON text: long values come through as they are, and whole numbers are integers.
#include "io/json_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.h"

namespace {

using eikon::Json;
using eikon::parse_json;

std::string long_text(char letter) { return "data:;base64," + std::string(100000, letter); }

TEST(JsonText, long_values_are_kept_wherever_they_stand) {
  const Json document = {{"buffers", {{{"uri", long_text('A')}, {"byteLength", 3}}, {{"uri", long_text('B')}}}},
                         {"extras", {long_text('A'), long_text('\n'), long_text('"'), {{"deep", long_text('C')}}}},
                         {long_text('D'), long_text('E')},
                         {"after", 1}};
  for (const int indent : {-1, 2}) EXPECT_EQ(parse_json(document.dump(indent)), document);
}

TEST(JsonText, text_after_a_long_value_is_still_checked) {
  const std::string good = Json({{"a", long_text('A')}, {"b", 1}}).dump();
  EXPECT_THROW(parse_json(good.substr(0, good.size() - 1)), eikon::InputError);
  EXPECT_THROW(parse_json(good + "x"), eikon::InputError);
  EXPECT_THROW(parse_json(good.substr(0, 5000)), eikon::InputError);
  std::string control = good;
  control[1000] = '\x01';
  EXPECT_THROW(parse_json(control), eikon::InputError);
  std::string no_utf8 = good;
  no_utf8[1000] = '\xFF';
  EXPECT_THROW(parse_json(no_utf8), eikon::InputError);
}

TEST(JsonText, whole_numbers_are_integers_and_others_stay) {
  const Json read =
      parse_json(R"({"a": [1.0, 1e3, 7.2e1, 0.0, 9007199254740992.0], "b": [0.5, -1.0, -0.0, 1e300, 1e17]})");
  for (const Json& number : read["a"]) EXPECT_TRUE(number.is_number_unsigned()) << number;
  EXPECT_EQ(read["a"], Json({1, 1000, 72, 0, 9007199254740992}));
  for (const Json& number : read["b"]) EXPECT_TRUE(number.is_number_float()) << number;
  EXPECT_TRUE(std::signbit(read["b"][2].get<double>()));
}

}  // namespace
