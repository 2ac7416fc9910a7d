# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Files that are made of bags: all or none of them, and what is told."""

import contextlib
import filecmp
import os
import pathlib
import signal
import sys
import tempfile

from bag_words import DAMAGE, BagError, FileError, in_a_line, say
from mcap_bag import check_regular, named


def check_target(path, inputs):
    """What is written takes the place of a regular file, and not of a bag."""
    if path.exists():
        with named(f"cannot write {path}"):
            check_regular(path.stat().st_mode)
            if any(bag.exists() and path.samefile(bag) for bag in inputs):
                raise BagError("is the bag that is read")


def free_name(path):
    aside, k = f"{path}~", 2
    while os.path.lexists(aside):
        aside, k = f"{path}~{k}", k + 1
    return aside


def is_same(file, other):
    return other.exists() and filecmp.cmp(file, other, shallow=False)


def publish(part, folder, are_kept):
    """Moves files from one folder to another, all or none. Others that were there get new names if they are kept, which
    the lines that are returned tell."""
    moved, lines = [], []
    try:
        for file in sorted(part.iterdir()):
            target = folder / file.name
            if are_kept and os.path.lexists(target) and not is_same(file, target):
                aside = free_name(target)
                os.rename(target, aside)
                moved.append((target, aside))
                lines.append(f"{target} was there before; it is now {aside}")
            os.replace(file, target)
            moved.append((file, target))
    except BaseException:
        for before, now in reversed(moved):
            os.replace(now, before)
        raise
    return lines


@contextlib.contextmanager
def staged(shown, folder, others, names=(), inputs=()):
    """A hidden folder whose files, of these names, appear in `folder` once all are complete; a failure leaves what was
    there. `others` that are there are "kept" under new names, "replaced" or "refused". Messages name what is shown."""
    made, lines = [], []
    try:
        if not str(shown):
            raise FileError("cannot write: the name is empty")
        if others == "refused" and folder.exists() and next(folder.iterdir(), None):
            raise FileError(f"{shown} is not empty: name a folder that is empty or new")
        for name in names:
            check_target(folder / name, inputs)
        made = [path for path in (folder, *folder.parents) if not path.exists()]
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".", dir=folder, ignore_cleanup_errors=True) as part:
            yield pathlib.Path(part)
            lines = publish(pathlib.Path(part), folder, others == "kept")
        made = []
    except OSError as error:
        raise FileError(f"cannot write {shown}: {error.strerror}") from None
    finally:
        for path in made:
            with contextlib.suppress(OSError):
                path.rmdir()
    for line in lines:
        say(line)


def told(program, convert, options):
    """Runs a conversion; what is wrong is told in one line. Signals end it with nothing written."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    bags = " ".join(options.bag)
    try:
        convert(options)
        return 0
    except KeyboardInterrupt:
        return 128 + signal.SIGINT
    except FileError as error:
        what = str(error)
    except BagError as error:
        what = f"{bags}: {error}"
    except OSError as error:
        what = f"{error.filename or bags}: {error.strerror}"
    except DAMAGE as error:
        what = f"{bags}: messages are damaged, or not as ROS defines them: {type(error).__name__} {error}"
    return f"{program}: {in_a_line(what)}"
