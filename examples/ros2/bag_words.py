# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What is wrong with a bag, and lines that tell it."""

import os
import sys

# What a message or a definition that is damaged, or not as ROS has it, leads to.
DAMAGE = (ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError, ValueError)


class BagError(Exception):
    """What is wrong with a bag, for the user."""


class FileError(BagError):
    """The same, with the name of the file."""


def in_a_line(text):
    """With escapes for line ends and control characters, which the names in a damaged bag have."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def say(text):
    """Prints a line. An output that is full, or whose reader has gone, loses it, and no more."""
    try:
        print(in_a_line(text), flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
