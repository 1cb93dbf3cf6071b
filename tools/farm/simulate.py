# SPDX-License-Identifier: Apache-2.0
"""Invented clusters that run the production policy: how long a submission takes on nodes of different speeds, that fail,
are preempted, and share one file system. Events in a queue; no clock, no files."""
import collections
import dataclasses
import heapq
import itertools
import random

from . import policy

# Events of a simulated submission for each node and task, and at least: one that has more makes no
# progress.
MOST_EVENTS_EACH, LEAST_MOST_EVENTS = 20, 200_000


@dataclasses.dataclass
class Work:
    """The images to be rendered, as a measured run describes them. Seconds are those of a node of speed 1."""
    images_s: list  # seconds of rendering, for each image
    samples: int  # per pixel, of each image: no more parts than that
    startup_s: float
    part_mb: float = 0.0
    merge_s: float = 0.0  # of one part, computing alone
    write_s: float = 0.0  # of one part, computing alone


@dataclasses.dataclass
class Cluster:
    """Invented nodes."""
    nodes: int
    spread: float = 0.0  # speeds lie evenly between 1 - spread and 1 + spread
    failures_per_hour: float = 0.0  # of a node: its task ends, and it is away for `repair_s`
    repair_s: float = 600.0
    preemptions_per_hour: float = 0.0  # of a node: the task saves, and is queued again
    errors: float = 0.0  # share of attempts that end with exit code 4, at a random moment
    disk_mb_s: float = 1000.0  # of the file system, for all nodes together
    launches_per_s: float = 50.0  # of the scheduler
    checkpoint_s: float = 60.0
    seed: int = 1


@dataclasses.dataclass
class Outcome:
    """The times and numbers of a simulated submission."""
    seconds: float = 0.0
    parts: int = 0
    tasks: int = 0
    starts: int = 0  # of tasks, so again after a failure or preemption
    failed: int = 0  # parts that the policy gave up
    unfinished: int = 0  # parts that were not rendered within the most events
    rendered_s: float = 0.0  # seconds of nodes that became part of an image
    startup_s: float = 0.0  # seconds of nodes for starting
    lost_s: float = 0.0  # seconds of nodes that were lost with a kill
    disk_s: float = 0.0  # seconds of nodes that waited for the file system
    merge_s: float = 0.0  # from the last part to the last picture

    def is_done(self):
        """Tells whether every image was written: one of which a part is missing is not."""
        return not self.failed and not self.unfinished

    def limit(self, nodes):
        """Returns what keeps the cluster from being faster, in a word."""
        if self.failed:
            return f"{self.failed} of {self.parts} parts failed"
        if self.unfinished:
            return f"interruptions: {self.unfinished} of {self.parts} parts unfinished when the simulation ended"
        total = max(self.seconds * nodes, 1e-9)
        shares = {"start-up": self.startup_s / total, "the file system": self.disk_s / total, "failures": self.lost_s / total,
                  "the merge": self.merge_s / max(self.seconds, 1e-9)}
        rest = "waiting for the last tasks" if self.tasks >= nodes else "parts that would be too short"
        shares[rest] = max(0.0, 1 - self.rendered_s / total - sum(shares.values()))
        word = max(shares, key=shares.get)
        return "nothing: rendering" if shares[word] < 0.05 else word


@dataclasses.dataclass
class Task:
    """Seconds of rendering that are left, and how often it ended with an error."""
    left_s: float
    parts: int
    tries: int = 0


class Disk:
    """A file system that serves one after the other."""

    def __init__(self, mb_per_s):
        self.mb_per_s, self.free_at = mb_per_s, 0.0

    def transfer(self, now, megabytes):
        """Moves so much, and returns when it is written or read."""
        self.free_at = max(now, self.free_at) + megabytes / self.mb_per_s
        return self.free_at


def make_tasks(work, nodes):
    """Parts and tasks, as `submit` makes them."""
    number = len(work.images_s)
    counts = policy.parts_of_images([work.samples] * number, work.images_s, work.startup_s, nodes,
                                    [work.merge_s + work.write_s] * number)
    pieces = [seconds * (end - begin) / work.samples for seconds, count in zip(work.images_s, counts)
              for begin, end in policy.divide(0, work.samples, count)]
    groups = policy.group(pieces, work.startup_s, nodes)
    return counts, [Task(sum(pieces[member] for member in members), len(members)) for members in groups]


class Run:
    """One simulated submission."""

    def __init__(self, work, cluster):
        self.work, self.cluster = work, cluster
        self.random = random.Random(cluster.seed)
        self.outcome = Outcome()
        self.disk = Disk(cluster.disk_mb_s)
        self.speeds = [1 + cluster.spread * self.random.uniform(-1, 1) for _ in range(cluster.nodes)]
        self.order = itertools.count()  # of events at the same time
        self.events = []
        self.waiting = collections.deque()
        self.idle = []
        self.launched_at = 0.0
        self.done_at = 0.0
        self.rendered = 0  # parts

    def at(self, when, action, *words):
        """Has something happen."""
        heapq.heappush(self.events, (when, next(self.order), action, words))

    def simulate(self):
        """Returns the outcome."""
        counts, tasks = make_tasks(self.work, self.cluster.nodes)
        self.outcome.parts, self.outcome.tasks = sum(counts), len(tasks)
        self.limit_s = 60 * policy.limit_minutes(max(task.left_s for task in tasks) + self.work.startup_s)
        self.waiting.extend(tasks)
        for node in range(self.cluster.nodes):
            self.at(0.0, self.take, node)
        most = max(LEAST_MOST_EVENTS, MOST_EVENTS_EACH * (self.cluster.nodes + len(tasks)))
        for _ in range(most):
            if not self.events:
                break
            now, _, action, words = heapq.heappop(self.events)
            action(now, *words)
        self.outcome.unfinished = self.outcome.parts - self.outcome.failed - self.rendered
        self.outcome.seconds = self.done_at + self.merge(counts)
        self.outcome.merge_s = self.outcome.seconds - self.done_at
        return self.outcome

    def take(self, now, node):
        """A node is free."""
        if self.waiting:
            self.attempt(now, node, self.waiting.popleft())
        else:
            self.idle.append(node)

    def queue_again(self, now, task):
        """A task that was begun waits for a node."""
        self.waiting.append(task)
        if self.idle:
            self.take(now, self.idle.pop())

    def write(self, now, node, task):
        """A task has rendered everything."""
        written = self.disk.transfer(now, task.parts * self.work.part_mb)
        self.outcome.disk_s += written - now
        self.done_at = max(self.done_at, written)
        self.rendered += task.parts
        self.at(written, self.take, node)

    def next_event(self, per_hour):
        """Seconds until a thing that happens so often happens."""
        return self.random.expovariate(per_hour / 3600) if per_hour > 0 else float("inf")

    def attempt(self, now, node, task):
        """A node runs a task until it is rendered, or something ends it."""
        out, cluster, speed = self.outcome, self.cluster, self.speeds[node]
        self.launched_at = max(now, self.launched_at + 1 / cluster.launches_per_s)  # the scheduler starts one after the other
        begin, startup, needed = self.launched_at, self.work.startup_s / speed, task.left_s / speed
        out.starts += 1
        if cluster.errors > 0 and self.random.random() < cluster.errors:
            self.attempt_fails(begin, node, startup, self.random.random() * needed, task)
            return
        fails, preempted = self.next_event(cluster.failures_per_hour), self.next_event(cluster.preemptions_per_hour)
        stops = min(fails, preempted, self.limit_s)
        out.startup_s += min(startup, stops)
        if startup + needed <= stops:
            out.rendered_s += needed
            self.at(begin + startup + needed + task.parts * self.work.write_s / speed, self.write, node, task)
            return
        rendered = max(0.0, stops - startup)
        kept = rendered if stops != fails else rendered // cluster.checkpoint_s * cluster.checkpoint_s
        out.rendered_s += kept
        out.lost_s += rendered - kept
        task.left_s = max(0.0, task.left_s - kept * speed)
        self.at(begin + stops, self.queue_again, task)
        self.at(begin + stops + (cluster.repair_s if stops == fails else 0.0), self.take, node)

    def attempt_fails(self, begin, node, startup, rendered, task):
        """An attempt ends with a device's error: the policy says whether there is another."""
        self.outcome.startup_s += startup
        self.outcome.lost_s += rendered
        task.tries += 1
        end = begin + startup + rendered
        if policy.after(4, task.tries) == "failed":
            self.outcome.failed += task.parts
            self.done_at = max(self.done_at, end)
        else:
            self.at(end, self.queue_again, task)
        self.at(end, self.take, node)

    def merge(self, counts):
        """Seconds of all merges, level by level; those of a level share the nodes."""
        seconds, level = 0.0, 0
        trees = [policy.merge_tree(count) for count in counts]
        while any(level < len(tree) for tree in trees):
            merges = [end - begin for tree in trees if level < len(tree) for begin, end in tree[level]]
            rounds = -(-len(merges) // self.cluster.nodes)
            computing = rounds * (self.work.startup_s + max(merges) * self.work.merge_s)
            reading = (sum(merges) + len(merges)) * self.work.part_mb / self.cluster.disk_mb_s
            seconds += max(computing, reading)
            level += 1
        return seconds


def simulate(work, cluster):
    """The outcome of a submission of `work` to `cluster`."""
    return Run(work, cluster).simulate()
