// SPDX-License-Identifier: Apache-2.0
// The errors of eikon by whose fault they are, and the exit codes of the process.
#pragma once
#include <stdexcept>
#include <string>

namespace eikon {

/// Process exit codes; only host/cli returns them.
enum class ExitCode {
  done = 0,
  not_as_asked = 1,   // done, but not as asked: --fail-above, --strict, failed jobs of a batch
  usage = 2,          // UsageError
  input = 3,          // InputError
  device = 4,         // DeviceError
  internal = 5,       // InternalError, or any other exception
  interrupted = 130,  // by SIGINT
  terminated = 143    // by SIGTERM
};

/// An error of input, files or devices. what() is one line: what failed, on what, why, what to try.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// Words of a command line, or an environment variable, that cannot be followed.
struct UsageError : Error {
  explicit UsageError(const std::string& message) : Error(ExitCode::usage, message) {}
};
/// A file that is wrong, damaged or too large, or that cannot be read or written.
struct InputError : Error {
  explicit InputError(const std::string& message) : Error(ExitCode::input, message) {}
};
/// No device can be used, or one has failed; a render goes on with the others.
struct DeviceError : Error {
  explicit DeviceError(const std::string& message) : Error(ExitCode::device, message) {}
};
/// A broken invariant of eikon itself.
struct InternalError : Error {
  explicit InternalError(const std::string& message) : Error(ExitCode::internal, message) {}
};

}  // namespace eikon
