#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the farm's folder keeps, and what the commands make of it when it was damaged, moved, or is in use: without a cluster,
and without eikon. The argument, the real one, is not used."""
import contextlib
import errno
import io
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from farm import commands, errors, folder, jobs, locking, merging, nodes, openjd, slurm, submit  # noqa: E402


class Names(unittest.TestCase):
    """Of the images' files in the folder."""

    def names(self, *outputs):
        said = [{"error": None, "line": 1, "words": [], "part": [], "samples": [0, 1], "output": output, "key": "", "scene": "",
                 "size": None, "open_ended": False, "results": [output]} for output in outputs]
        with unittest.mock.patch.object(jobs, "list_lines", return_value=said):
            return [job.name for job in jobs.read_jobs("eikon", "", "/", "jobs.txt")]

    def test_no_two_images_have_one_name(self):
        self.assertEqual(self.names("x/a.exr", "y/a.exr", "a-2.exr"), ["a", "a-2", "a-2-2"])
        self.assertEqual(self.names("a-2.exr", "x/a.exr", "y/a.exr", "z/a.exr"), ["a-2", "a", "a-3", "a-4"])

    def test_a_name_of_dots_is_no_folder(self):
        self.assertEqual(self.names("..exr", "...exr", "out/..exr"), ["image", "image-2", "image-3"])


class Submitted(unittest.TestCase):
    """A farm of one image in two parts that are done, with a script in the place of eikon. What Slurm is asked is kept."""

    EIKON = """#!/bin/bash
[ "$1 $2" = "merge --quiet" ] && { [ -e "$3" ] && ! grep -q X "$3"; exit $((3 * $?)); }
[ "$1" = merge ] && { echo "eikon: parts/box: it is damaged" >&2; exit 3; }
if [ "$1 $3" = "batch --list" ]; then
  while read -r _; do echo '{"key": "k"}'; done
fi
exit 0
"""

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.base = pathlib.Path(kept.name).resolve() / "project"
        self.path = self.base / "jobs.txt.farm"
        self.path.mkdir(parents=True)
        eikon = self.base.parent / "eikon"
        eikon.write_text(self.EIKON)
        eikon.chmod(0o755)
        (self.base / "jobs.txt").write_text("render box.gltf -o box.exr\n")
        job = jobs.Job(1, "box", ["box.gltf", "-o", "box.exr"], ["box.gltf"], [0, 4], "box.exr", "key", "box.gltf", [4, 4],
                       parts=[[0, 2], [2, 4]])
        settings = {"eikon": str(eikon), "base": str(self.base), "file": str(self.base / "jobs.txt"), "text": "",
                    "name": "jobs.txt", "threads": 1, "partition": "work", "account": "", "gres": "", "exclude": "", "throttle": 0,
                    "memory_mb": 100, "minutes": 5, "signal_s": 90, "sbatch": [], "nodes": 1, "parts": 2, "lines": 1,
                    "checkpoint_every": 0}
        self.farm = folder.Farm(self.path, settings, [job], jobs.Measured(1.0, 1.0, 1.0, 1.0, 1, [4, 4]))
        folder.make_folders(self.farm)
        _, after = merging.write_merges(self.farm)
        folder.write_tasks(self.farm, self.farm.items(), after)
        self.parts = merging.part_files(self.farm, job)
        for number, name in enumerate(self.parts):
            (self.base / name).write_text(f"sums {number}")
            entry = {"state": "done", "key": "k", "seconds": 1.0,
                     "outputs": [{"path": name, "bytes": 6}]}
            (self.path / f"tasks/r0-{number:05d}.ledger").write_text(json.dumps(entry, separators=(",", ":")) + "\n")
        self.farm.save()

    def run_farm(self, *words):
        """(exit code, what it printed, what it said on stderr, the scripts that were submitted with their arrays)"""
        asked, said, wrong = [], io.StringIO(), io.StringIO()

        def answer(script, *options, exports=None):
            asked.append(" ".join([pathlib.Path(script).name, *options]))
            return str(100 + len(asked))

        with contextlib.ExitStack() as stack:
            for name, value in (("choose_partition", lambda name: "work"), ("states", lambda numbers: {}), ("submit", answer),
                                ("nodes", lambda *_: [("n1", True)]), ("longest_array", lambda: 1000)):
                stack.enter_context(unittest.mock.patch.object(slurm, name, value))
            stack.enter_context(unittest.mock.patch.object(nodes, "start", lambda farm: {}))
            stack.enter_context(unittest.mock.patch.object(nodes, "finish", lambda *_: ([], [])))
            stack.enter_context(unittest.mock.patch.object(jobs, "read_jobs", lambda *_: folder.load(self.path).jobs))
            stack.enter_context(contextlib.redirect_stdout(said))
            stack.enter_context(contextlib.redirect_stderr(wrong))
            code = commands.main(list(map(str, words)))
        return code, said.getvalue(), wrong.getvalue(), asked


class Damage(Submitted):
    """What stands in the way of a merge."""

    def test_a_damaged_part_of_the_right_size_is_rendered_again(self):
        (self.base / self.parts[1]).write_text("sums X")
        code, said, wrong, asked = self.run_farm("resubmit", self.path)
        self.assertEqual((code, wrong), (0, ""))
        self.assertIn(f"{self.parts[1]} is damaged: it is rendered again\n", said)
        self.assertIn("submitted 1 tasks of 1 parts", said)
        self.assertEqual(asked[0], "task.sh --array=0-0")
        self.assertIn("--samples=2:4", (self.path / "tasks/r1-00000.txt").read_text())
        self.assertFalse((self.base / self.parts[1]).exists())
        self.assertTrue((self.base / self.parts[0]).exists())

    def test_parts_whose_task_was_killed_before_it_marked_them_are_marked(self):
        self.run_farm("resubmit", self.path)
        self.assertEqual([(self.base / f"{name}.done").exists() for name in self.parts], [True, True])

    def test_status_shows_its_table_though_an_error_is_unknown(self):
        code, said, wrong, _ = self.run_farm("status", self.path)
        self.assertEqual((code, wrong), (1, ""))
        self.assertRegex(said, r"2 done, 0 running(.|\n)*box +2 +2 +0 +0 +-\n(.|\n)*error unknown: box: parts/box: it is damaged\n$")


class Moves(Submitted):
    """The folder is somewhere else than it was."""

    def move(self, what, to):
        shutil.move(what, to)
        return to

    def test_what_is_done_is_known_where_all_was_moved(self):
        (self.base / self.parts[1]).unlink()
        self.base = self.move(self.base, self.base.parent / "elsewhere")
        self.path = self.base / "jobs.txt.farm"
        self.assertIn("2 parts: 1 done, 0 running, 0 waiting, 1 failed", self.run_farm("status", self.path)[1])
        self.assertIn("submitted 1 tasks of 1 parts", self.run_farm("resubmit", self.path)[1])
        for script in ("task.sh", "merge-0.sh"):
            self.assertIn(f"farm={self.path}\nbase={self.base}\n", (self.path / script).read_text())
        self.assertEqual(folder.load(self.path).settings["file"], str(self.base / "jobs.txt"))

    def test_a_folder_that_was_moved_alone_is_refused(self):
        for name in ("jobs.txt.farm", "mine.farm"):
            (self.base.parent / "elsewhere").mkdir(exist_ok=True)
            there = self.move(self.path, self.base.parent / "elsewhere" / name)
            for command in ("status", "resubmit", "cancel"):
                code, said, wrong, asked = self.run_farm(command, there)
                self.assertEqual((code, said, asked), (3, "", []))
                self.assertRegex(wrong, f"^eikon-farm: {there}: it was {self.path} when its jobs were submitted, .*\\n$")
            self.move(there, self.path)
        self.assertEqual(self.run_farm("resubmit", self.path)[0], 0)

    def test_another_name_of_the_same_folder_is_no_move(self):
        before = str(self.path)
        self.base.rename(self.base.parent / "real")
        self.base.symlink_to(self.base.parent / "real")
        self.path = self.base.parent / "real/jobs.txt.farm"
        self.assertIn("2 parts: 2 done", self.run_farm("status", self.path)[1])
        self.assertEqual(str(folder.load(self.path).path), before)


class Words(Submitted):
    """What the commands say."""

    def test_merges_alone_are_counted(self):
        code, said, _, asked = self.run_farm("resubmit", self.path)
        self.assertEqual((code, asked), (0, ["merge-0.sh --array=0-0"]))
        self.assertIn("submitted 1 merge of 1 image; no part is to be rendered\n", said)
        self.assertNotIn("0 tasks", said)

    def test_merges_behind_tasks_are_counted(self):
        (self.base / self.parts[1]).unlink()
        self.assertIn("submitted 1 tasks of 1 parts; the other 1 are done or under way; 1 merge of 1 image behind them\n",
                      self.run_farm("resubmit", self.path)[1])

    def test_the_queue_of_a_template_keeps_its_logs(self):
        self.assertRegex(self.run_farm("status", self.path)[1], r"not written: box.exr: .*; log: .*; `eikon-farm resubmit` merges")
        (self.path / "job.template.json").touch()
        self.assertRegex(self.run_farm("status", self.path)[1], r"not written: .*; the queue keeps its log; the template, run again, merges")
        (self.base / self.parts[1]).unlink()
        self.assertRegex(self.run_farm("status", self.path)[1], r"failed: .*; the queue keeps its log\n")

    def test_a_template_is_named_without_braces(self):
        self.farm.path = self.base / "a{{x}}b.farm"
        self.assertEqual(openjd.template(self.farm, 1, [])["name"], "eikon axb")


class Shapes(Submitted):
    """A farm.json that no command has written."""

    def test_it_is_refused_with_one_line(self):
        whole = json.loads((self.path / "farm.json").read_text())
        for change in ({"rounds": [5]}, {"rounds": 5}, {"rounds": [{"tasks": [], "arrays": [5], "merges": []}]}, {"settings": 5},
                       {"rounds": [{"tasks": [], "arrays": [[7, 0, 1]], "merges": []}]}, {"jobs": [5]}, {"jobs": 5}, {"jobs": []}, {"measured": 5},
                       {"rounds": [{"tasks": [], "arrays": [["7", "0", 1]], "merges": []}]}, {"settings": {}},
                       {"jobs": [{**whole["jobs"][0], "parts": 5}]}, {"jobs": [{**whole["jobs"][0], "parts": [["a", "b"]]}]}):
            (self.path / "farm.json").write_text(json.dumps({**whole, **change}))
            for command in ("status", "cancel"):
                code, said, wrong, _ = self.run_farm(command, self.path)
                self.assertEqual((code, said), (3, ""), change)
                self.assertRegex(wrong, r"^eikon-farm: .*/farm.json: it is damaged; submit the jobs again: .*\n$")


class Locks(Submitted):
    """Two commands at once."""

    def test_of_two_resubmits_at_once_one_submits(self):
        (self.base / self.parts[1]).unlink()
        others, list_lines = [], jobs.list_lines

        def meanwhile(*words):
            if not others:
                others.append(None)
                others[0] = [self.run_farm(command, self.path) for command in ("resubmit", "cancel")]
            return list_lines(*words)

        with unittest.mock.patch.object(jobs, "list_lines", meanwhile):
            code, said, _, _ = self.run_farm("resubmit", self.path)
        self.assertEqual(code, 0)
        self.assertIn("submitted 1 tasks of 1 parts", said)
        for code, said, wrong, asked in others[0]:
            self.assertEqual((code, said, asked), (3, "", []))
            self.assertRegex(wrong, r"^eikon-farm: .*jobs.txt.farm: another eikon-farm, process \d+ on \S+, changes it: try again "
                                    r"when that has ended, or remove .*/lock if there is none\n$")
        self.assertEqual(len(folder.load(self.path).rounds), 2)
        self.assertFalse((self.path / "lock").exists())

    def test_of_two_submits_into_a_new_folder_one_is_refused(self):
        with self.assertRaisesRegex(errors.FarmError, "jobs were submitted here already"):
            with submit.new_folder(self.farm):
                self.fail("it went on")
        self.assertFalse((self.path / "lock").exists())

    def test_a_full_disk_lets_nobody_wait(self):
        full = OSError(errno.ENOSPC, "No space left on device")
        with unittest.mock.patch.object(locking.os, "open", side_effect=full):
            self.assertEqual(self.run_farm("cancel", self.path)[0], 0)
        with unittest.mock.patch.object(locking.os, "fdopen", side_effect=full):
            self.assertEqual(self.run_farm("cancel", self.path)[0], 0)
        self.assertFalse((self.path / "lock").exists())

    def test_the_lock_of_a_process_that_is_gone_is_taken_over(self):
        over = subprocess.Popen(["true"])
        over.wait()
        host = socket.gethostname()
        for holder, code in ((f"{host} {over.pid} 7\n", 0), (f"elsewhere {over.pid} 7\n", 3), (f"{host} {os.getpid()} 7\n", 0),
                             (f"{host} {os.getpid()} {locking.began(os.getpid())}\n", 3), ("", 3)):
            (self.path / "lock").write_text(holder)
            self.assertEqual(self.run_farm("resubmit", self.path)[0], code, holder)
            self.assertEqual((self.path / "lock").exists(), code == 3, holder)
        self.assertEqual(list(self.path.glob("lock.*")), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
