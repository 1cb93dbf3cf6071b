#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What eikon-farm says of wrong words, before it looks at anything else. Needs neither eikon nor Slurm."""
import os
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from farm import errors, flags, scripts, submit  # noqa: E402


class Command(unittest.TestCase):
    """Runs eikon-farm in a folder of its own, without Slurm and with a program `eikon` that does nothing."""

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.path = pathlib.Path(kept.name)
        (self.path / "eikon").write_text("#!/bin/bash\nexit 0\n")
        (self.path / "eikon").chmod(0o755)

    def farm(self, *words):
        """(exit code, stdout, stderr)"""
        environment = {**os.environ, "PATH": f"{self.path}:/usr/bin:/bin", "SLURM_CONF": "/dev/null"}
        run = subprocess.run([sys.executable, ROOT / "tools/eikon-farm", *words], cwd=self.path, env=environment, timeout=60,
                             stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        return run.returncode, run.stdout, run.stderr

    def refused(self, words, code, pattern):
        """Fails unless the command ends with this code and one line."""
        with self.subTest(words=words):
            got, said, wrong = self.farm(*words)
            self.assertEqual(got, code, said + wrong)
            self.assertRegex(wrong, pattern)
            self.assertEqual(wrong.count("\n"), 1, wrong)
            self.assertTrue(wrong.startswith("eikon-farm: "), wrong)


class Numbers(Command):
    """Numbers out of their range."""

    def test_submit_takes_no_number_out_of_its_range(self):
        for flag, values in (("--lines", ("-1", "0", "1.5", "many")), ("--parts", ("-1",)), ("--throttle", ("-1",)),
                             ("--minutes", ("-1", "0")), ("--nodes", ("-3",)), ("--measure", ("nan", "-1", "inf")),
                             ("--probe-wait", ("nan", "-1")), ("--checkpoint-every", ("nan", "0", "-1")),
                             ("--signal", ("-5", "100000")), ("--cpus", ("-1",)), ("--mem", ("-1",))):
            for value in values:
                self.refused(["submit", "a.gltf", "-o", "a.exr", f"{flag}={value}"], 2,
                             f"submit: {flag}: '{value}' is not a (whole )?number from .* to .*; see `eikon-farm submit --help`")
        self.refused(["submit", "a.gltf", "-o", "a.exr", "--lines", "-1"], 2, "--lines: '-1' is not a whole number from 1 to")

    def test_resubmit_takes_none_either(self):
        for words in (["--minutes", "0"], ["--mem", "-1"], ["--probe-wait", "nan"], ["--throttle", "-1"]):
            self.refused(["resubmit", "a.farm", *words], 2, f"resubmit: {words[0]}: '{words[1]}' is not a")
        self.refused(["status", "a.farm", "--wrong"], 2, "status: unrecognised: --wrong")


class Plan(Command):
    """Invented clusters and work."""

    WORK = "36000,4096,2,35,0.8"

    def test_nothing_is_ignored_beside_invented_work(self):
        self.refused(["plan", "--work", self.WORK, "--failure", "0.5"], 2, "--failure: --work stands alone.*did you mean --failures")
        self.refused(["plan", "--work", self.WORK, "a.gltf"], 2, "a.gltf: --work stands alone")
        self.refused(["plan"], 2, "name a jobs file or a scene")

    def test_work_is_finite_and_in_range(self):
        for work, name in (("nan,4096,2,35,0.8", "SECONDS"), ("inf,4096,2,35,0.8", "SECONDS"), ("-5,4096,2,35,0.8", "SECONDS"),
                           ("1e300,4096,2,35,0.8", "SECONDS"), ("3600,1e400,2,35,0.8", "SPP"), ("3600,1.5,2,35,0.8", "SPP"),
                           ("3600,0,2,35,0.8", "SPP"), ("3600,16,-1,35,0.8", "STARTUP"), ("3600,16,2,-1,0.8", "MB"),
                           ("3600,16,2,35,-1", "MERGE"), ("3600,16,2,35,x", "MERGE")):
            self.refused(["plan", f"--work={work}"], 2, f"--work {work}: {name} '.*' is not a (whole )?number from")
        for work in ("", "3600,16,2,35", "1,2,3,4,5,6"):
            self.refused(["plan", f"--work={work}"], 2, "takes SECONDS,SPP,STARTUP,MB,MERGE")

    def test_clusters_are_finite_and_in_range(self):
        for flag, values in (("--most", ("0", "1000000000000")), ("--spread", ("nan", "1.5", "1", "-0.1")), ("--disk", ("nan", "0")),
                             ("--failures", ("-1", "nan")), ("--preemptions", ("inf",)), ("--errors", ("2", "1", "-1"))):
            for value in values:
                self.refused(["plan", "--work", self.WORK, f"{flag}={value}"], 2, f"plan: {flag}: '{value}' is not a")

    def test_a_table_of_what_is_not_done(self):
        code, said, wrong = self.farm("plan", "--work", self.WORK, "--errors", "0.9", "--most", "8", "--svg", "plan.svg")
        self.assertEqual((code, wrong.count("\n")), (1, 1), wrong)
        self.assertIn("plan.svg: no number of nodes writes all images", wrong)
        self.assertIn("one node does not write all images", said)
        self.assertNotIn("times faster", said)
        self.assertEqual(self.farm("plan", "--work", self.WORK, "--most", "8", "--svg", "plan.svg")[::2], (0, ""))


class Input(Command):
    """What is to be rendered."""

    def test_a_jobs_file_that_is_not_utf8_is_refused_with_its_line(self):
        (self.path / "jobs.txt").write_bytes(b"render a.gltf -o a.exr\nrender b.gltf -o caf\xe9.exr\n")
        pattern = "jobs.txt:2: the byte 0xe9 is not utf-8.*iconv"
        self.refused(["openjd", "jobs.txt"], 3, pattern)
        self.refused(["submit", "jobs.txt", "--dry-run"], 3, pattern)
        farm = types.SimpleNamespace(settings={"file": str(self.path / "jobs.txt")})
        self.assertRaisesRegex(errors.FarmError, pattern, submit.reread, farm)

    def test_jobs_on_standard_input(self):
        self.refused(["submit", "-", "--dry-run"], 2, "-: `eikon-farm resubmit` reads the jobs again.*cat > jobs.txt")

    def test_flags_in_front_of_the_scene(self):
        (self.path / "jobs.txt").write_text("render a.gltf -o a.exr\n")
        for words in (["--size", "32x32", "cornell.gltf", "-o", "z.exr"], ["-o", "z.exr", "--fov", "20", "cornell.gltf"]):
            self.refused(["submit", "--dry-run", *words], 2, "it was taken for the scene.*eikon-farm submit cornell.gltf ...")
        self.refused(["openjd", "--threads", "3", "jobs.txt"], 2, "3: it was taken for .*eikon-farm openjd jobs.txt ...")
        self.refused(["openjd", "jobs.txt", "--spp", "3"], 2, "--spp: flags of a render go with a scene; those of jobs.txt")
        self.refused(["openjd", "absent.txt"], 3, "cannot read absent.txt: No such file")


class Sbatch(Command):
    """Words for sbatch."""

    def test_a_word_that_begins_with_dashes_is_no_other_flag(self):
        self.assertEqual(flags.joined(["submit", "a", "--sbatch", "--qos=long", "--sbatch", "-C big", "--parts", "2"]),
                         ["submit", "a", "--sbatch=--qos=long", "--sbatch=-C big", "--parts", "2"])
        self.assertEqual(flags.joined(["submit", "--sbatch"]), ["submit", "--sbatch"])
        self.refused(["submit", "a.gltf", "--sbatch", "--partition=x", "--dry-run"], 2, "a partition is named by --partition")

    def test_quoted_words_stay_one_word(self):
        words = flags.split(["--comment='a b' --qos=long", r"--comment='say \"hi\" # \\ you'"])
        self.assertEqual(words[:2], ["--comment=a b", "--qos=long"])
        self.assertEqual(scripts.sbatch_lines({"sbatch": words}, {}).split("\n"),
                         ['#SBATCH "--comment=a b"', "#SBATCH --qos=long", r'#SBATCH "--comment=say \\\"hi\\\" # \\\\ you"'])

    def test_a_quote_that_is_not_closed(self):
        self.refused(["submit", "a.gltf", "--dry-run", "--sbatch", "--comment='a"], 2, "--sbatch --comment='a: No closing quotation")
        self.assertRaisesRegex(errors.FarmError, "characters that a line", flags.split, ["'a\nb'"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
