# SPDX-License-Identifier: Apache-2.0
"""Reads and measures what is to be rendered. `eikon batch --list` reads the jobs, so that a line means the same here as in a
batch, and gives each the key of the ledger."""
import dataclasses
import json
import math
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile

from common import child_process

from . import errors

NEVER_SIZED = (1280, 720)  # guess for an image whose camera decides its size, until one was measured

COMPILED_S = 1.5  # kernels that were compiled before are there sooner, also on a busy machine

# The measured run renders a smaller picture of the same view, whose samples cost the same on
# average: a large one takes seconds for its pilot and its file. It begins with so many camera
# paths, which take a core a tenth of a second and more.
MEASURED_PIXELS, FIRST_PATHS = 1 << 16, 1 << 18
PILOT_PATHS_PER_PIXEL, MOST_PILOT_PATHS = 2, 1 << 19  # of eikon render
# Copies of the sums that a render has at most: its own, one for the checkpoint, and what is on its
# way to a file.
FILM_COPIES = 2.2


@dataclasses.dataclass
class Job:
    """An image: one line of a jobs file."""
    line: int
    name: str  # of its files in the farm's folder
    words: list
    part: list
    samples: list
    output: str
    key: str
    scene: str
    size: list = None
    open_ended: bool = False
    parts: list = dataclasses.field(default_factory=list)  # ranges of samples; empty: rendered in one piece
    results: list = dataclasses.field(default_factory=list)  # all files that it writes, the output is the first

    @property
    def pixels(self):
        """The number of pixels that it has, or is thought to have."""
        width, height = self.size or NEVER_SIZED
        return width * height

    @property
    def sample_count(self):
        """Camera paths of the whole image."""
        return self.pixels * (self.samples[1] - self.samples[0])


def find_eikon(name):
    """The path of the binary, which nodes have to find at the same place. None: the one in PATH."""
    found = shutil.which(name or "eikon")
    if not found:
        raise errors.FarmError(f"{name or 'eikon'}: no such program; name it with --eikon, by a path that every node has")
    return os.path.abspath(found)


def list_lines(eikon, text, folder):
    """Returns what `eikon batch --list` says of each line of a text, in their order, as dictionaries. Paths are relative to the
    folder. Raises errors.FarmError with eikon's message if it reads none."""
    run = subprocess.run([eikon, "batch", "-", "--list"], input=text, cwd=folder, capture_output=True, text=True,
                         check=False)
    if run.returncode not in (0, 1) or (run.returncode == 1 and not run.stdout):
        code = run.returncode if run.returncode in (2, 3, 4) else errors.INPUT
        raise errors.FarmError(run.stderr.removeprefix("eikon: ") or f"{eikon}: ended with {run.returncode}", code)
    return [json.loads(line) for line in run.stdout.splitlines()]


def name_of(output, names):
    """A name for the files of an output in the farm's folder, which no other one has. names: those so far; it is added"""
    stem = re.sub(r"[^A-Za-z0-9._-]", "_", pathlib.PurePath(output).stem)[:60]
    stem = stem if stem.strip(".") else "image"
    own, number = stem, 1
    while own in names:
        number += 1
        own = f"{stem}-{number}"
    names.add(own)
    return own


def read_jobs(eikon, text, folder, name):
    """The jobs of a text. Nothing is submitted where one is wrong."""
    jobs, names = [], set()
    for entry in list_lines(eikon, text, folder):
        if entry["error"]:
            code = errors.INPUT if "scene" in entry else errors.USAGE
            raise errors.FarmError(f"{name}:{entry['line']}: {entry['error']}; nothing was submitted", code)
        own = name_of(entry["output"], names)
        jobs.append(Job(line=entry["line"], name=own, words=entry["words"], part=entry["part"], samples=entry["samples"],
                        output=entry["output"], key=entry["key"], scene=entry["scene"], size=entry["size"],
                        open_ended=entry["open_ended"], results=entry["results"]))
    if not jobs:
        raise errors.FarmError(f"{name}: there is no job in it; nothing was submitted", errors.USAGE)
    return jobs


def key_of_kernels(eikon, job, folder):
    """A name for the programs that a job needs: of its scene and flags, whatever files it writes."""
    return list_lines(eikon, quote(["render", *job.part, "-o", "part.exr"]) + "\n", folder)[0]["key"]


@dataclasses.dataclass
class Measured:
    """A short run on one machine with as many threads as a task gets."""
    samples_per_second: float
    startup_s: float  # until the first sample, with compiled kernels
    finish_s: float  # from the last sample on: a part is written
    peak_mb: float
    part_bytes: int
    size: list

    def seconds(self, job):
        """Returns the seconds of rendering all of a job. Images of other scenes are taken to be as fast, for want of a better
        guess."""
        return job.sample_count / self.samples_per_second


def run_render(eikon, words, folder):
    """Runs eikon and returns (seconds, megabytes at most); fails with its message."""
    done = child_process.run([eikon, "render", *words], cwd=folder)
    if done.exit_code != 0:
        line = done.stderr.strip().split("\n")[-1].removeprefix("eikon: ")
        raise errors.FarmError(f"the measured run failed: {line}", abs(done.exit_code))
    return done.wall_s, done.peak_mib


def smaller(job):
    """(words of a part, pixels) of a picture of the job's view that is quickly measured; the part itself if the job has few
    pixels, or says its size by its camera or a window."""
    if not job.size or job.pixels <= 4 * MEASURED_PIXELS or any(word.startswith("--crop") for word in job.part):
        return job.part, job.pixels
    scale = math.sqrt(MEASURED_PIXELS / job.pixels)
    width, height = (max(1, round(side * scale)) for side in job.size)
    return [*without(job.part, {"--size": True}), f"--size={width}x{height}"], width * height


def measured_of(said, wall_s, peak_mb, part_bytes, job):
    """Returns what a run says of the whole picture, as Measured. said: its --stats"""
    took, size, pilot = said["seconds"], said["size"], said["pilot"] or {"seconds": 0.0, "paths": 0}
    pixels = size[0] * size[1]
    whole = job.size or size
    times = whole[0] * whole[1] / pixels
    startup_s, finish_s = took["first_sample"], max(0.0, wall_s - took["first_sample"] - took["render"])
    samples_per_second = said["samples"] / max(took["render"], 1e-3)
    if 0 < pilot["paths"] <= PILOT_PATHS_PER_PIXEL * pixels:  # by the size of the picture, not by a flag
        more = max(0.0, min(times * pilot["paths"], MOST_PILOT_PATHS) - pilot["paths"])
        startup_s += more / samples_per_second  # each costs about what a sample does
    return Measured(samples_per_second=samples_per_second, startup_s=startup_s,
                    finish_s=finish_s + (times - 1) * took["write"],
                    peak_mb=peak_mb + FILM_COPIES * (times - 1) * said["film_bytes"] / 1e6,
                    part_bytes=int(part_bytes * times), size=list(whole))


def measure(eikon, job, folder, threads, seconds):
    """Renders samples of a smaller picture of a job, twice as many and more, until rendering takes about so many seconds. A
    first run that had to compile kernels does not count."""
    with tempfile.TemporaryDirectory() as scratch:
        stats, image = os.path.join(scratch, "stats.json"), os.path.join(scratch, "part.exr")
        part, pixels = smaller(job)
        words = [*part, "--stats", stats, "-o", image, "--quiet"]
        if threads and not any(word.startswith("--threads") for word in words):
            words += ["--threads", str(threads)]
        begin, compiled = job.samples[0], False
        spp = min(job.samples[1] - begin, max(1, FIRST_PATHS // pixels))
        while True:
            wall_s, peak_mb = run_render(eikon, [*words, "--samples", f"{begin}:{begin + spp}"], folder)
            with open(stats, encoding="utf-8") as file:
                said = json.load(file)
            took = said["seconds"]
            result = measured_of(said, wall_s, peak_mb, os.path.getsize(image), job)
            cold = took["compile"] > COMPILED_S and not compiled
            compiled = True
            if not cold and (took["render"] >= seconds / 2 or begin + spp >= job.samples[1]):
                return result
            if not cold:
                spp = min(job.samples[1] - begin, max(2 * spp, min(64 * spp, int(spp * seconds / max(took["render"], 1e-3)))))


def measure_merge(eikon, job, folder):
    """Seconds that a merge takes for each part: of two parts, without those of one."""
    if job.samples[1] - job.samples[0] < 2:
        return 0.0
    with tempfile.TemporaryDirectory() as scratch:
        parts, took = [], []
        for number in range(2):
            begin = job.samples[0] + number
            parts.append(os.path.join(scratch, f"part{number}.exr"))
            run_render(eikon, [*job.part, "--samples", f"{begin}:{begin + 1}", "-o", parts[-1], "--quiet"], folder)
        for some in (parts[:1], parts):
            took.append(child_process.run([eikon, "merge", *some, "-o", os.path.join(scratch, "merged.exr"), "--quiet"]).wall_s)
    return max(0.0, took[1] - took[0])


def quote(words):
    """A line that a shell, and a batch, split into the same words."""
    return " ".join(shlex.quote(word) for word in words)


def without(words, flags):
    """Words of a render without some flags. flags: {name: whether a value follows}"""
    kept, skip = [], False
    for word in words:
        if skip:
            skip = False
        elif word.split("=")[0] in flags:
            skip = flags[word.split("=")[0]] and "=" not in word
        else:
            kept.append(word)
    return kept
