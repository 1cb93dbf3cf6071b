# SPDX-License-Identifier: Apache-2.0
"""Numbers of a table as the lines of a C initialiser, for the tools that write kernels' tables."""


def lines_of(texts):
    """Literals, each as it is to stand there, with commas, on indented lines of at most 120 columns."""
    lines, line = [], "   "
    for text in texts:
        if len(line) + len(text) + 2 > 120:
            lines.append(line)
            line = "   "
        line += " " + text + ","
    return "\n".join([*lines, line])
