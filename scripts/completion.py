#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Writes the completion of a program for bash and zsh, from its --help.

Usage: completion.py PROGRAM BASH_FILE ZSH_FILE
"""

import os
import re
import subprocess
import sys

# "  -c,--config INI   meaning", "  --set X ... meaning", "  --no-pictures{false}   meaning", "  --online Excludes: --method";
# with a long name, the meaning is on the next line.
OPTION = re.compile(r"^  (?:(-\w),)?(--[\w-]+)(?:\{\w+\})?"
                    r"( (?! )[^ ]+)?(?:.*?(?: \.\.\. |  +)(.*))?")
COMMAND = re.compile(r"^  ([a-z][\w-]*)  +(.*)$")


def help_of(program, *command):
    done = subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True)
    return done.stdout.splitlines()


def parts(lines, title):
    """The lines of the section `title` of a help text."""
    inside = False
    for line in lines:
        if line.endswith(":") and not line.startswith(" "):
            inside = line == title
        elif inside and line.startswith(" "):
            yield line
        elif inside:
            return


def options_of(lines):
    """(short name or None, long name, whether it takes a value, meaning) of every option."""
    found = []
    rows = [re.sub(r" (?:Excludes|Needs): --[\w-]+", "  ", line) for line in parts(lines, "Options:")]
    for i, line in enumerate(rows):
        match = OPTION.match(line)
        if not match:
            continue
        below = rows[i + 1] if i + 1 < len(rows) and not OPTION.match(rows[i + 1]) else ""
        meaning = match[4] or below
        found.append((match[1], match[2], match[3] is not None, meaning.strip()))
    return found


def words_of(options):
    return " ".join(name for short, long, _, _ in options for name in (short, long) if name)


def bash_text(name, top, commands):
    function = "_" + name.replace("-", "_")
    valued = sorted({n for options in [top, *commands.values()] for s, l, v, _ in options if v for n in (s, l) if n})
    lines = [f"# bash completion of {name}", f"{function}() {{",
             '  local word="${COMP_WORDS[COMP_CWORD]}" words="' + words_of(top) + '"']
    if commands:
        lines += [f'  [ "$COMP_CWORD" -gt 1 ] || words="$words {" ".join(commands)}"', '  case "${COMP_WORDS[1]}" in']
        lines += [f'    {command}) words="{words_of(options)}" ;;' for command, options in commands.items()]
        lines += ["  esac"]
    if valued:
        lines += ['  case "${COMP_WORDS[COMP_CWORD-1]}" in', f'    {"|".join(valued)}) words= ;;', "  esac"]
    # An empty reply completes file names.
    lines += ["  COMPREPLY=()", '  [[ "$word" == -* ' + ("|| $COMP_CWORD -eq 1 " if commands else "") + "]] || return 0",
              '  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")', "}",
              f"complete -o default -F {function} {name}", ""]
    return "\n".join(lines)


def zsh_option(short, long, valued, meaning):
    meaning = re.sub(r"['\[\]:]", "", meaning)
    value = ":value:_files" if valued else ""
    names = [n for n in (short, long) if n]
    return " ".join(f"'*{n}[{meaning}]{value}'" for n in names)


def zsh_text(name, top, commands):
    rows = [f"#compdef {name}"]
    if commands:
        rows.append('case "$words[2]" in')
        for command, options in commands.items():
            rows.append(f"  {command}) _arguments " + " ".join(zsh_option(*o) for o in options) + " '*:file:_files' ;;")
        listed = " ".join(commands)
        rows.append("  *) _arguments " + " ".join(zsh_option(*o) for o in top) + f" '1:format:({listed})' ;;")
        rows.append("esac")
    else:
        rows.append("_arguments " + " ".join(zsh_option(*o) for o in top) + " '*:file:_files'")
    return "\n".join(rows) + "\n"


def main():
    program, bash_file, zsh_file = sys.argv[1:]
    name = os.path.basename(program)
    lines = help_of(program)
    top = options_of(lines)
    if not top:
        sys.exit(f"{program} --help lists no options")
    names = [m[1] for m in map(COMMAND.match, parts(lines, "Subcommands:")) if m]
    commands = {command: options_of(help_of(program, command)) for command in names}
    with open(bash_file, "w", encoding="utf-8") as file:
        file.write(bash_text(name, top, commands))
    with open(zsh_file, "w", encoding="utf-8") as file:
        file.write(zsh_text(name, top, commands))


if __name__ == "__main__":
    main()
