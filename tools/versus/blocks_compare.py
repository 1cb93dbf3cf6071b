#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Do two renders agree within their noise? A z-test on every block of 16 x 16 pixels and channel, with Sidak's
correction for the number of tests, from the variances in the files (variance.R, .G, .B: of the pixel's mean).
Exit code 0: no block differs significantly; 1: one does.

The variance of a block's mean is the larger of what the files predict and what the spread of the pixel differences in
the block shows: the estimate of a few batches or replicates is itself uncertain and misses rare bright paths. Where
both are zero (a plain background), differences up to the rounding of single-precision sums are allowed.

--png shows both pictures and their relative difference (grey: none; white: 20 % brighter than the reference, black: darker),
for renderers whose models differ and of which no test can say more.

  tools/versus/blocks_compare.py out/cornell.exr out/mitsuba.exr
"""

import argparse
import math
import pathlib
import sys
import zlib

import modules

modules.need(["numpy", "OpenEXR"], "eikon-versus", "OpenEXR numpy")

import numpy as np  # noqa: E402

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from scene_builders.png_file import pack_png  # noqa: E402


def read(path):
    """(image, variance): (h, w, 3) float64; variance is None if the file has none."""
    import OpenEXR
    channels = OpenEXR.File(path, separate_channels=True).channels()

    def planes(prefix):
        names = [prefix + c for c in "RGB"]
        if any(name not in channels for name in names):
            return None
        return np.stack([channels[name].pixels.astype(np.float64) for name in names], axis=-1)

    image = planes("")
    if image is None:
        sys.exit(f"{path}: no channels R, G, B")
    return image, planes("variance.")


def blocks(values, size):
    """Whole blocks of an (h, w, 3) array as (rows, columns, size * size, 3); what does not fill a block is left out."""
    rows, columns = values.shape[0] // size, values.shape[1] // size
    cut = values[:rows * size, :columns * size].reshape(rows, size, columns, size, 3)
    return cut.transpose(0, 2, 1, 3, 4).reshape(rows, columns, size * size, 3)


# Relative error allowed to a mean that the other renderer summed in single precision.
ROUNDING = 2.0 ** -19


def block_z(test, reference, variance, size, tolerance=0.0):
    """(z of each block's mean difference, its standard deviation relative to the reference), each (rows, columns, 3);
    blocks that are equal, or differ by no more than `tolerance` times the reference, have z = 0."""
    d = blocks(test - reference, size)
    count = size * size
    seen = d.var(axis=2, ddof=1) / count
    predicted = np.zeros_like(seen) if variance is None else blocks(variance, size).sum(axis=2) / count ** 2
    level = np.abs(blocks(reference, size)).mean(axis=2)
    rounding = ROUNDING * level
    sigma = np.sqrt(np.maximum(seen, predicted) + rounding ** 2)
    mean = d.mean(axis=2)
    mean = np.sign(mean) * np.maximum(np.abs(mean) - tolerance * level, 0.0)
    certain = np.where(mean == 0, 0.0, np.copysign(np.inf, mean))
    z = np.divide(mean, sigma, out=certain, where=sigma > 0)
    return z, np.divide(sigma, level, out=np.zeros_like(sigma), where=level > 0)


def p_values(z):
    """Two-sided p of a standard normal."""
    return np.vectorize(lambda x: math.erfc(abs(x) / math.sqrt(2)))(z)


def sidak(smallest, tests):
    """Probability that the smallest of `tests` independent p-values is as small as `smallest` by chance."""
    return -math.expm1(tests * math.log1p(-min(smallest, 1 - 1e-16)))


def write_png(path, image):
    """(h, w, 3) of linear values, clipped to [0, 1], as sRGB."""
    image = np.clip(image, 0, 1)
    encoded = np.where(image <= 0.0031308, 12.92 * image, 1.055 * image ** (1 / 2.4) - 0.055)
    rows = np.round(255 * encoded).astype(np.uint8).reshape(image.shape[0], -1)
    rows = np.concatenate([np.zeros((len(rows), 1), np.uint8), rows], axis=1).tobytes()
    pathlib.Path(path).write_bytes(pack_png((image.shape[1], image.shape[0]), zlib.compress(rows)))


def side_by_side(test, reference, exposure):
    """Both pictures, 2^exposure brighter, and their difference relative to the reference."""
    difference = (test - reference) / (np.abs(reference) + 0.01 * np.abs(reference).mean())
    grey = 0.214  # the middle of sRGB
    shown = np.where(difference > 0, grey + (1 - grey) * difference / 0.2, grey + grey * difference / 0.2)
    return np.concatenate([test * 2.0 ** exposure, reference * 2.0 ** exposure, shown], axis=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("test")
    parser.add_argument("reference")
    parser.add_argument("--block", type=int, default=16, help="side of a block in pixels (default 16)")
    parser.add_argument("--tolerance", type=float, default=0.0, help="relative difference that is forgiven (default 0)")
    parser.add_argument("--alpha", type=float, default=0.01, help="significance over all blocks (default 0.01)")
    parser.add_argument("--png", metavar="OUT.png", help="write both and their difference side by side")
    parser.add_argument("--exposure", type=float, default=0.0, help="stops, of --png (default 0)")
    arguments = parser.parse_args()

    (test, test_variance), (reference, reference_variance) = read(arguments.test), read(arguments.reference)
    if test.shape != reference.shape:
        sys.exit(f"sizes differ: {test.shape[1]}x{test.shape[0]} and {reference.shape[1]}x{reference.shape[0]}")
    known = [v for v in (test_variance, reference_variance) if v is not None]
    variance = sum(known) if known else None
    z, sigma = block_z(test, reference, variance, arguments.block, arguments.tolerance)
    p = p_values(z)
    worst = np.unravel_index(np.argmin(p), p.shape)
    corrected = sidak(p[worst], p.size)
    if arguments.png:
        write_png(arguments.png, side_by_side(test, reference, arguments.exposure))
    print(f"means       {' '.join(f'{v:.6g}' for v in test.mean((0, 1)))}  against"
          f"  {' '.join(f'{v:.6g}' for v in reference.mean((0, 1)))}")
    print(f"ratio       {test.mean() / reference.mean():.6f}")
    print(f"blocks      {z.shape[0] * z.shape[1]} x 3, z has mean {z.mean():+.3f}, deviation {z.std():.3f}")
    print(f"sharpness   standard deviation of a block below {100 * np.quantile(sigma, 0.9):.2f} % of it in nine of ten")
    print(f"worst block row {worst[0]}, column {worst[1]}, channel {'RGB'[worst[2]]}: z = {z[worst]:+.2f}")
    print(f"p           {corrected:.4g} over all blocks: {'differ' if corrected < arguments.alpha else 'agree'}")
    return 1 if corrected < arguments.alpha else 0


if __name__ == "__main__":
    sys.exit(main())
