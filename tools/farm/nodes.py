# SPDX-License-Identifier: Apache-2.0
"""Looks at nodes before they get work: whether they see the folder, and whether their eikon gives the same bits."""
import re
import secrets
import sys
import time

from . import errors, folder, scripts, slurm

ASK_SLURM_S = 0.5
MOST_PROBED = 32  # of a large partition; the others look at themselves before their first task
# Why a job waits that will not begin by itself, as squeue says it. All other reasons pass, such as
# Resources and Priority.
NEVER = re.compile("Partition(Config|TimeLimit|NodeLimit|Down|Inactive)|BadConstraints|Invalid(Account|QOS)|(Account|QOS)NotAllowed"
                   "|JobHeld(User|Admin)|DependencyNeverSatisfied|ReservationDeleted|.*(PerJob(Limit)?|NotSatisfied)|MaxMemPerLimit")


def read(path):
    """{word: rest of its line}"""
    try:
        return dict((line.split(" ", 1) + [""])[:2] for line in path.read_text().splitlines())
    except OSError:
        return {}


def start(farm):
    """Submits a probe to each node that can take one, and returns {node: job}. Every node writes down a secret that stands
    in the folder, so that another folder of the same name is recognised."""
    place = farm.path / "nodes"
    if not (place / "token").exists():
        folder.write(place / "token", secrets.token_hex(16) + "\n")
    (place / "expected").unlink(missing_ok=True)
    probe = farm.path / "probe.sh"
    folder.write(probe, scripts.probe_script(farm), executable=True)
    up = [name for name, is_up in slurm.nodes(farm.settings["partition"], farm.excluded) if is_up]
    if not up:
        raise errors.FarmError("no node of the partition can take work: `sinfo` says why")
    for name in up:
        for file in (name, f"{name}.probed"):
            (place / file).unlink(missing_ok=True)
    return {name: slurm.submit(probe, f"--nodelist={name}") for name in up[:MOST_PROBED]}


def leave_out(probes, queue):
    """Takes those out of `probes` that Slurm will never start; fails where none is left. queue: what Slurm says of them"""
    reasons = {}
    for node, job in probes.items():
        state, *rest = queue.get((job, 0), ("",))
        if state == "PENDING" and rest and NEVER.fullmatch(rest[-1]):
            reasons[node] = rest[-1]
    if not reasons:
        return
    slurm.cancel([probes.pop(node) for node in reasons])
    text = "; ".join(f"{', '.join(sorted(node for node, why in reasons.items() if why == reason))}: {reason}"
                     for reason in sorted(set(reasons.values())))
    if not probes:
        raise errors.FarmError(f"Slurm will start no task on these nodes ({text}): ask for less with --cpus, --mem, --gres or "
                               "--sbatch, or for other nodes with --partition; `sinfo -N -o '%N %c %m %G'` shows what they have")
    print(f"eikon-farm: without nodes on which Slurm will start no task ({text})", file=sys.stderr)


def wait_for_probes(place, probes, seconds):
    """Waits until all probes are over; after so many seconds goes on without those that have not begun. Their files say so
    sooner than Slurm does. Takes those out that never begin. place: of these files"""
    end, cancelled = time.monotonic() + seconds, set()
    while True:
        soon = time.monotonic() + ASK_SLURM_S
        while time.monotonic() < soon:
            if all((place / f"{node}.probed").exists() for node in set(probes) - cancelled):
                return cancelled
            time.sleep(0.02)
        queue = slurm.states(list(probes.values()))
        leave_out(probes, queue)
        left = {node for node, job in probes.items() if queue.get((job, 0), ("",))[0] in slurm.ACTIVE}
        if not left:
            return cancelled
        if time.monotonic() > end:
            waiting = {node for node in left if queue[probes[node], 0][0] == "PENDING"}
            slurm.cancel([probes[node] for node in waiting])
            cancelled |= waiting
            if waiting == left:
                return cancelled
            end += seconds


def finish(farm, probes, seconds):
    """Waits for the probes, and writes what all nodes must be like: (nodes that are, nodes that are busy). Fails, with a
    line, where one is not."""
    late = wait_for_probes(farm.path / "nodes", probes, seconds)
    said = {}
    token = (farm.path / "nodes" / "token").read_text().strip()
    for node in sorted(set(probes) - late):
        file, end = farm.path / "nodes" / node, time.monotonic() + 3
        while not file.exists() and time.monotonic() < end:
            time.sleep(0.1)  # a network file system may show it late
        said[node] = read(file)
        if not said[node]:
            raise errors.FarmError(f"{farm.path}: node {node} does not share this folder (its probe file is not here), or "
                                   "its probe failed: choose another with --folder, or leave the node out with --exclude")
        if said[node].get("token") != token:
            raise errors.FarmError(f"{farm.path}: node {node} has another folder of this name: choose one that all share")
    check_alike(said)
    first = next(iter(said.values()), None)
    if first:
        folder.write(farm.path / "nodes" / "expected",
                     "".join(f"{what} {first[what]}\n" for what in ("token", "version", "arithmetic")))
    return sorted(said), sorted(late)


def check_alike(said):
    """Fails if nodes differ in what decides the bits of an image."""
    for what, name in (("version", "versions of eikon"), ("arithmetic", "classes of arithmetic")):
        groups = {}
        for node, words in said.items():
            groups.setdefault(words.get(what, ""), []).append(node)
        if len(groups) > 1:
            text = "; ".join(f"'{value}' on {', '.join(members[:4])}{' ...' if len(members) > 4 else ''}"
                             for value, members in sorted(groups.items()))
            raise errors.FarmError(f"nodes have different {name}, whose parts may have other bits: {text}; leave some out "
                                   "with --exclude")
        if what == "version" and groups and not next(iter(groups)).startswith("eikon "):
            raise errors.FarmError(f"the nodes cannot run eikon: {next(iter(groups))}; name it by --eikon", errors.INPUT)
