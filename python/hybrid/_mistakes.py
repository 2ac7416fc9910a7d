# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Wrong arguments told in a sentence, in place of pybind11's list of overloads."""

import functools
import inspect
import re
import types

import numpy as np

from . import _core

_SPECIAL = {"__init__", "__getitem__", "__setitem__", "__delitem__", "__contains__", "__mul__", "__matmul__"}
_EXAMPLES = {"Key": "a key such as 'x3'", "Noise": "Noise, such as Noise.isotropic(3, 0.1)", "int": "a whole number", "float": "a number",
             "str": "a text", "bool": "True or False", "iterable": "an iterable", "Iterable": "an iterable", "dict": "a dict",
             "object": "anything", "DiscreteKey": "DiscreteKey, such as DiscreteKey('d0', 2)", "Values": "Values or a dict", "Estimate": "an Estimate, Values or a dict"}


def split(text):
    """The parts of a list of parameters, which may hold brackets and texts."""
    parts, depth, quote, start = [], 0, None, 0
    for i, c in enumerate(text):
        if quote:
            quote = None if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c in "([{<":
            depth += 1
        elif c in ")]}" or (c == ">" and text[i - 1] != "-"):
            depth -= 1
        elif c == "," and depth == 0:
            parts.append(text[start:i].strip())
            start = i + 1
    return [part for part in [*parts, text[start:].strip()] if part]


def _shape(kind):
    """The shape of an array that pybind11 names, as numbers and letters; None if it is not said."""
    found = re.match(r"numpy\.ndarray\[numpy\.\w+\[([^\]]*)\]", kind)
    return found and [int(size) if size.isdigit() else size for size in found[1].split(", ")]


def _fits_array(value, shape):
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        return False
    if shape is None or array.ndim == 0:
        return array.ndim > 0
    wanted = shape[:-1] if shape[-1] == 1 and array.ndim == 1 else shape
    return array.ndim == len(wanted) and all(isinstance(w, str) or w == size for w, size in zip(wanted, array.shape))


def _fits_sequence(value, inner):
    return isinstance(value, (list, tuple, np.ndarray)) and all(_fits(entry, inner) for entry in value)


def _fits_class(value, name):
    if name == "Key" and isinstance(value, str):
        return True
    if name in ("Values", "Estimate", "Assignment") and isinstance(value, dict):
        return True
    if name == "Estimate" and isinstance(value, _core.Values):
        return True
    return isinstance(value, getattr(_core, name, object))


def _fits(value, kind):
    """Whether an argument is of a type that pybind11 names."""
    generic = re.match(r"(Optional|List|Tuple|Callable)\[(.*)\]$", kind)
    if generic and generic[1] == "Optional":
        return value is None or _fits(value, generic[2])
    if generic and generic[1] == "List":
        return _fits_sequence(value, generic[2])
    if generic and generic[1] == "Tuple":
        inner = split(generic[2])
        return isinstance(value, (list, tuple)) and len(value) == len(inner) and all(map(_fits, value, inner))
    if kind.startswith(("Callable", "function")):
        return callable(value)
    if kind.startswith("numpy.ndarray"):
        return _fits_array(value, _shape(kind))
    if kind == "float":
        return hasattr(value, "__float__") or hasattr(value, "__index__")
    if kind == "int":
        return hasattr(value, "__index__")
    if kind in ("bool", "str", "dict", "list", "tuple"):
        return isinstance(value, {"bool": (bool, np.bool_), "str": (str, bytes), "dict": dict, "list": list, "tuple": tuple}[kind])
    if kind.lower() == "iterable":
        return hasattr(value, "__iter__")
    return _fits_class(value, kind) if hasattr(_core, kind) else True


def _told(kind):
    """A type in the words of users."""
    if kind.startswith("numpy.ndarray"):
        shape = [size for size in _shape(kind) or ["n"] if size != 1] or [1]
        return f"an array ({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
    generic = re.match(r"(Optional|List|Tuple)\[(.*)\]$", kind)
    if generic and generic[1] == "Optional":
        return f"{_told(generic[2])} or None"
    if generic and generic[1] == "List":
        return f"a list, each entry {_told(generic[2])}"
    if generic:
        return "a tuple of " + ", ".join(map(_told, split(generic[2])))
    return _EXAMPLES.get(kind, kind)


def _given(value):
    if value is None:
        return "None"
    name = type(value).__name__
    article = "an" if re.match(r"[aeiouAEIO]|S[EO]\d", name) else "a"
    short = f" ({value!r})" if isinstance(value, (int, float, str, bytes)) and len(repr(value)) < 40 else ""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    return f"{article} {name} of {len(value)}" if isinstance(value, (list, tuple)) else f"{article} {name}{short}"


def _overloads(doc, name):
    """Names, types and whether there is a default, of the parameters of each overload."""
    made = []
    for inside in re.findall(rf"^(?:\d+\. )?{re.escape(name)}\((.*)\) -> .+$", doc or "", re.MULTILINE):
        parts = [part.split(": ", 1) for part in split(inside.replace("hybrid._core.", ""))]
        if all(len(part) == 2 for part in parts):
            made.append([(label, *re.split(r" = ", kind, maxsplit=1)) for label, kind in parts])
    return made


def _complaints(parameters, arguments, keywords, skip):
    """What is wrong with the arguments for one overload: place, name, what is given (None: nothing), the type wanted."""
    wrong = []
    for place, (label, kind, *default) in enumerate(parameters):
        if place < len(arguments):
            value = arguments[place]
        elif label in keywords:
            value = keywords[label]
        elif default:
            continue
        else:
            wrong.append((place + 1 - skip, label, "is missing", kind))
            continue
        if not _fits(value, kind):
            wrong.append((place + 1 - skip, label, f"is {_given(value)}", kind))
    names = [label for label, *_ in parameters]
    wrong += [(place + 1 - skip, "", "is too many", "") for place in range(len(parameters), len(arguments))]
    return wrong + [(0, name, "is no argument", "") for name in keywords if name not in names]


def _distance(wrong):
    """How far arguments are from an overload: an argument that is missing is the least."""
    what = [entry[2] for entry in wrong]
    return len(what) - what.count("is missing"), len(what), what.count("is too many")


def _sentence(title, overloads, arguments, keywords, skip):
    """The mistake, by the overload that it is least far from; overloads that are as near add what they want."""
    all_wrong = [_complaints(parameters, arguments, keywords, skip) for parameters in overloads]
    all_wrong = [wrong for wrong in all_wrong if wrong]
    if not all_wrong:
        return None
    best = min(all_wrong, key=_distance)
    parts = []
    for entry, (place, label, what, kind) in enumerate(best):
        alike = [wrong[entry] for wrong in all_wrong if [w[0::2] for w in wrong] == [w[0::2] for w in best]] if kind else []
        kinds = list(dict.fromkeys(_told(wrong[3]) for wrong in alike))
        wanted = f"; wanted {', '.join(kinds[:-1]) + ' or ' if len(kinds) > 1 else ''}{kinds[-1]}" if kinds else ""
        which = f"argument {place}{f' ({label})' if label and not label.startswith('arg') else ''}" if place else f"'{label}'"
        parts.append(f"{which} {what}{wanted}")
    return f"{title}: {'; '.join(parts)}"


def _hint(owner, name, arguments):
    """Another method that takes several keys, where one key is wanted."""
    several = f"joint_{name}"
    if hasattr(owner, several) and any(isinstance(value, (list, tuple)) for value in arguments):
        return f"; {several} takes several keys"
    return ""


def _title(owner, name, arguments):
    if owner is None:
        return name
    if name == "__setitem__" and isinstance(arguments[1], (str, _core.Key)):
        return f"{owner.__name__}['{arguments[1]}']"
    return owner.__name__ if name.startswith("__") else f"{owner.__name__}.{name}"


def _explained(function, owner, field, arguments, keywords):
    """The sentence about arguments that a function does not take; None if there is none."""
    name, doc = function.__name__, function.__doc__
    if re.search(r"\(self: [\w.]+, \*\*kwargs\)", doc or ""):
        return f"{owner.__name__} takes its fields by name, such as {owner.__name__}({_first_field(owner)}=...)"
    skip = int(owner is not None and not isinstance(function, types.FunctionType) and "self" in (doc or ""))
    text = _sentence(_title(owner, field or name, arguments), _overloads(doc, name), arguments, keywords, skip)
    if text and (field or name == "__setitem__"):
        text = re.sub(r": argument \d \(?\w*\)? ?is", " is", text)
    return text and text + _hint(owner, name, arguments)


def _first_field(owner):
    return next(name for name, member in vars(owner).items() if isinstance(member, property))


def _telling(function, owner=None, field=""):
    """The function, with a sentence about arguments that it does not take."""
    start = f"{function.__name__}(): incompatible "

    @functools.wraps(function)
    def told(*arguments, **keywords):
        try:
            return function(*arguments, **keywords)
        except TypeError as error:
            text = _explained(function, owner, field, arguments, keywords) if str(error).startswith(start) else None
            if text is None:
                raise
        raise TypeError(text)

    told.__module__ = "hybrid"
    told.__qualname__ = function.__name__ if owner is None else f"{owner.__name__}.{function.__name__}"
    return told


def _is_worth_it(name, function):
    """Whether somebody calls it with arguments."""
    return (not name.startswith("_") or name in _SPECIAL) and re.search(r"\((?!\)|self: [\w.]+\))", function.__doc__ or "") is not None


def _add_to_class(cls):
    for name, member in list(vars(cls).items()):
        function = member.__func__ if isinstance(member, staticmethod) else member
        if isinstance(member, property) and type(member) is property and member.fset:
            setattr(cls, name, property(member.fget, _telling(member.fset, cls, name), doc=member.__doc__))
        elif callable(function) and not isinstance(function, type) and _is_worth_it(name, function):
            told = _telling(function, cls)
            setattr(cls, name, staticmethod(told) if isinstance(member, staticmethod) else told)


def add_to(module, names):
    """Lets all functions, methods and fields of these names in the module tell mistakes."""
    for name in names:
        thing = getattr(module, name)
        if inspect.isbuiltin(thing):
            setattr(module, name, _telling(thing))
        elif isinstance(thing, type) and not issubclass(thing, Exception) and not hasattr(thing, "__members__"):
            _add_to_class(thing)
