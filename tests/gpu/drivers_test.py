#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/gpu/drivers.py over the drivers that are installed, and its judgement of drivers that fail, crash or compute other bits.

  tests/gpu/drivers_test.py EIKON [unittest arguments]"""
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools/gpu"))
from bench_session import Session  # noqa: E402
import drivers  # noqa: E402

EIKON = ""
LISTING = "0: some device\\n   Some platform (vendor), OpenCL 3.0, driver 1.2\\n   arithmetic exact\\n"


class Drivers(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="eikon_drivers_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def trial(self, program, films):
        """The trial of a driver on which eikon does what the text of a shell script says."""
        eikon = self.folder / "eikon"
        eikon.write_text(f"#!/bin/sh\n{program}\n")
        eikon.chmod(0o700)
        session = Session(types.SimpleNamespace(eikon=eikon, seconds=None), {"command_seconds": 60}, self.folder)
        trial = drivers.Trial(session, drivers.Driver("some", "some.so", {}, self.folder))
        trial.run(["cornell"], films)
        return trial

    def test_those_installed_have_the_same_bits(self):
        done = subprocess.run([ROOT / "tools/gpu/drivers.py", self.folder, "--eikon", EIKON, "--installed", "--scenes", "cornell",
                               "--only", "Oclgrind,Mesa rusticl"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = {line.split(" | ")[0][2:]: line.split(" | ") for line in done.stdout.splitlines() if line.startswith("| ")}
        self.assertEqual(rows["PoCL"][3:6] + rows["PoCL"][7:8], ["exact", "ok", "1 same", "ok"])
        self.assertEqual(rows["Oclgrind"][3:6], ["exact", "ok", "1 same"])

    def test_other_bits_of_exact_arithmetic_are_a_fault(self):
        draws = f"""case $1 in devices) printf '{LISTING}';; render) while [ "$1" != --checkpoint ]; do shift; done; echo film > $2;; esac"""
        films = {}
        self.assertFalse(self.trial(draws, films).is_wrong)
        again = self.trial(draws, films)
        self.assertEqual((again.bits, again.selftest, again.is_wrong), ({"cornell": "same"}, "ok", False))
        other = self.trial(draws, {"cornell": "another digest"})
        self.assertEqual((other.bits, other.is_wrong), ({"cornell": "different"}, True))
        inexact = self.trial(draws.replace("arithmetic exact", "arithmetic other-12345678"), {"cornell": "another digest"})
        self.assertEqual((inexact.bits, inexact.is_wrong), ({"cornell": "different"}, False))

    def test_a_driver_that_is_refused_in_a_line_is_no_fault_and_one_that_ends_the_process_is(self):
        refuses = f"""case $1 in devices) printf '{LISTING}';; render) echo 'eikon: device x is not to be trusted' >&2; exit 4;;
            *) echo '  furnace   FAIL  x'; echo 'eikon: selftest failed' >&2; exit 4;; esac"""
        refused = self.trial(refuses, {})
        self.assertEqual((refused.canary, refused.bits, refused.selftest, refused.is_wrong),
                         ("refused", {"cornell": "refused"}, "fails: furnace", False))
        crashed = self.trial(f"case $1 in devices) printf '{LISTING}';; *) echo InvalidFunctionCall >&2; exit 8;; esac", {})
        self.assertEqual((crashed.bits, crashed.is_wrong), ({"cornell": "failed"}, True))
        killed = self.trial("kill -SEGV $$", {})
        self.assertTrue(killed.is_wrong)
        self.assertIn("(signal 11)", killed.row()[-1])


if __name__ == "__main__":
    EIKON = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
