#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/bench_gpu.sh with PoCL driven as a GPU: whole, with a device that fails, without one, and where nothing can be written.

  tests/gpu/bench_test.py EIKON [unittest arguments]"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
EIKON = ""
AS_GPU = {"EIKON_LANES": "1", "EIKON_FAULT": "device:0:gpu", "EIKON_VERSUS": "/nonexistent"}  # the last: LuxCore is left out


class BenchGpu(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="eikon_bench_gpu_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def bench(self, *words, code, eikon=None, **variables):
        """Runs it and checks the exit code and that it leaves nothing but the archive. returns  what it prints on stderr"""
        temporary = self.folder / "tmp"
        temporary.mkdir(exist_ok=True)
        done = subprocess.run([ROOT / "tools/bench_gpu.sh", "--eikon", eikon or EIKON, "--quick", *map(str, words)], cwd=self.folder,
                              env={**os.environ, "TMPDIR": str(temporary), **AS_GPU, **variables}, capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        self.assertEqual(list(temporary.iterdir()), [])
        return done.stderr

    def unpacked(self, name="eikon-gpu.tar.gz"):
        """(page, results) of an archive."""
        with tarfile.open(self.folder / name) as archive:
            archive.extractall(self.folder / name.split(".")[0])
        inside = self.folder / name.split(".")[0] / "eikon-gpu"
        return (inside / "page.md").read_text(), json.loads((inside / "results.json").read_text())

    def rows(self, page, title):
        """The cells of the first table of a section."""
        section = page.split(f"\n## {title}\n")[1].split("\n## ")[0]
        lines = [line for line in section.splitlines() if line.startswith("| ")]
        return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines[1:]]

    def test_all_steps_pass_and_their_tables_are_filled(self):
        self.bench("--devices", "0", code=0)
        page, results = self.unpacked()
        self.assertEqual({row[1] for row in self.rows(page, "Steps") if row[0] != "luxcore"}, {"ok"})
        self.assertTrue(next(row[1] for row in self.rows(page, "Steps") if row[0] == "luxcore").startswith("left out: pyluxcore"))
        self.assertIn("\n## What failed\n\nNothing.\n", page)
        self.assertEqual([row[:2] for row in self.rows(page, "Bits")], [["cornell", "yes"], ["nori_triangle_1", "yes"], ["run_10_moving", "yes"]])
        compiled = {tuple(row[:2]) for row in self.rows(page, "Compiling, many at a time")}
        self.assertEqual(compiled, {("cornell", "usual"), ("nori_triangle_1", "usual"), ("run_10_moving", "usual"),
                                    ("cornell", "2^12"), ("cornell", "2^20")})
        for title, column in (("Rays by layout", 4), ("Paths by layout", 2), ("Paths by unit", 3)):
            rows = self.rows(page, title)
            self.assertGreaterEqual(len(rows), 2, title)
            self.assertTrue(all(float(row[column]) > 0 for row in rows), title)
        self.assertEqual([row[1] for row in self.rows(page, "Rays by layout")], ["bvh2", "bvh4", "cwbvh"])
        self.assertLessEqual({"generate", "intersect", "shade", "compact", "shadow", "film", "gaps"},
                             {row[2] for row in self.rows(page, "Time by stage")})
        small, large = results["units"]
        self.assertLess(small["device_bytes"], large["device_bytes"])
        self.assertGreater(small["units"], large["units"])
        self.assertEqual(results["canary"]["devices"][0]["arithmetic"], "exact")
        self.assertEqual(results["canary"]["devices"][0]["lanes"], 1)

    def test_films_are_compared_with_kept_ones_and_differences_are_found(self):
        only = ("--devices", "0", "--steps", "bits", "--scenes", "cornell")
        self.bench(*only, "--reference", "none", "--out", "first.tar.gz", code=0)
        self.assertEqual(self.rows(self.unpacked("first.tar.gz")[0], "Bits")[0][:2], ["cornell", "not compared"])
        kept = self.folder / "first/eikon-gpu/films/device"
        self.bench(*only, "--reference", kept, "--out", "second.tar.gz", code=0)
        self.assertEqual(self.rows(self.unpacked("second.tar.gz")[0], "Bits")[0][:2], ["cornell", "yes"])
        # Other random numbers, on the device alone.
        shutil.copytree(ROOT / "kernels", self.folder / "kernels")
        sampler = self.folder / "kernels/lanes/sampler.h"
        other = sampler.read_text().replace("0xbb67ae85u", "0xbb67ae87u")
        self.assertNotEqual(other, sampler.read_text())
        sampler.write_text(other)
        self.bench(*only, "--out", "third.tar.gz", code=1, EIKON_KERNEL_DIR=str(self.folder / "kernels"))
        page, results = self.unpacked("third.tar.gz")
        self.assertEqual(self.rows(page, "Bits")[0][:2], ["cornell", "no"])
        self.assertGreater(results["bits"][0]["relmse"], 0)
        self.assertIn("the picture differs", self.rows(page, "What failed")[0][2])
        # Films of another size cannot be compared.
        films = json.loads((kept / "films.json").read_text())
        (kept / "films.json").write_text(json.dumps({**films, "film_size": "25x16"}))
        self.bench(*only, "--reference", kept, "--out", "fourth.tar.gz", code=1)
        self.assertIn("25x16", self.rows(self.unpacked("fourth.tar.gz")[0], "What failed")[0][2])

    def test_a_device_that_fails_in_the_middle_is_recorded_and_the_others_steps_are_done(self):
        self.bench("--devices", "0", "--steps", "info,layouts,units,stages", code=1, EIKON_FAULT="device:0:gpu;device:0:after=2")
        page, results = self.unpacked()
        done = {row[0]: row[1] for row in self.rows(page, "Steps")}
        self.assertEqual(done, {"devices": "ok", "canary": "ok", "info": "ok", "layouts": "3 failed", "units": "2 failed", "stages": "1 failed"})
        failed = self.rows(page, "What failed")
        self.assertEqual(len(failed), 6)
        for _, _, line in failed:
            self.assertIn("CL_OUT_OF_RESOURCES", line)
            self.assertNotIn(str(self.folder), line)
        self.assertTrue(all(failure["code"] == 4 for failure in results["failures"]))

    def test_a_device_that_computes_wrongly_is_said_to_be(self):
        self.bench("--devices", "0", "--steps", "selftest", code=1, EIKON_FAULT="device:0:gpu;device:0:wrong")
        failed = self.rows(self.unpacked()[0], "What failed")
        self.assertEqual([row[0] for row in failed], ["canary", "selftest"])
        self.assertIn("is not to be trusted", failed[0][2])

    def test_nothing_is_measured_where_there_is_no_device(self):
        self.assertIn("no such device 'gpu'", self.bench(code=4))
        self.assertIn("takes DEVICE:NxUNITS", self.bench("--devices", "0:9x", code=2))
        self.assertIn("no OpenCL device", self.bench("--devices", "0", code=4, OCL_ICD_VENDORS="/nonexistent"))
        self.assertEqual([path.name for path in self.folder.iterdir()], ["tmp"])

    def test_an_archive_that_cannot_be_written_is_refused_before_anything_is_measured(self):
        message = self.bench("--devices", "0", "--out", self.folder / "missing/out.tar.gz", code=3)
        self.assertIn("missing/out.tar.gz: cannot be written", message)
        self.assertIn("name a file", self.bench("--devices", "0", "--out", self.folder, code=3))
        self.assertIn("no step nothing", self.bench("--steps", "nothing", code=2))
        self.assertIn("scenes/nothing.gltf", self.bench("--scenes", "nothing", code=2))

    def test_what_is_out_of_time_is_not_begun(self):
        self.bench("--devices", "0", "--steps", "info", "--seconds", "0.5", code=1)
        self.assertIn("the time of --seconds is over", self.rows(self.unpacked()[0], "What failed")[0][2])

    def test_a_program_that_hangs_is_stopped(self):
        hangs = self.folder / "eikon"
        hangs.write_text("#!/bin/sh\n[ $1 = --version ] || { echo begun >&2; sleep 1000; }\n")
        hangs.chmod(0o700)
        self.bench("--devices", "0", "--steps", "info", "--seconds", "3", code=1, eikon=hangs)
        line = self.rows(self.unpacked()[0], "What failed")[0][2]
        self.assertRegex(line, r"^stopped after \d s \(signal 9\)$")


if __name__ == "__main__":
    EIKON = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
