# SPDX-License-Identifier: Apache-2.0
"""Decides how large parts are, how they are merged, and what is tried again. These decisions stand here alone: submitting, the
scripts on the nodes and the simulation all ask here. Plain numbers in, plain numbers out; no files and no clock."""
import math

# Start-up (load, compile, tree, upload, and the scheduler's own time) is at most this share of a
# task.
STARTUP_SHARE = 0.1
# Each node gets this many tasks, so that the last ones of fast and slow nodes end at about the same
# time.
TASKS_PER_NODE = 4
# A division into parts that takes at most so many times as long as the quickest one costs next to
# nothing more.
NEXT_TO_NOTHING = 1.05
# A longer task gains nothing, and waits longer for a place in a busy cluster.
LONGEST_TASK_S = 3600
# A merge reads so many files. Memory does not grow with it; a smaller number makes a deeper tree,
# which copies more.
MERGE_FAN_IN = 64
# How often a task is run on its node, by the exit code of eikon: what another attempt may cure. A
# task that was killed continues from its checkpoint. Wrong flags stay wrong, and so does input, but
# for a file system that was away.
ATTEMPTS = {1: 1, 2: 1, 3: 2, 4: 3, 5: 1, 137: 3}
ATTEMPTS_OTHER = 2
# The limit of a task's time, as a multiple of what was predicted: nodes differ, and a task that
# meets the limit is saved and queued again, so this costs nothing but a restart.
TIME_MARGIN = 3
LEAST_MINUTES = 5


def least_task_seconds(startup_s):
    """Seconds of rendering that make start-up a small enough share of a task."""
    return startup_s * (1 / STARTUP_SHARE - 1)


def parts_of_images(samples, seconds, startup_s, nodes, part_s):
    """Into how many parts each of several images is divided: each has nodes by its share of the work. samples, seconds, part_s:
    lists, of each image, as parts_of takes them."""
    total = max(sum(seconds), 1e-9)
    counts = []
    for of_image, work_s, each_s in zip(samples, seconds, part_s):
        share = nodes * work_s / total
        # Many images keep the nodes busy by themselves.
        whole = share * TASKS_PER_NODE <= 1 + 1e-9
        counts.append(1 if whole else parts_of(of_image, work_s, startup_s, max(1, math.ceil(share - 1e-9)), each_s))
    return counts


def parts_of(samples, work_s, startup_s, nodes, part_s=0.0):
    """Into how many parts an image of so many samples per pixel, that takes one node work_s of rendering, is divided.
    part_s: what each part costs beside, to be written and merged."""
    # Whole samples, so that the smallest part is large enough too.
    least = max(1, math.ceil(least_task_seconds(startup_s) * samples / max(work_s, 1e-9) - 1e-9))
    most = max(1, samples // least)
    # A single node has nothing to even out. Where merging costs much, some nodes may be left
    # without a part.
    counts = [nodes * times for times in range(1, TASKS_PER_NODE + 1 if nodes > 1 else 2)]
    counts += [nodes >> halvings for halvings in range(1, nodes.bit_length())]
    counts.append(max(max(counts), math.ceil(work_s / LONGEST_TASK_S)))
    took = {count: image_seconds(count, samples, work_s, startup_s, nodes, part_s)
            for count in {1, *(min(most, count) for count in counts)}}
    # More parts even out the speeds of nodes, so they are taken where they cost next to nothing.
    return max(count for count, seconds in took.items() if seconds <= NEXT_TO_NOTHING * min(took.values()))


def image_seconds(parts, samples, work_s, startup_s, nodes, part_s):
    """About how long one image takes on nodes that are alike."""
    if parts == 1:
        return work_s + startup_s
    rounds = math.ceil(parts / nodes)
    merges = sum(max(end - begin for begin, end in level) for level in merge_tree(parts))
    # Parts have whole samples: some of them one more than others.
    largest_s = math.ceil(samples / parts) / samples * work_s
    return rounds * (largest_s + startup_s + part_s) + merges * part_s


def divide(begin, end, parts):
    """Half-open ranges of samples that differ by at most one in length."""
    count = end - begin
    parts = min(parts, count)
    edges = [begin + count * i // parts for i in range(parts + 1)]
    return list(zip(edges, edges[1:]))


def group(seconds, startup_s, nodes):
    """Returns lists of indices of the lines that share a task: in their order, until a task has enough to do. seconds: of each."""
    enough = max(least_task_seconds(startup_s), 0)
    # Where there is plenty, tasks are longer than they must be, so that there are not too many of
    # them. Beyond ten times that, start-up takes a hundredth of a task, and longer ones gain little.
    enough = max(enough, min(sum(seconds) / (nodes * TASKS_PER_NODE), 10 * enough))
    tasks, load = [], math.inf
    for number, each in enumerate(seconds):
        # A line that would make a task more than twice as long as it must be begins another one.
        if load >= enough * (1 - 1e-9) or load + each > 2 * enough:
            tasks.append([])
            load = 0
        tasks[-1].append(number)
        load += each
    return tasks


def attempts(code):
    """Returns how often a task is run on its node before it counts as failed, if eikon ended with this exit code."""
    return ATTEMPTS.get(code, ATTEMPTS_OTHER)


def after(code, tries):
    """Returns what becomes of a task after so many tries, the last of which ended with this exit code: done, again or failed."""
    if code == 0:
        return "done"
    return "again" if tries < attempts(code) else "failed"


def limit_minutes(task_s):
    """The limit of a task's time for the scheduler."""
    return max(LEAST_MINUTES, math.ceil(TIME_MARGIN * task_s / 60))


def warn_after_s(limit_minutes, before_s):
    """Returns the seconds after its start at which a task is to save, so that it has so many seconds until its limit; half of its
    time at least."""
    return max(60 * limit_minutes - before_s, 30 * limit_minutes)


def merge_tree(parts):
    """The merges of so many parts: for each level a list of ranges of the level below. The last level has one merge."""
    levels, count = [], parts
    while count > 1:
        merges = [(at, min(at + MERGE_FAN_IN, count)) for at in range(0, count, MERGE_FAN_IN)]
        levels.append(merges)
        count = len(merges)
    return levels
