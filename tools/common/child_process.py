# SPDX-License-Identifier: Apache-2.0
"""Runs a command to its end and tells what it took: seconds of the clock and of the processor, and memory. Linux alone."""

import os
import pathlib
import subprocess
import sys
import tempfile
import time
import typing


class Finished(typing.NamedTuple):
    """A command that has ended, with what it printed and took. Processes that it waited for count with it."""
    exit_code: int  # below zero: the number of the signal that ended it
    stdout: str
    stderr: str
    wall_s: float
    user_s: float
    system_s: float
    peak_bytes: int  # the most memory that was resident at a time; the kernel counts it in 1024 bytes

    @property
    def processor_s(self):
        """The seconds of the processor, the user's and the system's."""
        return self.user_s + self.system_s

    @property
    def peak_mib(self):
        """The most memory in units of 2^20 bytes."""
        return self.peak_bytes / (1 << 20)


def run(command, **more):
    """Runs the words of `command`, of any type that str() takes, and returns a Finished. more: what subprocess.Popen takes
    besides, such as cwd= and env=. Raises OSError if the command cannot be started.

    The kernel lets the peak of a child begin with the memory of the process that starts it. So a parent with large arrays
    measures its own memory; peak_bytes_from_small_parent() does not."""
    with tempfile.TemporaryFile("w+", errors="replace") as stdout, tempfile.TemporaryFile("w+", errors="replace") as stderr:
        begin = time.monotonic()
        child = subprocess.Popen([str(word) for word in command], stdout=stdout, stderr=stderr, **more)
        try:
            _, status, usage = os.wait4(child.pid, 0)
        except BaseException:  # such as Ctrl-C: nothing is left running
            child.kill()
            child.wait()
            raise
        wall_s = time.monotonic() - begin
        child.returncode = os.waitstatus_to_exitcode(status)  # else Popen would wait for the child again
        stdout.seek(0)
        stderr.seek(0)
        return Finished(child.returncode, stdout.read(), stderr.read(), wall_s, usage.ru_utime, usage.ru_stime,
                        1024 * usage.ru_maxrss)


def run_or_exit(*command, **more):
    """Does what run() does, and ends this script with one line if the command cannot be started or fails."""
    words, script = " ".join(str(word) for word in command), pathlib.Path(sys.argv[0]).name
    try:
        done = run(command, **more)
    except OSError as error:
        sys.exit(f"{script}: {words} cannot be started: {error.strerror}")
    if done.exit_code != 0:
        sys.exit(f"{script}: {words} ended with {done.exit_code}: {done.stderr.strip()}")
    return done


def peak_bytes_from_small_parent(*command):
    """Returns the most memory of a command that a small process starts instead of this one; ends this script if it fails."""
    return int(run_or_exit(sys.executable, __file__, *command).stdout)


if __name__ == "__main__":
    print(run_or_exit(*sys.argv[1:]).peak_bytes)
