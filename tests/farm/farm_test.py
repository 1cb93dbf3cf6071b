#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""eikon-farm on a real Slurm of two one-core nodes on this machine (tools/common/slurm_cluster.py).

  tests/farm/farm_test.py EIKON [unittest's words]

Classes run in alphabetical order, which their first letters give. Slurm lets no task have less than a minute, and a task that runs
into its limit takes longer: B submits one, C and D pass that time on the same cluster, and E checks what became of it. E alone
fails. Exit code 77, skipped, where Slurm cannot be started. Node n2 does not see the folder `hidden`, if mounts are allowed."""
import atexit
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
import unittest
import unittest.mock

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))
from common import slurm_cluster  # noqa: E402

COMMAND = ROOT / "tools/eikon-farm"
CORNELL = ROOT / "scenes/cornell.gltf"


def setUpModule():
    """One cluster for all tests, and a job in it that runs into its time limit while the others are tested."""
    global space, slurm, begin_times
    begin_times = {}  # {job: since when it waits to be started again}
    space = pathlib.Path(tempfile.mkdtemp(prefix="eikon_farm_"))
    (space / "hidden").mkdir()
    can_mount = subprocess.run(["unshare", "--mount", "true"], capture_output=True, check=False).returncode == 0
    slurm = slurm_cluster.Cluster(space / "hidden" if can_mount else None)
    atexit.register(shutil.rmtree, space, ignore_errors=True)  # an interrupted test does no cleanup of its own
    unittest.addModuleCleanup(slurm.stop)
    slurm.__enter__()
    slurm.environment["EIKON_NODE_CACHE"] = str(space / "node_cache")


def farm(*words, environment=None, folder=None):
    """Runs eikon-farm, and returns (exit code, what it printed, what it said on stderr)."""
    run = subprocess.run([COMMAND, *map(str, words)], env=environment or slurm.environment, cwd=folder or space,
                         capture_output=True, text=True, check=False)
    return run.returncode, run.stdout, run.stderr


def submit(name, *words, program=None, **more):
    """Submits jobs into the folder `name`, without a long measured run."""
    return farm("submit", *words, "--folder", space / name, "--eikon", program or eikon, "--measure", "0.1", **more)


def queue(name):
    """The states of what a farm has in the queue."""
    ours = [line.split("|") for line in slurm.run("squeue", "-h", "-r", "-o", "%T|%j|%r|%F_%K").splitlines()]
    ours = [line for line in ours if line[1].endswith(f"-{name}")]
    for state, _, reason, job in ours:
        # Slurm lets a task wait for two minutes before it starts it again. Three seconds are enough
        # for what the old one still has to say, which would else count as said by the new one.
        if state == "PENDING" and reason == "BeginTime":
            began = begin_times.setdefault(job, time.monotonic())
            if time.monotonic() - began > 3:
                slurm.run("scontrol", "update", f"JobId={job}", "StartTime=now")
        else:
            begin_times.pop(job, None)
    return [line[0] for line in ours]


def wait(name, seconds=120):
    """Until Slurm has nothing of a farm in its queue any more."""
    slurm_cluster.wait_until(lambda: not queue(name), seconds, f"the end of {name}")


def ledger(name):
    """Every event of a farm's ledgers."""
    return [json.loads(line) for file in sorted((space / name / "tasks").glob("*.ledger"))
            for line in file.read_text().splitlines()]


def done_entries(name):
    """The events of outputs that were finished, each once."""
    lines = {json.dumps(entry) for entry in ledger(name) if entry["state"] == "done"}  # a new round repeats old ones
    return [json.loads(line) for line in lines]


class FarmTest(unittest.TestCase):
    """Claims about images and refusals."""

    maxDiff = None

    def same_bits(self, image, *words):
        """Fails unless the image is that of an undivided render."""
        reference = space / f"reference{len(list(space.glob('reference*')))}.exr"
        subprocess.run([eikon, "render", *map(str, words), "-o", reference, "--quiet"], check=True, capture_output=True)
        said = subprocess.run([eikon, "compare", image, reference], check=True, capture_output=True, text=True).stdout
        self.assertIn("MSE 0.000000e+00", said)

    def process(self, name):
        """The number of an eikon process that renders for a farm."""
        def find():
            for entry in pathlib.Path("/proc").iterdir():
                if entry.name.isdigit():
                    try:
                        words = (entry / "cmdline").read_bytes().decode(errors="replace").split("\0")
                    except OSError:
                        continue
                    if words[1:3] == ["batch", "-"] and any(f"/{name}/tasks/" in word for word in words):
                        return int(entry.name)
            return None
        return slurm_cluster.wait_until(find, 30, "a process that renders")

    def program(self, name, condition, command):
        """A script that is eikon, but first runs a command where a condition holds."""
        path = space / name
        path.write_text(f'#!/bin/sh\n{condition} && {command}\nexec "{eikon}" "$@"\n')
        path.chmod(0o755)
        return path

    def slow_program(self, name, factor):
        """(a program that is eikon on a device that is so many times slower, a file: without it the device has its speed). What is to be
        interrupted is slow until then, so that it is not over before, and takes few samples."""
        switch = space / f"{name}_is_slow"
        switch.touch()
        return self.program(name, f'[ "$1" = batch ] && [ -e "{switch}" ]', f"export EIKON_FAULT=device:0:slow={factor}"), switch

    def refused(self, result, code, pattern):
        """Fails unless a command ended with a code and one line."""
        self.assertEqual(result[0], code, result)
        self.assertRegex(result[2], pattern)
        self.assertEqual(result[2].count("\n"), 1, result[2])


class A_Refusals(FarmTest):
    def test_no_slurm(self):
        bare = space / "bare"
        bare.mkdir()
        (bare / "python3").symlink_to(sys.executable)
        self.refused(submit("none", CORNELL, environment=dict(os.environ, PATH=str(bare))), 3, "there is no Slurm here")

    def test_unknown_partition(self):
        self.refused(submit("none", CORNELL, "--partition", "nowhere"), 2, "partition 'nowhere' does not exist; there is other, work")
        self.refused(submit("none", CORNELL, "--sbatch", "-p other"), 2, "a partition is named by --partition")

    def test_wrong_lines(self):
        self.refused(submit("none", CORNELL, "--wrong"), 2, "nothing was submitted")
        self.refused(submit("none", space / "absent.gltf"), 3, "no such file")
        self.refused(farm("status", space / "none"), 3, "no farm was submitted here")

    def test_dry_run_prints_scripts_and_writes_nothing(self):
        code, said, wrong = submit("dry", CORNELL, "--size", "64x64", "--spp", 8, "--parts", 4, "--dry-run", "--gres", "gpu:1")
        self.assertEqual(code, 0, wrong)
        for text in ("#SBATCH --requeue", "#SBATCH --gres=gpu:1", "#SBATCH --signal=B:USR1@90", "--samples=2:4", "scontrol requeue"):
            self.assertIn(text, said)
        self.assertFalse((space / "dry").exists())
        for script in re.findall(r"(#!/bin/bash\n.*?)(?=\n\n# /)", said, re.DOTALL):
            self.assertEqual(subprocess.run(["bash", "-n"], input=script, text=True, check=False).returncode, 0, script)

    def wrapper(self, name, node, word, reply):
        """A program that is eikon, but for one answer on one node."""
        return self.program(name, f'[ "$SLURMD_NODENAME $1" = "{node} {word}" ]', f'{{ echo "{reply}"; exit 0; }}')

    def test_versions_and_arithmetic_that_differ(self):
        other = self.wrapper("eikon_version", "n2", "--version", "eikon 9.9.9")
        result = farm("submit", CORNELL, "--size", "32x32", "--spp", 4, "--folder", space / "version", "--eikon", other, "--measure", 0.1)
        self.refused(result, 3, r"nodes have different versions of eikon.*'eikon 9.9.9' on n2")
        other = self.wrapper("eikon_arithmetic", "n2", "devices", "   arithmetic fused")
        result = farm("submit", CORNELL, "--size", "32x32", "--spp", 4, "--folder", space / "arithmetic", "--eikon", other, "--measure", 0.1)
        self.refused(result, 3, r"different classes of arithmetic.*'fused' on n2")

    def test_a_folder_that_is_not_shared(self):
        if not slurm.hidden:
            self.skipTest("not allowed to mount")
        self.refused(submit("hidden/farm", CORNELL, "--size", "32x32", "--spp", 4), 3, "node n2 does not share this folder")


class B_LimitBegins(FarmTest):
    def test_a_task_that_will_run_into_its_limit_begins(self):
        # Slurm looks every 30 s for tasks to warn, and may warn this one in vain before its script
        # runs. The script warns itself after half of the minute. Until then its device is so slow
        # that no processor comes to the end.
        slow = self.program("eikon_limit", '[ "$1$SLURM_RESTART_COUNT" = batch ]', "export EIKON_FAULT=device:0:slow=60")
        code, said, wrong = submit("limit", CORNELL, "-o", "limit.exr", "--size", "128x128", "--spp", LIMIT_SPP, "--parts", 1,
                                   "--minutes", 1, "--signal", 30, "--exclude", "n2", "--checkpoint-every", 0.5, program=slow)
        self.assertEqual(code, 0, said + wrong)


LIMIT_SPP = 1000


class C_Whole(FarmTest):
    def test_eight_parts_of_which_one_is_killed_have_the_bits_of_one_render(self):
        words = ["--size", "128x128", "--spp", "400"]  # as large as a picture must be to have a pilot
        slow, switch = self.slow_program("eikon_eight", 20)
        code, said, wrong = submit("eight", CORNELL, "-o", "eight.exr", "--png", "eight.png", *words, "--parts", 8, "--lines", 1,
                                   "--checkpoint-every", 0.02, "--exclude", "n1", program=slow)
        self.assertEqual(code, 0, said + wrong)
        process = self.process("eight")
        slurm_cluster.wait_until(lambda: list((space / "eight/checkpoints").glob("*.exr")), 30, "a checkpoint")
        switch.unlink()
        os.kill(process, signal.SIGKILL)
        slurm_cluster.wait_until(lambda: "137" in "".join(file.read_text() for file in (space / "eight/logs").glob("r0*")),
                                 20, "the kill")
        code, said, _ = farm("status", space / "eight")
        self.assertRegex(said, r"8 parts: \d done, \d running")
        wait("eight")
        code, said, wrong = farm("status", space / "eight")
        self.assertEqual(code, 0, said + wrong)
        self.assertIn("8 done, 0 running, 0 waiting, 0 failed", said)
        self.assertRegex(said, r"eight +8 +8 +0 +0 +\d\.\d+e-")
        done = done_entries("eight")
        self.assertEqual(len(done), 8, "a part was rendered twice, or not at all")
        samples = sorted(entry["samples"] for entry in done)
        self.assertEqual(samples[1:], [50 * 128 * 128] * 7)
        self.assertLess(samples[0], samples[1], "the killed part began anew instead of from its checkpoint")
        self.same_bits(space / "eight.exr", CORNELL, *words)
        self.assertEqual(len(list((space / "eight/pilots").iterdir())), 1, "the parts do not share a pilot")
        self.assertTrue((space / "eight.png").exists())
        self.assertEqual(list((space / "eight/checkpoints").iterdir()), [], "checkpoints were left behind")
        self.assertIn("nothing was submitted", farm("resubmit", space / "eight")[1])

    def test_twelve_frames_are_cancelled_and_continued(self):
        (space / "frames.txt").write_text("".join(
            f"render {CORNELL} -o frame{i:02d}.exr --size 64x64 --spp 300 --look-at 0.278,0.27,{-0.8 - 0.01 * i}:0.278,0.27,0\n"
            for i in range(12)))
        slow, switch = self.slow_program("eikon_frames", 4)
        code, said, wrong = submit("frames", space / "frames.txt", "--parts", 1, "--lines", 2, "--exclude", "n1",
                                   "--checkpoint-every", 0.03, program=slow)
        self.assertEqual(code, 0, said + wrong)
        slurm_cluster.wait_until(lambda: len(done_entries("frames")) >= 3, 60, "three frames")
        self.assertEqual(farm("cancel", space / "frames")[0], 0)
        switch.unlink()
        wait("frames", 20)
        code, said, _ = farm("status", space / "frames")
        self.assertEqual(code, 1)
        self.assertRegex(said, r"failed: .*frame11.exr: it was never begun; log: .*r0-00005.log")
        code, said, wrong = farm("resubmit", space / "frames")
        self.assertEqual(code, 0, said + wrong)
        wait("frames")
        self.assertIn("12 done, 0 running, 0 waiting, 0 failed", farm("status", space / "frames")[1])
        self.assertEqual(len(done_entries("frames")), 12, "a frame was rendered twice")
        # A saved task goes on where it was: nothing is rendered twice.
        for output in {entry["outputs"][0]["path"] for entry in ledger("frames")}:
            events = {json.dumps(e): e for e in ledger("frames") if e["outputs"][0]["path"] == output}.values()
            self.assertEqual(sum(e["samples"] for e in events if e["state"] in ("done", "interrupted")), 300 * 64 * 64, output)
        # One line changes: one frame is rendered again.
        text = (space / "frames.txt").read_text().replace("-o frame05.exr --size 64x64 --spp 300", "-o frame05.exr --size 64x64 --spp 8")
        (space / "frames.txt").write_text(text)
        self.assertIn("submitted 1 tasks of 1 parts; the other 11", farm("resubmit", space / "frames")[1])
        wait("frames")
        self.assertEqual(len(done_entries("frames")), 13)
        self.same_bits(space / "frame05.exr", CORNELL, "--size", "64x64", "--spp", "8", "--look-at",
                       f"0.278,0.27,{-0.8 - 0.01 * 5}:0.278,0.27,0")


    def test_a_part_that_was_half_done_is_not_merged_and_goes_on(self):
        words = ["--size", "64x64", "--spp", "1200"]
        slow, switch = self.slow_program("eikon_half", 30)
        code, said, wrong = submit("half", CORNELL, "-o", "half.exr", *words, "--parts", 2, "--lines", 1, "--exclude", "n1",
                                   program=slow)
        self.assertEqual(code, 0, said + wrong)
        self.process("half")
        slurm_cluster.wait_until(lambda: ledger("half"), 20, "the start of a part")
        time.sleep(1)
        self.assertEqual(farm("cancel", space / "half")[0], 0)
        switch.unlink()
        wait("half", 20)
        parts = space / "half/parts/half"
        self.assertEqual([file.name for file in parts.iterdir()], ["00000000-00000600.exr"])
        self.assertFalse((space / "half.exr").exists())
        self.assertIn("submitted 2 tasks", farm("resubmit", space / "half")[1])
        wait("half")
        events = {json.dumps(event): event for event in ledger("half")}.values()
        samples = [event["samples"] for event in events if event["state"] in ("done", "interrupted")]
        self.assertEqual((len(samples), sum(samples)), (3, 1200 * 64 * 64), "samples were lost, or rendered twice")
        self.same_bits(space / "half.exr", CORNELL, *words)
        # A merge that was killed after it had written the picture, and before all else that was
        # asked for.
        self.assertEqual(farm("status", space / "half")[0], 0)
        (parts / "picture.done").unlink()
        code, said, _ = farm("status", space / "half")
        self.assertEqual(code, 1)
        self.assertRegex(said, r"not written: half.exr: its parts are done, but .*; log: .*/half/logs/merge-0-00000.log")
        self.assertIn("submitted 1 merge of 1 image; no part is to be rendered", farm("resubmit", space / "half")[1])
        wait("half")
        self.assertEqual(farm("status", space / "half")[0], 0)

    def test_a_node_that_has_the_kernels_of_a_job_gives_them_to_others_without_compiling(self):
        lists = []
        for name in ("cold", "warm"):
            code, said, wrong = submit(name, CORNELL, "-o", f"{name}.exr", "--size", "16x16", "--spp", 4)
            self.assertEqual(code, 0, said + wrong)
            archive = next((space / name / "kernels").glob("*.tar"))
            self.assertGreater(archive.stat().st_size, 20000)
            with tarfile.open(archive) as packed:
                self.assertTrue(any(file.startswith("./eikon/") for file in packed.getnames()), packed.getnames())
            key = re.search(r'jobs/([0-9a-f]{16})-', (space / name / "probe.sh").read_text())[1]
            lists.append({file: file.stat().st_mtime_ns for file in (space / "node_cache").glob("*.jobs/*") if key in file.name})
            wait(name)
        self.assertEqual(len(lists[0]), 1)
        # A probe that renders writes the list of programs anew.
        self.assertEqual(lists[0], lists[1])

    def test_a_sequence_is_a_job_for_each_frame(self):
        words = [ROOT / "scenes/bending_arm.gltf", "--size", "48x32", "--spp", "8", "--shutter", "0.5"]
        frames = [*words, "-o", "arm_%02d.exr", "--frames", "0:20:4"]
        code, said, wrong = submit("arm", *frames, "--parts", 2, "--lines", 4)
        self.assertEqual(code, 0, said + wrong)
        self.assertIn("6 images in 12 parts", said)
        self.assertIn("submitted 3 tasks", said)
        wait("arm")
        code, said, _ = farm("status", space / "arm", "--no-error")
        self.assertEqual(code, 0, said)
        self.assertIn("6 images, 12 parts: 12 done, 0 running, 0 waiting, 0 failed", said)
        self.assertEqual(len(done_entries("arm")), 12, "a part was rendered twice, or not at all")
        self.assertEqual(sorted(file.name for file in space.glob("arm_*.exr")), [f"arm_{i:02d}.exr" for i in range(0, 21, 4)])
        for frame in (0, 16):
            self.same_bits(space / f"arm_{frame:02d}.exr", *words, "--frame", frame)
        self.assertIn("nothing was submitted", farm("resubmit", space / "arm")[1])

    def test_an_image_is_merged_when_it_is_done_and_not_when_all_are(self):
        words = ["--size", "64x64", "--spp", "66"]
        (space / "two.txt").write_text(f"render {CORNELL} -o sooner.exr {' '.join(words)}\n"
                                       f"render {CORNELL} -o later.exr --size 64x64 --spp 200\n")
        code, said, wrong = submit("two", space / "two.txt", "--parts", 66, "--lines", 33, "--exclude", "n1")
        self.assertEqual(code, 0, said + wrong)
        wait("two")
        logs = [(space / "two/logs" / f"r0-{task:05d}.log").read_text() for task in range(4)]
        last_began = float(re.search(r"^== at (\S+)", logs[3], re.MULTILINE)[1])
        self.assertLess((space / "sooner.exr").stat().st_mtime, last_began,
                        "it waited for the tasks of another image, or was merged once more behind them")
        self.assertNotIn("is tried again", "".join(logs))
        self.assertEqual(list((space / "two/parts").glob("*/*.lock")), [])
        self.same_bits(space / "sooner.exr", CORNELL, *words)


class D_Failures(FarmTest):
    def test_a_texture_that_one_node_lacks(self):
        if not slurm.hidden:
            self.skipTest("not allowed to mount")
        scene = json.loads((ROOT / "scenes/textured.gltf").read_text())
        for number, image in enumerate(scene["images"]):
            if "uri" in image and not image["uri"].startswith("data:"):
                shutil.copy(ROOT / "scenes" / image["uri"], space / "hidden" / f"{number}.png")
                image["uri"] = f"hidden/{number}.png"
        shutil.copy(ROOT / "scenes/sky.hdr", space)
        for buffer in scene.get("buffers", []):
            if not buffer["uri"].startswith("data:"):
                shutil.copy(ROOT / "scenes" / buffer["uri"], space)
        (space / "textured.gltf").write_text(json.dumps(scene))
        words = [space / "textured.gltf", "--size", "32x32", "--spp", "16"]
        code, said, wrong = submit("texture", *words, "-o", "texture.exr", "--parts", 4, "--lines", 1, "--probe-wait", 1)
        self.assertEqual(code, 0, said + wrong)
        wait("texture")
        code, said, _ = farm("status", space / "texture")
        self.assertEqual(code, 1)
        failed = [line for line in said.splitlines() if line.startswith("failed: ")]
        self.assertTrue(failed)
        for line in failed:
            self.assertRegex(line, r"texture/parts/.*\.exr: .*hidden/\d.png.*; log: .*/texture/logs/r0-\d+\.log")
            self.assertIn("on n2", pathlib.Path(line.split("log: ")[1]).read_text())
        self.assertFalse((space / "texture.exr").exists(), "an image of some of its samples looks like a whole one")
        code, said, wrong = farm("resubmit", space / "texture")
        self.assertEqual(code, 0, said + wrong)
        self.assertIn("without n2, where parts have failed", said)
        self.assertIn(f"submitted {len(failed)} tasks", said)
        wait("texture")
        self.assertEqual([log for log in (space / "texture/logs").glob("r1-*.log") if " on n2" in log.read_text()], [])
        self.assertEqual(len(done_entries("texture")), 4)
        self.same_bits(space / "texture.exr", *words)


class E_LimitEnds(FarmTest):
    def test_it_was_saved_before_its_limit_and_went_on(self):
        wait("limit", 300)
        log = (space / "limit/logs/r0-00000.log").read_text()
        self.assertIn("1 done, 0 running, 0 waiting, 0 failed", farm("status", space / "limit")[1], log)
        self.assertIn("saved before the time limit, and queued again", log)
        samples = [entry["samples"] for entry in ledger("limit") if entry["state"] in ("done", "interrupted")]
        self.assertGreaterEqual(len(samples), 2)
        self.assertEqual(sum(samples), LIMIT_SPP * 128 * 128, "samples were lost, or rendered twice")

    def test_a_node_that_is_drained_gives_its_tasks_to_the_other(self):
        words = ["--size", "64x64", "--spp", "600"]
        code, said, wrong = submit("drain", CORNELL, "-o", "drain.exr", *words, "--parts", 6, "--lines", 1)
        self.assertEqual(code, 0, said + wrong)
        self.process("drain")
        slurm.run("scontrol", "update", "NodeName=n2", "State=DRAIN", "Reason=test")
        try:
            wait("drain")
        finally:
            slurm.run("scontrol", "update", "NodeName=n2", "State=RESUME")
        self.assertEqual(len(done_entries("drain")), 6)
        self.same_bits(space / "drain.exr", CORNELL, *words)


class F_FullDisk(FarmTest):
    def test_a_full_disk_loses_nothing(self):
        disk = space / "disk"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "none", disk], capture_output=True, check=False).returncode:
            self.skipTest("not allowed to mount")
        self.addCleanup(subprocess.run, ["umount", "-l", disk], check=False)
        self.refused(submit("disk/large", CORNELL, "--size", "2000x2000", "--spp", 64, "--parts", 32), 3,
                     r"disk/large: the disk has 0.0\d GB left, parts and merges take about")
        words = ["--size", "64x64", "--spp", "600"]
        slow, switch = self.slow_program("eikon_full", 8)
        # Node n2 does not see this mount.
        code, said, wrong = submit("disk/farm", CORNELL, "-o", disk / "full.exr", *words, "--parts", 4, "--lines", 4, "--exclude", "n2",
                                   program=slow)
        self.assertEqual(code, 0, said + wrong)
        self.process("farm")
        # Without a buffer: closing a file whose last write was cut short would try, and fail, to
        # write the rest.
        with open(disk / "filler", "wb", buffering=0) as filler:
            try:
                while True:
                    filler.write(b"x" * 65536)
            except OSError:
                pass
        switch.unlink()
        wait("farm")
        code, said, _ = farm("status", disk / "farm", "--no-error")
        self.assertEqual(code, 1, said)
        self.assertRegex(said, r"failed: .*disk/farm/parts.*; log: .*disk/farm/logs/r0-00000.log")
        (disk / "filler").unlink()
        code, said, wrong = farm("resubmit", disk / "farm")
        self.assertEqual(code, 0, said + wrong)
        wait("farm")
        self.assertEqual(farm("status", disk / "farm"), (0, unittest.mock.ANY, ""))
        self.same_bits(disk / "full.exr", CORNELL, *words)


if __name__ == "__main__":
    if why := slurm_cluster.missing():
        print(why)
        sys.exit(77)
    eikon = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main(verbosity=2)
