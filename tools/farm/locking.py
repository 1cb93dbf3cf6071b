# SPDX-License-Identifier: Apache-2.0
"""Lets one command at a time change a farm: two would each submit what the other one has submitted."""
import contextlib
import errno
import os
import pathlib
import socket

from . import errors


def began(process):
    """Returns when a process of this machine began, as text, or "-" where the system does not say it. Its number may be that
    of a later process by now."""
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[19]
    except (OSError, IndexError):
        return "-"


def is_gone(holder):
    """Tells whether the process that a lock names was one of this machine, and has ended."""
    try:
        host, process, since = holder.split()
        if host != socket.gethostname():
            return False
        os.kill(int(process), 0)
        return began(process) != since
    except ProcessLookupError:
        return True
    except (ValueError, OSError):
        return False  # just being written, or of another user


def take_over(file, holder):
    """Removes the lock of a process that is gone, unless another one has done so meanwhile."""
    aside = file.with_name(f"{file.name}.{socket.gethostname()}.{os.getpid()}")
    with contextlib.suppress(FileNotFoundError):
        file.rename(aside)
        if aside.read_text() != holder:
            with contextlib.suppress(FileExistsError):
                os.link(aside, file)
        aside.unlink()


@contextlib.contextmanager
def locked(path):
    """Holds the lock of a farm's folder. It is a file, since a network file system may not know other locks."""
    file, own = path / "lock", f"{socket.gethostname()} {os.getpid()} {began(os.getpid())}\n"
    while True:
        try:
            handle = os.open(file, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644)
            break
        except FileExistsError:
            try:
                holder = file.read_text(errors="replace")
            except FileNotFoundError:
                continue
        except OSError as error:
            if error.errno in (errno.ENOSPC, errno.EDQUOT):
                handle = None  # `cancel` has to work on a full disk, and nothing is submitted there
                break
            raise errors.FarmError(f"cannot write {file}: {error.strerror}") from error
        if not is_gone(holder):
            host, process = (holder.split() + ["?", "?"])[:2]
            raise errors.FarmError(f"{path}: another eikon-farm, process {process} on {host}, changes it: try again when that has "
                                   f"ended, or remove {file} if there is none")
        take_over(file, holder)
    try:
        if handle is not None:
            with contextlib.suppress(OSError), os.fdopen(handle, "w") as opened:
                opened.write(own)
        yield
    finally:
        with contextlib.suppress(OSError):
            if handle is not None and file.read_text() in ("", own):
                file.unlink()
