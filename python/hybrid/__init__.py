# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Discrete-continuous smoothing and mapping.

Graphs of continuous factors, tables and hybrid factors (HybridGraph), solved in batch (alternate) or online
(IncrementalSmoother), with covariances (ContinuousMarginals), probabilities (posterior) and evidence (log_evidence);
pose graphs whose closures may be false (select_closures), maps of landmarks from detections without ids
(LandmarkMapper2), registration of point clouds (register_clouds), rawlogs (replay, if built with MRPT). hybrid.plot draws
with matplotlib.

Lengths are in metres, angles in radians, arrays are float64. Solvers release the lock of the interpreter (GIL): other
threads run meanwhile, and must not use the graph that is being solved.
"""

import importlib.util as _util

from . import _core, _mistakes, _represent

_mistakes.add_to(_core, [name for name in vars(_core) if not name.startswith("_")])

from ._core import *  # noqa: E402, F403
from ._graphs import add_pickling as _add_pickling, read_g2o  # noqa: E402, F401

__version__ = _core.__version__
__all__ = [name for name in vars(_core) if not name.startswith("_")]
for _name in __all__:
    if isinstance(vars(_core)[_name], type):
        vars(_core)[_name].__module__ = __name__
_represent.add_to([vars(_core)[_name] for _name in __all__ if isinstance(vars(_core)[_name], type)])
__all__.append("read_g2o")
_add_pickling()

if _util.find_spec(__name__ + "._mrpt") is not None:
    from ._replay import ReplayResult, replay  # noqa: F401

    __all__ += ["ReplayResult", "replay"]
    ReplayResult.__module__ = __name__
