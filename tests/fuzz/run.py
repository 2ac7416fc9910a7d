#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Runs all programs on damaged inputs and prints what became of them, by program and by kind of
damage. The same seed gives the same cases. Exits with 1 if any case ends in a way that none may.

    tests/fuzz/run.py --cases 10000 --seed 1
    tests/fuzz/run.py --case 1:4711        # that case of seed 1 alone, its files kept
"""

import argparse
import collections
import concurrent.futures
import os
import pathlib
import random
import shutil
import sys
import tempfile

import damage
import material
import oracle
import outcome

KINDS = {"log": damage.LOG_KINDS, "INI": damage.INI_KINDS, "map": damage.MAP_KINDS}
SPECIAL_SHARE = 0.04  # of the cases
PROGRAMS = ["hybrid-replay", "hybrid-pgo", "hybrid-register", "hybrid-objects",
            "hybrid-switching", "hybrid-import", "hybrid-simulate", "hybrid-experiment", "hybrid-map"]


def kinds_of(form):
    return KINDS.get(form, damage.TEXT_KINDS)


def choose(inputs, seed, number):
    """The input, file and kind of damage of a case, and the generator that goes on."""
    rng = random.Random(f"{seed}:{number}")
    by_program = collections.defaultdict(list)
    for entry in inputs:
        by_program[entry.program].append(entry)
    weights = {"hybrid-replay": 6, "hybrid-import": 4, "hybrid-pgo": 3, "hybrid-register": 2,
               "hybrid-map": 2}
    program = rng.choices(PROGRAMS, [weights.get(p, 1) for p in PROGRAMS])[0]
    entry = rng.choice(by_program[program])
    logs = [n for n, form in entry.formats.items() if form == "log"]
    name = rng.choice(logs if logs and rng.random() < 0.6 else sorted(entry.formats))
    if rng.random() < SPECIAL_SHARE:
        return entry, name, damage.SPECIAL, rng
    return entry, name, rng.choice(sorted(kinds_of(entry.formats[name]))), rng


def write_files(entry, folder):
    folder.mkdir()
    for name, content in entry.files.items():
        (folder / name).write_bytes(content)


def command_of(entry, binaries, folder, out):
    places = {name: folder / name for name in entry.files}
    places.update({"dir": folder, "out": out})
    filled = []
    for argument in entry.arguments:
        for name, place in places.items():
            argument = argument.replace("{" + name + "}", str(place))
        filled.append(argument)
    return [binaries / entry.program, *filled]


def out_of(entry, base):
    """Where the result is written: a folder, or files whose names begin so."""
    if entry.result == "folder":
        return base / "out"
    (base / "result").mkdir(exist_ok=True)
    return base / "result" / "out"


def execute(entry, binaries, base, limits=True):
    out = out_of(entry, base)
    run = outcome.run(command_of(entry, binaries, base / "in", out), base / "text", limits=limits)
    return run, out if entry.result == "folder" else base / "result"


def undamaged(entry, binaries, base):
    """What an input gives as it is, which must be good."""
    base.mkdir(parents=True)
    write_files(entry, base / "in")
    run, out = execute(entry, binaries, base)
    if run.code != 0:
        sys.exit(f"{entry.name}, undamaged: exit code {run.code}\n{run.text}")
    return outcome.Expected.of(run, outcome.results(out), base / "former", out)


def run_case(entry, name, kind, rng, binaries, base, expected, over_former):
    """The outcome of one case, and a word about it. `over_former`: the undamaged result stands where
    this one is written to."""
    base.mkdir(parents=True)
    write_files(entry, base / "in")
    path = base / "in" / name
    if kind == damage.SPECIAL:
        path.unlink()
        fault = damage.make_special(str(path), rng)
    else:
        form = entry.formats[name]
        data = kinds_of(form)[kind](entry.files[name], rng)
        path.write_bytes(data)
        fault = oracle.fault(data, form)
    lasting = entry.program == "hybrid-experiment"  # goes on from what stands there
    former = None
    if over_former and not lasting:
        former = outcome.lay(expected.former, base / ("out" if entry.result == "folder" else "result"))
    run, out = execute(entry, binaries, base)
    names = [name, f"{base}/in/"]  # or another file that it no longer fits
    if entry.formats[name] == "INI":
        names += ["[", "command line", ".rawlog"]
    return outcome.classify(run, out, expected, fault, names, former, lasting)


def keep_files(source, target):
    """Copies the regular files of a case; a huge one has no content worth the disk."""
    target.mkdir(parents=True, exist_ok=True)
    for path in sorted(source.iterdir()):
        if path.is_file() and not path.is_symlink() and path.stat().st_size < 1 << 26:
            shutil.copy(path, target)


def table(rows, columns, counts):
    """Markdown, with the sums of all columns below."""
    lines = ["| | cases | " + " | ".join(columns) + " |", "|---|" + "---|" * (len(columns) + 1)]
    for row in [*rows, "all"]:
        cells = [sum(n for (r, c), n in counts.items() if c == column and row in (r, "all"))
                 for column in columns]
        if sum(cells):
            lines.append(f"| {row} | {sum(cells)} | " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", metavar="SEED:NUMBER", help="one case; its files are kept")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--binaries", type=pathlib.Path,
                        default=material.ROOT / "build" / "release" / "bin")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the inputs of bad cases")
    return parser.parse_args()


def report(results):
    by_program, by_kind = collections.Counter(), collections.Counter()
    for (entry, _, kind), (result, _) in results:
        by_program[entry.program, result] += 1
        by_kind[kind, result] += 1
    print(table(PROGRAMS, outcome.OUTCOMES, by_program), end="\n\n")
    print(table(sorted({kind for (_, _, kind), _ in results}), outcome.OUTCOMES, by_kind))


def main():
    options = parse_arguments()
    seed, first, count = options.seed, 0, options.cases
    if options.case:
        seed, first = map(int, options.case.split(":"))
        count = 1
    work = pathlib.Path(tempfile.mkdtemp(prefix="hybrid_fuzz_"))
    keep = options.keep or (pathlib.Path.cwd() / "fuzz-cases" if options.case else None)
    os.environ["HOME"] = str(work / "never printed")
    (work / "material").mkdir()
    inputs = material.all_inputs(options.binaries, work / "material")
    chosen = [choose(inputs, seed, i) for i in range(first, first + count)]
    needed = {entry.name: entry for entry, _, _, _ in chosen}

    def one(i):
        entry, name, kind, rng = chosen[i]
        base = work / str(first + i)
        result, why = run_case(entry, name, kind, rng, options.binaries, base, expected[entry.name],
                               (first + i) % 3 == 0)
        if result in outcome.BAD + ["unclear message"] or options.case:
            print(f"case {seed}:{first + i}: {entry.name}, {name}, {kind}: {result}: {why}",
                  flush=True)
            if keep:
                keep_files(base / "in", keep / f"{seed}_{first + i}")
        shutil.rmtree(base)
        return (entry, name, kind), (result, why)

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        expected = dict(zip(needed, pool.map(
            lambda e: undamaged(e, options.binaries, work / e.name.replace(" ", "_")),
            needed.values())))
        results = list(pool.map(one, range(count)))
    shutil.rmtree(work)
    if not options.case:
        report(results)
    bad = sum(result in outcome.BAD for _, (result, _) in results)
    print(f"{count} cases of seed {seed}, {bad} bad")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
