# SPDX-License-Identifier: Apache-2.0
"""Runs the program eikon, and reads what it says. Needs no Blender."""
import pathlib
import shutil
import subprocess
import threading

DONE, NOT_AS_ASKED = 0, 1  # exit codes


class EikonError(Exception):
    """One line for the user."""


def find_eikon(preferred):
    """The program that the preferences name, or else that of PATH. Raises EikonError."""
    if preferred:
        path = pathlib.Path(preferred).expanduser()
        if not path.is_file():
            raise EikonError('eikon: the preferences of the add-on name "%s", which is not there' % path)
        return str(path)
    found = shutil.which("eikon")
    if found is None:
        raise EikonError("eikon: the program is not in PATH; name it in the preferences of the add-on")
    return found


class Eikon:
    """A render that goes on."""

    def __init__(self, program, flags, folder):
        """Starts `program render FLAGS...`. Raises EikonError when it cannot be started."""
        self.progress, self.status = 0.0, ""
        self.lines = []  # what it wrote to stderr
        try:
            self.process = subprocess.Popen([program, "render", *flags, "--progress", "openjd", "--quiet"], cwd=folder,
                                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                            text=True, encoding="utf-8", errors="replace")
        except OSError as error:
            raise EikonError("eikon: cannot start %s: %s" % (program, error.strerror)) from error
        self.readers = [threading.Thread(target=read, daemon=True) for read in (self._read_progress, self._read_lines)]
        for reader in self.readers:
            reader.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.cancel()

    def _read_progress(self):
        with self.process.stdout as lines:
            for line in lines:
                kind, _, text = line.strip().partition(": ")
                if kind == "openjd_progress":
                    self.progress = float(text) / 100
                elif kind == "openjd_status":
                    self.status = text

    def _read_lines(self):
        with self.process.stderr as lines:
            self.lines.extend(line.strip() for line in lines if line.strip())

    def wait(self, seconds):
        """True once it has ended; waits so long at most."""
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            return False
        for reader in self.readers:
            reader.join()
        return True

    def cancel(self):
        """Asks it to end, and sees to it that it does."""
        self.process.terminate()
        if not self.wait(10):
            self.process.kill()
            self.wait(None)

    def failure(self):
        """After its end: the line that says why there is no picture, or "" if there is one."""
        code = self.process.returncode
        if code in (DONE, NOT_AS_ASKED):
            return ""
        if self.lines:
            return self.lines.pop()
        return "eikon: ended by signal %d" % -code if code < 0 else "eikon: ended with exit code %d" % code
