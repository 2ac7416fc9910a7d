#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Type stubs from the signatures in the built package: make_stubs.py > python/hybrid/__init__.pyi

PYTHONPATH must contain the built package. A test compares the output with the committed file.
"""

import enum
import inspect
import re
import sys

sys.path.pop(0)  # the folder of this file, which holds the sources of the package

import hybrid
from hybrid._mistakes import split

HEAD = '''# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
# Written by python/make_stubs.py.
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, ClassVar, overload

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
KeyLike = Key | str
'''
# Special methods that are listed in the stubs.
SHOWN = {"__init__", "__getitem__", "__setitem__", "__delitem__", "__contains__", "__len__", "__mul__", "__matmul__",
         "__eq__", "__lt__", "__hash__", "__copy__", "__deepcopy__", "__iter__"}


def to_type(text, argument):
    """The type of Python's checkers for one named by pybind11. Arguments accept more types than results have."""
    text = text.replace("hybrid._core.", "")
    text = re.sub(r"numpy\.ndarray\[(?:bool|numpy\.bool_?)\]", "npt.NDArray[np.bool_]", text)
    text = re.sub(r"numpy\.ndarray\[numpy\.int32\]", "npt.NDArray[np.int32]", text)
    text = re.sub(r"numpy\.ndarray(\[numpy\.float64(\[[^\]]*\](, flags\.\w+)*)?\])?", "Array", text)
    if argument:
        text = re.sub(r"\bKey\b", "KeyLike", text).replace("Array", "npt.ArrayLike")
        text = re.sub(r"^Assignment$", "Assignment | dict[KeyLike, int]", text).replace("List[", "Sequence[")
        text = re.sub(r"^Values$", "Values | dict[KeyLike, Any]", text)
        text = re.sub(r"^Estimate$", "Estimate | Values | dict[KeyLike, Any]", text)
    text = re.sub(r"Optional\[(.*)\]$", r"\1 | None", re.sub(r"Optional\[(\w+)\]", r"\1 | None", text))
    text = text.replace("Tuple[", "tuple[").replace("List[", "list[").replace("Dict[", "dict[")
    text = re.sub(r"\bIterable\b(?!\[)", "Iterable[Any]", re.sub(r"\bIterator\b(?!\[)", "Iterator[Any]", text))
    text = re.sub(r"\blist\b(?!\[)", "list[Any]", re.sub(r"\bdict\b(?!\[)", "dict[Any, Any]", text))
    return re.sub(r"\bobject\b|\bhandle\b", "Any", re.sub(r"\btuple\b(?!\[)", "tuple[Any, ...]", text))


def parameter(text):
    if text.startswith(("*", "self")):
        return text.split(":")[0]
    name, rest = text.split(": ", 1)
    kind, *default = re.split(r" = ", rest, maxsplit=1)
    plain = default and re.fullmatch(r"[-\w.]+|'\w*'", default[0])
    value = f" = {default[0] if plain else '...'}" if default else ""
    optional = " | None" if value == " = None" and "None" not in kind and "Optional" not in kind else ""
    return f"{name}: {to_type(kind, True)}{optional}{value}"


def signatures(name, doc):
    """Parameters and result of each overload."""
    found = re.findall(rf"^(?:\d+\. )?{re.escape(name)}\((.*)\) -> (.+)$", doc or "", re.MULTILINE)
    made = [([parameter(part) for part in split(inside)], to_type(result, False)) for inside, result in found]
    # Overloads that differ by the shape of an array alone are one to a checker of types.
    kinds = [tuple(part.partition(": ")[2] for part in parameters) for parameters, _ in made]
    return [entry for i, entry in enumerate(made) if kinds[i] not in kinds[:i] or not kinds[i]]


def fields(cls):
    """The keywords of a class of settings, as parameters."""
    names = [name for name, member in vars(cls).items() if isinstance(member, property) and member.fset]
    types = (signatures("", vars(cls)[name].fget.__doc__)[0][1] for name in names)
    return [f"{name}: {to_type(kind, True)} = ..." for name, kind in zip(names, types)]


def function(name, doc, indent="", static=False, cls=None):
    """The overloads of a function or method; for the constructor of a class of settings `cls`, its keywords."""
    lines = []
    all_of_it = signatures(name, doc)
    for parameters, result in all_of_it:
        if "**kwargs" in parameters:
            parameters = ["self", "*", *fields(cls)]
        if name == "__eq__":
            parameters = ["self", "other: object"]
        if len(all_of_it) > 1:
            lines.append(f"{indent}@overload")
        if static:
            lines.append(f"{indent}@staticmethod")
        lines.append(f"{indent}def {name}({', '.join(parameters)}) -> {result}: ...")
    return lines


def property_lines(name, member):
    found = signatures("", member.fget.__doc__)
    kind = found[0][1] if found else "Any"
    lines = ["    @property", f"    def {name}(self) -> {kind}: ..."]
    if member.fset:
        lines += [f"    @{name}.setter", f"    def {name}(self, value: {to_type(kind, True)}) -> None: ..."]
    return lines


def class_lines(name, cls):
    if issubclass(cls, Exception):
        return [f"class {name}({cls.__base__.__name__}): ..."]
    bases = [base.__name__ for base in cls.__bases__ if base.__name__ != "pybind11_object"]
    lines = [f"class {name}({', '.join(bases)}):" if bases else f"class {name}:"]
    if hasattr(cls, "__members__"):
        lines += [f"    {member}: ClassVar[{name}]" for member in cls.__members__]
        return lines + ["    @property", "    def name(self) -> str: ...", "    @property",
                        "    def value(self) -> int: ...", "    def __int__(self) -> int: ..."]
    before = len(lines)
    for member, value in vars(cls).items():
        if member.startswith("_") and member not in SHOWN:
            continue
        if type(value).__name__ == "pybind11_static_property":
            lines.append(f"    {member}: ClassVar[int]")
        elif isinstance(value, property):
            lines += property_lines(member, value)
        elif isinstance(value, staticmethod):
            lines += function(member, value.__func__.__doc__, "    ", static=True)
        elif callable(value):
            lines += function(member, value.__doc__, "    ", cls=cls)
    return lines if len(lines) > before else [lines[0] + " ..."]


def annotation(text):
    """A type in the words of the stubs, of one in the words of the sources."""
    text = text.replace("collections.abc.", "").replace("str | os.PathLike", "Any").replace("pathlib.Path", "Any")
    text = text.replace("_core.", "").replace("hybrid.", "").replace("numpy.ndarray", "Array").replace("np.ndarray", "Array")
    return re.sub(r"\bdict\b(?!\[)", "dict[str, Any]", re.sub(r"^'(.*)'$", r"\1", text))


def python_function(name, value, indent=""):
    inside, result = str(inspect.signature(value))[1:].rsplit(") -> ", 1)
    parameters = [annotation(text) for text in split(inside)]
    return [f"{indent}def {name}({', '.join(parameters)}) -> {annotation(result)}: ..."]


def python_class(name, cls):
    lines = [f"class {name}({', '.join('dict[str, Any]' if base is dict else base.__name__ for base in cls.__bases__)}):"]
    for member, value in vars(cls).items():
        if isinstance(value, property):
            kind = annotation(str(inspect.signature(value.fget)).rsplit(") -> ", 1)[1])
            lines += ["    @property", f"    def {member}(self) -> {kind}: ..."]
        elif isinstance(value, classmethod):
            lines += ["    @classmethod", *python_function(member, value.__func__, "    ")]
        elif member == "__init__":
            parameters = [annotation(text) for text in split(str(inspect.signature(value))[1:-1])]
            lines += [f"    def {member}({', '.join(parameters)}) -> None: ..."]
    return lines


def stubs(package):
    lines = ["__version__: str"]
    for name in package.__all__:
        value = inspect.unwrap(getattr(package, name))
        if isinstance(value, type) and issubclass(value, dict):
            lines += ["", *python_class(name, value)]
        elif isinstance(value, type) and not issubclass(value, enum.Enum):
            lines += ["", *class_lines(name, value)]
        elif inspect.isfunction(value):
            lines += ["", *python_function(name, value)]
        else:
            lines += ["", *function(name, value.__doc__)]
    return HEAD + "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(stubs(hybrid), end="")
