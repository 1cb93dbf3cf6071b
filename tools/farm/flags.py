# SPDX-License-Identifier: Apache-2.0
"""Checks what flags say: numbers in their range, and words that begin with dashes. A wrong one ends the command with a line."""
import argparse
import math
import re
import shlex

from . import errors


class Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, as eikon does."""

    def error(self, message):
        about = message.removeprefix("argument ")
        raise errors.FarmError(f"{self.prog.removeprefix('eikon-farm ')}: {about}; see `{self.prog} --help`", errors.USAGE)


def whole(least, most):
    """A whole number in this range."""
    def read(text):
        try:
            value = int(text)
        except ValueError:
            value = None
        if value is None or not least <= value <= most:
            raise argparse.ArgumentTypeError(f"'{text}' is not a whole number from {least} to {most}")
        return value
    return read


def number(least, most, below=False):
    """A finite number in this range. below: without its upper end"""
    def read(text):
        value = number_of(text)
        if not least <= value <= most or below and value == most:
            raise argparse.ArgumentTypeError(f"'{text}' is not a number from {least:g} to {'below ' if below else ''}{most:g}")
        return value
    return read


def number_of(text):
    """The number that a text says; NaN, which is in no range, if it says none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


PARTS, THROTTLE, NODES = whole(1, 1_000_000), whole(0, 1_000_000), whole(1, 100_000)
THREADS, MEGABYTES, MINUTES = whole(0, 65_536), whole(1, 10**9), whole(1, 366 * 24 * 60)
SIGNAL_S = whole(0, 65_535)  # as sbatch takes it
CHECKPOINT_S = number(0.01, 1e9)  # as eikon render takes it
SHARE, PER_HOUR, DISK_MB_S = number(0, 1, below=True), number(0, 1e6), number(0.001, 1e9)
MEASURED_S, WAIT_S = number(0, 3600), number(0, 86400)


def joined(words):
    """`--sbatch WORDS` as `--sbatch=WORDS`: WORDS that begin with a dash would count as another flag."""
    kept, rest = [], iter(words)
    for word in rest:
        value = next(rest, None) if word == "--sbatch" and words[0] in ("submit", "openjd") else None
        kept.append(word if value is None else f"{word}={value}")
    return kept


def split(texts):
    """The words for sbatch, of each --sbatch."""
    words = []
    for text in texts:
        try:
            words += shlex.split(text)
        except ValueError as error:
            raise errors.FarmError(f"--sbatch {text}: {error}: close its quotes", errors.USAGE) from error
    for word in words:
        if not word.isprintable():
            raise errors.FarmError(f"--sbatch: {word!r} has characters that a line of a script cannot have", errors.USAGE)
    return words


def quote_for_sbatch(word):
    """A word of an #SBATCH line, where Slurm takes a backslash for an escape in single quotes too."""
    return word if re.fullmatch(r"[\w@%+=:,./-]+", word, re.ASCII) else '"' + re.sub(r'(["\\])', r"\\\1", word) + '"'
