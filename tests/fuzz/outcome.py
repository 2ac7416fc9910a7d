# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Runs a program within limits and says what became of it."""

import hashlib
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass

CPU_SECONDS = 20
WALL_SECONDS = 600  # of a machine that others use too
MEMORY = 1 << 30  # of addresses
RESIDENT = 500 << 20

OUTCOMES = ["crash", "hang", "memory", "mixed or half result", "NaN in result", "silently wrong",
            "unclear message", "clear message", "partial, stated", "ok, stated", "other result",
            "same result"]
BAD = OUTCOMES[:6]


@dataclass
class Run:
    code: int
    text: str
    signal: int = 0
    peak: int = 0
    timed_out: bool = False


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS + 2))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(command, log, environment=None, limits=True):
    """Runs a command with its output in a file, never longer than WALL_SECONDS."""
    with open(log, "wb") as out:
        process = subprocess.Popen([str(c) for c in command], stdin=subprocess.DEVNULL, stdout=out,
                                   stderr=subprocess.STDOUT, env=environment,
                                   preexec_fn=limit if limits else None)
    end, timed_out = time.monotonic() + WALL_SECONDS, False
    while True:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            break
        if time.monotonic() > end:
            timed_out = True
            process.kill()
            _, status, usage = os.wait4(process.pid, 0)
            break
        time.sleep(0.004)
    process.returncode = 0  # waited for above
    killed = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    text = pathlib.Path(log).read_bytes()[:100000].decode("utf-8", "replace")
    return Run(os.WEXITSTATUS(status) if not killed else 128 + killed, text, killed,
               usage.ru_maxrss * 1024, timed_out)


VOLATILE = {"seconds", "command", "inputs", "files", "version", "steps"}


def without_times(value):
    if isinstance(value, dict):
        return {k: without_times(v) for k, v in value.items()
                if k not in VOLATILE and not k.endswith(("_s", "_ms"))}
    return [without_times(v) for v in value] if isinstance(value, list) else value


def content_of(path):
    """What must be the same in another run of the same input."""
    if path.name == "summary.json":
        return json.dumps(without_times(json.loads(path.read_text())))
    if path.name in ("steps.csv", "results.csv", "summary.csv", "summary.txt", "experiment.ini",
                     "settings.txt") or path.suffix == ".png":
        return ""  # times, or drawn from the others
    return path.read_bytes()


def results(out):
    """Files of a result by name; `out` is a folder, or the begin of the names of files."""
    out = pathlib.Path(out)
    files = sorted(out.rglob("*")) if out.is_dir() else sorted(out.parent.glob(out.name + "*"))
    return {str(f.relative_to(out.parent)): f for f in files if f.is_file()}


def has_nan(files):
    """A number that is none, in the result that calls itself good."""
    for path in files.values():
        if path.suffix in (".csv", ".tum", ".txt", ".g2o", ".xyz"):
            if re.search(rb"(?i)(^|[\s,])[-+]?(nan|inf)\b", path.read_bytes()):
                return path.name
        if path.name == "summary.json":
            summary = json.loads(path.read_text())
            if any(key in summary and summary[key] is None for key in ("objective", "cost", "rms")):
                return path.name
    return ""


def lines_of(text):
    """The lines of what a program said, whatever the numbers and paths."""
    return {re.sub(r"\S*/\S*|[-+\d.e]+|nan", "", line).strip() for line in text.splitlines()}


def said_of(files):
    """What the summary says was left out."""
    for path in files.values():
        if path.name == "summary.json":
            summary = json.loads(path.read_text())
            return summary.get("dropped"), summary.get("warnings")
    return None


@dataclass
class Expected:
    """What an undamaged input gives."""
    contents: dict
    lines: set
    said: object
    former: pathlib.Path

    @staticmethod
    def of(run, files, former, out):
        """The result is moved from `out` to `former`."""
        expected = Expected({n: content_of(f) for n, f in files.items()}, lines_of(run.text),
                            said_of(files), former)
        os.rename(out, former)
        return expected


def lay(former, out):
    """Puts a former result where a new one is to be written; returns its contents by name."""
    shutil.copytree(former, out)
    return {n: f.read_bytes() for n, f in results(out).items()}


def mixed(run, files, former, lasting):
    """What shows that files are not those of one result, or "". `lasting`: trials are kept."""
    for name, path in files.items():
        if path.suffix in (".part", ".partial") or ".part-" in name or path.name[0] == ".":
            return name
    if lasting:
        return ""
    if run.code == 1:
        if former is None:
            return ", ".join(files)
        if {n: f.read_bytes() for n, f in files.items()} != former:
            return "the former result was changed"
        return ""
    summary = next((f for f in files.values() if f.name == "summary.json"), None)
    if summary is None:
        return ""
    listed = {f["path"]: f["sha256"] for f in json.loads(summary.read_text()).get("files", [])}
    here = {str(f.relative_to(summary.parent)): f for f in files.values() if f != summary}
    if set(listed) != set(here):
        return f"not one result: {set(listed) ^ set(here)}"
    wrong = [n for n, f in here.items() if hashlib.sha256(f.read_bytes()).hexdigest() != listed[n]]
    return ", ".join(wrong)


def crashed(run):
    return run.signal not in (0, signal.SIGXCPU, signal.SIGKILL) or "terminate called" in run.text


def classify(run, out, expected, fault, names, former=None, lasting=False):
    """The outcome and a word why. `fault` says why the input is certainly damaged; a clear message
    has one of `names` in it. `former`: contents of the result that was there before."""
    files = results(out)
    if run.signal == signal.SIGXCPU or run.timed_out:
        return "hang", f"{CPU_SECONDS} s"
    if run.peak > RESIDENT or "bad_alloc" in run.text or "allocate memory" in run.text:
        return "memory", f"{run.peak >> 20} MB"
    if crashed(run) or run.code > 2:
        return "crash", f"code {run.code}"
    if mixed(run, files, former, lasting):
        return "mixed or half result", mixed(run, files, former, lasting)
    if run.code == 1:
        if len(run.text) > 20000:
            return "unclear message", f"{len(run.text)} characters"
        clear = any(name in run.text for name in names) and not re.search("[\x00-\x08\x0b-\x1f]",
                                                                          run.text)
        return ("clear message" if clear else "unclear message"), run.text.strip()[:200]
    if has_nan(files):
        return "NaN in result", has_nan(files)
    if run.code == 2:
        return "partial, stated", run.text.strip()[-200:]
    if {n: content_of(f) for n, f in files.items()} == expected.contents:
        return "same result", ""
    if lines_of(run.text) - expected.lines or said_of(files) != expected.said:
        return "ok, stated", ""
    return ("silently wrong", fault) if fault else ("other result", "")
