# SPDX-License-Identifier: Apache-2.0
"""The farm's folder, which every node sees: the plan, the lines of each task with the ledger of what became of them,
parts, merges and logs. Everything is text that one can read, and the ledgers are those of `eikon batch`.

    farm.json           settings, jobs and what was submitted
    lock                while a command changes the farm: its machine, its process, and when that began
    tasks/r0-00007.txt  the lines of a task: round 0 is the first submission, each `resubmit` makes another round
    tasks/*.ledger      what became of the lines
    tasks/*.merges      the merges that may be due when the task ends
    parts/NAME/         samples of an image, until they are merged. Beside each file that may be merged stands FILE.done, and
                        picture.done says which merge has written the picture, and how large its files are
    merges/*.sh         merges of parts and of merges; the last one of an image writes what the job asks for
    merges/r0-1.txt     those of a level, which a round does when its tasks are over
    pilots/             what the first task of an image learned of its light (eikon render --pilot), for the others
    nodes/              what each node says of itself
    kernels/            compiled kernels, one archive for each kind of node
    logs/               of each task, merge and probe"""
import dataclasses
import json
import os
import pathlib

from . import errors, jobs, policy

FOLDERS = ("tasks", "parts", "merges", "pilots", "nodes", "kernels", "logs", "checkpoints")

USUAL_CHECKPOINT_S = 60  # of eikon render
SLOW_NODE = 4  # how much longer than predicted a task may well take


@dataclasses.dataclass
class Item:
    """A line of a task: a part of an image, or all of it."""
    job: jobs.Job
    line: str
    output: str
    checkpoint: str
    share: float  # of the job's samples
    key: str = None


@dataclasses.dataclass
class Farm:
    """All that is known of a submission."""
    path: pathlib.Path
    settings: dict
    jobs: list
    measured: jobs.Measured
    avoided: list = dataclasses.field(default_factory=list)  # nodes that this command leaves out, where parts have failed
    rounds: list = dataclasses.field(default_factory=list)  # {"tasks": [[line, ..], ..], "arrays": [[id, offset, count], ..]}

    @property
    def base(self):
        """The folder to which the jobs' paths are relative."""
        return self.settings["base"]

    @property
    def excluded(self):
        """The nodes that get no work, as Slurm lists them."""
        return ",".join(name for name in (self.settings["exclude"], *self.avoided) if name)

    def inside(self, *names):
        """A path in the folder as the jobs name it: relative if the folder lies below theirs, so that it can be moved."""
        path = self.path.joinpath(*names)
        try:
            return str(path.relative_to(self.base))
        except ValueError:
            return str(path)

    def items(self):
        """Everything that is to be rendered, in the order of the jobs."""
        found = []
        for job in self.jobs:
            if not job.parts:
                found.append(self._whole(job))
            for begin, end in job.parts:
                found.append(self._part(job, begin, end))
        return found

    def threads(self, words):
        """The flag that gives eikon the processors of a task, unless the words have it."""
        count = self.settings["threads"]
        return [] if any(w.startswith("--threads") for w in words) or not count else [f"--threads={count}"]

    def _checkpoint(self, name, seconds):
        """(flags, file) of the checkpoint of what is said to take so long. Without one where even a node that is much slower
        would write none before the end: at the end it has what the part has, and costs as much to write. What is
        interrupted goes on from what it has saved under its own name."""
        every = self.settings["checkpoint_every"]
        if SLOW_NODE * seconds < (every or USUAL_CHECKPOINT_S):
            return [], ""
        file = self.inside("checkpoints", name)
        return [f"--checkpoint={file}", *([f"--checkpoint-every={every:g}"] if every else [])], file

    def _whole(self, job):
        words, checkpoint = jobs.without(job.words, {"--quiet": False}), ""
        if not any(word.split("=")[0] == "--checkpoint" for word in words):
            words = jobs.without(words, {"--checkpoint-every": True, "--resume": False})
            seconds = float("inf") if job.open_ended else self.measured.seconds(job)
            flags, checkpoint = self._checkpoint(f"{job.name}.exr", seconds)
            words += flags
        words += self.threads(words)
        return Item(job, jobs.quote(["render", *words]), job.output, checkpoint, 1.0)

    def _part(self, job, begin, end):
        name = f"{begin:08d}-{end:08d}.exr"
        output = self.inside("parts", job.name, name)
        share = (end - begin) / (job.samples[1] - job.samples[0])
        flags, checkpoint = self._checkpoint(f"{job.name}-{name}", self.measured.seconds(job) * share)
        words = [*job.part, f"--samples={begin}:{end}", f"--output={output}", *flags, "--quiet"]
        if not any(word.split("=")[0] == "--pilot" for word in words):
            # One of another image is refused, so the name changes with the job's inputs and
            # settings.
            words.append(f"--pilot={self.inside('pilots', f'{job.name}-{job.key}')}")
        words += self.threads(words)
        return Item(job, jobs.quote(["render", *words]), output, checkpoint, share)

    def seconds(self, item):
        """Returns the seconds that an item renders, by the measured run."""
        return self.measured.seconds(item.job) * item.share

    def list_items(self):
        """The items with the keys that their inputs and settings have now."""
        items = self.items()
        said = jobs.list_lines(self.settings["eikon"], "".join(item.line + "\n" for item in items), self.base)
        for item, entry in zip(items, said):
            item.key = entry["key"]  # None: an input is gone
        return items

    def ledger(self):
        """The last event of each output, over all tasks, with the ledger that has it. The names are those of items."""
        last = {}
        for file in sorted((self.path / "tasks").glob("*.ledger")):
            for line in file.read_text(errors="replace").splitlines():
                try:
                    entry = json.loads(line)
                    entry["task"], entry["text"] = file.stem, line
                    for output in entry["outputs"]:
                        before = last.get(output["path"])
                        if before is None or round_and_task(entry["task"]) >= round_and_task(before["task"]):
                            last[output["path"]] = entry
                except (ValueError, KeyError, TypeError):
                    continue  # cut off by a power failure: the line is rendered again
        return last

    def is_done(self, item, entry):
        """Tells whether the output of an item is there, made from what its inputs and settings are now."""
        if entry is None or entry["state"] != "done" or (item.key is not None and entry["key"] != item.key):
            return False
        try:
            return all(os.path.getsize(os.path.join(self.base, output["path"])) == output["bytes"]
                       for output in entry["outputs"])
        except OSError:
            return False

    def save(self):
        """Writes farm.json, whole or not at all."""
        content = {"settings": {**self.settings, "folder": str(self.path)}, "jobs": [dataclasses.asdict(job) for job in self.jobs],
                   "measured": dataclasses.asdict(self.measured), "rounds": self.rounds}
        write(self.path / "farm.json", json.dumps(content, indent=1))


def round_and_task(name):
    """(round, task) of a task's name, as in r10-00003."""
    return tuple(int(number) for number in name[1:].split("-"))


def find(path):
    """The folder of a farm, which may be named without its .farm."""
    path = pathlib.Path(path).resolve()
    if not (path / "farm.json").is_file() and pathlib.Path(f"{path}.farm").is_dir():
        path = pathlib.Path(f"{path}.farm")
    if not (path / "farm.json").is_file():
        raise errors.FarmError(f"{path}: no farm was submitted here: there is no farm.json")
    return path


def load(path):
    """Reads the folder of a farm."""
    path = find(path)
    try:
        content = json.loads((path / "farm.json").read_text())
        found = [jobs.Job(**job) for job in content["jobs"]]
        check_shape(content["settings"], found, content["rounds"])
        return Farm(moved(path, content["settings"], found), content["settings"], found, jobs.Measured(**content["measured"]),
                    rounds=content["rounds"])
    except OSError as error:
        raise errors.FarmError(f"cannot read {path / 'farm.json'}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise errors.FarmError(f"{path / 'farm.json'}: it is damaged; submit the jobs again: {error}") from error


def check_shape(settings, found, rounds):
    """Fails by a ValueError or its like where what was read is not what a command would have written."""
    words = (*(settings[name] for name in ("eikon", "base", "partition", "exclude")),
             *(text for job in found for text in (job.name, job.output)))
    tasks = [output for one in rounds for outputs in one["tasks"] for output in outputs]
    arrays = [array for one in rounds for array, _, _ in [*one["arrays"], *one["merges"]]]
    if not found or not all(isinstance(word, str) for word in (*words, *tasks, *arrays)):
        raise ValueError("there is no job, or a text is something else")
    numbers = [number for one in rounds for _, *place in [*one["arrays"], *one["merges"]] for number in place]
    if not all(isinstance(number, int) for number in (*numbers, *(end for job in found for part in job.parts for end in part))):
        raise ValueError("a number is something else")


def moved(path, settings, found):
    """The path of a folder, after its settings were changed to what they are where it lies now. Fails if it was moved, and what
    its jobs read was not."""
    before, base = pathlib.Path(settings.get("folder") or path), settings["base"]
    if before == path or os.path.exists(before) and os.path.samefile(before, path):
        return before
    below = before.relative_to(base).parts if before.is_relative_to(base) else ("..",)
    place = pathlib.Path(*path.parts[:len(path.parts) - len(below)])
    file = settings["file"] and place / pathlib.Path(settings["file"]).relative_to(base)
    if path != place.joinpath(*below) or not os.path.exists(file or place / found[0].scene):
        raise errors.FarmError(f"{path}: it was {before} when its jobs were submitted, whose paths are relative to {base}: move it "
                               f"back, or, if it lay in there, move all of {base}")
    settings.update(base=str(place), file=file and str(file))
    return path


def write(path, text, executable=False):
    """Writes a file under another name and renames it, so that nobody reads half of one."""
    temporary = pathlib.Path(f"{path}.new")
    try:
        temporary.write_text(text)
        if executable:
            temporary.chmod(0o755)
        temporary.replace(path)
    except OSError as error:
        raise errors.FarmError(f"cannot write {path}: {error.strerror}") from error


def make_folders(farm):
    """Creates the folder, and those of images with parts."""
    try:
        for name in FOLDERS:
            (farm.path / name).mkdir(parents=True, exist_ok=True)
        for job in farm.jobs:
            if job.parts:
                (farm.path / "parts" / job.name).mkdir(exist_ok=True)
    except OSError as error:
        raise errors.FarmError(f"cannot write {error.filename}: {error.strerror}") from error


def choose_parts(farm, asked, nodes):
    """Divides the jobs into parts: so many as are asked for, or as many as keep start-up a small part of each."""
    measured, samples = farm.measured, [job.samples[1] - job.samples[0] for job in farm.jobs]
    part_s = [measured.finish_s * job.pixels / (measured.size[0] * measured.size[1]) for job in farm.jobs]
    counts = policy.parts_of_images(samples, [measured.seconds(job) for job in farm.jobs], measured.startup_s, nodes, part_s)
    for job, count, most in zip(farm.jobs, counts, samples):
        if job.open_ended:
            count = 1  # the render itself decides when to end, and needs all samples for that
        elif asked:
            count = min(asked, most)
        job.parts = [list(part) for part in policy.divide(*job.samples, count)] if count > 1 else []


def group(farm, items):
    """Returns lists of indices of the items that share a task."""
    lines = farm.settings["lines"]
    if lines:
        return [list(range(at, min(at + lines, len(items)))) for at in range(0, len(items), lines)]
    return policy.group([farm.seconds(item) for item in items], farm.measured.startup_s, farm.settings["nodes"])


def write_tasks(farm, items, merges_after):
    """Writes the tasks of a new round, and returns their number. An earlier ledger's word of a line goes with it, so that
    what was begun is continued. merges_after: of the files that are merged (merging.write_merges)"""
    number, last, tasks = len(farm.rounds), farm.ledger(), group(farm, items)
    for at, members in enumerate(tasks):
        own = [items[member] for member in members]
        stem = farm.path / "tasks" / f"r{number}-{at:05d}"
        write(f"{stem}.txt", "".join(item.line + "\n" for item in own))
        write(f"{stem}.checkpoints", "".join(item.checkpoint + "\n" for item in own if item.checkpoint))
        merges = {merge for item in own for merge in merges_after.get(item.output, [])}
        write(f"{stem}.merges", "".join(name + "\n" for _, name in sorted(merges)))
        said = [last[item.output]["text"] for item in own if item.output in last]
        if said:
            write(f"{stem}.ledger", "\n".join(said) + "\n")
    farm.rounds.append({"tasks": [[items[member].output for member in members] for members in tasks], "arrays": [],
                        "merges": []})
    return len(tasks)
