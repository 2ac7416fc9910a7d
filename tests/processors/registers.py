#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Disassembles a library: instructions that only newer processors have may stand in their dense kernels alone.

registers.py LIBRARY exits with 1 and names the functions where they stand elsewhere, or if the kernels have none.
"""

import re
import subprocess
import sys

FUNCTION = re.compile(r"^[0-9a-f]+ <(.+)>:$")
# All instructions of AVX and after have a leading v and work on registers of these names.
WIDE = re.compile(r"^\s*[0-9a-f]+:\s+v\w+\s.*%[xyz]mm")
# DenseKernels<4> and DenseKernels<8>.
KERNEL = re.compile(r"DenseKernelsILi([48])E")


def main():
    code = subprocess.run(["objdump", "--disassemble", "--no-show-raw-insn", sys.argv[1]],
                          check=True, capture_output=True, text=True).stdout
    function, elsewhere, kernels = "", set(), set()
    for line in code.splitlines():
        start = FUNCTION.match(line)
        if start:
            function = start.group(1)
        elif WIDE.match(line):
            kernel = KERNEL.search(function)
            kernels.add(kernel.group(1)) if kernel else elsewhere.add(function)
    for name in sorted(elsewhere):
        print(f"instructions of newer processors in {name}")
    if kernels != {"4", "8"}:
        print(f"wide registers expected in the kernels for AVX2 and AVX-512, but found in {sorted(kernels)}")
        return 1
    return 1 if elsewhere else 0


if __name__ == "__main__":
    sys.exit(main())
