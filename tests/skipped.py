#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads what ctest wrote with --output-junit and lists the tests that were skipped.

    skipped.py JUNIT      exit code 1 if one was skipped for another reason than those below

What tools/setup.sh installs is there in continuous integration, so a test that misses it has to fail there."""
import re
import sys
import xml.etree.ElementTree

# Rights, hardware and packages that set-up cannot give.
ACCEPTED = re.compile(r"cannot be divided|can be divided|divides so|not allowed to mount|may write everywhere|"
                      r"EIKON_OIDN does not name|flip-evaluator is not installed|memory of their own|"
                      r"processor with vectors")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    missing = []
    for case in xml.etree.ElementTree.parse(sys.argv[1]).getroot().iter("testcase"):
        if case.find("skipped") is None:
            continue
        output = case.findtext("system-out") or ""
        accepted = ACCEPTED.search(output)
        print(f"skipped{'' if accepted else ', but must not be'}: {case.get('name')}: {accepted.group(0) if accepted else output.strip()[-300:]}")
        if not accepted:
            missing.append(case.get("name"))
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
