#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/gpu/model.py: the page has what it prints, its counts are those of the kernels, and it answers as a model should.

  tests/gpu/model_test.py EIKON [unittest arguments]"""
import dataclasses
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/gpu"))
import model  # noqa: E402

EIKON = ""
H100 = model.GPUS[0]


class ModelOfGpus(unittest.TestCase):
    def test_the_page_has_what_it_prints(self):
        page = model.PAGE.read_text()
        self.assertIn(model.BEGIN + "\n" + model.tables() + model.END, page, "bounds.tsv or counts.tsv changed: model.py --adopt")
        key = ("cornell", "shade")
        before = model.BOUNDS[key]
        self.addCleanup(model.BOUNDS.__setitem__, key, before)
        model.BOUNDS[key] = {**before, "nv_registers": "255"}
        self.assertNotIn(model.tables(), page)

    def test_counts_are_those_of_the_kernels(self):
        kept = [line for line in model.COUNTS.read_text().splitlines() if line.startswith("cornell\t")]
        counted = model.count_lines(EIKON, "cornell", ("bvh2", "cwbvh"))
        self.assertEqual([line for line in kept if "\tbvh4/" not in line], counted)

    def test_assumptions_are_in_order(self):
        for field in dataclasses.fields(model.Assumed):
            slow, middle, fast = getattr(model.Assumed(), field.name)
            self.assertTrue(slow <= middle <= fast or slow >= middle >= fast, field.name)
        for scene in model.SCENES:
            for block in (128, 256):
                rates = [model.megapaths_per_s(H100, scene, block, end) for end in range(3)]
                self.assertEqual(rates, sorted(rates))

    def test_larger_units_and_fewer_registers_are_no_slower_and_full_devices_are_fastest(self):
        for scene in model.SCENES:
            rates = [model.megapaths_per_s(H100, scene, paths, 1) for paths in (1 << 16, 1 << 20, 1 << 23, 1 << 25)]
            self.assertEqual(rates, sorted(rates))
            self.assertLess(rates[-1], 1e-6 * model.Model(H100, scene, "bvh2", 1).full_paths_per_s())
        made = model.Model(H100, "cornell_spheres", "bvh2", 1)
        seconds = made.kernel_s("shade_transmissive", 1e6, 1, 1e6)
        made.rows["shade_transmissive"] = {**made.rows["shade_transmissive"], "nv_registers": "64"}
        self.assertLess(made.kernel_s("shade_transmissive", 1e6, 1, 1e6), seconds / 2)

    def test_larger_units_are_worth_more_than_kernels_of_twice_the_speed(self):
        for end in range(3):
            gain = model.megapaths_per_s(H100, "cornell", 1 << 23, end) / model.megapaths_per_s(H100, "cornell", 1 << 20, end)
            self.assertGreater(gain, 1 / (1 - 0.5 * 0.01 * model.percent_in_kernels(H100, "cornell", 1 << 20, end)))

    def test_the_middle_of_all_assumptions_is_near_what_was_measured(self):
        for line in model.MEASURED.read_text().splitlines():
            gpu, scene, units, paths, kernel, ms = line.split("\t") if not line.startswith("#") else [""] * 6
            if kernel != "all":
                continue
            made = model.Model(next(g for g in model.GPUS if g.name == gpu), scene, "bvh2", 1)
            predicted = int(units) * made.unit_times(int(paths) / int(units), model.MEASURED_SAMPLES)[0]
            # The counts of cornell_spheres end after 30 depths, of which a unit has 100.
            self.assertLess(abs(1e-3 * float(ms) / predicted - 1), 0.45 if scene == "cornell_spheres" else 0.1, scene)

    def test_times_follow_from_the_two_limits(self):
        made = model.Model(H100, "cornell", "bvh2", 1)
        # One warp on its own: so many clocks for each instruction.
        self.assertAlmostEqual(made.run_s("shade", 32, 1000), 1000 * 42 / H100.hertz)
        self.assertAlmostEqual(made.run_s("shadow", 32, 1000), 1000 * 12 / H100.hertz)
        # A full device: 32 warps of an SM, 8 of a scheduler, of which each issues in one clock of
        # 42.
        full = 1e8
        self.assertAlmostEqual(made.run_s("shade", full, 1000) / (full * 1000 / (132 * 128 * H100.hertz * 8 / 42)), 1)
        self.assertAlmostEqual(made.run_s("shade", full, 1, 1e12), 1e12 / H100.dram)


if __name__ == "__main__":
    EIKON = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
