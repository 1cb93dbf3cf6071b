# SPDX-License-Identifier: Apache-2.0
"""Holds what the steps of bench_gpu.py share: running eikon with a limit of time, logs, what failed, and the results so far."""
import concurrent.futures
import json
import os
import pathlib
import re
import signal
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# They say what eikon runs on a device, and how. The reference is rendered without them.
EXECUTION_VARIABLES = ("EIKON_FAULT", "EIKON_LANES", "EIKON_STAGES", "EIKON_NO_OPTIMISE", "EIKON_UNIT_PATHS", "EIKON_UNIT_BLOCK",
                       "EIKON_KERNEL_DIR")


class Failed(Exception):
    """A command failed; the message is its one line. out: what it printed until then"""

    def __init__(self, line, code=None, out=""):
        super().__init__(line)
        self.code, self.out = code, out


class LeftOut(Exception):
    """A step cannot be done here, which is nobody's fault; the message says why."""


def one_line(text):
    """The line of a command's messages that says why it failed: eikon's own, or else the last one."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    own = [line for line in lines if line.startswith("eikon: ")]
    return (own or lines or ["it said nothing"])[-1]


class Session:
    """The folder of an archive and what has been found so far."""

    def __init__(self, options, sizes, folder, scratch=None):
        """scratch: a folder for what the archive does not need [folder]"""
        self.options, self.sizes, self.folder, self.scratch = options, sizes, folder, scratch or folder
        self.end = time.monotonic() + options.seconds if options.seconds else None
        self.results = {}   # by step: what the page shows
        self.steps = []     # {"step", "result", "seconds"}
        self.failures = []  # {"step", "what", "line", "code": of the command that failed, or None}
        self.made = {}      # scenes that are not shipped: name -> file
        self.film_options = {}  # of films that take more than a scene: name -> words for eikon
        (folder / "logs").mkdir(exist_ok=True)

    def scene(self, name):
        return self.made.get(name, ROOT / f"scenes/{name}.gltf")

    def seconds_left(self, most):
        """Seconds that a command may take. throws Failed when there are none"""
        if self.end is None:
            return most
        left = self.end - time.monotonic()
        if left <= 1:
            raise Failed("the time of --seconds is over")
        return min(most, left)

    def run(self, name, command, environment=None):
        """Runs a command, and keeps what it prints under the name. environment: variables, where None takes one away
        returns  its standard output. throws Failed"""
        variables = {**os.environ, **(environment or {})}
        variables = {key: value for key, value in variables.items() if value is not None}
        limit = self.seconds_left(self.sizes["command_seconds"])
        log = self.folder / "logs" / (re.sub(r"[^\w.-]+", "_", name) + ".txt")
        try:
            process = subprocess.Popen([str(word) for word in command], env=variables, stdin=subprocess.DEVNULL, text=True,
                                       errors="replace", stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
        except OSError as error:
            raise Failed(f"{command[0]}: {error.strerror}") from error
        try:
            out, messages = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            out, messages = process.communicate()
            messages += f"\nstopped after {limit:.0f} s"
        log.write_text(f"$ {' '.join(map(str, command))}\n{out}\n{messages}\nexit code {process.returncode}\n")
        if process.returncode != 0:
            died = f" (signal {-process.returncode})" if process.returncode < 0 else ""
            raise Failed(one_line(messages) + died, process.returncode, out)
        return out

    def eikon(self, name, words, environment=None):
        return self.run(name, [self.options.eikon, *words], environment)

    def json(self, name, words, flag, environment=None):
        """Runs `eikon words flag FILE` and returns what it writes there as JSON."""
        path = self.scratch / (re.sub(r"[^\w.-]+", "_", name) + ".json")
        path.unlink(missing_ok=True)
        self.eikon(name, [*words, flag, path], environment)
        try:
            return json.loads(path.read_text())
        finally:
            path.unlink()

    def each(self, step, names, body, jobs=1):
        """[body(name)] of those that do not fail; the others are recorded, and so is one that finds no time. jobs: how many at a time"""
        def done(name):
            try:
                return body(name)
            except Failed as error:
                self.fail(step, name, error)

        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            return [found for found in pool.map(done, names) if found is not None]

    def fail(self, step, what, error):
        what = " ".join(map(str, what)) if isinstance(what, tuple) else what
        line = str(error).replace(f"{self.folder}/", "").removeprefix("eikon: ")
        self.failures.append({"step": step, "what": what, "line": line, "code": getattr(error, "code", None)})

    def do(self, step, body):
        """Does a step, whatever comes of it."""
        print(f"{step} ...", end=" ", flush=True)
        begin, before = time.monotonic(), len(self.failures)
        result = "ok"
        try:
            self.results[step] = body(self)
        except LeftOut as why:
            result = f"left out: {why}"
        except Failed as error:
            self.fail(step, step, error)
        except (KeyError, ValueError, TypeError, OSError) as error:  # what a tool wrote is not as expected, or cannot be written
            self.fail(step, step, f"{type(error).__name__}: {error}")
        if len(self.failures) > before:
            result = f"{len(self.failures) - before} failed"
        self.steps.append({"step": step, "result": result, "seconds": time.monotonic() - begin})
        print(f"{result}  ({self.steps[-1]['seconds']:.1f} s)", *(f["line"] for f in self.failures[before:]), sep="\n    ", flush=True)
