# SPDX-License-Identifier: Apache-2.0
"""Writes the shell scripts that run on the nodes. They need bash and eikon there, nothing else; `--dry-run` prints them.

The texts stand here as templates; the functions below fill them in for a farm, a folder.Farm, and return them as strings."""
import hashlib
import re
import shlex

from . import flags, jobs, policy

HEAD = """\
#!/bin/bash
# Written by eikon-farm. Change what you like: `eikon-farm resubmit` writes it again, a running task
# has its own copy.
{directives}
farm={farm}
base={base}
eikon={eikon}
"""

NODE = r"""
# Checks a node, and prepares it: sourced by every task.
node="${SLURMD_NODENAME:-$(hostname -s)}"
fail() { echo "eikon-farm: $node: $1" >&2; exit 3; }

# The kernels are compiled once for each kind of node. Every node has its own copy on its own disk:
# PoCL's cache is many small files, which a thousand nodes would otherwise look up, and write, over
# the network. A task asks what its probe has written down; eikon would look for devices.
# Where the program was replaced since, nothing of that holds any more.
devices= kind=
program="$(stat -L -c %Y-%s "$eikon" 2> /dev/null)"
if [ "$(sed -n 's/^program //p' "$farm/nodes/$node" 2> /dev/null)" = "$program" ]; then
  kind="$(sed -n 's/^kind //p' "$farm/nodes/$node" 2> /dev/null)"
fi
known="$kind"
if [ -z "$kind" ]; then
  devices="$("$eikon" devices 2> /dev/null)"
  kind="$(sed -n '/^[0-9]*: /p; /driver/p' <<< "$devices" | cksum | tr -d ' ')"
fi
archive="$farm/kernels/$kind.tar"
cache="${EIKON_NODE_CACHE:-}"
if [ -z "$cache" ]; then
  # Compiled kernels are run, so they must not be somebody else's.
  cache="${TMPDIR:-/tmp}/eikon-kernels-$(id -u)"
  mkdir -p -m 700 "$cache" 2> /dev/null
  [ -O "$cache" ] && [ ! -L "$cache" ] ||
    fail "$cache cannot be made, or is another user's: name another folder by EIKON_NODE_CACHE"
fi
export POCL_CACHE_DIR="$cache/$kind"
mkdir -p "$POCL_CACHE_DIR" || fail "cannot write $cache: name another folder by EIKON_NODE_CACHE"
unpacked="$POCL_CACHE_DIR.unpacked/$(stat -L -c %Y-%s "$archive" 2> /dev/null)"
if [ -f "$archive" ] && [ ! -e "$unpacked" ]; then
  # Other tasks may read the folder meanwhile. So each program is renamed into it whole, unless it
  # is there already.
  fresh="$(mktemp -d "$POCL_CACHE_DIR.XXXXXX")"
  tar -xf "$archive" -C "$fresh" && (
    cd "$fresh" && for program in */*; do
      mkdir -p "$POCL_CACHE_DIR/${program%/*}" && mv -nT "$program" "$POCL_CACHE_DIR/$program" 2> /dev/null
    done
    mkdir -p "${unpacked%/*}" && echo > "$unpacked"
  )
  rm -rf "$fresh"
fi

# What the node is. Its version and arithmetic may decide the bits, so they must be those of all
# others. A merge is less strict: it refuses parts of another arithmetic, or of a version that is
# known to render other images.
describe_node() {
  [ -n "$devices" ] || devices="$("$eikon" devices 2> /dev/null)"
  echo "token $(cat "$farm/nodes/token" 2>/dev/null)"
  echo "version $("$eikon" --version 2>&1 | head -1)"
  echo "arithmetic $(sed -n 's/^ *arithmetic //p' <<< "$devices" | sort -u | paste -sd,)"
  echo "kind $kind"
  echo "program $program"
}
if [ -z "$known" ]; then
  described="$(describe_node)"
  echo "$described" > "$farm/nodes/$node.$$" && mv "$farm/nodes/$node.$$" "$farm/nodes/$node" ||
    fail "cannot write $farm/nodes: is the disk full, or the folder not shared?"
fi
# If no node had time for its probe, the first that gets a task says what the others must be like.
if [ ! -s "$farm/nodes/expected" ]; then
  grep -E '^(token|version|arithmetic) ' "$farm/nodes/$node" > "$farm/nodes/expected.$node.$$"
  ln "$farm/nodes/expected.$node.$$" "$farm/nodes/expected" 2> /dev/null
  rm -f "$farm/nodes/expected.$node.$$"
fi
if [ -s "$farm/nodes/expected" ]; then
  for what in token version arithmetic; do
    here="$(sed -n "s/^$what //p" "$farm/nodes/$node")"
    wanted="$(sed -n "s/^$what //p" "$farm/nodes/expected")"
    [ "$what" != token ] || [ "$here" = "$wanted" ] || fail "$farm is not the folder that the jobs were submitted from"
    [ "$here" = "$wanted" ] || fail "its $what is '$here', that of the other nodes is '$wanted': its parts may have other bits"
  done
fi
"""

PROBE = r"""
[ -d "$farm" ] || { echo "eikon-farm: $farm is not there" >&2; exit 3; }
exec >> "$farm/logs/probe-${SLURMD_NODENAME:-here}.log" 2>&1
rm -f "$farm/nodes/${SLURMD_NODENAME:-none}"
source "$farm/node.sh"
# The node's own list of the programs that the first job needs, from an earlier submission of it by
# the same program.
used="$POCL_CACHE_DIR.jobs/{key}-$(stat -L -c %Y-%s "$eikon")"
pack() { [ -s "$used" ] && tar -cf "$archive.$$" -C "$POCL_CACHE_DIR" -T "$used" 2> /dev/null && mv "$archive.$$" "$archive"; }
if [ ! -f "$archive" ] && ! pack; then
  # Compile the kernels of the first job, and keep them for all nodes of this kind.
  scratch="$(mktemp -d)"
  mkdir -p "$POCL_CACHE_DIR.jobs"
  touch "$scratch/begin"
  cd "$base" && "$eikon" render {first} -o "$scratch/first.exr" --quiet --samples {samples} > /dev/null
  # Of what this node has compiled before, only programs that this job used: PoCL and eikon note
  # when that was.
  (cd "$POCL_CACHE_DIR" && find . -newer "$scratch/begin" \( -name last_accessed -printf '%h\n' -o -path './eikon/[0-9a-f]*' -print \)) \
    > "$scratch/used"
  mv "$scratch/used" "$used"
  rm -rf "$scratch"
  pack || rm -f "$archive.$$"
fi
echo > "$farm/nodes/$node.probed"
"""

TASK = r"""
name="r$EIKON_ROUND-$(printf %05d $((SLURM_ARRAY_TASK_ID + EIKON_OFFSET)))"
exec >> "$farm/logs/$name.log" 2>&1 || exit 3
echo "== at $(date +%s.%3N) $(date -u +%FT%TZ) $name on ${SLURMD_NODENAME:-$(hostname -s)}, job ${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID, start ${SLURM_RESTART_COUNT:-0}"
# Slurm warns a task once, and in vain if that is before this script runs. So the script warns
# itself, too.
(trap 'kill $!' TERM; sleep {warn_after_s} & wait $! && kill -USR1 $$) &
trap "kill $! 2> /dev/null" EXIT
{run}
if [ -n "$requeue" ] && [ $code = 143 ]; then
  echo "eikon-farm: saved before the time limit, and queued again"
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
  sleep 60
fi
echo "== at $(date +%s.%3N) $(date -u +%FT%TZ) $name ended with exit code $code on ${SLURMD_NODENAME:-$(hostname -s)}"
exit $code
"""

# A queue that speaks Open Job Description keeps the log, and reads the lines of progress in it.
OPENJD_TASK = r"""
name="r0-$(printf %05d "$1")"
{run}
exit $code
"""

# This runs the lines of task $name, and sets `code`.
RUN_TASK = r"""# Shortly before the time limit comes USR1: eikon saves, and the task is queued again. TERM, which comes before a task is
# cancelled or preempted, saves too. What SIGKILL ends continues from its last checkpoint.
# Only the first TERM is passed on: a second one ends eikon at once, without its picture.
requeue= ended= stopping= ready= child= told= code=143
stop() { stopping=1; if [ -n "$child" ] && [ -z "$told" ]; then told=1; kill -TERM $child; fi; }
trap 'requeue=1; stop' USR1
trap 'ended=1; stop; [ -n "$ready" ] || exit 143' TERM INT
source "$farm/node.sh"
cd "$base" || fail "cannot enter $base"
# A moment for the log, and the processor's seconds until then.
stamp() { echo "== at $(date +%s.%3N) $1; user and system seconds, of this script and of what it ran:"; times; }
stamp "ready"

# A part is saved under its name when it is interrupted, too. Only one that the ledger calls done
# may be merged, and has a file FILE.done beside it.
PART='parts/[A-Za-z0-9._-]+/[0-9]+-[0-9]+\.exr'
mark_done() {
  # The farm's path may have what JSON writes behind a backslash.
  sed -nE 's#.*"path":"(([^"\\]|\\.)*/)?('"$PART"')".*"state":"([a-z]+)".*#\3 \4#p' "$farm/tasks/$name.ledger" | while read -r part state; do
    if [ "$state" = done ]; then echo > "$farm/$part.done"; else rm -f "$farm/$part.done"; fi
  done
}
grep -oE "$PART" "$farm/tasks/$name.txt" | while read -r part; do rm -f "$farm/$part.done"; done

tries=0 ready=1
while [ -z "$stopping" ]; do
  tries=$((tries + 1))
  child= told=
  "$eikon" batch - --ledger "$farm/tasks/$name.ledger" {progress} < "$farm/tasks/$name.txt" &
  child=$!
  [ -z "$stopping" ] || stop
  wait $child; code=$?
  while kill -0 $child 2> /dev/null; do wait $child; code=$?; done
  if [ $code = 143 ] || [ $code = 130 ]; then break; fi
  # How often a task is run here, by its exit code.
  case $code in
{attempts}
  esac
  if [ $code = 0 ] || [ $tries -ge $most ]; then break; fi
  echo "eikon-farm: exit code $code at try $tries of $most; once more"
  sleep $tries
done
trap '' USR1  # merging takes the rest of the time
trap '' TERM INT
stamp "rendered"
mark_done
[ -n "$ended" ] || trap - TERM INT  # who has ended the task may say so again
if [ $code = 0 ]; then
  while read -r checkpoint; do rm -f "$checkpoint"; done < "$farm/tasks/$name.checkpoints"
  # The task that has the last part of an image merges it, so that no image waits for the tasks of
  # others.
  while read -r merge; do
    (if_ready=1; source "$farm/merges/$merge.sh") || echo "eikon-farm: $merge is tried again when all tasks are over"
  done < "$farm/tasks/$name.merges"
  stamp "merged"
fi"""

MERGE = r"""
level={level}
name="merge-$level-$(printf %05d $((SLURM_ARRAY_TASK_ID + EIKON_OFFSET)))"
exec >> "$farm/logs/$name.log" 2>&1 || exit 3
echo "== at $(date +%s.%3N) $(date -u +%FT%TZ) $name"
source "$farm/node.sh"
cd "$base" || fail "cannot enter $base"
source "$farm/merges/$(sed -n "$((SLURM_ARRAY_TASK_ID + EIKON_OFFSET + 1))p" "$farm/merges/r$EIKON_ROUND-$level.txt").sh"
"""

OPENJD_MERGE = r"""
source "$farm/node.sh"
cd "$base" || fail "cannot enter $base"
source "$farm/merges/$(sed -n "$(($2 + 1))p" "$farm/merges/r0-$1.txt").sh"
"""

# A merge of some files, or the last one of an image.
ONE_MERGE = r"""
# {about}
inputs=({inputs})
output={output}
lock={lock}
mark={mark}  # says which merge has written the results, and how large they are
key={key}
results=({results})
written() {{ echo "$key"; stat -L -c '%s %n' -- "${{results[@]}}"; }}
for input in "${{inputs[@]}}"; do
  if [ ! -s "$input" ] || [ ! -e "$input.done" ]; then
    [ -z "$if_ready" ] || exit 0
    echo "eikon-farm: {name} cannot be merged yet: $input is missing, or not done"
    exit 1
  fi
done
if [ -n "$if_ready" ]; then
  # Two tasks may both have found all files there.
  mkdir "$lock" 2> /dev/null || exit 0
  trap 'rmdir "$lock"' EXIT
fi
fresh=
[ "$(written 2> /dev/null)" = "$(cat "$mark" 2> /dev/null)" ] || fresh=1
for input in "${{inputs[@]}}"; do
  [ "$input" -nt "$mark" ] && fresh=1
done
if [ -n "$fresh" ]; then
  # The mark has the time at which the merge began, so that an input that changes meanwhile is
  # newer.
  rm -f "$mark" && echo "$key" > "$mark.new" || exit 1
  {command}
  written > "$mark.full" && touch -r "$mark.new" "$mark.full" && mv "$mark.full" "$mark" && rm -f "$mark.new" || exit 1
fi
"""


def sbatch_lines(settings, options):
    """Returns the #SBATCH lines of a script. settings: those of the farm, of which "sbatch" has the user's own words; options:
    {name: value}, True for a flag without value; None, "" and False leave the option out."""
    lines = [f"#SBATCH --{name}={value}" if value is not True else f"#SBATCH --{name}" for name, value in options.items()
             if value not in (None, "", False)]
    lines += [f"#SBATCH {flags.quote_for_sbatch(word)}" for word in settings["sbatch"]]
    return "\n".join(lines)


def script_head(farm, options):
    """Returns the first lines of every script of the farm; options: as of sbatch_lines()."""
    return HEAD.format(directives=sbatch_lines(farm.settings, options), farm=shlex.quote(str(farm.path)),
                       base=shlex.quote(farm.base), eikon=shlex.quote(farm.settings["eikon"]))


def job_options(farm, name):
    """Returns {option of sbatch: value} that every job of the farm has. name: the kind of job, for people who look at the queue."""
    settings = farm.settings
    # Slurm takes what follows a space for another option.
    job = re.sub(r"[^A-Za-z0-9._-]+", "_", f"eikon-{name}-{farm.path.stem}")[:60]
    return {"job-name": job, "partition": settings["partition"],
            "account": settings["account"], "cpus-per-task": settings["threads"] or None,
            "mem": f"{settings['memory_mb']}M" if settings["memory_mb"] else None,
            "exclude": farm.excluded, "output": "/dev/null", "error": "/dev/null"}


def task_lines(progress):
    """Returns the part of a script that runs the lines of a task, and tries again as the policy says. progress: the flag by which
    eikon says how far it is."""
    lines = [f"    {code}) most={policy.attempts(code)} ;;" for code in sorted(policy.ATTEMPTS)]
    lines.append(f"    *) most={policy.ATTEMPTS_OTHER} ;;")
    return RUN_TASK.replace("{attempts}", "\n".join(lines)).replace("{progress}", progress)


def openjd_scripts(farm):
    """Returns {name: text} of the scripts that the steps of an Open Job Description template run."""
    return {"openjd-task.sh": script_head(farm, {}) + OPENJD_TASK.replace("{run}", task_lines("--progress openjd")),
            "openjd-merge.sh": script_head(farm, {}) + OPENJD_MERGE}


def task_script(farm):
    """Returns the text of the script that runs one task of an array."""
    options = {**job_options(farm, "task"), "gres": farm.settings["gres"], "time": farm.settings["minutes"], "requeue": True,
               "signal": f"B:USR1@{farm.settings['signal_s']}", "open-mode": "append"}
    text = TASK.replace("{run}", task_lines("--quiet"))
    return script_head(farm, options) + text.replace(
        "{warn_after_s}", str(policy.warn_after_s(farm.settings["minutes"], farm.settings["signal_s"])))


def probe_script(farm):
    """Returns the text of the script that looks at one node, and compiles kernels for its kind."""
    job = farm.jobs[0]
    options = {**job_options(farm, "probe"), "gres": farm.settings["gres"], "time": 10}
    # A window of the picture has the same kernels, and is sooner written.
    window = [] if any(word.startswith("--crop") for word in job.part) else ["--crop=0,0,1,1"]
    first = [*job.part, *window, *([f"--threads={farm.settings['threads']}"] if farm.settings["threads"] else [])]
    return script_head(farm, options) + PROBE.replace("{first}", jobs.quote(first)).replace(
        "{samples}", f"{job.samples[0]}:{job.samples[0] + 1}").replace(
            "{key}", jobs.key_of_kernels(farm.settings["eikon"], job, farm.base))


def node_script():
    """Returns the text that every script sources on its node: it checks the node and prepares it."""
    return NODE.lstrip()


def merge_script(farm, level):
    """Returns the text of the script that runs one merge of an array. level: that of the merge in its tree, 0 is the first."""
    options = {**job_options(farm, f"merge{level}"), "time": 60, "requeue": True}
    return script_head(farm, options) + MERGE.replace("{level}", str(level))


def partial_merge_script(farm, job, about, inputs, output):
    """Returns the text of the script that merges some files into one of their kind.

    about: a comment for its head; inputs, output: names of files as farm.inside() makes them."""
    # One with gaps ends with 1, and is not kept.
    command = ('"$eikon" merge "${inputs[@]}" -o "$output.new.exr" --quiet && mv "$output.new.exr" "$output" '
               '|| { rm -f "$output.new.exr"; exit 1; }')
    return merge_script_text(job, about, inputs, output, done_mark(farm, job, output), command)


def final_merge_script(farm, job, about, inputs):
    """Returns the text of the script that completes an image: the samples of all files are there, so eikon renders nothing, and
    writes what the job asks for. about, inputs: as of partial_merge_script()."""
    # Of the line's own flags, those about its checkpoint would contradict the farm's.
    words = jobs.without(job.words, {"--checkpoint": True, "--checkpoint-every": True, "--resume": False, "--quiet": False,
                                     "--add": True})
    words += farm.threads(words)
    command = '"$eikon" render ' + jobs.quote(words) + ' "${inputs[@]/#/--add=}" --quiet || exit $?'
    return merge_script_text(job, about, inputs, job.output, done_mark(farm, job, job.output), command)


def done_mark(farm, job, output):
    """Returns the path of the file that a merge writes when its output is whole."""
    return farm.inside("parts", job.name, "picture.done") if output == job.output else f"{output}.done"


def results_of_merge(job, output):
    """Returns the names of all files that the merge of an output writes."""
    return job.results or [output] if output == job.output else [output]


def key_of_merge(text):
    """Returns the key in a merge's text. It is another one if the merge has other inputs, or writes its output otherwise."""
    return re.search(r"^key=(\w+)$", text, re.MULTILINE)[1]


def merge_script_text(job, about, inputs, output, mark, command):
    """Returns the text of the script of a merge. mark: as done_mark() returns it; command: the shell command that merges."""
    quoted = [shlex.quote(name) for name in inputs]
    key = hashlib.sha256("\n".join([output, command, *inputs]).encode()).hexdigest()[:16]
    return ONE_MERGE.format(about=about, inputs="\n  ".join(["", *quoted]) + "\n", output=shlex.quote(output),
                            lock=shlex.quote(mark.removesuffix(".done") + ".lock"), mark=shlex.quote(mark), key=key,
                            results=jobs.quote(results_of_merge(job, output)), name=job.name, command=command).lstrip()
