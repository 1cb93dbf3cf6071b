# SPDX-License-Identifier: Apache-2.0
"""The one kind of error that a command of the farm ends with: a line, and an exit code of eikon's table."""

NOT_AS_ASKED, USAGE, INPUT, DEVICE = 1, 2, 3, 4


class FarmError(Exception):
    """A line that says what failed, on what, why, and what to try."""

    def __init__(self, message, code=INPUT):
        super().__init__(" ".join(str(message).split()))
        self.code = code
