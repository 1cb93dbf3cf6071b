#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The farm's policy, by itself and in simulated clusters of up to 10,000 nodes, and the script of a task, run without a cluster.
Needs neither eikon nor Slurm."""
import contextlib
import io
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import types
import unittest
import unittest.mock

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
from farm import errors, folder, jobs, nodes, planning, policy, scripts, simulate  # noqa: E402


class Constants(unittest.TestCase):
    """Numbers of eikon that the farm repeats."""

    def test_they_are_those_of_eikon(self):
        host = pathlib.Path(__file__).resolve().parents[2] / "host"
        for file, name, expected in (("render/pilot/pilot.cpp", "kPathsPerPixel", jobs.PILOT_PATHS_PER_PIXEL),
                                     ("render/pilot/pilot.h", "kMaxPilotPaths", jobs.MOST_PILOT_PATHS),
                                     ("job/checkpoint.h", "every_s", folder.USUAL_CHECKPOINT_S)):
            value, shift = re.search(name + r" = (\d+)U?(?: << (\d+))?;", (host / file).read_text()).groups()
            self.assertEqual(int(value) << int(shift or 0), expected, name)


class Folder(unittest.TestCase):
    """What the farm's folder tells of tasks, and what Slurm is asked for."""

    def test_the_tenth_round_comes_after_the_ninth(self):
        with tempfile.TemporaryDirectory() as space:
            tasks = pathlib.Path(space) / "tasks"
            tasks.mkdir()
            for name, state in (("r9-00000", "failed"), ("r10-00000", "done")):
                (tasks / f"{name}.ledger").write_text(f'{{"state": "{state}", "outputs": [{{"path": "a.exr"}}]}}\n')
            last = folder.Farm.ledger(types.SimpleNamespace(path=pathlib.Path(space)))
            self.assertEqual(last["a.exr"]["state"], "done")

    def test_the_name_of_a_job_has_no_blank(self):
        farm = types.SimpleNamespace(path=pathlib.Path("/scenes/my scene.farm"), excluded="",
                                     settings={"partition": "", "account": "", "threads": 1, "memory_mb": 100})
        self.assertEqual(scripts.job_options(farm, "tasks")["job-name"], "eikon-tasks-my_scene")

    def test_a_busy_node_stays_busy_while_another_one_compiles(self):
        queue = [{(1, 0): ("PENDING",), (2, 0): ("RUNNING",)}, {(2, 0): ("RUNNING",)}, {}]
        with tempfile.TemporaryDirectory() as space, unittest.mock.patch.object(nodes, "ASK_SLURM_S", 0.01), \
                unittest.mock.patch.object(nodes.slurm, "states", lambda ids: queue.pop(0) if len(queue) > 1 else queue[0]), \
                unittest.mock.patch.object(nodes.slurm, "cancel"):
            self.assertEqual(nodes.wait_for_probes(pathlib.Path(space), {"busy": 1, "slow": 2}, 0.0), {"busy"})

    def waited(self, *reasons):
        """(nodes that are busy, those that are left) where the probe of node n0, n1, ... waits for these reasons, or is over."""
        queue = {(at, 0): ("PENDING", "", reason) for at, reason in enumerate(reasons) if reason}
        probes = {f"n{at}": at for at in range(len(reasons))}
        with tempfile.TemporaryDirectory() as space, unittest.mock.patch.object(nodes, "ASK_SLURM_S", 0.01), \
                unittest.mock.patch.object(nodes.slurm, "states", lambda ids: queue), \
                unittest.mock.patch.object(nodes.slurm, "cancel") as cancel, unittest.mock.patch.object(nodes.sys, "stderr"):
            try:
                return nodes.wait_for_probes(pathlib.Path(space), probes, 0.0), set(probes)
            finally:
                self.assertEqual(cancel.called, any(reasons))

    def test_nodes_that_can_never_run_a_task_are_not_called_busy(self):
        self.assertRaisesRegex(errors.FarmError, r"\(n1: JobHeldUser; n0, n2: PartitionConfig\): ask for less with --cpus",
                               self.waited, "PartitionConfig", "JobHeldUser", "PartitionConfig")
        self.assertRaisesRegex(errors.FarmError, "QOSMaxCpuPerJobLimit", self.waited, "QOSMaxCpuPerJobLimit")
        self.assertEqual(self.waited("Resources", "PartitionConfig", None), ({"n0"}, {"n0", "n2"}))
        for reason in ("Priority", "None", "QOSMaxJobsPerUserLimit", "ReqNodeNotAvail, UnavailableNodes:n0"):
            self.assertEqual(self.waited(reason), ({"n0"}, {"n0"}))


class Parts(unittest.TestCase):
    """How images are divided."""

    def test_startup_is_at_most_a_tenth_of_the_smallest_part(self):
        for samples in (1, 7, 64, 1000):
            for work_s in (0.1, 10.0, 1e4):
                for startup_s in (0.01, 1.0, 30.0):
                    parts = policy.parts_of(samples, work_s, startup_s, 1000)
                    smallest = min(end - begin for begin, end in policy.divide(0, samples, parts)) * work_s / samples
                    if parts > 1:
                        self.assertLessEqual(startup_s, 0.1 * (startup_s + smallest) * (1 + 1e-9))

    def test_ranges_cover_all_samples_once(self):
        for count in (1, 2, 3, 64, 65):
            ranges = policy.divide(5, 70, count)
            self.assertEqual((ranges[0][0], ranges[-1][1], len(ranges)), (5, 70, count))
            self.assertTrue(all(a[1] == b[0] for a, b in zip(ranges, ranges[1:])))
            lengths = [end - begin for begin, end in ranges]
            self.assertLessEqual(max(lengths) - min(lengths), 1)

    def test_short_images_share_a_task_until_startup_is_a_tenth(self):
        seconds = [0.5] * 1000
        tasks = policy.group(seconds, 1.0, 10)
        self.assertEqual([member for task in tasks for member in task], list(range(1000)))
        self.assertTrue(all(sum(seconds[m] for m in task) >= 9.0 for task in tasks[:-1]))
        self.assertEqual(policy.group([100.0] * 5, 1.0, 10), [[0], [1], [2], [3], [4]])

    def test_a_tree_of_merges_reads_every_part_once(self):
        for parts in (1, 2, 64, 65, 4096, 4097, 10000):
            below = parts
            for merges in policy.merge_tree(parts):
                self.assertEqual([number for begin, end in merges for number in range(begin, end)], list(range(below)))
                self.assertTrue(all(end - begin <= policy.MERGE_FAN_IN for begin, end in merges))
                below = len(merges)
            self.assertEqual(below, 1)

    def test_wrong_flags_are_not_tried_again_and_killed_tasks_are(self):
        self.assertEqual(policy.after(0, 1), "done")
        self.assertEqual(policy.after(2, 1), "failed")
        self.assertEqual([policy.after(137, tries) for tries in (1, 2, 3)], ["again", "again", "failed"])
        self.assertEqual([policy.after(4, tries) for tries in (1, 2, 3)], ["again", "again", "failed"])

    def test_one_node_gets_an_image_in_one_part(self):
        self.assertEqual(policy.parts_of(4096, 1000.0, 1.0, 1, 0.5), 1)
        self.assertGreater(policy.parts_of(4096, 100 * policy.LONGEST_TASK_S, 1.0, 1, 0.5), 50)

    def test_nodes_go_where_the_work_is(self):
        # One image is as large as the other 49 together.
        counts = policy.parts_of_images([4096] * 50, [49000.0] + [1000.0] * 49, 1.0, 100, [0.1] * 50)
        self.assertGreaterEqual(counts[0], 49)
        self.assertEqual(policy.parts_of_images([4096] * 8, [1000.0] * 8, 1.0, 2, [0.1] * 8), [1] * 8)
        self.assertEqual(policy.parts_of_images([4096], [1000.0], 1.0, 1, [0.1]), [1])

    def test_parts_that_cost_much_leave_nodes_idle(self):
        # Merging a part takes nearly as long as 2 s of rendering on each of 64 nodes.
        self.assertLess(policy.parts_of(4096, 140.0, 0.1, 64, 0.5), 32)

    def job(self, part, size):
        return jobs.Job(line=1, name="a", words=[], part=part, samples=[0, 64], output="a.exr", key="", scene="a.gltf", size=size)

    def test_a_smaller_picture_of_the_view_is_measured(self):
        words, pixels = jobs.smaller(self.job(["a.gltf", "--size=1280x720", "--fov=30"], [1280, 720]))
        self.assertEqual(words, ["a.gltf", "--fov=30", "--size=341x192"])
        self.assertEqual(pixels, 341 * 192)
        for part, size in ((["a.gltf"], None), (["a.gltf", "--size=320x320"], [320, 320]),
                           (["a.gltf", "--size=1280x720", "--crop=0,0,9,9"], [1280, 720])):
            self.assertEqual(jobs.smaller(self.job(part, size))[0], part)

    def test_what_was_measured_is_told_for_the_whole_picture(self):
        said = {"seconds": {"first_sample": 1.0, "render": 0.5, "write": 0.1}, "size": [320, 180], "samples": 500000,
                "pilot": {"seconds": 0.5, "paths": 115200}, "film_bytes": 5000000}
        job = self.job(["a.gltf", "--size=1280x720"], [1280, 720])
        whole = jobs.measured_of(said, 2.0, 100.0, 1000, job)
        self.assertEqual((whole.size, whole.part_bytes, whole.samples_per_second), ([1280, 720], 16000, 1e6))
        self.assertAlmostEqual(whole.startup_s, 1.0 + (jobs.MOST_PILOT_PATHS - 115200) * 1e-6)
        self.assertAlmostEqual(whole.finish_s, 0.5 + 15 * 0.1)
        self.assertAlmostEqual(whole.peak_mb, 100 + jobs.FILM_COPIES * 15 * 5)
        same = jobs.measured_of(said, 2.0, 100.0, 1000, self.job([], [320, 180]))
        self.assertEqual((same.startup_s, same.peak_mb, same.part_bytes), (1.0, 100.0, 1000))

    def test_words_without_some_flags(self):
        words = ["a.gltf", "--checkpoint", "x", "--resume", "--checkpoint-every=3", "-o", "b"]
        self.assertEqual(jobs.without(words, {"--checkpoint": True, "--checkpoint-every": True, "--resume": False}),
                         ["a.gltf", "-o", "b"])


WORK = simulate.Work([36000.0], 65536, 2.0, 35.0, 0.3)


class Clusters(unittest.TestCase):
    """Simulated submissions."""

    def test_one_node_without_failures_takes_the_sum(self):
        work = simulate.Work([1000.0], 64, 1.0)
        out = simulate.simulate(work, simulate.Cluster(1, launches_per_s=1e9))
        self.assertAlmostEqual(out.seconds - out.merge_s, 1000.0 + out.tasks * 1.0, delta=1e-3)
        self.assertEqual(out.failed, 0)

    def test_what_is_rendered_is_the_work_whatever_happens(self):
        for nodes in (1, 10, 1000, 10000):
            out = simulate.simulate(WORK, simulate.Cluster(nodes, failures_per_hour=1, preemptions_per_hour=2, errors=0.01))
            if out.failed == 0:
                self.assertAlmostEqual(out.rendered_s, 36000.0, delta=36.0)
            self.assertGreaterEqual(out.starts, out.tasks)
            self.assertLessEqual(out.failed, 0.001 * out.parts)

    def test_speeds_that_differ_keep_the_nodes_busy(self):
        even = simulate.simulate(WORK, simulate.Cluster(50))
        uneven = simulate.simulate(WORK, simulate.Cluster(50, spread=0.5))
        self.assertLess(uneven.seconds, 1.4 * even.seconds)

    def test_a_slow_disk_limits_and_is_named(self):
        fast = simulate.simulate(WORK, simulate.Cluster(500, disk_mb_s=1e6))
        slow = simulate.simulate(WORK, simulate.Cluster(500, disk_mb_s=50))
        self.assertGreater(slow.seconds, 5 * fast.seconds)
        self.assertIn(slow.limit(500), ("the file system", "the merge"))
        self.assertEqual(simulate.simulate(simulate.Work([36000.0], 65536, 0.001), simulate.Cluster(1)).limit(1), "nothing: rendering")

    def test_more_nodes_are_never_worth_it_for_nothing(self):
        rows = [{"nodes": nodes, "seconds": seconds, "done": True}
                for nodes, seconds in ((1, 100), (2, 51), (4, 27), (8, 25), (16, 12))]
        self.assertEqual(planning.nodes_worth_it(rows), 4)
        rows[1]["done"] = False
        self.assertEqual(planning.nodes_worth_it(rows), 1)
        rows[0]["done"] = False
        self.assertEqual(planning.nodes_worth_it(rows), 0)

    def test_an_image_of_which_parts_fail_is_not_done(self):
        out = simulate.simulate(WORK, simulate.Cluster(64, errors=0.9))
        self.assertGreater(out.failed, out.parts // 2)
        self.assertFalse(out.is_done())
        self.assertEqual(out.limit(64), f"{out.failed} of {out.parts} parts failed")
        options = types.SimpleNamespace(most=2, spread=0.0, failures=0.0, preemptions=0.0, errors=0.9, disk=1000.0, seed=1)
        with contextlib.redirect_stdout(io.StringIO()) as said:
            planning.print_table(planning.table_of(WORK, options))
        self.assertRegex(said.getvalue(), r"\n +2 +not done +- +10 +[1-9]\d* +10 .* of 10 parts failed\n")

    def test_a_cluster_that_finishes_nothing_has_an_end(self):
        out = simulate.simulate(WORK, simulate.Cluster(16, failures_per_hour=1000.0))
        self.assertEqual((out.unfinished, out.failed, out.is_done()), (out.parts, 0, False))
        self.assertIn("parts unfinished", out.limit(16))
        self.assertEqual(simulate.simulate(WORK, simulate.Cluster(16, failures_per_hour=1.0)).unfinished, 0)

    def test_more_nodes_are_no_slower(self):
        few = [10 ** (at * 4.5 / 49) for at in range(50)]  # seconds of images of all sizes
        for work in (simulate.Work(few, 3, 1.0, 10.0, 0.01), simulate.Work(few, 16, 0.4, 1.0, 0.01),
                     simulate.Work([140.0], 450, 0.1, 0.2, 0.3), simulate.Work([8.0, 16.0, 2300.0], 5779, 4.0, 2.0, 0.8)):
            before = math.inf
            for power in range(9):
                took = simulate.simulate(work, simulate.Cluster(2 ** power)).seconds
                self.assertLess(took, 1.05 * before + 0.5, (work, 2 ** power))
                before = took

    def test_the_same_seed_gives_the_same_cluster(self):
        cluster = simulate.Cluster(100, spread=0.3, failures_per_hour=3, errors=0.05, seed=7)
        self.assertEqual(simulate.simulate(WORK, cluster), simulate.simulate(WORK, cluster))


class TaskScript(unittest.TestCase):
    """The script of a task, with programs in the places of eikon and of Slurm's scontrol."""

    EIKON = "#!/bin/bash\necho begun >> {folder}/begun\ntrap 'echo saved; exit 143' TERM\nfor i in $(seq {tenths}); do sleep 0.1; done\n"

    def run_task(self, eikon_s, node_s=0.0, warn_after_s=1):
        """Runs a task of so many seconds, on a node that takes so long to look at. Returns (its log, what scontrol was asked,
        how often eikon began)."""
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for inside in ("logs", "tasks", "bin"):
                (folder / inside).mkdir()
            for end in ("txt", "checkpoints", "merges"):
                (folder / f"tasks/r0-00000.{end}").touch()
            (folder / "node.sh").write_text(f"fail() {{ exit 3; }}\nsleep {node_s}\n")
            # Slurm ends a task that is queued again.
            programs = {"eikon": self.EIKON.format(folder=folder, tenths=int(10 * eikon_s)),
                        "bin/scontrol": f'#!/bin/bash\necho "$*" >> {folder}/asked\nkill -KILL $PPID\n'}
            for program, text in programs.items():
                (folder / program).write_text(text)
                (folder / program).chmod(0o755)
            settings = {"partition": "", "account": "", "threads": 1, "memory_mb": 0, "gres": "", "minutes": 2, "signal_s": 90,
                        "sbatch": [], "eikon": str(folder / "eikon")}
            farm = types.SimpleNamespace(path=folder, base=name, excluded="", settings=settings)
            with unittest.mock.patch.object(policy, "warn_after_s", return_value=warn_after_s):
                text = scripts.task_script(farm)
            environment = {**os.environ, "PATH": f"{folder}/bin:{os.environ['PATH']}", "EIKON_ROUND": "0", "EIKON_OFFSET": "0",
                           "SLURM_ARRAY_TASK_ID": "0", "SLURM_ARRAY_JOB_ID": "7"}
            with subprocess.Popen(["bash", "-c", text], env=environment, start_new_session=True) as process:
                process.wait(60)
            if not (folder / "asked").exists():
                self.no_process_is_left(process.pid)
            read = [(folder / file).read_text() if (folder / file).exists() else "" for file in ("logs/r0-00000.log", "asked", "begun")]
            return read[0], read[1].strip(), read[2].count("begun")

    def no_process_is_left(self, group):
        for _ in range(50):
            try:
                os.killpg(group, 0)
            except ProcessLookupError:
                return
            time.sleep(0.1)
        self.fail("the script has ended, and something that it began has not")

    def test_it_warns_itself_before_its_limit(self):
        log, asked, begun = self.run_task(eikon_s=30)
        self.assertEqual((asked, begun), ("requeue 7_0", 1), log)
        self.assertRegex(log, "saved\\n(.|\\n)*saved before the time limit, and queued again")

    def test_warned_while_it_looks_at_the_node_it_begins_nothing(self):
        log, asked, begun = self.run_task(eikon_s=30, node_s=3)
        self.assertEqual((asked, begun), ("requeue 7_0", 0), log)

    def test_done_in_time_it_leaves_no_process_behind(self):
        log, asked, begun = self.run_task(eikon_s=0.2, warn_after_s=30)
        self.assertEqual((asked, begun), ("", 1), log)
        self.assertIn("ended with exit code 0", log)

    def test_a_task_has_half_of_its_time_before_it_is_warned(self):
        self.assertEqual(policy.warn_after_s(10, 90), 510)
        self.assertEqual(policy.warn_after_s(2, 90), 60)
        self.assertEqual(policy.warn_after_s(1, 3600), 30)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
