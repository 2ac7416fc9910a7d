#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What the shared libraries in a folder show: exports.py FOLDER. Exits with 1 and says what is wrong."""

import pathlib
import subprocess
import sys


def shown(library):
    """Strong symbols that a library defines for others."""
    lines = subprocess.run(["nm", "--dynamic", "--demangle", "--defined-only", str(library)], check=True,
                           capture_output=True, text=True).stdout.splitlines()
    symbols = (line.split(" ", 2) for line in lines)
    return {name for _, kind, name in symbols if kind in "TDBR"}


def main():
    wrong = []
    libraries = sorted(path for path in pathlib.Path(sys.argv[1]).rglob("libhybrid*.so") if path.is_file())
    symbols = {path.name: shown(path) for path in libraries}
    of_library = symbols["libhybrid.so"]
    if not any(name.startswith("hybrid::levenberg_marquardt(") for name in of_library):
        wrong.append("libhybrid.so hides hybrid::levenberg_marquardt")
    for name in ("hybrid::kernels()", "hybrid::kBaselineKernels", "hybrid::kAvx2Kernels"):
        if name in of_library:
            wrong.append(f"libhybrid.so shows {name}, which is not of the API")
    for path in libraries:
        if not path.resolve().name.startswith(path.name + "."):
            wrong.append(f"{path.name} has no version in its name")
    for name, found in symbols.items():
        foreign = sorted(s for s in found if "hybrid" not in s and s not in ("_init", "_fini", "_end", "_edata", "__bss_start"))
        wrong += [f"{name} shows {symbol}" for symbol in foreign]
        if name != "libhybrid.so":
            wrong += [f"{name} has a copy of {symbol}" for symbol in sorted(found & of_library) if "hybrid::" in symbol]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
