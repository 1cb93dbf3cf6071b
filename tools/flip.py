#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Mean HDR-FLIP [Andersson et al. 2021] of an image against a reference: how different they look, from 0 to 1.

  tools/flip.py TEST.exr REFERENCE.exr

Negative values and values that are not finite count as 0. Needs numpy, OpenEXR and flip-evaluator from PyPI.
"""
import argparse
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "versus"))
import modules  # noqa: E402

modules.need(["numpy", "OpenEXR", "flip_evaluator"], "eikon-versus", "numpy OpenEXR flip-evaluator")

import flip_evaluator  # noqa: E402
import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402


def read_rgb(path):
    """R, G and B of the first part, as a (height, width, 3) array of floats."""
    channels = OpenEXR.File(str(path), separate_channels=True).parts[0].channels
    rgb = np.stack([channels[name].pixels for name in "RGB"], axis=-1).astype(np.float32)
    return np.where(np.isfinite(rgb) & (rgb > 0), rgb, np.float32(0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("test", type=pathlib.Path)
    parser.add_argument("reference", type=pathlib.Path)
    options = parser.parse_args()
    test, reference = read_rgb(options.test), read_rgb(options.reference)
    if test.shape != reference.shape:
        sys.exit(f"the images have {test.shape[1]} x {test.shape[0]} and {reference.shape[1]} x {reference.shape[0]} pixels")
    print(f"FLIP {flip_evaluator.evaluate(reference, test, 'HDR', applyMagma=False)[1]:.6f}")


if __name__ == "__main__":
    main()
