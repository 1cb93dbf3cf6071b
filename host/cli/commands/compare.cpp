// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "io/atomic_file.h"
#include "job/file_identity.h"
#include "job/log.h"
#include "image/image.h"

namespace eikon {
namespace {

struct CompareOptions {
  std::string test, reference, png, json;
  double fail_above = -1;
};

ExitCode compare_command(const CompareOptions& options) {
  require_writable({options.png, options.json}, {.files = {options.test, options.reference}});
  const Image test = read_exr(options.test), reference = read_exr(options.reference);
  if (test.x0 != reference.x0 || test.y0 != reference.y0)
    print_to_stderr("eikon: the windows begin at {},{} and {},{} of their pictures, and are laid over each other\n",
                    test.x0, test.y0, reference.x0, reference.y0);
  const Comparison result = compare_images(test, reference);
  if (!options.png.empty()) write_png(options.png, difference_image(test, reference), 0);
  if (!options.json.empty()) {
    const nlohmann::json out = {{"mse", result.mse},
                                {"relmse", result.relmse},
                                {"mape", result.mape},
                                {"ratio_of_means", result.ratio_of_means},
                                {"nonfinite", result.nonfinite}};
    write_text(options.json, out.dump() + "\n");
  } else {
    fmt::print("MSE {:.6e}\nrelMSE {:.6e}\nMAPE {:.6e}\nratio of means {:.6f}\n", result.mse, result.relmse,
               result.mape, result.ratio_of_means);
    if (result.nonfinite > 0) fmt::print("{} values are not finite and were left out\n", result.nonfinite);
  }
  // Values that could not be compared are no success; nor is NaN below any bound.
  const bool within = result.relmse <= options.fail_above && result.nonfinite == 0;
  return options.fail_above >= 0 && !within ? ExitCode::not_as_asked : ExitCode::done;
}

}  // namespace

void add_compare(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<CompareOptions>();
  CommandFlags flags =
      root.command("compare", "measure how far an image is from a reference: MSE, relMSE, MAPE, ratio of means",
                   "tools/flip.py TEST REF computes FLIP, which predicts what an observer sees.\n\n"
                   "Example:\n  eikon compare test.exr reference.exr --png difference.png --fail-above 0.01");
  flags.text({"TEST", "", "OpenEXR image"}, options->test);
  flags.text({"REF", "", "OpenEXR image of the same size"}, options->reference);
  flags.group("Output (- is standard output)");
  flags.json(options->json, "print one line of JSON, or write it to FILE");
  flags.picture({"--png", "FILE", "write a picture of the difference"}, options->png, ".png");
  flags.number({"--fail-above", "RELMSE", "exit with code 1 when relMSE is larger"}, options->fail_above, 0, 1e30);
  flags.run(chosen, [options] { return compare_command(*options); });
}

}  // namespace eikon
