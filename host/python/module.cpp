// SPDX-License-Identifier: Apache-2.0
// The module eikon._eikon: what the package in eikon/ calls. Words are those of the command line,
// so a render from Python is that of `eikon render` with the same words.
#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/commands.h"
#include "cli/commands/meter.h"
#include "cli/flags.h"
#include "core/error.h"
#include "device/device.h"
#include "image/image.h"
#include "job/render_job.h"
#include "python/interruptible.h"

namespace nb = nanobind;

namespace eikon::python {
namespace {

using Plane = nb::ndarray<const float, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

/// Words of the program, as bytes: names of files may hold any.
std::vector<std::string> strings_of(const std::vector<nb::bytes>& words) {
  std::vector<std::string> strings;
  for (const nb::bytes& word : words) strings.emplace_back(word.c_str(), word.size());
  return strings;
}

/// Text for Python. Bytes that are not UTF-8, which names of files may have, are escaped, as the
/// program prints them.
nb::str text_of(std::string_view text) {
  return nb::steal<nb::str>(PyUnicode_DecodeUTF8(text.data(), Py_ssize_t(text.size()), "backslashreplace"));
}

nb::list texts_of(const std::vector<std::string>& lines) {
  nb::list list;
  for (const std::string& line : lines) list.append(text_of(line));
  return list;
}

/// Lines for the user, which any thread may add.
class Notes {
 public:
  [[nodiscard]] Log log() {
    return [this](const std::string& line) {
      const std::lock_guard lock(mutex_);
      lines_.push_back(line);
    };
  }
  [[nodiscard]] std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::move(lines_);
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

/// Calls Python with the progress of a render, which ends if that returns False or raises.
class ProgressCall {
 public:
  ProgressCall(nb::object callback, std::atomic<bool>& stop) : callback_(std::move(callback)), stop_(stop) {}

  void operator()(const Progress& now) {
    const nb::gil_scoped_acquire acquired;
    if (raised_ != nullptr) return;
    try {
      if (callback_(now.share, now.samples, now.samples_per_second, now.seconds, now.left_s).is(nb::bool_(false)))
        stop_ = true;
    } catch (...) {
      raised_ = std::current_exception();
      stop_ = true;
    }
  }
  void rethrow() const {
    if (raised_ != nullptr) std::rethrow_exception(raised_);
  }

 private:
  nb::object callback_;
  std::atomic<bool>& stop_;
  std::exception_ptr raised_;
};

/// Renders what the words after `eikon render` say, and writes its files. Returns the exit code,
/// notes for the user, and whether there is a picture: nothing is written before the first sample.
std::tuple<int, nb::list, bool> render_words(const std::vector<nb::bytes>& words, const nb::object& progress) {
  RenderOptions options = parse_render(strings_of(words));
  if (options.frames || options.is_replay())
    throw UsageError(
        "render: renders one image at a time; call it for each frame, and trace paths with `eikon render`");
  options.quiet = false;
  Notes notes;
  ExitCode code{};
  bool has_picture = false;
  std::unique_ptr<ProgressCall> call;
  run_interruptible([&](std::atomic<bool>& stop) {
    RenderJob job(options, notes.log());
    job.load();
    RenderHooks hooks;
    if (!progress.is_none()) {
      const nb::gil_scoped_acquire acquired;
      call = std::make_unique<ProgressCall>(progress, stop);
      hooks.progress = [&](const Progress& now, const Film&) { (*call)(now); };
    }
    job.render(stop, std::move(hooks));
    job.write();
    code = job.code();
    has_picture = job.has_samples();
  });
  if (call != nullptr) call->rethrow();
  return {int(code), texts_of(notes.take()), has_picture};
}

/// Measures what the words after `eikon meter` say. Returns JSON and notes for the user.
std::pair<nb::str, nb::list> meter_words(const std::vector<nb::bytes>& words) {
  Notes notes;
  std::string text;
  run_interruptible([&](std::atomic<bool>& stop) {
    if (auto json = meter_json(strings_of(words), notes.log(), stop)) text = std::move(*json);
  });
  return {text_of(text), texts_of(notes.take())};
}

/// Merges what the words after `eikon merge` say. Returns the exit code.
int merge_words(const std::vector<nb::bytes>& given) {
  std::vector<std::string> words = strings_of(given);
  words.insert(words.begin(), "merge");
  Command chosen;
  (void)parse_words(words, [&](CommandFlags root) { add_merge(root, chosen); });
  ExitCode code{};
  run_interruptible([&](std::atomic<bool>&) { code = chosen(); });
  return int(code);
}

/// The keywords of a command that take a value, which True is not: its flag alone would take the
/// next word for it.
nb::list valued_keywords(const std::string& command) {
  nb::list keywords;
  for (const CommandHelp& known : describe_commands().commands)
    for (const FlagHelp& flag : known.flags) {
      const bool may_be_alone = !flag.takes_value || flag.placeholder.starts_with("[=");
      if (last_word(known) != command || may_be_alone || flag.is_positional()) continue;
      std::string keyword = flag.names.back().substr(flag.names.back().find_first_not_of('-'));
      std::ranges::replace(keyword, '-', '_');
      keywords.append(keyword.c_str());
    }
  return keywords;
}

/// The planes of a picture, by channel, as arrays of shape (height, width).
nb::dict read_planes(const nb::bytes& path) {
  auto image = std::make_unique<Image>();
  {
    const std::string file(path.c_str(), path.size());
    const nb::gil_scoped_release released;
    *image = read_exr(file);
  }
  nb::dict planes;
  for (std::size_t i = 0; i < image->channels.size(); ++i) {
    auto plane = std::make_unique<std::vector<float>>(std::move(image->planes[i]));
    const nb::capsule owner(plane.get(), [](void* data) noexcept { delete static_cast<std::vector<float>*>(data); });
    planes[image->channels[i].c_str()] =
        nb::ndarray<nb::numpy, float, nb::ndim<2>>(plane.release()->data(), {image->height, image->width}, owner);
  }
  nb::dict result;
  result["planes"] = planes;
  nb::dict metadata;
  for (const auto& [key, value] : image->metadata) metadata[text_of(key)] = text_of(value);
  result["metadata"] = metadata;
  return result;
}

/// A picture of planes of the same size.
Image image_of(const std::vector<std::pair<std::string, Plane>>& planes) {
  Image image;
  for (const auto& [channel, plane] : planes) {
    const auto height = static_cast<std::uint32_t>(plane.shape(0)), width = static_cast<std::uint32_t>(plane.shape(1));
    if (!image.planes.empty() && (image.height != height || image.width != width))
      throw InputError("the channels of a picture have the same size");
    image.height = height;
    image.width = width;
    image.channels.push_back(channel);
    image.planes.emplace_back(plane.data(), plane.data() + plane.size());
  }
  return image;
}

std::vector<std::pair<std::string, Plane>> listed(const nb::dict& planes) {
  std::vector<std::pair<std::string, Plane>> list;
  for (const auto [name, plane] : planes) list.emplace_back(nb::cast<std::string>(name), nb::cast<Plane>(plane));
  return list;
}

nb::dict compare_planes(const nb::dict& test, const nb::dict& reference) {
  const Comparison result = compare_images(image_of(listed(test)), image_of(listed(reference)));
  nb::dict numbers;
  numbers["mse"] = result.mse;
  numbers["relmse"] = result.relmse;
  numbers["mape"] = result.mape;
  numbers["ratio_of_means"] = result.ratio_of_means;
  numbers["nonfinite"] = result.nonfinite;
  return numbers;
}

void write_png_of(const nb::bytes& path, const nb::dict& planes, double exposure_ev, std::optional<double> ev100,
                  const std::string& tonemap) {
  const auto map = tone_map_of(tonemap);
  if (!map) refuse_choice("tonemap", tonemap, tone_map_names());
  const auto require = [](const char* name, double value, double most) {  // false for NaN
    if (!(std::abs(value) <= most))
      throw UsageError(fmt::format("{}: {} is not from {} to {}", name, value, -most, most));
  };
  require("exposure", exposure_ev, PngOptions::kMaxExposureEv);
  if (ev100) require("ev100", *ev100, PngOptions::kMaxEv100);
  PngOptions{.file = {path.c_str(), path.size()}, .exposure_ev = exposure_ev, .ev100 = ev100, .tone_map = *map}.write(
      image_of(listed(planes)));
}

nb::list devices() {
  require_own_process();
  nb::list list;
  for (const DeviceInfo& info : list_devices()) {
    nb::dict device;
    device["index"] = info.index;
    device["name"] = info.name;
    device["vendor"] = info.vendor;
    device["platform"] = info.platform;
    device["driver"] = info.driver;
    device["kind"] = info.gpu ? "gpu" : info.cpu ? "cpu" : "accelerator";
    device["compute_units"] = info.compute_units;
    device["memory_bytes"] = info.memory_bytes;
    device["unusable"] = info.unusable;
    list.append(device);
  }
  return list;
}

/// Kinds of exceptions, by exit code; others are eikon.Error.
std::map<ExitCode, PyObject*>& exception_kinds() {
  static std::map<ExitCode, PyObject*> kinds;
  return kinds;
}

/// Raises an error of the program in Python. That of nanobind would fail for names of files that
/// are not UTF-8.
void raise_in_python(const std::exception_ptr& thrown, void* base) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    const auto kind = exception_kinds().find(error.code());
    PyErr_SetObject(kind == exception_kinds().end() ? static_cast<PyObject*>(base) : kind->second,
                    text_of(error.what()).ptr());
  }
}

nb::object add_exception(nb::module_& module, const char* name, nb::handle base, const char* about, ExitCode code) {
  nb::object type =
      nb::steal(PyErr_NewExceptionWithDoc(fmt::format("eikon.{}", name).c_str(), about, base.ptr(), nullptr));
  type.attr("code") = int(code);
  module.attr(name) = type;
  return type;
}

void add_exceptions(nb::module_& module) {
  const nb::object base =
      add_exception(module, "Error", PyExc_Exception,
                    "What eikon refuses or fails at; `code` is the exit code of the program.", ExitCode::internal);
  const auto add = [&](const char* name, const char* about, ExitCode code) {
    exception_kinds()[code] = add_exception(module, name, base, about, code).release().ptr();
  };
  add("UsageError", "A wrong argument.", ExitCode::usage);
  add("InputError", "A wrong or damaged input, or a file that cannot be written.", ExitCode::input);
  add("DeviceError", "No device, or none left.", ExitCode::device);
  add("InternalError", "A broken invariant of eikon.", ExitCode::internal);
  nb::register_exception_translator(raise_in_python, base.ptr());
}

}  // namespace
}  // namespace eikon::python

NB_MODULE(_eikon, module) {
  using namespace eikon::python;
  module.attr("version") = EIKON_VERSION;
  add_exceptions(module);
  module.def("render", &render_words, nb::arg("words"), nb::arg("progress").none());
  module.def("meter", &meter_words, nb::arg("words"));
  module.def("merge", &merge_words, nb::arg("words"));
  module.def("valued_keywords", &valued_keywords, nb::arg("command"));
  module.def("read_exr", &read_planes, nb::arg("path"));
  module.def("compare", &compare_planes, nb::arg("test"), nb::arg("reference"));
  module.def("write_png", &write_png_of, nb::arg("path"), nb::arg("planes"), nb::arg("exposure"),
             nb::arg("ev100").none(), nb::arg("tonemap"));
  module.def("devices", &devices);
}
