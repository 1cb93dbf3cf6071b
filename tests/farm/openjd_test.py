#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The templates of eikon-farm, checked and run by the reference implementation of Open Job Description.

  tests/farm/openjd_test.py EIKON

EIKON_OPENJD names its program `openjd` (PyPI: openjd-cli). Exit code 77, skipped, without it."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CORNELL = ROOT / "scenes/cornell.gltf"


class Template(unittest.TestCase):
    """One farm of two images, one of them in parts of three."""

    def setUp(self):
        self.space = pathlib.Path(tempfile.mkdtemp(prefix="eikon_openjd_"))
        self.addCleanup(shutil.rmtree, self.space)
        (self.space / "jobs.txt").write_text(f"render {CORNELL} -o box.exr --png box.png --size 64x64 --spp 16\n"
                                             f"render {CORNELL} -o 'a near one.exr' --size 64x64 --spp 16 --fov 25\n")
        subprocess.run([ROOT / "tools/eikon-farm", "openjd", "jobs.txt", "--parts", "3", "--lines", "2", "--eikon", eikon,
                        "--measure", "0.1"], cwd=self.space, check=True, capture_output=True)
        self.template = self.space / "jobs.txt.farm/job.template.json"

    def openjd(self, *words):
        """What openjd says; it may fail."""
        return subprocess.run([openjd, *words], capture_output=True, text=True, check=False,
                              env=dict(os.environ, EIKON_NODE_CACHE=str(self.space / "kernels")))

    def test_it_is_valid_and_one_that_is_broken_is_not(self):
        self.assertEqual(self.openjd("check", self.template).returncode, 0)
        broken = json.loads(self.template.read_text())
        broken["steps"][1]["dependencies"] = [{"dependsOn": "Nothing"}]
        (self.space / "broken.json").write_text(json.dumps(broken))
        self.assertNotEqual(self.openjd("check", self.space / "broken.json").returncode, 0)

    def test_its_run_tells_progress_and_gives_the_bits_of_one_render(self):
        run = self.openjd("run", self.template, "--step", "Merge0", "--run-dependencies")
        self.assertEqual(run.returncode, 0, run.stdout[-3000:])
        progress = [float(number) for number in re.findall(r"openjd_progress: ([0-9.]+)", run.stdout)]
        self.assertEqual(progress.count(100.0), 3, "not every task told that it was done")
        reference = self.space / "reference.exr"
        for image, words in (("box.exr", []), ("a near one.exr", ["--fov", "25"])):
            subprocess.run([eikon, "render", CORNELL, "-o", reference, "--size", "64x64", "--spp", "16", *words], check=True,
                           capture_output=True)
            said = subprocess.run([eikon, "compare", self.space / image, reference], check=True, capture_output=True, text=True)
            self.assertIn("MSE 0.000000e+00", said.stdout)
        self.assertTrue((self.space / "box.png").exists())
        # Run again, it renders nothing: what is done stands in the ledgers.
        before = [file.read_text().count('"done"') for file in sorted((self.space / "jobs.txt.farm/tasks").glob("*.ledger"))]
        self.assertEqual(self.openjd("run", self.template, "--step", "Merge0", "--run-dependencies").returncode, 0)
        self.assertEqual(before, [file.read_text().count('"done"')
                                  for file in sorted((self.space / "jobs.txt.farm/tasks").glob("*.ledger"))])


if __name__ == "__main__":
    openjd = os.environ.get("EIKON_OPENJD", "")
    if not os.access(openjd, os.X_OK):
        print("EIKON_OPENJD does not name a program: pip install openjd-cli has it")
        sys.exit(77)
    eikon = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
