# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What the classes of the library that have only fields, such as reports and settings, show of themselves."""

_LONGEST = 6


def _shown(value):
    """A value on one line; long lists and arrays by their size."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if hasattr(value, "shape"):
        return f"<array {' x '.join(map(str, value.shape))}>" if value.size > _LONGEST else repr(value.tolist())
    if isinstance(value, (list, tuple, dict)) and len(value) > _LONGEST:
        return f"<{len(value)} entries>"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_shown, value)) + "]"
    if hasattr(type(value), "__members__"):
        return value.name
    return repr(value)


def _fields(cls):
    """Names of the fields, those of base classes first."""
    names = [name for base in reversed(cls.__mro__) for name, member in vars(base).items() if isinstance(member, property)]
    return [name for name in dict.fromkeys(names) if not name.startswith("_")]


def _shown_field(thing, name):
    try:
        return _shown(getattr(thing, name))
    except Exception as error:  # a field that is not to be had says why
        return f"<{error}>"


def represent(thing):
    """<SolverReport status=CONVERGED iterations=7 ...>"""
    cls = type(thing)
    return f"<{' '.join([cls.__name__, *(f'{name}={_shown_field(thing, name)}' for name in _fields(cls))])}>"


def add_to(classes):
    """Gives `represent` to those that have fields and no text of their own."""
    for cls in classes:
        own = any("__repr__" in vars(base) for base in cls.__mro__ if base.__module__.startswith("hybrid"))
        if not own and _fields(cls) and not issubclass(cls, Exception):
            cls.__repr__ = represent
