# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""python -m hybrid replay LOG, python -m hybrid plot FOLDER, python -m hybrid compare RUN RUN"""

import argparse
import sys

import hybrid


def _replay(options):
    if not hasattr(hybrid, "replay"):
        raise hybrid.Error("this package was built without MRPT: it cannot read rawlogs")
    settings = dict(pair.split("=", 1) for pair in options.set)
    result = hybrid.replay(options.config, options.output, rawlog=options.log, truth_path=options.truth_path,
                           truth_map=options.truth_map, settings=settings, pictures=options.pictures)
    print(f"{result['keyframes']} keyframes, {result['landmarks']} landmarks -> {options.output}")
    if result.get("message"):
        print(result["message"], file=sys.stderr)
    return 0 if result["status"] == "ok" else 2


def _plot(options):
    from hybrid import plot

    plot.save(options.picture, plot.run(options.folder))
    print(f"wrote {options.picture}")
    return 0


def _compare(options):
    from hybrid import _pages

    _pages.compare([options.run_a, *options.runs], options.output)
    print(f"wrote {options.output}")
    return 0


def _setting(text):
    if "=" not in text or "." not in text.split("=")[0]:
        raise argparse.ArgumentTypeError(f"'{text}' is no SECTION.KEY=VALUE")
    return text


def _parser():
    parser = argparse.ArgumentParser(prog="python -m hybrid", description=hybrid.__doc__.splitlines()[0])
    parser.add_argument("--version", action="version", version=f"hybrid {hybrid.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    replay = commands.add_parser("replay", help="map a rawlog, as hybrid-replay does")
    replay.add_argument("log", nargs="?", default="", help="the rawlog; without -c it chooses the plugins")
    replay.add_argument("-c", "--config", default="", metavar="INI")
    replay.add_argument("-o", "--output", default="hybrid-replay-out", metavar="FOLDER")
    replay.add_argument("--truth-path", default="", metavar="FILE")
    replay.add_argument("--truth-map", default="", metavar="FILE")
    replay.add_argument("--set", action="append", default=[], type=_setting, metavar="SECTION.KEY=VALUE")
    replay.add_argument("--no-pictures", dest="pictures", action="store_false")
    replay.set_defaults(run=_replay)
    plot = commands.add_parser("plot", help="draw path and landmarks of a result; needs matplotlib")
    plot.add_argument("folder", help="written by hybrid-replay")
    plot.add_argument("picture", help="the file to write: .png, .pdf or .svg")
    plot.set_defaults(run=_plot)
    compare = commands.add_parser("compare", help="one page about several runs: figures, settings, paths, landmarks, errors")
    compare.add_argument("run_a", metavar="RUN", help="a folder of hybrid-replay --report, or its report.html")
    compare.add_argument("runs", nargs="+", metavar="RUN", help="those that it is compared with")
    compare.add_argument("-o", "--output", default="compare.html", metavar="FILE")
    compare.set_defaults(run=_compare)
    return parser


def main(arguments=None):
    options = _parser().parse_args(arguments)
    try:
        return options.run(options)
    except (hybrid.Error, ImportError, OSError) as error:
        print(f"python -m hybrid: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
