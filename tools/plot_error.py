#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws what `eikon bench scene --json` measured: error against seconds, and against samples per pixel.

  tools/plot_error.py MEASURED.json... -o ERROR.svg        (or .png, .pdf)

Needs matplotlib.
"""
import argparse
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "versus"))
import modules  # noqa: E402

modules.need(["matplotlib"], "eikon-versus", "matplotlib")

import matplotlib  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("measured", type=pathlib.Path, nargs="+")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    options = parser.parse_args()
    figure, (by_time, by_spp) = plt.subplots(1, 2, figsize=(10, 4.2), sharey=True, layout="constrained")
    for path in options.measured:
        run = json.loads(path.read_text())
        error = "relmse_predicted" if run["reference"] is None else "relmse"
        points = [point for point in run["points"] if point[error]]
        errors = [point[error] for point in points]
        by_time.loglog([point["seconds"] for point in points], errors, "o-", label=f"{path.stem}: rendering alone")
        by_time.loglog([point["seconds_from_start"] for point in points], errors, "o--",
                       label=f"{path.stem}: from process start")
        by_spp.loglog([point["spp"] for point in points], errors, "o-", label=path.stem)
        by_time.set_ylabel("relMSE" if error == "relmse" else "predicted relMSE")
    by_time.set_xlabel("seconds")
    by_spp.set_xlabel("samples per pixel")
    for axes in (by_time, by_spp):
        axes.grid(alpha=0.3)
        axes.legend()
    figure.savefig(options.output)


if __name__ == "__main__":
    main()
