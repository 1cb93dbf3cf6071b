#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Loads every scene of a corpus (tools/make_corpus.py), and judges how that ended.

    run_corpus.py RUNNER CORPUS [--jobs N] [--batch N]

RUNNER: the program corpus_reader, built with sanitizers. A scene that loads ends with 0; one that does not with 3 and one line on stderr that
begins with "eikon: ". Neither a signal, nor a sanitizer's report, nor more than 10 s of processor time or 2 GB is ever right, and no message quotes
what lies outside the scene's folder. A process loads several scenes, since its start and the search for leaks at its end take most of the
time; where anything is wrong, each of them is loaded again, in a process of its own.
"""

import argparse
import concurrent.futures
import os
import queue
import re
import subprocess
import sys
import tempfile

SECONDS = 10
BYTES = 2 << 30
BATCH = 32
LEAST_CASES = 500  # tools/make_corpus.py makes more


class Runner:
    """A process that starts one process after another to load scenes."""

    def __init__(self, program, folder):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.files = [tempfile.NamedTemporaryFile(dir=folder) for _ in range(2)]

    def run(self, scenes):
        """(exit code or negative signal of the process, stdout, what each scene came to, what it said after them, peak bytes); exit code
        None: out of time. A scene comes to (exit code, stderr, seconds)."""
        self.process.stdin.write("\t".join([*(file.name for file in self.files), str(SECONDS), *scenes]) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline().split()
        if len(answer) != 3:
            raise RuntimeError(f"the runner ended at one of {scenes}")
        text = []
        for file in self.files:
            with open(file.name, "rb") as written:
                text.append(written.read().decode("utf-8", "replace"))
        status = int(answer[0])
        code = None if status < 0 else os.waitstatus_to_exitcode(status)
        *pieces, rest = text[1].split("\0")
        loaded = []
        for err, end in zip(pieces[::2], pieces[1::2]):
            one = re.fullmatch(r"(\d+) (\d+\.\d+)", end)
            if not one:  # a message with a zero byte
                loaded, rest = [], text[1]
                break
            loaded.append((int(one[1]), err, float(one[2])))
        return code, text[0], loaded, rest, int(answer[2]) * 1024

    def end(self):
        self.process.stdin.close()
        return self.process.wait()


def judge(expect, code, out, err, peak):
    """What is wrong with a scene; empty if nothing is."""
    if code is None:
        return f"took more than {SECONDS} s"
    if code < 0:
        return f"ended by signal {-code}"
    if "Sanitizer" in err or "runtime error" in err:
        return "a sanitizer's report"
    if peak > BYTES:
        return f"took {peak >> 20} MB"
    if code not in (0, 3):
        return f"exit code {code}"
    if expect == "good" and code != 0:
        return "a good scene was refused"
    if expect == "bad" and code != 3:
        return "a bad scene was accepted"
    lines = err.splitlines()
    if code == 3 and (len(lines) != 1 or not lines[0].startswith("eikon: ")):
        return f"{len(lines)} lines instead of one that begins with 'eikon: '"
    if "root:x:" in out + err:
        return "shows a file outside the scene's folder"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runner")
    parser.add_argument("corpus")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--batch", type=int, default=BATCH, help="scenes that a process loads")
    args = parser.parse_args()
    with open(os.path.join(args.corpus, "cases.txt"), encoding="utf-8") as file:
        cases = [line.rstrip("\n").split("\t") for line in file]

    folder = tempfile.TemporaryDirectory()
    runners = queue.SimpleQueue()
    for _ in range(args.jobs):
        runners.put(Runner(args.runner, folder.name))

    def attempt(batch):
        """[(name, what is wrong, exit code, stderr, seconds, peak bytes)] of each case"""
        runner = runners.get()
        try:
            code, out, loaded, rest, peak = runner.run([os.path.join(args.corpus, scene) for _, scene, _ in batch])
        finally:
            runners.put(runner)
        if len(loaded) < len(batch) or code != 0:  # also one that ends well, but too soon
            loaded += [(1, "", 0.0)] * (len(batch) - len(loaded))
            loaded[-1] = (1 if code == 0 else code, loaded[-1][1] + rest, loaded[-1][2])
        found = [(name, judge(expect, code, out, err, peak), code, err, seconds, peak)
                 for (name, _, expect), (code, err, seconds) in zip(batch, loaded)]
        if len(batch) == 1 or not any(fault for _, fault, *_ in found):
            return found
        alone = [one for case in batch for one in attempt([case])]
        if not any(fault for _, fault, *_ in alone):
            alone[-1] = (f"{batch[0][0]} to {batch[-1][0]} in one process", *next(one for one in found if one[1])[1:])
        return alone

    batches = [cases[begin:begin + args.batch] for begin in range(0, len(cases), args.batch)]
    wrong = refused = 0
    slowest = largest = 0.0
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for name, fault, code, err, seconds, peak in (one for found in pool.map(attempt, batches) for one in found):
            refused += code == 3
            slowest, largest = max(slowest, seconds), max(largest, peak)
            if fault:
                wrong += 1
                print(f"{name}: {fault}\n  " + "\n  ".join(err.splitlines()[:12]))
    print(
        f"{len(cases)} cases, {refused} refused, {wrong} wrong; slowest {slowest:.2f} s, largest {largest / 2**20:.0f} MB"
    )
    failed = [runner.end() for runner in (runners.get() for _ in range(args.jobs))]
    if any(failed):
        print(f"the runners ended with {failed}")
    too_few = len(cases) < LEAST_CASES
    if too_few:
        print(f"{len(cases)} cases are too few: the corpus was not made as it should be")
    sys.exit(1 if wrong or any(failed) or too_few else 0)


if __name__ == "__main__":
    main()
