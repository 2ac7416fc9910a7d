#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Writes the completion of a program for bash and zsh, from its --help: names of options, values of those that have a few, and
the keys of --set with their values where the program has --print-config.

Usage: completion.py PROGRAM BASH_FILE ZSH_FILE
"""

import os
import re
import subprocess
import sys

# "  -c, --config INI   meaning"; the meaning may go on in further rows, or begin in the next one.
OPTION = re.compile(r"^  (?:(-\w), )?(--[\w-]+)( [^ ]+)?(?: {2,}(.*))?$")
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


def keys_of(program):
    """section.key of every setting, with its values if they are a few; none where the program prints no configuration."""
    done = subprocess.run([program, "--print-config"], capture_output=True, text=True)
    section, note, keys = "", "", {}
    for line in done.stdout.splitlines() if done.returncode == 0 else []:
        if line.startswith("["):
            section = line.strip("[]")
        elif line.startswith("#"):
            note = line
        elif " = " in line:
            listed = re.search(r"\((?:one of: ([^();]*)|true or (false)); default [^()]*\)$", note)
            keys[f"{section}.{line.split(' = ')[0]}"] = (listed[1].split() if listed[1] else ["true", "false"]) if listed else []
    if "plugins.classes" in keys:  # a plugin has a section of its own name, CamelCase as its class
        keys["plugins.classes"] = ["auto", *dict.fromkeys(key.split(".")[0] for key in keys if key[0].isupper())]
    return keys


def options_of(lines):
    """(short name or None, long name, its value or None, meaning) of every option."""
    found, methods = [], [line.split()[0] for line in parts(lines, "Methods:")]
    for line in parts(lines, "Options:"):
        match = OPTION.match(line)
        if match:
            value = f" one of: {' '.join(methods)}" if methods and match[3] == " METHOD" else match[3]
            found.append([match[1], match[2], value, match[4] or ""])
        elif found:
            found[-1][3] = f"{found[-1][3]} {line.strip()}".strip()
    return found


def choices_of(value, meaning):
    """The values of an option: those listed as "(one of: auto build; default auto)", or of " all|odometry|FILE"."""
    listed = re.search(r"one of: ([^;)]*)", f"{value} {meaning}")
    return listed[1].split() if listed else re.findall(r"[a-z]+", value or "") if "|" in (value or "") else []


def or_file(value):
    """Whether a file may stand in place of such a value."""
    return (value or "").endswith("|FILE")


def words_of(options):
    return " ".join(name for short, long, _, _ in options for name in (short, long) if name)


def bash_values(options, keys):
    """Lines of a case that complete what follows an option: one of few values, a key, or a file."""
    lines, plain = [], set()
    for short, long, value, meaning in options:
        names = [n for n in (short, long) if n]
        choices = [f"{key}=" for key in keys] if long == "--set" else choices_of(value, meaning)
        if choices:
            files = " files=yes" if or_file(value) else ""
            lines.append(f'    {"|".join(names)}) values="{" ".join(choices)}"{files} ;;')
        elif value:
            plain.update(names)
    if plain:
        lines.append(f'    {"|".join(sorted(plain))}) words= ;;')
    return list(dict.fromkeys(lines))


def bash_equals(keys):
    """Lines that find what is completed, `before`: bash takes `--option=value` and `section.key=value` for three words."""
    lines = ["  local at=$COMP_CWORD", '  if [ "$word" = = ]; then word="" at=$((at + 1)); fi', '  local before="${COMP_WORDS[at-1]}"',
             '  [ "$before" != = ] || before="${COMP_WORDS[at-2]}"']
    if not keys:
        return lines
    lines += ['  if [ "${COMP_WORDS[at-1]}" = = ] && [[ "$before" != -* ]]; then', '    local few=', '    case "$before" in']
    lines += [f'    {key}) few="{" ".join(values)}" ;;' for key, values in keys.items() if values]
    return lines + ["    esac", '    mapfile -t COMPREPLY < <(compgen -W "$few" -- "$word")', "    return 0", "  fi"]


def bash_text(name, top, commands, keys):
    function = "_" + name.replace("-", "_")
    values = bash_values([option for options in [top, *commands.values()] for option in options], keys)
    lines = [f"# bash completion of {name}", f"{function}() {{",
             '  local word="${COMP_WORDS[COMP_CWORD]}" words="' + words_of(top) + '"']
    if commands:
        lines += [f'  [ "$COMP_CWORD" -gt 1 ] || words="$words {" ".join(commands)}"', '  case "${COMP_WORDS[1]}" in']
        lines += [f'    {command}) words="{words_of(options)}" ;;' for command, options in commands.items()]
        lines += ["  esac"]
    if values:
        lines += [*bash_equals(keys), '  local values= files=', '  case "$before" in', *values, "  esac",
                  '  if [ -n "$values" ]; then', '    mapfile -t COMPREPLY < <(compgen -W "$values" -- "$word"; [ -z "$files" ] || compgen -f -- "$word")',
                  '    [[ "${COMPREPLY[*]}" == *= ]] && compopt -o nospace', "    return 0", "  fi"]
    # An empty reply completes file names.
    lines += ["  COMPREPLY=()", '  [[ "$word" == -* ' + ("|| $COMP_CWORD -eq 1 " if commands else "") + "]] || return 0",
              '  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")', "}",
              f"complete -o default -F {function} {name}", ""]
    return "\n".join(lines)


def zsh_option(keys, short, long, valued, meaning):
    settings = [f"{key}={value}" for key, values in keys.items() for value in values or [""]]
    choices = settings if long == "--set" else choices_of(valued, meaning)
    meaning = re.sub(r"['\[\]:]", "", meaning)
    value = f":value:({' '.join(choices)})" if choices and not or_file(valued) else ":value:_files" if valued else ""
    if or_file(valued):
        value = ":value:{ _alternative \"values\\:value\\:(" + " ".join(choices) + ")\" \"files\\:file\\:_files\" }"
    names = [n for n in (short, f"{long}=" if value else long) if n]  # --option value and --option=value
    return " ".join(f"'*{n}[{meaning}]{value}'" for n in names)


def zsh_text(name, top, commands, keys):
    rows = [f"#compdef {name}"]
    if commands:
        rows.append('case "$words[2]" in')
        for command, options in commands.items():
            rows.append(f"  {command}) _arguments " + " ".join(zsh_option(keys, *o) for o in options) + " '*:file:_files' ;;")
        listed = " ".join(commands)
        rows.append("  *) _arguments " + " ".join(zsh_option(keys, *o) for o in top) + f" '1:format:({listed})' ;;")
        rows.append("esac")
    else:
        rows.append("_arguments " + " ".join(zsh_option(keys, *o) for o in top) + " '*:file:_files'")
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
    keys = keys_of(program)
    with open(bash_file, "w", encoding="utf-8") as file:
        file.write(bash_text(name, top, commands, keys))
    with open(zsh_file, "w", encoding="utf-8") as file:
        file.write(zsh_text(name, top, commands, keys))


if __name__ == "__main__":
    main()
