#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What every node runs before a task, the merges, and the arrays that Slurm is asked for, without a cluster: a shell script is in
the place of eikon. The argument, the real one, is not used."""
import json
import os
import pathlib
import subprocess
import sys
import tarfile
import tempfile
import time
import unittest
import unittest.mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from farm import errors, folder, jobs, merging, scripts, slurm, submit  # noqa: E402


class Place(unittest.TestCase):
    """A farm's folder."""

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.path = pathlib.Path(kept.name)
        for name in ("nodes", "kernels", "tasks", "parts/box", "merges", "logs"):
            (self.path / name).mkdir(parents=True)

    def eikon(self, text):
        (self.path / "eikon").write_text(f"#!/bin/bash\n{text}\n")
        (self.path / "eikon").chmod(0o755)

    def run_script(self, text, **more):
        """Runs lines of a script with the variables that its head sets: (exit code, what it printed)."""
        done = subprocess.run(["bash", "-c", f'farm={self.path}; base={self.path}; eikon="$farm/eikon"; cd "$base"\n{text}'],
                              env={**os.environ, **more}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        return done.returncode, done.stdout


class NodeScript(Place):
    """How a node prepares itself."""

    def look(self, node="n1", version="1"):
        self.eikon(f'[ "$1" = devices ] && echo "   arithmetic plain" || echo "eikon {version}"')
        return self.run_script(scripts.node_script() + '\necho "$POCL_CACHE_DIR"', SLURMD_NODENAME=node,
                               EIKON_NODE_CACHE=str(self.path / "cache"))

    def pack(self, program, when):
        """An archive of one compiled program, for the kind of this node."""
        (self.path / "packed" / program).mkdir(parents=True)
        (self.path / "packed" / program / "kernel").write_text(program)
        kind = next(line.split()[1] for line in (self.path / "nodes/n1").read_text().splitlines() if line.startswith("kind"))
        archive = self.path / "kernels" / f"{kind}.tar"
        with tarfile.open(archive, "w") as file:
            file.add(self.path / "packed", ".")
        os.utime(archive, (when, when))

    def test_kernels_are_unpacked_once_into_a_cache_that_is_there_already(self):
        code, said = self.look()
        self.assertEqual(code, 0, said)
        cache = pathlib.Path(said.strip())
        self.pack("ab/first", 1000)
        self.look()
        self.assertEqual((cache / "ab/first/kernel").read_text(), "ab/first")
        (cache / "ab/first/kernel").write_text("in use")
        self.pack("ab/second", 2000)
        self.look()
        self.assertEqual((cache / "ab/second/kernel").read_text(), "ab/second")
        self.assertEqual((cache / "ab/first/kernel").read_text(), "in use")
        (cache / "ab/second/kernel").unlink()
        self.look()
        self.assertFalse((cache / "ab/second/kernel").exists(), "the same archive was unpacked again")
        self.assertEqual(sorted(file.name for file in cache.parent.iterdir()), [cache.name, f"{cache.name}.unpacked"])

    def test_the_first_node_says_what_others_must_be_like_if_no_probe_could(self):
        self.assertEqual(self.look("n1", "1")[0], 0)
        code, said = self.look("n2", "2")
        self.assertEqual(code, 3)
        self.assertIn("n2: its version is 'eikon 2', that of the other nodes is 'eikon 1'", said)
        self.assertEqual(self.look("n3", "1")[0], 0)

    def test_a_program_that_was_replaced_is_looked_at_again(self):
        self.assertEqual(self.look(version="1")[0], 0)
        self.assertEqual(self.look(version="1")[0], 0)
        code, said = self.look(version="10")
        self.assertEqual(code, 3)
        self.assertIn("n1: its version is 'eikon 10', that of the other nodes is 'eikon 1': its parts may have other bits", said)
        self.assertEqual(self.look(version="1")[0], 0)

    def test_a_node_that_is_known_is_not_looked_at_again(self):
        self.look()
        self.eikon('echo run >> "$farm/runs"')
        there = self.path / "nodes/n1"
        program = subprocess.run(["stat", "-c", "%Y-%s", self.path / "eikon"], capture_output=True, text=True, check=True).stdout
        there.write_text("".join(line for line in there.read_text().splitlines(True) if "program" not in line) + f"program {program}")
        self.run_script(scripts.node_script(), SLURMD_NODENAME="n1", EIKON_NODE_CACHE=str(self.path / "cache"), farm=str(self.path))
        self.assertFalse((self.path / "runs").exists())


class MergeScript(Place):
    """When a merge is due, and when it is over."""

    def setUp(self):
        super().setUp()
        self.eikon('echo "$*" >> "$farm_log"; while [ "$1" != -o ]; do shift; done; echo picture > "$2"; exit "${fails:-0}"')
        self.job = jobs.Job(1, "box", ["box.gltf", "-o", "box.exr"], ["box.gltf"], [0, 4], "box.exr", "key", "box.gltf",
                            parts=[[0, 2], [2, 4]])
        self.farm = folder.Farm(self.path, {"base": str(self.path), "threads": 1}, [self.job], None)
        for name in merging.part_files(self.farm, self.job):
            (self.path / name).write_text("sums")
            (self.path / f"{name}.done").touch()

    def merge(self, **more):
        """Runs the last merge: (exit code, how often eikon has run so far)."""
        merging.write_merges(self.farm)
        code, _ = self.run_script('source "$farm/merges/box-0-00000.sh"', farm_log=str(self.path / "log"), **more)
        log = self.path / "log"
        return code, log.read_text().count("\n") if log.exists() else 0

    def test_a_part_that_was_saved_before_it_was_done_is_not_merged(self):
        mark = self.path / "parts/box/00000002-00000004.exr.done"
        mark.unlink()
        self.assertEqual(self.merge(), (1, 0))
        self.assertEqual(self.merge(if_ready="1"), (0, 0))
        mark.touch()
        self.assertEqual(self.merge(if_ready="1"), (0, 1))
        self.assertTrue(merging.is_written(self.farm, self.job))

    def test_what_failed_after_it_had_written_the_picture_is_done_again(self):
        self.assertEqual(self.merge(fails="3"), (3, 1))
        self.assertTrue((self.path / "box.exr").exists())
        self.assertFalse(merging.is_written(self.farm, self.job))
        self.assertEqual(self.merge(), (0, 2))
        self.assertTrue(merging.is_written(self.farm, self.job))
        self.assertEqual(self.merge(), (0, 2), "it was merged twice")
        self.assertEqual(self.merge(fails="3"), (0, 2), "it was merged twice")

    def test_a_picture_that_is_asked_for_otherwise_is_written_again(self):
        self.assertEqual(self.merge(), (0, 1))
        self.job.words += ["--png", "box.png"]
        self.assertFalse(merging.is_written(self.farm, self.job))
        self.assertEqual(self.merge(), (0, 2))
        self.assertIn("--png box.png", (self.path / "log").read_text())

    def test_results_that_are_gone_or_cut_off_are_written_again(self):
        self.eikon('echo run >> "$farm_log"; echo picture > box.exr; echo smaller > "my box.png"')
        self.job.results = ["box.exr", "my box.png"]
        self.assertEqual(self.merge(), (0, 1))
        self.assertTrue(merging.is_written(self.farm, self.job))
        (self.path / "my box.png").unlink()
        self.assertFalse(merging.is_written(self.farm, self.job))
        self.assertEqual(self.merge(), (0, 2))
        self.assertTrue(merging.is_written(self.farm, self.job))
        (self.path / "box.exr").write_text("pict")
        self.assertFalse(merging.is_written(self.farm, self.job))
        self.assertEqual(self.merge(), (0, 3))
        self.assertEqual(self.merge(), (0, 3), "it was merged twice")

    def test_a_part_that_was_rendered_again_is_merged_again(self):
        self.assertEqual(self.merge(), (0, 1))
        part = self.path / merging.part_files(self.farm, self.job)[0]
        later = part.stat().st_mtime + 100
        os.utime(part, (later, later))
        self.assertFalse(merging.is_written(self.farm, self.job))
        self.assertEqual(self.merge()[1], 2)


class MarksOfATask(Place):
    """A task marks the parts that its ledger calls done, by the last that is said of each."""

    def marked(self, above):
        """Which parts are marked where the jobs name them by a path that begins so."""
        self.eikon('cat > /dev/null; exit 1')
        names = [f"parts/box/{number:08d}-{number + 1:08d}.exr" for number in range(4)]
        said = [(0, "started"), (0, "done"), (1, "interrupted"), (2, "done"), (2, "started"), (2, "failed")]
        (self.path / "tasks/r0-00000.ledger").write_text("".join(json.dumps(
            {"job": f"render -o {above}{names[at]} --quiet", "outputs": [{"bytes": 1, "path": above + names[at]}], "seconds": 1.0,
             "state": state}, separators=(",", ":")) + "\n" for at, state in said))
        (self.path / "tasks/r0-00000.txt").write_text("".join(f"render --output={name} --quiet\n" for name in names))
        for name in names:
            (self.path / f"{name}.done").touch()
        (self.path / "node.sh").write_text("fail() { exit 3; }\n")
        self.run_script("name=r0-00000\n" + scripts.task_lines("--quiet"))
        return [number for number, name in enumerate(names) if (self.path / f"{name}.done").exists()]

    def test_only_what_is_done_is_marked(self):
        self.assertEqual(self.marked(""), [0])
        self.assertEqual(self.marked("/scenes/box.farm/"), [0])

    def test_a_path_that_json_writes_otherwise_is_marked_too(self):
        self.assertEqual(self.marked('/my "best"/box.farm/'), [0])
        self.assertEqual(self.marked("a\\b\\/box.farm/"), [0])


class EndOfATask(Place):
    """TERM comes again and again when a task is cancelled."""

    def test_eikon_is_told_once_and_its_parts_are_marked(self):
        part = "parts/box/00000000-00000001.exr"
        entry = json.dumps({"outputs": [{"path": part}], "state": "done"}, separators=(",", ":"))
        # Like eikon, it saves when it is told to end, and saves nothing when it is told once more.
        self.eikon(f"""told=0
trap 'told=$((told + 1)); echo "told $told"' TERM
echo begun > "{self.path}/begun"
while [ $told = 0 ]; do sleep 0.05; done
for i in $(seq 30); do sleep 0.05; done
[ $told = 1 ] && echo '{entry}' >> "{self.path}/tasks/r0-00000.ledger"
exit 143""")
        (self.path / "tasks/r0-00000.txt").write_text(f"render --output={part} --quiet\n")
        (self.path / "node.sh").write_text("fail() { exit 3; }\n")
        # Marking takes a moment, in which TERM comes once more.
        (self.path / "sed").write_text('#!/bin/bash\nsleep 0.5; PATH="${PATH#*:}"; exec sed "$@"\n')
        (self.path / "sed").chmod(0o755)
        text = (f'farm={self.path}; base={self.path}; eikon="$farm/eikon"; PATH="$farm:$PATH"; name=r0-00000\n'
                + scripts.task_lines("--quiet"))
        with subprocess.Popen(["bash", "-c", text], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
            while not (self.path / "begun").exists():
                time.sleep(0.02)
            while process.poll() is None:
                process.terminate()
                time.sleep(0.2)
            said = process.stdout.read()
        self.assertEqual(said.count("told"), 1, said)
        self.assertTrue((self.path / f"{part}.done").exists(), said)


class Cancel(unittest.TestCase):
    """What Slurm is told when tasks are cancelled."""

    def test_term_is_sent_again_until_the_tasks_are_over(self):
        asked, queue = [], [{("7", 0): ("RUNNING", "n1", "")}] * 4 + [{}]
        with unittest.mock.patch.object(slurm, "states", lambda _: queue.pop(0) if len(queue) > 1 else queue[0]), \
                unittest.mock.patch.object(slurm, "REPEAT_TERM_S", 0.3), \
                unittest.mock.patch.object(slurm.subprocess, "run", lambda words, **_: asked.append(" ".join(words))):
            slurm.cancel(["7"])
        self.assertGreaterEqual(asked.count("scancel --batch --signal=TERM --state=RUNNING 7"), 2)
        self.assertEqual((asked[0], asked[-1]), ("scancel --state=PENDING 7", "scancel 7"))


class Arrays(Place):
    """What is asked of Slurm."""

    def submitted(self, count, throttle, refused_at=None):
        """The options of each array, of a cluster whose arrays have five tasks at most."""
        asked = []

        def answer(_script, *options, exports):
            if len(asked) == refused_at:
                raise errors.FarmError("sbatch refused")
            asked.append([option.removeprefix("--") for option in options])
            return f"{len(asked)}"

        job = jobs.Job(1, "box", [], [], [0, 1], "box.exr", "key", "box.gltf")
        farm = folder.Farm(self.path, {"throttle": throttle, "base": str(self.path), "lines": 1, "partition": "", "account": "",
                                       "threads": 1, "memory_mb": 1, "exclude": "", "sbatch": [], "eikon": "eikon"},
                           [job], jobs.Measured(1.0, 1.0, 1.0, 1.0, 1, [1, 1]))
        items = [folder.Item(job, "render", f"{number}.exr", "", 1.0) for number in range(count)]
        with unittest.mock.patch.object(slurm, "longest_array", return_value=5), \
                unittest.mock.patch.object(slurm, "submit", answer):
            try:
                submit.submit_round(farm, items)
            except errors.FarmError:
                asked.append("refused")
        return asked

    def test_the_throttle_is_that_of_all_arrays_together(self):
        self.assertEqual(self.submitted(12, 0), [["array=0-4"], ["array=0-4"], ["array=0-1"]])
        self.assertEqual(self.submitted(12, 7), [["array=0-4%2"], ["array=0-4%2"], ["array=0-1%2"]])
        self.assertEqual(self.submitted(12, 2), [["array=0-4%1"], ["array=0-4%1"], ["array=0-1%1", "dependency=afterany:1"]])

    def test_arrays_that_are_queued_are_known_when_the_next_one_is_refused(self):
        self.assertEqual(self.submitted(12, 0, refused_at=2)[-1], "refused")
        self.assertEqual(folder.load(self.path).rounds[0]["arrays"], [["1", 0, 5], ["2", 5, 5]])


class TimeLimit(unittest.TestCase):
    """The limit of a task's time."""

    def test_it_counts_the_lines_that_share_a_task(self):
        measured = jobs.Measured(100.0, 0.1, 0.0, 1.0, 1, [10, 10])
        frames = [jobs.Job(at, f"f{at}", [], [], [0, 60], f"{at}.exr", "key", "box.gltf", [10, 10]) for at in range(20)]
        limits = []
        for lines in (1, 20):
            settings = {"lines": lines, "minutes": 0, "parts": 0, "nodes": 1, "base": "/", "threads": 1, "checkpoint_every": 0}
            farm = folder.Farm(pathlib.Path("/farm"), settings, frames, measured)
            submit.settle(farm)
            limits.append(settings["minutes"])
        self.assertEqual(limits, [5, 61])


class Partitions(unittest.TestCase):
    """Where the nodes are looked for."""

    def test_the_default_is_that_of_slurm(self):
        with unittest.mock.patch.dict(os.environ), unittest.mock.patch.object(slurm, "run", return_value="long\nwork*\n") as run:
            os.environ.pop("SBATCH_PARTITION", None)
            self.assertEqual([slurm.choose_partition(name) for name in ("", None, "long", "long,work")],
                             ["work", "work", "long", "long,work"])
            run.return_value = "long\nwork\n"
            self.assertRaisesRegex(errors.FarmError, "no default partition: name one with --partition; there is long, work",
                                   slurm.choose_partition, "")
            self.assertRaisesRegex(errors.FarmError, "partition 'short' does not exist", slurm.choose_partition, "long,short")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
