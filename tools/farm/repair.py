# SPDX-License-Identifier: Apache-2.0
"""Does what `resubmit` needs about parts and merged files that stand in the way of a merge."""
import pathlib
import subprocess

from . import errors, merging, scripts, status


def is_whole(farm, name):
    """Tells whether a part can be read: eikon compares its sums with the hash that the file has of them."""
    words = [farm.settings["eikon"], "merge", "--quiet", name, "-o", "-"]
    done = subprocess.run(words, cwd=farm.base, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    return done.returncode != errors.INPUT


def doubtful(farm, job):
    """(parts, merged files) that may be damaged, of an image whose last merge has failed: the parts that no merged file stands
    for, and what a merge that began and failed has read."""
    parts, merged = [], []
    if pathlib.Path(farm.base, scripts.done_mark(farm, job, job.output)).exists():
        return parts, merged
    for level, merges in enumerate(merging.tree(farm, job)):
        for inputs, output in merges:
            mark = pathlib.Path(farm.base, scripts.done_mark(farm, job, output))
            if level == 0 and not mark.exists():
                parts += inputs
            if level > 0 and pathlib.Path(f"{mark}.new").exists():
                merged += inputs
    return parts, merged


def remove(farm, *names):
    """Removes files that may not be there."""
    for name in names:
        pathlib.Path(farm.base, name).unlink(missing_ok=True)


def repair(farm, states):
    """Sees to it that merges find what they need. A task that is killed has not marked its parts, so what the ledgers call done
    is marked here. Of images that could not be merged, damaged parts are removed, so that they are rendered again."""
    for state in states:
        mark = pathlib.Path(farm.base, f"{state.item.output}.done")
        if state.item.job.parts and state.state == "done" and not mark.exists():
            mark.write_text("\n")
    state_of = {state.item.output: state for state in states}
    for job in status.unwritten(farm, states):
        parts, merged = doubtful(farm, job)
        remove(farm, *(f"{name}.done" for name in merged))
        if parts:
            print(f"{job.name} was not merged: checking {len(parts)} parts ...", flush=True)
        for name in parts:
            if not is_whole(farm, name):
                print(f"{name} is damaged: it is rendered again")
                remove(farm, f"{name}.done", name)
                state_of[name].state = "failed"
