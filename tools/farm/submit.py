# SPDX-License-Identifier: Apache-2.0
"""submit, resubmit and cancel."""
import contextlib
import os
import pathlib
import re
import shlex
import shutil

from . import errors, flags, folder, jobs, locking, merging, nodes, policy, repair, scripts, slurm, status

SCENES = (".gltf", ".glb")  # and all other inputs are jobs
LEAST_MEMORY_MB, MEMORY_MARGIN = 400, 1.3


def read_input(options):
    """(text of the jobs, folder of their paths, name for messages, the file or None)"""
    path = pathlib.Path(options.input)
    if options.input == "-":
        raise errors.FarmError("-: `eikon-farm resubmit` reads the jobs again, so they stand in a file: write them into one first, "
                               "as by `cat > jobs.txt`", errors.USAGE)
    if path.suffix.lower() in SCENES:
        return jobs.quote(["render", options.input, *options.render]) + "\n", os.getcwd(), options.input, None
    later = next((word for word in options.render if pathlib.Path(word).suffix.lower() in SCENES or
                  not path.exists() and word.endswith(".txt") and pathlib.Path(word).is_file()), None)
    if later:
        raise errors.FarmError(f"{options.input}: it was taken for the scene or the jobs, which come first: say `eikon-farm "
                               f"{options.command} {shlex.quote(later)} ...`, with the flags of a render behind", errors.USAGE)
    if options.render:
        raise errors.FarmError(f"{options.render[0]}: flags of a render go with a scene; those of {options.input} stand in "
                               "its lines", errors.USAGE)
    return read_text(options.input), str(path.resolve().parent), options.input, str(path.resolve())


def read_text(name):
    """The text of a jobs file."""
    try:
        return pathlib.Path(name).read_text()
    except OSError as error:
        raise errors.FarmError(f"cannot read {name}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        line, byte = error.object.count(b"\n", 0, error.start) + 1, error.object[error.start]
        raise errors.FarmError(f"{name}:{line}: the byte {byte:#04x} is not {error.encoding}, as which a farm keeps names: convert the "
                               "file, such as by `iconv -f latin1 -t utf-8`, and rename the files that it names so") from error


def default_folder(options, found):
    """Beside the jobs file, or beside the picture of a single scene."""
    if options.folder:
        return pathlib.Path(options.folder).resolve()
    if found[3]:
        return pathlib.Path(found[3] + ".farm")
    return pathlib.Path(os.path.splitext(os.path.abspath(options.input))[0] + ".farm").resolve()


def refuse_used(path):
    """Fails where a farm has the folder already."""
    if (path / "farm.json").exists():
        raise errors.FarmError(f"{path}: jobs were submitted here already: `eikon-farm resubmit {path}` renders what failed "
                               "or changed; or choose another with --folder", errors.USAGE)


@contextlib.contextmanager
def new_folder(farm):
    """Makes the folder of a new farm, and holds its lock."""
    folder.make_folders(farm)
    with locking.locked(farm.path):
        refuse_used(farm.path)  # another command may have been faster
        yield


def read_farm(options):
    """Returns the farm of what is to be rendered and how, before anything is measured; writes nothing."""
    options.sbatch = flags.split(options.sbatch)
    if any(re.match(r"-p|--partition(=|$)", word) for word in options.sbatch):
        raise errors.FarmError("--sbatch: a partition is named by --partition, so that its nodes are looked at", errors.USAGE)
    eikon = jobs.find_eikon(options.eikon)
    found = read_input(options)
    text, base, name, file = found
    path = default_folder(options, found)
    if not options.dry_run:
        refuse_used(path)
    settings = {"eikon": eikon, "base": base, "file": file, "text": text, "name": name, "threads": options.cpus,
                "partition": options.partition, "account": options.account, "gres": options.gres,
                "exclude": options.exclude, "throttle": options.throttle, "memory_mb": options.mem, "minutes": options.minutes,
                "signal_s": options.signal, "sbatch": options.sbatch, "nodes": options.nodes, "parts": options.parts,
                "lines": options.lines, "checkpoint_every": options.checkpoint_every}
    return folder.Farm(path, settings, jobs.read_jobs(eikon, text, base, name), None)


def measure(farm, seconds):
    """Runs a little of the largest image, and settles memory, parts and the time limit."""
    largest = max(farm.jobs, key=lambda job: job.sample_count)
    threads = farm.settings["threads"]
    print(f"measuring {largest.name} with {threads} threads ...", flush=True)
    measured = farm.measured = jobs.measure(farm.settings["eikon"], largest, farm.base, threads, seconds)
    largest.size = largest.size or measured.size
    if not farm.settings["memory_mb"]:
        larger = max(1, max(job.pixels for job in farm.jobs) / (measured.size[0] * measured.size[1]))
        farm.settings["memory_mb"] = max(LEAST_MEMORY_MB, int(MEMORY_MARGIN * measured.peak_mb * larger))
    settle(farm)
    say_sizes(farm)


def settle(farm):
    """Divides the jobs, and sets the time limit of a task."""
    settings = farm.settings
    folder.choose_parts(farm, settings["parts"], settings["nodes"])
    if not settings["minutes"]:
        items = farm.items()
        seconds = [farm.seconds(item) for item in items]
        tasks = folder.group(farm, items)
        longest = max(sum(seconds[member] for member in members) for members in tasks)
        open_ended = any(job.open_ended for job in farm.jobs)
        settings["minutes"] = 24 * 60 if open_ended else policy.limit_minutes(longest + farm.measured.startup_s)


def disk_bytes(farm):
    """Returns the bytes that the parts and merges take on disk, with a checkpoint for each node."""
    per_pixel = farm.measured.part_bytes / (farm.measured.size[0] * farm.measured.size[1])
    files = sum(job.pixels * (len(job.parts) * (1 + 1 / policy.MERGE_FAN_IN) + 1) for job in farm.jobs if job.parts)
    return per_pixel * (files + farm.settings["nodes"] * max(job.pixels for job in farm.jobs))


def check_disk(farm):
    """Fails where the parts will not fit."""
    place = next(parent for parent in (farm.path, *farm.path.parents) if parent.exists())
    free, needed = shutil.disk_usage(place).free, disk_bytes(farm)
    if needed > free:
        raise errors.FarmError(f"{farm.path}: the disk has {free / 1e9:.2f} GB left, parts and merges take about "
                               f"{needed / 1e9:.2f} GB: ask for fewer with --parts, or choose another folder with --folder")


def say_sizes(farm):
    """Prints what was decided, and why."""
    items, measured = farm.items(), farm.measured
    seconds = sum(farm.seconds(item) for item in items) / len(items)
    share = measured.startup_s / (measured.startup_s + seconds)
    print(f"measured: {measured.samples_per_second / 1e6:.2f} Msamples/s, start-up {measured.startup_s:.2f} s, "
          f"{measured.peak_mb:.0f} MB, {measured.part_bytes / 1e6:.1f} MB a part")
    print(f"{len(farm.jobs)} images in {len(items)} parts of about {status.in_words(seconds)}; start-up is "
          f"{100 * share:.0f} % of one; {farm.settings['memory_mb']} MB and {farm.settings['minutes']} minutes for a task; "
          f"about {disk_bytes(farm) / 1e9:.2f} GB on disk")
    for job in farm.jobs:
        if job.open_ended and farm.settings["parts"]:
            print(f"{job.name}: --time or --target-error ends it, so it is one part")


def write_node_script(farm):
    """Writes what every script sources."""
    folder.write(farm.path / "node.sh", scripts.node_script())


def write_scripts(farm):
    """Writes the scripts of the nodes, and a copy of the jobs."""
    write_node_script(farm)
    folder.write(farm.path / "task.sh", scripts.task_script(farm), executable=True)
    folder.write(farm.path / "jobs.txt", farm.settings["text"])


def print_scripts(farm):
    """For --dry-run."""
    print(f"\n# {farm.path}/node.sh\n{scripts.node_script()}")
    for name, text in (("probe.sh", scripts.probe_script(farm)), ("task.sh", scripts.task_script(farm)),
                       ("merge-0.sh", scripts.merge_script(farm, 0))):
        print(f"\n# {farm.path}/{name}\n{text}")
    print("\n# lines of the tasks")
    for item in farm.items():
        print(item.line)
    job = next((job for job in farm.jobs if job.parts), None)
    if job:
        inputs, _ = merging.tree(farm, job)[-1][0]
        print(f"\n# {farm.path}/merges: the last merge of {job.name}")
        print(scripts.final_merge_script(farm, job, job.name, inputs))
    print("\nnothing was submitted (--dry-run)")


def submit_round(farm, items, merge_jobs=None):
    """Submits the items as an array, and the merges of their images behind it. merge_jobs: names, or None for all."""
    levels, merges_after = merging.write_merges(farm, merge_jobs)
    count = folder.write_tasks(farm, items, merges_after) if items else 0
    if not items:
        farm.rounds.append({"tasks": [], "arrays": [], "merges": []})
    one, number = farm.rounds[-1], len(farm.rounds) - 1
    # Slurm may refuse the next array: what is in the queue must be known then.
    for array in slurm.submit_array(farm.path / "task.sh", count, farm.settings["throttle"], {"EIKON_ROUND": number}):
        one["arrays"].append(list(array))
        farm.save()
    behind = [array for array, _, _ in one["arrays"]]
    for level, merges in enumerate(levels):
        script = farm.path / f"merge-{level}.sh"
        folder.write(script, scripts.merge_script(farm, level), executable=True)
        # Tasks merge their images when they can; this does what is left. afterany: images of which
        # nothing failed are merged although others have failures.
        arrays = []
        for array in slurm.submit_array(script, merges, 0, {"EIKON_ROUND": number}, behind):
            arrays.append(list(array))
            one["merges"].append(list(array))
            farm.save()
        behind = [array for array, _, _ in arrays]
    farm.save()
    return count


def submit(options):
    """Divides, probes and submits."""
    if not options.dry_run:
        options.partition = slurm.choose_partition(options.partition)
    if not options.nodes:
        try:
            options.nodes = max(1, len(slurm.nodes(options.partition or slurm.choose_partition(""), options.exclude)))
        except errors.FarmError:
            options.nodes = 1
    farm = read_farm(options)
    if options.dry_run:
        measure(farm, options.measure)
        print_scripts(farm)
        return 0
    with new_folder(farm):
        write_node_script(farm)
        probes = nodes.start(farm)  # which takes its time, as does the measured run
        measure(farm, options.measure)
        check_disk(farm)
        folder.make_folders(farm)
        write_scripts(farm)
        probed, late = nodes.finish(farm, probes, options.probe_wait)
        print(f"{len(probed)} nodes share the folder and give the same bits"
              + (f"; {len(late)} are busy and will be looked at before their first task" if late else ""))
        count = submit_round(farm, farm.items())
    print(f"submitted {count} tasks; look at them with: eikon-farm status {farm.path}")
    return 0


def resubmit(options):
    """Submits what is neither done nor under way, or what has changed."""
    with locking.locked(folder.find(options.folder)):
        return resubmit_alone(options, folder.load(options.folder))


def resubmit_alone(options, farm):
    """Does so while no other command changes the farm."""
    for name in ("partition", "exclude", "minutes", "throttle", "mem"):
        if (value := getattr(options, name)) is not None:
            farm.settings["memory_mb" if name == "mem" else name] = value
    farm.settings["partition"] = slurm.choose_partition(farm.settings["partition"])
    reread(farm)
    folder.make_folders(farm)
    states = status.items_state(farm, status.queued_tasks(farm), keyed=True)
    repair.repair(farm, states)
    if options.exclude is None:
        avoid(farm, status.failed_on(states))
    write_scripts(farm)
    again = [state.item for state in states if state.state == "failed"]
    unmerged = unmerged_jobs(farm, {item.job.name for item in again}, states)
    if not again and not unmerged:
        print("nothing failed or changed: nothing was submitted")
        return 0
    if again:
        nodes.finish(farm, nodes.start(farm), options.probe_wait)
    count = submit_round(farm, again, unmerged)
    merges = sum(size for _, _, size in farm.rounds[-1]["merges"])
    behind = f"{merges} merge{'s' if merges > 1 else ''} of {len(unmerged)} image{'s' if len(unmerged) > 1 else ''}"
    if again:
        print(f"submitted {count} tasks of {len(again)} parts; the other {len(states) - len(again)} are done or under way"
              + (f"; {behind} behind them" if merges else ""))
    else:
        print(f"submitted {behind}; no part is to be rendered")
    return 0


def avoid(farm, failing):
    """Leaves out the nodes on which parts have failed, if there are others."""
    up = {name for name, is_up in slurm.nodes(farm.settings["partition"], farm.settings["exclude"]) if is_up}
    if failing and up - set(failing):
        farm.avoided = failing
        print(f"without {', '.join(failing)}, where parts have failed; --exclude '' takes all nodes")


def reread(farm):
    """Takes over what was changed in the jobs file."""
    settings = farm.settings
    if settings["file"]:
        settings["text"] = read_text(settings["file"])
    before = {job.name: job for job in farm.jobs}
    farm.jobs = jobs.read_jobs(settings["eikon"], settings["text"], farm.base, settings["name"])
    folder.choose_parts(farm, settings["parts"], settings["nodes"])
    for job in farm.jobs:
        old = before.get(job.name)
        if old and old.samples == job.samples and old.open_ended == job.open_ended:
            job.parts, job.size = old.parts, job.size or old.size


def unmerged_jobs(farm, again, states):
    """Names of images that are to be merged: those with new parts, and those whose picture was not written, or not as it is
    asked for now."""
    return {job.name for job in farm.jobs if job.parts and job.name in again} | {
        job.name for job in status.unwritten(farm, states)}


def cancel(options):
    """Takes everything out of the queue. What is done stays, and running tasks save first."""
    with locking.locked(folder.find(options.folder)):
        farm = folder.load(options.folder)
        queue = slurm.states(status.array_numbers(farm) + status.merge_numbers(farm))
        active = sorted({number for (number, _), state in queue.items() if state[0] in slurm.ACTIVE})
        slurm.cancel(active)
    print(f"cancelled {sum(1 for state in queue.values() if state[0] in slurm.ACTIVE)} tasks and merges; "
          "`eikon-farm resubmit` continues them")
    return 0
