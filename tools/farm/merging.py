# SPDX-License-Identifier: Apache-2.0
"""Merges of parts: the tree that runs on the nodes, and a look at an image while it grows."""
import os
import pathlib
import re
import subprocess

from . import errors, folder, policy, scripts

MERGED = "merged-{level}-{number:05d}.exr"


def part_files(farm, job):
    """The files of a job's parts, in the order of their samples."""
    return [farm.inside("parts", job.name, f"{begin:08d}-{end:08d}.exr") for begin, end in job.parts]


def tree(farm, job):
    """The merges of a job's parts: for each level [(inputs, output), ..]. The last one writes the picture itself."""
    below, levels = part_files(farm, job), []
    ranges_of = policy.merge_tree(len(below))
    for level, ranges in enumerate(ranges_of):
        outputs = [farm.inside("parts", job.name, MERGED.format(level=level, number=number)) for number in range(len(ranges))]
        outputs = outputs if level + 1 < len(ranges_of) else [job.output]
        levels.append([(below[begin:end], output) for (begin, end), output in zip(ranges, outputs)])
        below = outputs
    return levels


def write_merges(farm, some=None):
    """Writes the scripts of all merges, and a list of them for each level. some: names of jobs. Returns the number of merges
    in each level, and for each file the (level, name) of all merges that it goes into."""
    levels, after = [], {}
    for job in farm.jobs:
        if not job.parts or (some is not None and job.name not in some):
            continue
        merges = tree(farm, job)
        levels += [[] for _ in range(len(merges) - len(levels))]
        for level in reversed(range(len(merges))):
            for number, (inputs, output) in enumerate(merges[level]):
                name = f"{job.name}-{level}-{number:05d}"
                folder.write(farm.path / "merges" / f"{name}.sh", text_of(farm, job, merges, level, number))
                levels[level].append(name)
                after.update((file, [(level, name), *after.get(output, [])]) for file in inputs)
    for level, names in enumerate(levels):
        folder.write(farm.path / "merges" / f"r{len(farm.rounds)}-{level}.txt", "".join(name + "\n" for name in names))
    return [len(names) for names in levels], after


def text_of(farm, job, merges, level, number):
    """Returns the text of the script of a merge. merges: the tree of the job; level, number: the place of the merge in it."""
    inputs, output = merges[level][number]
    about = f"{job.name}: merge {number + 1} of {len(merges[level])} of level {level + 1} of {len(merges)}"
    if level + 1 == len(merges):
        return scripts.final_merge_script(farm, job, about, inputs)
    return scripts.partial_merge_script(farm, job, about, inputs, output)


def is_written(farm, job):
    """Tells whether all that a job in parts writes is there as the last merge, as it is now, has left it, and no part is newer."""
    merges, mark = tree(farm, job), scripts.done_mark(farm, job, job.output)
    try:
        sizes = [f"{os.path.getsize(os.path.join(farm.base, name))} {name}" for name in scripts.results_of_merge(job, job.output)]
        key = scripts.key_of_merge(text_of(farm, job, merges, len(merges) - 1, 0))
        return (pathlib.Path(farm.base, mark).read_text() == "".join(line + "\n" for line in [key, *sizes])
                and all(newer(farm, mark, name) for name in part_files(farm, job)))
    except OSError:
        return False


def log_of(farm, job):
    """The log of the job's last merge in the newest array of merges that has it, or None."""
    last = len(tree(farm, job)) - 1
    for number in reversed(range(len(farm.rounds))):
        try:
            names = (farm.path / "merges" / f"r{number}-{last}.txt").read_text().split()
        except OSError:
            continue
        if f"{job.name}-{last}-00000" in names:
            return farm.path / "logs" / f"merge-{last}-{names.index(f'{job.name}-{last}-00000'):05d}.log"
    return None


def preview(farm, job, output, png, extra=()):
    """Merges the parts of a job that are there, and returns eikon's line about the error, or None if there are none."""
    present, covered = [], set()
    for level in reversed(tree(farm, job)[:-1]):  # a merged file stands for all that went into it
        for inputs, merged in level:
            if os.path.exists(os.path.join(farm.base, merged)) and merged not in covered:
                if all(newer(farm, merged, name) for name in inputs):
                    present.append(merged)
                    covered.update(inputs)
            if merged in covered:
                covered.update(inputs)
    present += [name for name in part_files(farm, job) if name not in covered and os.path.exists(os.path.join(farm.base, name))]
    if not present:
        return None
    words = [farm.settings["eikon"], "merge", *present, "-o", os.path.abspath(output), *extra]
    if png:
        words += ["--png", os.path.abspath(png)]
    done = subprocess.run(words, cwd=farm.base, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise errors.FarmError(done.stderr.strip().split("\n")[-1].removeprefix("eikon: "), done.returncode)
    return done.stdout.strip().split("\n")[-1]


def newer(farm, merged, name):
    """Tells whether a merged file was written after one that went into it, or that one is gone."""
    try:
        return os.path.getmtime(os.path.join(farm.base, merged)) >= os.path.getmtime(os.path.join(farm.base, name))
    except OSError:
        return True


def error_of(line):
    """The number in "predicted relMSE 1.2e-3 (...)"."""
    found = re.search(r"relMSE (?:at least )?([0-9.e+-]+)", line or "")
    return float(found[1]) if found else None
