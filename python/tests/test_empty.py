# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Objects that were made without __init__, and damaged pickles, raise exceptions."""

import copy
import operator
import pickle
import random
import sys
import types

import hybrid as h
import pytest
from hybrid import _core
from test_fields import results
from test_pickle import FACTORS, world

sys.setrecursionlimit(1000)
CLASSES = sorted({cls for module in (h, _core) for cls in vars(module).values()
                  if isinstance(cls, type) and not issubclass(cls, Exception) and cls.__module__.startswith("hybrid")},
                 key=lambda cls: cls.__name__)
FUNCTIONS = [f for f in vars(_core).values() if isinstance(f, types.BuiltinFunctionType)]


def members(cls):
    names = {name for base in cls.__mro__ if base is not object for name in vars(base)}
    return sorted(names - {"__new__", "__init__", "__setstate__", "__class__", "__dict__", "__del__"})


def try_call(function, *arguments):
    try:
        function(*arguments)
    except Exception:  # of whatever kind
        pass


def use(thing, cls):
    """All that can be done with one thing alone."""
    for function in (repr, str, len, iter, hash, bool, list, copy.copy, copy.deepcopy, *(lambda x, n=n: pickle.dumps(x, n) for n in range(6))):
        try_call(function, thing)
    for operation in (operator.eq, operator.ne, operator.lt, operator.mul, operator.add, operator.getitem, operator.contains):
        try_call(operation, thing, thing)
    for name in members(cls):
        member = getattr(thing, name, None) if not isinstance(getattr(cls, name, None), property) else try_call(getattr, thing, name)
        if callable(member):
            for arguments in ((), (thing,), (thing, thing), ("x0", thing)):
                try_call(member, *arguments)


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_an_object_without_a_value_is_refused(cls):
    thing = cls.__new__(cls)
    use(thing, cls)
    for function in FUNCTIONS:
        for arguments in ((thing,), (thing, thing), (thing, {}), ([thing], thing)):
            try_call(function, *arguments)


def test_the_reason_is_told():
    graph = h.HybridGraph.__new__(h.HybridGraph)
    for call in (lambda: len(graph), lambda: h.levenberg_marquardt(graph, {}), lambda: list(graph)):
        with pytest.raises(TypeError, match="its __init__ was not called"):
            call()
    assert len(CLASSES) > 60


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_all_protocols(protocol):
    values = h.Values({"x0": h.SE2(1, 2, 3)})
    assert pickle.loads(pickle.dumps(values, protocol)) == values
    for factor in FACTORS:
        assert repr(pickle.loads(pickle.dumps(factor, protocol))) == repr(factor)
    assert repr(pickle.loads(pickle.dumps(world(), protocol))) == repr(world())
    assert pickle.loads(pickle.dumps(h.WindowMode.FIXED_LAG, protocol)) == h.WindowMode.FIXED_LAG


def test_damaged_pickles():
    rng = random.Random(5)
    texts = [pickle.dumps(thing, protocol) for thing in (*results(), world(), *FACTORS) for protocol in (0, 2, 4)]
    texts = [text for text in texts if b"numpy" not in text]  # whose own arrays crash it
    assert len(texts) > 30
    for _ in range(400):
        text = bytearray(rng.choice(texts))
        text[rng.randrange(len(text))] = rng.randrange(256)
        try:
            thing = pickle.loads(bytes(text))
        except Exception:
            continue
        if type(thing) in CLASSES:
            use(thing, type(thing))
