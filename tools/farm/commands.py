# SPDX-License-Identifier: Apache-2.0
"""The command line of eikon-farm."""
import sys
import tempfile

from . import errors, flags, folder, merging, openjd, planning, status, submit


def add_submit(commands, name, about, run):
    """The flags of `submit` and `openjd`; all others are those of a render."""
    parser = commands.add_parser(name, allow_abbrev=False, help=about,
                                 description="Everything that is not listed here is a flag of `eikon render` for SCENE.")
    parser.add_argument("input", metavar="JOBS.txt|SCENE", help="lines as of `eikon batch`, or a .gltf or .glb file")
    parser.add_argument("--parts", type=flags.PARTS, default=0, metavar="N", help="parts of each image [by a measured run]")
    parser.add_argument("--lines", type=flags.PARTS, default=0, metavar="N",
                        help="parts and images of each task [by a measured run]")
    parser.add_argument("--folder", metavar="DIR", help="on a disk that all nodes share [JOBS.txt.farm, or SCENE.farm]")
    parser.add_argument("--dry-run", action="store_true", help="print the scripts, and submit nothing")
    parser.add_argument("--cpus", type=flags.THREADS, default=1, metavar="N", help="threads of each task [1]")
    parser.add_argument("--gres", default="", metavar="GPU", help="devices of each task, such as gpu:1")
    parser.add_argument("--nodes", type=flags.NODES, default=0, metavar="N", help="nodes to divide for [all of the partition]")
    parser.add_argument("--account", default="", metavar="NAME", help="account to charge")
    parser.add_argument("--signal", type=flags.SIGNAL_S, default=90, metavar="SECONDS", help="before the limit, to save a task [90]")
    parser.add_argument("--sbatch", action="append", default=[], metavar="WORDS", help="more words for sbatch")
    parser.add_argument("--eikon", metavar="FILE", help="the program, at a path that all nodes have [that in PATH]")
    parser.add_argument("--measure", type=flags.MEASURED_S, default=0.1, metavar="SECONDS", help="of the measured run, about [0.1]")
    parser.add_argument("--checkpoint-every", type=flags.CHECKPOINT_S, default=0, metavar="SECONDS",
                        help="as of eikon render [60]")
    add_limits(parser, "", 0)
    parser.set_defaults(run=run)


def add_limits(parser, none, zero):
    """Flags that `resubmit` can change."""
    parser.add_argument("--partition", default=none, metavar="NAME", help="partition [Slurm's default]")
    parser.add_argument("--exclude", default=none, metavar="NODES", help="nodes to leave out")
    parser.add_argument("--throttle", type=flags.THROTTLE, default=zero, metavar="N", help="most tasks at a time")
    parser.add_argument("--minutes", type=flags.MINUTES, default=zero, metavar="N", help="limit of a task [by the measured run]")
    parser.add_argument("--mem", type=flags.MEGABYTES, default=zero, metavar="MB", help="memory of a task [by the measured run]")
    parser.add_argument("--probe-wait", type=flags.WAIT_S, default=60, metavar="SECONDS",
                        help="for busy nodes to say what they are [60]")


def show_status(options):
    """Prints what was done; 1 if something failed, or a picture was not written."""
    farm = folder.load(options.folder)
    queued = status.queued_tasks(farm)
    states = status.items_state(farm, queued)
    errors_of, unknown = {}, []
    for state in states:
        if not state.item.job.parts and state.state == "done" and state.entry.get("relmse_predicted"):
            errors_of[state.item.job.name] = state.entry["relmse_predicted"]
    for job in farm.jobs if options.error else []:
        if job.parts:
            try:
                with tempfile.TemporaryDirectory() as scratch:
                    said = merging.preview(farm, job, f"{scratch}/preview.exr", None)
                errors_of[job.name] = merging.error_of(said)
            except errors.FarmError as error:
                unknown.append(f"error unknown: {job.name}: {error}")
    not_written = status.unwritten(farm, states)
    status.show(farm, queued, states, errors_of, not_written)
    print("".join(line + "\n" for line in unknown), end="")
    return errors.NOT_AS_ASKED if status.counts(states)["failed"] or not_written else 0


def preview(options):
    """Merges what there is of an image."""
    farm = folder.load(options.folder)
    found = [job for job in farm.jobs if job.parts and options.image in (None, job.name, job.output)]
    if not found:
        names = ", ".join(job.name for job in farm.jobs if job.parts)
        raise errors.FarmError(f"no image '{options.image or ''}' in parts; there is {names or 'none'}", errors.USAGE)
    said = merging.preview(farm, found[0], options.output, options.png)
    if said is None:
        raise errors.FarmError(f"{found[0].name}: no part is done yet", errors.NOT_AS_ASKED)
    print(f"{options.output}: {said}")
    return 0


def parser_of_all():
    """The whole command line."""
    parser = flags.Parser(prog="eikon-farm", description="Renders images over a cluster; tools/farm/README.md has "
                          "examples. Exit codes are those of eikon.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    add_submit(commands, "submit", "submit a jobs file, or one scene with flags of a render, to Slurm", submit.submit)
    add_submit(commands, "openjd", "write the same as a template of Open Job Description", openjd.write_template)
    one = commands.add_parser("status", help="what is done, running and failed")
    one.add_argument("folder", metavar="FOLDER")
    one.add_argument("--no-error", dest="error", action="store_false", help="do not merge to tell the predicted error")
    one.set_defaults(run=show_status)
    one = commands.add_parser("cancel", help="take everything out of the queue; running tasks save")
    one.add_argument("folder", metavar="FOLDER")
    one.set_defaults(run=submit.cancel)
    one = commands.add_parser("resubmit", help="submit what failed, or changed")
    one.add_argument("folder", metavar="FOLDER")
    add_limits(one, None, None)
    one.set_defaults(run=submit.resubmit)
    one = commands.add_parser("preview", help="merge the parts of an image that are there")
    one.add_argument("folder", metavar="FOLDER")
    one.add_argument("image", nargs="?", help="its name in `status` [the first]")
    one.add_argument("-o", "--output", default="preview.exr", metavar="FILE")
    one.add_argument("--png", metavar="FILE")
    one.set_defaults(run=preview)
    planning.add_plan(commands)
    return parser


def main(words):
    """Runs a command and returns its exit code."""
    try:
        options, rest = parser_of_all().parse_known_args(flags.joined(words))
        if rest and options.command not in ("submit", "openjd", "plan"):
            raise errors.FarmError(f"{options.command}: unrecognised: {' '.join(rest)}; see "
                                   f"`eikon-farm {options.command} --help`", errors.USAGE)
        options.render = rest
        return options.run(options)
    except errors.FarmError as error:
        print(f"eikon-farm: {error}", file=sys.stderr)
        return error.code
    except OSError as error:
        print(f"eikon-farm: {error.filename or 'the system'}: {error.strerror}", file=sys.stderr)
        return errors.INPUT
    except KeyboardInterrupt:
        return 130
