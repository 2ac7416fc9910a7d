# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
# Sourced by the other scripts, from any directory: strict mode, the root of the tree, shared steps.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
export CCACHE_BASEDIR=$root CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=pch_defines,time_macros
jobs=$(nproc 2>/dev/null || echo 2)

fail() {
  echo "$(basename "$0"): $*" >&2
  exit 1
}

options=()
# build PRESET [TARGET]: configures, with the options, and builds. Prints progress only on a terminal, and all output on failure.
build() {
  local preset=$1 log
  shift
  echo "Building ($preset)"
  mkdir -p "build/$preset"
  log=build/$preset/build.log
  if [ -t 1 ]; then
    cmake --preset "$preset" "${options[@]}" >"$log" || { cat "$log"; fail "configuring failed"; }
    cmake --build --preset "$preset" --parallel "$jobs" ${1:+--target "$1"} || fail "the build failed"
  elif ! { cmake --preset "$preset" "${options[@]}" && cmake --build --preset "$preset" --parallel "$jobs" ${1:+--target "$1"}; } \
    >"$log" 2>&1 </dev/null; then
    grep -v '^\[[0-9]*/[0-9]*\] \(Building\|Linking\)' "$log" | tail -n 100
    fail "the build failed; all of it is in $log"
  fi
}
