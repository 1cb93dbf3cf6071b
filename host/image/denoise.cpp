// SPDX-License-Identifier: Apache-2.0
#include "image/denoise.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"

namespace eikon {
namespace {

// Types and constants of the C API of Open Image Denoise 2.
using OidnDevice = void*;
using OidnFilter = void*;
constexpr int kDeviceCpu = 1, kFloat3 = 3, kNoError = 0;
constexpr const char* kUsualName = "libOpenImageDenoise.so.2";

/// Interleaves three channels, as the library needs them: R, G, B of a pixel side by side.
std::vector<float> interleaved(const Image& picture, std::span<const std::string_view, 3> names) {
  std::vector<float> values(std::size_t{3} * picture.width * picture.height);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float>* const plane = picture.plane(std::string(names[c]));
    if (plane == nullptr) throw InternalError(fmt::format("denoising needs the channel {}", names[c]));
    for (std::size_t i = 0; i < plane->size(); ++i) values[3 * i + c] = (*plane)[i];
  }
  return values;
}

}  // namespace

struct Denoiser::Library {
  void* handle = nullptr;
  OidnDevice device = nullptr;

  OidnDevice (*new_device)(int type) = nullptr;
  void (*set_device_int)(OidnDevice, const char* name, int value) = nullptr;
  void (*set_device_bool)(OidnDevice, const char* name, bool value) = nullptr;
  void (*commit_device)(OidnDevice) = nullptr;
  void (*release_device)(OidnDevice) = nullptr;
  int (*device_error)(OidnDevice, const char** message) = nullptr;
  OidnFilter (*new_filter)(OidnDevice, const char* type) = nullptr;
  void (*set_image)(OidnFilter, const char* name, void* data, int format, std::size_t width, std::size_t height,
                    std::size_t offset, std::size_t pixel_stride, std::size_t row_stride) = nullptr;
  void (*set_filter_bool)(OidnFilter, const char* name, bool value) = nullptr;
  void (*commit_filter)(OidnFilter) = nullptr;
  void (*execute)(OidnFilter) = nullptr;
  void (*release_filter)(OidnFilter) = nullptr;

  Library() {
    const char* const named = std::getenv("EIKON_OIDN");
    const std::string file = named != nullptr && *named != '\0' ? named : kUsualName;
    handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) {
      const char* const why = dlerror();
      throw InputError(
          fmt::format("--denoise: cannot load Open Image Denoise 2: {}; install it, or name its library "
                      "by EIKON_OIDN=.../{}",
                      why != nullptr ? why : file, kUsualName));
    }
    const auto find = [&](auto& function, const char* name) {
      function = reinterpret_cast<std::decay_t<decltype(function)>>(dlsym(handle, name));
      if (function == nullptr)
        throw InputError(fmt::format("--denoise: {} is not Open Image Denoise 2: it has no {}", file, name));
    };
    try {
      find(new_device, "oidnNewDevice");
      find(set_device_int, "oidnSetDeviceInt");
      find(set_device_bool, "oidnSetDeviceBool");
      find(commit_device, "oidnCommitDevice");
      find(release_device, "oidnReleaseDevice");
      find(device_error, "oidnGetDeviceError");
      find(new_filter, "oidnNewFilter");
      find(set_image, "oidnSetSharedFilterImage");
      find(set_filter_bool, "oidnSetFilterBool");
      find(commit_filter, "oidnCommitFilter");
      find(execute, "oidnExecuteFilter");
      find(release_filter, "oidnReleaseFilter");
    } catch (...) {
      dlclose(handle);
      throw;
    }
  }
  ~Library() {
    if (device != nullptr) release_device(device);
    // The library stays loaded because its threads may outlive its devices.
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  /// throws InputError with the library's message after an error
  void check(OidnDevice asked) const {
    const char* message = nullptr;
    if (device_error(asked, &message) != kNoError)
      throw InputError(fmt::format("--denoise: Open Image Denoise: {}", message != nullptr ? message : "it failed"));
  }
};

Denoiser::Denoiser(unsigned threads) : library_(std::make_unique<Library>()) {
  Library& oidn = *library_;
  oidn.device = oidn.new_device(kDeviceCpu);
  oidn.check(oidn.device);  // a null device returns the last error of the thread
  if (oidn.device == nullptr) throw InputError("--denoise: Open Image Denoise does not support this processor");
  oidn.set_device_bool(oidn.device, "setAffinity", false);
  if (threads > 0) oidn.set_device_int(oidn.device, "numThreads", static_cast<int>(threads));
  oidn.commit_device(oidn.device);
  oidn.check(oidn.device);
}

Denoiser::~Denoiser() = default;

std::string Denoiser::problem() {
  try {
    const Library found;
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

void Denoiser::denoise(Image& picture) const {
  const Library& oidn = *library_;
  constexpr std::array<std::string_view, 3> kColor{"R", "G", "B"};
  std::vector<float> color = interleaved(picture, kColor);
  std::vector<float> albedo = interleaved(picture, std::span(kAuxiliary).first<3>());
  std::vector<float> normal = interleaved(picture, std::span(kAuxiliary).last<3>());
  std::vector<float> output(color.size());
  struct Filter {
    const Library& oidn;
    OidnFilter filter;
    ~Filter() {
      if (filter != nullptr) oidn.release_filter(filter);
    }
  } const owned{oidn, oidn.new_filter(oidn.device, "RT")};
  oidn.check(oidn.device);
  const auto give = [&](const char* name, std::vector<float>& data) {
    oidn.set_image(owned.filter, name, data.data(), kFloat3, picture.width, picture.height, 0, 0, 0);
  };
  give("color", color);
  give("albedo", albedo);
  give("normal", normal);
  give("output", output);
  oidn.set_filter_bool(owned.filter, "hdr", true);
  oidn.commit_filter(owned.filter);
  oidn.execute(owned.filter);
  oidn.check(oidn.device);

  for (std::size_t c = 0; c < 3; ++c) {
    const auto at = std::ranges::find(picture.channels, kColor[c]) - picture.channels.begin();
    std::vector<float>& plane = picture.planes[static_cast<std::size_t>(at)];
    for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = output[3 * i + c];
  }
}

}  // namespace eikon
