# SPDX-License-Identifier: Apache-2.0
"""The arithmetic of error against time. Needs numpy alone.

Images are (h, w, 3) arrays of linear radiance. A curve is a list of (seconds, error), rising in seconds.
"""

import math

import numpy as np

EPSILON = 1e-2  # as `eikon compare` has it


def relmse(test, reference):
    """Mean of (x - r)^2 / (r^2 + 1e-2) over pixels and channels."""
    return float(np.mean((test - reference) ** 2 / (reference ** 2 + EPSILON)))


class Reference:
    """The mean of independent images of one renderer, which knows its own error."""

    def __init__(self, images):
        if len(images) < 2:
            raise ValueError("a reference takes two images at least: their spread is its error")
        self.mean = np.mean(images, axis=0)
        variance = np.var(images, axis=0, ddof=1) / len(images)
        self.relmse = float(np.mean(variance / (self.mean ** 2 + EPSILON)))

    def error_of(self, test):
        """relMSE of an independent image against the truth: what is seen is its error and the reference's, since noise
        that is independent adds in squares; so the latter is taken off. May be negative where both are alike."""
        return relmse(test, self.mean) - self.relmse


def seconds_at(curve, error):
    """Seconds at which a curve reaches an error, straight lines between its points in logarithms of both. None outside:
    nothing is extrapolated."""
    for (t0, e0), (t1, e1) in zip(curve, curve[1:]):
        if min(e0, e1) <= error <= max(e0, e1) and e0 > 0 and e1 > 0:
            if e0 == e1:
                return t0
            part = math.log(error / e0) / math.log(e1 / e0)
            return t0 * (t1 / t0) ** part
    return None


def common_errors(curves, count=9):
    """Errors that every curve reaches, evenly in the logarithm from the largest to the least; none where they do not
    overlap."""
    usable = [[e for _, e in curve if e > 0] for curve in curves]
    if not all(usable):
        return []
    most, least = min(max(errors) for errors in usable), max(min(errors) for errors in usable)
    if most < least:
        return []
    between = [most * (least / most) ** (i / (count - 1)) for i in range(1, count - 1)]
    return [most, *between, least]  # the ends without rounding, since a curve ends there


def times_as_fast(curve, other):
    """(at the least common error, median over the common errors): seconds of `other` over those of `curve`. None, None
    where they have no error in common."""
    ratios = []
    for error in common_errors([curve, other]):
        ours, theirs = seconds_at(curve, error), seconds_at(other, error)
        if ours and theirs:
            ratios.append(theirs / ours)
    if not ratios:
        return None, None
    return ratios[-1], float(np.median(ratios))


def curve_of(runs, seconds):
    """The curve of one renderer: for each number of samples the best of its times and the mean of its errors. runs:
    [{"spp", "relmse", seconds}]; seconds: "seconds" (rendering alone) or "seconds_from_start"."""
    points = []
    for spp in sorted({run["spp"] for run in runs}):
        same = [run for run in runs if run["spp"] == spp]
        points.append((min(run[seconds] for run in same), float(np.mean([run["relmse"] for run in same]))))
    return points


def rate(runs, pixels):
    """Samples per second of rendering alone, at the most samples: there fixed costs count least; best of the rounds."""
    most = max(run["spp"] for run in runs)
    return pixels * most / min(run["seconds"] for run in runs if run["spp"] == most)
