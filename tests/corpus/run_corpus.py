#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Loads every scene of a corpus (tools/make_corpus.py), each in a process of its own, and judges how that ended.

    run_corpus.py RUNNER CORPUS [--jobs N]

RUNNER: the program corpus_reader, built with sanitizers. A scene that loads ends with 0; one that does not with 3 and one line on stderr that
begins with "eikon: ". Neither a signal, nor a sanitizer's report, nor more than 10 s of processor time or 2 GB is ever right, and no message quotes
what lies outside the scene's folder.
"""

import argparse
import concurrent.futures
import os
import queue
import subprocess
import sys
import tempfile

SECONDS = 10
BYTES = 2 << 30


class Runner:
    """A process that runs one scene after another."""

    def __init__(self, program, folder):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.files = [tempfile.NamedTemporaryFile(dir=folder) for _ in range(2)]

    def run(self, scene):
        """(exit code or negative signal, stdout, stderr, seconds, peak bytes); exit code None: out of time."""
        self.process.stdin.write("\t".join([*(file.name for file in self.files), str(SECONDS), scene]) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline().split()
        if len(answer) != 3:
            raise RuntimeError(f"the runner ended at {scene}")
        text = []
        for file in self.files:
            with open(file.name, "rb") as written:
                text.append(written.read().decode("utf-8", "replace"))
        status = int(answer[0])
        code = None if status < 0 else os.waitstatus_to_exitcode(status)
        return code, text[0], text[1], float(answer[1]), int(answer[2]) * 1024

    def end(self):
        self.process.stdin.close()
        return self.process.wait()


def judge(expect, code, out, err, peak):
    """What is wrong; empty if nothing is."""
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
    args = parser.parse_args()
    with open(os.path.join(args.corpus, "cases.txt"), encoding="utf-8") as file:
        cases = [line.rstrip("\n").split("\t") for line in file]

    folder = tempfile.TemporaryDirectory()
    runners = queue.SimpleQueue()
    for _ in range(args.jobs):
        runners.put(Runner(args.runner, folder.name))

    def attempt(case):
        name, scene, expect = case
        runner = runners.get()
        try:
            code, out, err, seconds, peak = runner.run(os.path.join(args.corpus, scene))
        finally:
            runners.put(runner)
        return name, judge(expect, code, out, err, peak), code, err, seconds, peak

    wrong = refused = 0
    slowest = largest = 0.0
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        for name, fault, code, err, seconds, peak in pool.map(attempt, cases):
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
    sys.exit(1 if wrong or any(failed) or len(cases) < 500 else 0)


if __name__ == "__main__":
    main()
