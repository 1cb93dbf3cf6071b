// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <stdexcept>
#include <string>

namespace eikon {

/// Process exit codes; only host/cli returns them.
enum class ExitCode {
  done = 0,
  not_as_asked = 1,
  usage = 2,
  input = 3,
  device = 4,
  internal = 5,
  interrupted = 130,
  terminated = 143
};

/// An error of input, files or devices. what() is one line: what failed, on what, why, what to try.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

struct UsageError : Error {
  explicit UsageError(const std::string& message) : Error(ExitCode::usage, message) {}
};
struct InputError : Error {
  explicit InputError(const std::string& message) : Error(ExitCode::input, message) {}
};
struct DeviceError : Error {
  explicit DeviceError(const std::string& message) : Error(ExitCode::device, message) {}
};
/// A broken invariant of eikon itself.
struct InternalError : Error {
  explicit InternalError(const std::string& message) : Error(ExitCode::internal, message) {}
};

}  // namespace eikon
