#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lists the tests that were skipped, by the reports that ctest (--output-junit) and GoogleTest (--gtest_output=xml) wrote.

    skipped.py REPORT...      exit code 1 if one was skipped for another reason than those below

What tools/setup.sh installs is there in continuous integration, so a test that misses it has to fail there."""
import re
import sys
import xml.etree.ElementTree

# Rights, hardware and packages that set-up cannot give.
ACCEPTED = re.compile(r"cannot be divided|can be divided|divides so|not allowed to mount|may write everywhere|"
                      r"EIKON_OIDN does not name|EIKON_BASISU does not name|EIKON_OPENJD does not name|EIKON_BPY does not name|by another user than root|"
                      r"flip-evaluator is not installed|PyPI does not give ptxas|memory of their own|"
                      r"processor with vectors")


def skipped_tests(report):
    """(name, reason) of each."""
    for case in xml.etree.ElementTree.parse(report).getroot().iter("testcase"):
        skipped = case.find("skipped")
        if skipped is not None:
            yield case.get("name"), (skipped.get("message") or "") + (case.findtext("system-out") or "")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    missing = 0
    for report in sys.argv[1:]:
        for name, output in skipped_tests(report):
            accepted = ACCEPTED.search(output)
            why = accepted.group(0) if accepted else output.strip()[-300:]
            print(f"skipped{'' if accepted else ', but must not be'}: {name}: {why}")
            missing += accepted is None
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
