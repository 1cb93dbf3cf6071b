// SPDX-License-Identifier: Apache-2.0
// Reads the messages of errors, so that a test can say in one line what it expects of them.
#pragma once
#include <gtest/gtest.h>

#include <string>

#include "core/error.h"

namespace eikon::test {

/// True if `part` stands somewhere in `text`; a failure shows both.
inline ::testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return ::testing::AssertionSuccess() << "'" << part << "' is in: " << text;
  return ::testing::AssertionFailure() << "'" << part << "' is not in: " << text;
}

/// The message of the error of type `Wanted` that `action` throws, or "" if it throws nothing. An
/// error of another type passes through and so fails the test, and so does a message that is empty
/// or has several lines.
template <typename Wanted = InputError, typename Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Wanted& error) {
    const std::string message = error.what();
    EXPECT_FALSE(message.empty());
    EXPECT_FALSE(contains(message, "\n"));
    return message;
  }
  return "";
}

/// As error_of(), but for an action that must throw: the test fails if it does not.
template <typename Wanted = InputError, typename Action>
std::string message_of(const Action& action) {
  const std::string message = error_of<Wanted>(action);
  if (message.empty()) ADD_FAILURE() << "nothing was thrown";
  return message;
}

}  // namespace eikon::test
