# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Wrong arguments are told in a sentence."""

import pickle

import hybrid as h
import pytest

NOISE, POSE = h.Noise.isotropic(3, 0.1), h.SE2(1, 0, 0)
GRAPH, VALUES = h.HybridGraph([h.Prior("x0", POSE, NOISE)]), h.Values({"x0": POSE})
ANY = "SO2, SE2, SO3, SE3 or an array (m,)"
FACTOR = "wanted ContinuousFactor, Table, HybridFactor or an iterable"


def assign(thing, name, value):
    setattr(thing, name, value)


def put(key, value):
    values = h.Values(dict(VALUES.items()))
    values[key] = value


@pytest.mark.parametrize("call, message", [
    (lambda: h.BetweenSE2("x0", "x1", NOISE, POSE), "BetweenSE2: argument 3 (measured) is a Noise; wanted SE2; "
     "argument 4 (noise) is an SE2; wanted Noise, such as Noise.isotropic(3, 0.1)"),
    (lambda: h.BetweenSE2("x0", "x1", POSE, 0.1), "argument 4 (noise) is a float (0.1); wanted Noise, such as Noise.isotropic(3, 0.1)"),
    (lambda: h.Prior("x0", 3, NOISE), f"Prior: argument 2 (measured) is an int (3); wanted {ANY}"),
    (lambda: h.Prior(None, POSE, NOISE), "Prior: argument 1 (key) is None; wanted a key such as 'x3'"),
    (lambda: h.Prior(1.5, POSE, NOISE), "argument 1 (key) is a float (1.5); wanted a key such as 'x3'"),
    (lambda: h.Prior(b"x1", POSE, NOISE), "argument 1 (key) is a bytes (b'x1'); wanted a key such as 'x3'"),
    (lambda: h.BearingRange("x0", "l0", [1, 2, 3, 4], NOISE), "(measured) is a list of 4; wanted an array (2,) or an array (3,)"),
    (lambda: h.Prior("x0", POSE, NOISE, los=1), "Prior: 'los' is no argument"),
    (lambda: h.alternate(GRAPH), "alternate: argument 2 (initial) is missing; wanted an Estimate, Values or a dict"),
    (lambda: h.Estimate({"x0": 3}), f"Values['x0'] is an int (3); wanted {ANY}"),
    (lambda: put("x0", "a"), f"Values['x0'] is a str ('a'); wanted {ANY}"),
    (lambda: h.HybridGraph().add(3), f"HybridGraph.add: argument 1 (factor) is an int (3); {FACTOR}"),
    (lambda: h.HybridGraph().add([1, 2]), f"HybridGraph.add: argument 1 (factor) is an int (1); {FACTOR}"),
    (lambda: h.SE2(1, 2), "SE2: argument 3 (angle) is missing; wanted a number"),
    (lambda: h.SO2("a"), "SO2: argument 1 (angle) is a str ('a'); wanted a number"),
    (lambda: h.Noise.isotropic("a", 1), "Noise.isotropic: argument 1 (dim) is a str ('a'); wanted a whole number"),
    (lambda: h.OutlierMixture("d0", h.Prior("x0", POSE, NOISE), h.Prior("x0", POSE, NOISE)),
     "argument 1 (switch_key) is a str ('d0'); wanted DiscreteKey, such as DiscreteKey('d0', 2)"),
    (lambda: h.ContinuousMarginals(GRAPH, VALUES).covariance(["x0", "x1"]), "ContinuousMarginals.covariance: argument 1 (key) is a list of 2; "
     "wanted a key such as 'x3'; joint_covariance takes several keys"),
    (lambda: h.SolverOptions(3), "SolverOptions takes its fields by name, such as SolverOptions(max_iterations=...)"),
    (lambda: assign(h.SolverOptions(), "threads", "a"), "SolverOptions.threads is a str ('a'); wanted a whole number"),
])
def test_a_wrong_argument_is_told_in_a_sentence(call, message):
    with pytest.raises(TypeError) as raised:
        call()
    assert message in str(raised.value) and "incompatible" not in str(raised.value)


def test_mistakes_of_functions_of_users_stay_as_they_are():
    class Bad(h.Factor):
        def residual(self, pose):
            return pose + 1

    with pytest.raises(TypeError, match="unsupported operand"):
        h.levenberg_marquardt(h.HybridGraph([Bad(["x0"], [h.SE2], h.Noise.isotropic(1, 1))]), VALUES)


def test_functions_keep_their_names_and_are_pickled():
    assert pickle.loads(pickle.dumps(h.alternate)) is h.alternate and h.alternate.__doc__.startswith("alternate(graph")
    assert h.Values.stack.__name__ == "stack"
