# SPDX-License-Identifier: Apache-2.0
"""Tells what has become of everything: from the ledgers of the tasks, which say what was done, and Slurm's queue, which says
what is still to come."""
import collections
import dataclasses
import re

from . import errors, merging, slurm


@dataclasses.dataclass
class State:
    """The state of an item: done, running, waiting or failed."""
    item: object
    state: str
    why: str = ""
    log: str = ""
    entry: dict = None


def array_numbers(farm):
    """Slurm's numbers of all tasks."""
    return [number for one in farm.rounds for number, _, _ in one["arrays"]]


def merge_numbers(farm):
    """Slurm's numbers of all merges."""
    return [number for one in farm.rounds for number, _, _ in one["merges"]]


def queued_tasks(farm):
    """{name of the task: (state, node, reason)} of the tasks that Slurm will still run or runs."""
    queue, found = slurm.states(array_numbers(farm)), {}
    for number, one in enumerate(farm.rounds):
        for array, offset, size in one["arrays"]:
            for task in range(size):
                state = queue.get((array, task))
                if state and state[0] in slurm.ACTIVE:
                    found[f"r{number}-{offset + task:05d}"] = state
    return found


def items_state(farm, queued, keyed=False):
    """The state of every item. keyed: what was made from other inputs or settings counts as not done."""
    items = farm.list_items() if keyed else farm.items()
    ledger = farm.ledger()
    task_of = {}  # the last task that has the item
    for number, one in enumerate(farm.rounds):
        for at, outputs in enumerate(one["tasks"]):
            for output in outputs:
                task_of[output] = f"r{number}-{at:05d}"
    states = []
    for item in items:
        entry, task = ledger.get(item.output), task_of.get(item.output)
        log = str(farm.path / "logs" / f"{task}.log") if task else ""
        state = State(item, "failed", log=log, entry=entry)
        if farm.is_done(item, entry):
            state.state = "done"
        elif task in queued:
            running = queued[task][0] == "RUNNING" and entry is not None and entry["state"] == "started"
            state.state = "running" if running else "waiting"
            state.why = queued[task][2]
        elif entry is None:
            state.state, state.why = "failed", last_line(log) or "it was never begun"
        elif entry["state"] == "failed":
            state.why = entry["message"]
        elif entry["state"] == "done":
            state.why = "its inputs, settings or output have changed since"
        else:
            state.why = "it was ended before it was done, and can be continued"
        states.append(state)
    return states


def unwritten(farm, states):
    """The jobs whose parts are all done, but whose picture no merge has written, or will."""
    numbers = merge_numbers(farm)
    if any(state[0] in slurm.ACTIVE for state in slurm.states(numbers).values()):
        return []
    unfinished = {state.item.job.name for state in states if state.state != "done"}
    return [job for job in farm.jobs if job.parts and job.name not in unfinished and not merging.is_written(farm, job)]


def failed_on(states):
    """The nodes on which parts have failed by their input or a device: another node may have what these lack."""
    found = set()
    for state in states:
        if state.state != "failed" or (state.entry or {}).get("exit_code") not in (errors.INPUT, errors.DEVICE):
            continue
        try:
            with open(state.log, encoding="utf-8", errors="replace") as file:
                ends = re.findall(r"^== at .* ended with exit code \d+ on (\S+)$", file.read(), re.MULTILINE)
            found.update(ends[-1:])
        except OSError:
            continue
    return sorted(found)


def last_line(log):
    """The last line that says what went wrong, of a log that may not be there."""
    try:
        with open(log, encoding="utf-8", errors="replace") as file:
            lines = [line.strip() for line in file if line.startswith(("eikon", "slurmstepd"))]
        return lines[-1] if lines else ""
    except OSError:
        return ""


def seconds_left(farm, states, running):
    """Until everything is rendered, by the seconds that finished parts took on the nodes that run now; None: unknown."""
    took, expected = 0.0, 0.0
    for state in states:
        if state.state == "done" and state.entry["seconds"] > 0:
            took += state.entry["seconds"]
            expected += farm.seconds(state.item) + farm.measured.startup_s
    pace = took / expected if expected > 0 else 1.0
    left = sum(farm.seconds(s.item) + farm.measured.startup_s for s in states if s.state in ("running", "waiting"))
    return pace * left / running if running else None


def in_words(seconds):
    """3 h 20 min."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{int(seconds // 3600)} h {int(seconds % 3600 // 60)} min"


def is_openjd(farm):
    """Tells whether the farm is a template of Open Job Description, of which Slurm knows nothing."""
    return (farm.path / "job.template.json").exists()


def place_of(farm, log):
    """Returns words for the place where the log of a task or a merge is to be found. log: the file that it writes under Slurm"""
    return "the queue keeps its log" if is_openjd(farm) else f"log: {log}" if log else "it has no log"


def again_words(farm, does):
    """Returns words that say what to try. does: what that brings about"""
    return f"the template, run again, {does}" if is_openjd(farm) else f"`eikon-farm resubmit` {does}"


def counts(states):
    """Returns {state: number of items in it}."""
    return collections.Counter(state.state for state in states)


def show(farm, queued, states, errors_of, not_written):
    """Prints the table. errors_of: {job's name: predicted error of what is merged}; not_written: jobs without a picture."""
    total = counts(states)
    running = sum(1 for state in queued.values() if state[0] == "RUNNING")
    left = seconds_left(farm, states, running)
    print(f"{farm.path}: {len(farm.jobs)} images, {len(states)} parts: {total['done']} done, {total['running']} running, "
          f"{total['waiting']} waiting, {total['failed']} failed"
          + (f"; about {in_words(left)} left on {running} nodes" if left and total["waiting"] + total["running"] else ""))
    by_job = collections.defaultdict(collections.Counter)
    for state in states:
        by_job[state.item.job.name][state.state] += 1
    print(f"{'image':<28} {'parts':>6} {'done':>6} {'running':>8} {'failed':>7}  predicted relMSE")
    for job in farm.jobs:
        one = by_job[job.name]
        error = errors_of.get(job.name)
        print(f"{job.name:<28} {sum(one.values()):>6} {one['done']:>6} {one['running']:>8} {one['failed']:>7}  "
              f"{f'{error:.3e}' if error else '-'}")
    blocked = {reason for state, _, reason in queued.values() if state == "PENDING"} - {
        "None", "Priority", "Resources", "BeginTime", "JobArrayTaskLimit", "Dependency", ""}
    for reason in sorted(blocked):
        print(f"Slurm lets tasks wait: {re.sub('[^ -~]', '?', reason)}")
    failed = [state for state in states if state.state == "failed"]
    for state in failed[:20]:
        print(f"failed: {state.item.output}: {state.why}; {place_of(farm, state.log)}")
    if len(failed) > 20:
        print(f"failed: and {len(failed) - 20} more; {again_words(farm, 'renders them all')}")
    for job in not_written[:20]:
        print(f"not written: {job.output}: its parts are done, but they were not merged into it as it is asked for now; "
              f"{place_of(farm, merging.log_of(farm, job))}; {again_words(farm, 'merges them again')}")
