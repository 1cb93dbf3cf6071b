#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The arithmetic of tools/versus/ on known images and curves. Exit code 77, skipped, without numpy."""

import ast
import pathlib
import sys
import unittest

try:
    import numpy as np
except ImportError:
    print("numpy is missing")
    sys.exit(77)

sys.dont_write_bytecode = True
VERSUS = pathlib.Path(__file__).resolve().parent.parent / "tools" / "versus"
sys.path.insert(0, str(VERSUS))
import error_time  # noqa: E402
import process_time  # noqa: E402


class RelMse(unittest.TestCase):
    def test_known_images(self):
        reference = np.full((2, 3, 3), 0.3)
        self.assertEqual(error_time.relmse(reference, reference), 0)
        self.assertAlmostEqual(error_time.relmse(reference + 0.1, reference), 0.01 / (0.09 + 0.01), places=15)
        black = np.zeros((2, 3, 3))
        self.assertAlmostEqual(error_time.relmse(black + 0.5, black), 0.25 / 0.01, places=12)
        one = reference.copy()
        one[1, 2, 0] += 0.2  # one of 18 values
        self.assertAlmostEqual(error_time.relmse(one, reference), 0.04 / 0.1 / 18, places=15)

    def test_reference_takes_its_own_noise_off(self):
        random = np.random.Generator(np.random.PCG64(1))
        truth, size = 0.5, (100, 100, 3)
        noisy = [truth + 0.02 * random.standard_normal(size) for _ in range(4)]
        reference = error_time.Reference(noisy)
        relative = truth ** 2 + 0.01
        # Of 30,000 values the mean square has a standard deviation of 0.8 %; 5 % is more than four,
        # and the reference's noise in the denominator adds 0.2 %.
        self.assertAlmostEqual(reference.relmse * relative / 1e-4, 1, delta=0.05)
        test = truth + 0.01 * random.standard_normal(size)
        self.assertAlmostEqual(error_time.relmse(test, reference.mean) * relative / 2e-4, 1, delta=0.05)  # twice too much
        self.assertAlmostEqual(reference.error_of(test) * relative / 1e-4, 1, delta=0.1)

    def test_reference_of_one_image_is_refused(self):
        with self.assertRaises(ValueError):
            error_time.Reference([np.zeros((1, 1, 3))])


class Curves(unittest.TestCase):
    CURVE = [(1.0, 1.0), (4.0, 0.25), (16.0, 0.0625)]  # error = 1 / seconds

    def test_seconds_at_an_error(self):
        self.assertAlmostEqual(error_time.seconds_at(self.CURVE, 0.5), 2.0, places=12)
        self.assertAlmostEqual(error_time.seconds_at(self.CURVE, 0.1), 10.0, places=12)
        self.assertEqual(error_time.seconds_at(self.CURVE, 1.0), 1.0)
        self.assertAlmostEqual(error_time.seconds_at(self.CURVE, 0.0625), 16.0, places=12)

    def test_nothing_is_extrapolated(self):
        self.assertIsNone(error_time.seconds_at(self.CURVE, 1.1))
        self.assertIsNone(error_time.seconds_at(self.CURVE, 0.06))
        self.assertIsNone(error_time.seconds_at([], 0.5))

    def test_times_as_fast(self):
        slower = [(3 * t, e) for t, e in self.CURVE]
        last, median = error_time.times_as_fast(self.CURVE, slower)
        self.assertAlmostEqual(last, 3, places=9)
        self.assertAlmostEqual(median, 3, places=9)
        # error = 1 / seconds^2: as fast at 1, at 1/16 it takes 4 s to 16 s.
        steeper = [(1.0, 1.0), (2.0, 0.25), (4.0, 0.0625)]
        last, median = error_time.times_as_fast(steeper, self.CURVE)
        self.assertAlmostEqual(last, 4, places=9)
        self.assertAlmostEqual(median, 2, places=9)
        self.assertEqual(error_time.times_as_fast(self.CURVE, [(1.0, 1e-3), (2.0, 1e-4)]), (None, None))

    def test_curve_is_the_best_time_and_the_mean_error(self):
        runs = [{"spp": 4, "relmse": 0.1, "seconds": 2.0, "seconds_from_start": 5.0},
                {"spp": 4, "relmse": 0.3, "seconds": 1.0, "seconds_from_start": 6.0},
                {"spp": 1, "relmse": 0.8, "seconds": 0.5, "seconds_from_start": 4.0}]
        self.assertEqual(error_time.curve_of(runs, "seconds"), [(0.5, 0.8), (1.0, 0.2)])
        self.assertEqual(error_time.curve_of(runs, "seconds_from_start"), [(4.0, 0.8), (5.0, 0.2)])
        self.assertEqual(error_time.rate(runs, 100), 400)


class ProcessTime(unittest.TestCase):
    def test_begins_with_the_process_and_goes_on(self):
        first = process_time.process_seconds()
        self.assertGreater(first, 0)
        self.assertLess(first, 600)
        self.assertGreaterEqual(process_time.process_seconds(), first)


class Page(unittest.TestCase):
    def test_every_renderer_has_a_colour_without_which_the_page_leaves_it_out(self):
        def table(script, name):
            for statement in ast.parse((VERSUS / script).read_text()).body:
                if isinstance(statement, ast.Assign) and statement.targets[0].id == name:
                    return ast.literal_eval(statement.value)
            return None

        colors = table("versus_page.py", "COLORS")
        self.assertEqual(sorted(colors), sorted(table("versus.py", "RENDERERS")))
        self.assertEqual(len(set(colors.values())), len(colors))


if __name__ == "__main__":
    unittest.main()
