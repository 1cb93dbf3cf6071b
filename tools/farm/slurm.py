# SPDX-License-Identifier: Apache-2.0
"""Asks Slurm by its own commands."""
import math
import os
import re
import shutil
import subprocess
import time

from . import errors

ACTIVE = {"PENDING", "RUNNING", "SUSPENDED", "COMPLETING", "CONFIGURING", "REQUEUED", "STOPPED", "SIGNALING"}

REPEAT_TERM_S = 1


def run(*command, text=None):
    """Returns what a command prints; raises a FarmError with its message if it fails."""
    if not shutil.which(command[0]):
        raise errors.FarmError(f"there is no Slurm here: {command[0]} is not in PATH; run this on a login node of the cluster")
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip() or f"exit code {done.returncode}").split("\n")[0]
        raise errors.FarmError(f"{command[0]} refused: {said.removeprefix(command[0] + ': ').removeprefix('error: ')}")
    return done.stdout


def choose_partition(name):
    """The partitions that are asked for, separated by commas, or Slurm's default. Fails unless Slurm answers and has them."""
    found = run("sinfo", "-h", "-o", "%P").split()
    names = [line.rstrip("*") for line in found]
    name = name or os.environ.get("SBATCH_PARTITION") or next((line[:-1] for line in found if line.endswith("*")), None)
    if not name:
        raise errors.FarmError(f"Slurm has no default partition: name one with --partition; there is {', '.join(names) or 'none'}",
                               errors.USAGE)
    for one in name.split(","):
        if one not in names:
            raise errors.FarmError(f"partition '{one}' does not exist; there is {', '.join(names) or 'none'}", errors.USAGE)
    return name


def nodes(partition, excluded=""):
    """(name, whether it can take work now) of each node of a partition."""
    out = expand(excluded) if excluded else []
    found = {}
    for line in run("sinfo", "-h", "-N", "-o", "%N %t", "-p", partition).splitlines():
        name, state = line.split()
        if name not in out:
            found[name] = re.sub(r"[^a-z]", "", state) in ("idle", "mix", "mixed", "alloc", "allocated", "comp")
    return sorted(found.items())


def expand(names):
    """The nodes of a list such as n[1-3]."""
    return run("scontrol", "show", "hostnames", names).split()


def longest_array():
    """The number of tasks that one array may have."""
    found = re.search(r"^MaxArraySize\s*=\s*(\d+)", run("scontrol", "show", "config"), re.MULTILINE)
    return max(1, int(found[1]) if found else 1001)


def submit(script, *options, exports=None):
    """Submits a script and returns the job's number."""
    export = "--export=" + ",".join(["ALL", *(f"{name}={value}" for name, value in (exports or {}).items())])
    return run("sbatch", "--parsable", export, *options, str(script)).split(";")[0].strip()


def submit_array(script, count, throttle, exports, after=()):
    """Submits `count` tasks, of which `throttle` at most run at a time (0: all), when the jobs `after` are over. Does so in as
    many arrays as the cluster's limit asks for, and yields (number, first task, tasks) of each as soon as it is in the
    queue."""
    longest, numbers = longest_array(), []
    arrays = math.ceil(count / longest)
    side_by_side = min(arrays, throttle) if throttle else arrays
    for offset in range(0, count, longest):
        size = min(longest, count - offset)
        limit = f"%{throttle // side_by_side}" if throttle else ""
        before = [*after, *(numbers[-side_by_side:][:1] if len(numbers) >= side_by_side else [])]
        options = ["--dependency=afterany:" + ":".join(before)] if before else []
        numbers.append(submit(script, f"--array=0-{size - 1}{limit}", *options, exports={**exports, "EIKON_OFFSET": offset}))
        yield numbers[-1], offset, size


def states(numbers):
    """{(array's number, task): (state, node, reason)} of what Slurm still has in its queue."""
    if not numbers:
        return {}
    found = {}
    for chunk in (numbers[i:i + 100] for i in range(0, len(numbers), 100)):
        try:
            text = run("squeue", "-h", "-r", "-t", "all", "-o", "%F|%K|%T|%N|%r", "-j", ",".join(chunk))
        except errors.FarmError as error:
            if "Invalid job id" in str(error):  # all of them are over, and forgotten
                continue
            raise
        for line in text.splitlines():
            number, task, state, node, reason = line.split("|", 4)
            found[number, int(task) if task.isdigit() else 0] = (state, node, reason)
    return found


def cancel(numbers, seconds=30):
    """Cancels jobs, which have so many seconds to save; those that are over do not matter."""
    if not numbers:
        return
    end, again = time.monotonic() + seconds, 0.0
    while (now := time.monotonic()) < end:
        if now >= again:
            # First what waits: it would start when the others end. The script of a task passes the
            # first TERM on, so that eikon saves. Slurm calls a task running before its script is
            # there, and what is sent then is lost, so it is sent again.
            for words in (["--state=PENDING"], ["--batch", "--signal=TERM", "--state=RUNNING"]):
                subprocess.run(["scancel", *words, *numbers], capture_output=True, check=False)
            again = now + REPEAT_TERM_S
        if not any(state[0] in ACTIVE for state in states(numbers).values()):
            break
        time.sleep(0.2)
    subprocess.run(["scancel", *numbers], capture_output=True, check=False)
