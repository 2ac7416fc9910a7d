# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Kinds of damage. Each takes the bytes of a file and a random generator, and gives other bytes."""

import gzip
import os
import socket
import struct

TOKENS = [
    "nan", "inf", "-inf", "1e300", "-1e300", "1e308", "1e400", "1e-300", "1e-400", "9e18", "-1",
    "0", "0x10", "1e", "1.5", "abc", "", "--", "1,5", "1;5", "+", "1_000", "99999999999999999999",
    "4294967297", "2147483648", "18446744073709551615", "-0.0", "1.", ".5", "\uff11\uff12", "\u22125",
    "1e5x", "\x1b[31m", "%s%n", "1 2"]


def unpacked(data):
    return gzip.decompress(data)


def packed(data):
    return gzip.compress(data, 6, mtime=0)


def span(data, random, longest=64):
    begin = random.randrange(max(1, len(data)))
    return begin, min(len(data), begin + random.randint(1, longest))


def cut(data, random):
    return data[:random.randrange(max(1, len(data)))]


def overwritten(data, random):
    """1 to 64 bytes, in up to four places."""
    out = bytearray(data)
    for _ in range(random.randint(1, 4)):
        begin, end = span(out, random, 16)
        out[begin:end] = bytes(random.choice([0, 1, 0x7f, 0x80, 0xff, random.randrange(256)])
                               for _ in range(end - begin))
    return bytes(out)


def flipped(data, random):
    out = bytearray(data)
    out[random.randrange(len(out))] ^= 1 << random.randrange(8)
    return bytes(out)


def shuffled_blocks(data, random):
    begin, end = span(data, random, max(16, len(data) // 4))
    block = data[begin:end]
    kind = random.randrange(3)
    if kind == 0:
        return data[:end] + block * random.randint(1, 3) + data[end:]
    if kind == 1:
        return data[:begin] + data[end:]
    other = random.randrange(max(1, len(data)))
    rest = data[:begin] + data[end:]
    return rest[:other] + block + rest[other:]


def huge_length(data, random):
    """A number of four or eight bytes where a length may stand."""
    value = random.choice([0xffffffff, 0x7fffffff, 0x80000000, 0x10000000, 0x00ffffff, 1000000])
    raw = struct.pack("<I", value) if random.random() < 0.8 else struct.pack("<Q", value << 8)
    begin = random.randrange(max(1, len(data) - len(raw)))
    return data[:begin] + raw + data[begin + len(raw):]


def header_then_garbage(data, random):
    keep = random.randrange(1, max(2, min(len(data), 400)))
    return data[:keep] + bytes(random.randrange(256) for _ in range(random.randint(1, 20000)))


def recompressed(damage):
    return lambda data, random: packed(damage(unpacked(data), random))


def plain(damage):
    return lambda data, random: damage(unpacked(data), random)


LOG_KINDS = {
    "log: truncated gzip": cut,
    "log: truncated, recompressed": recompressed(cut),
    "log: truncated, plain": plain(cut),
    "log: one bit flipped in gzip": flipped,
    "log: bytes overwritten, recompressed": recompressed(overwritten),
    "log: bytes overwritten, plain": plain(overwritten),
    "log: blocks repeated, deleted, moved": recompressed(shuffled_blocks),
    "log: huge length fields": recompressed(huge_length),
    "log: header, then garbage": header_then_garbage,
}


# SQLite has pages of 4096 bytes, so that whole pages are moved by some of the blocks.
MAP_KINDS = {
    "map: truncated": cut,
    "map: one bit flipped": flipped,
    "map: bytes overwritten": overwritten,
    "map: blocks repeated, deleted, moved": shuffled_blocks,
    "map: huge length fields": huge_length,
    "map: header, then garbage": header_then_garbage,
}


def lines_of(data):
    return data.decode("utf-8", "surrogateescape").split("\n")


def text_of(lines):
    return "\n".join(lines).encode("utf-8", "surrogateescape")


def token_replaced(data, random):
    lines = lines_of(data)
    for _ in range(random.randint(1, 3)):
        at = random.randrange(len(lines))
        separator = "," if "," in lines[at] else " "
        words = lines[at].split(separator)
        words[random.randrange(len(words))] = random.choice(TOKENS)
        lines[at] = separator.join(words)
    return text_of(lines)


def lines_changed(data, random):
    lines = lines_of(data)
    at = random.randrange(len(lines))
    kind = random.randrange(9)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(at, lines[at])
    elif kind == 2:
        other = random.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 3:
        lines[at] = lines[at][:random.randrange(len(lines[at]) + 1)]
    elif kind == 4 and at + 1 < len(lines):
        lines[at:at + 2] = [lines[at] + lines[at + 1]]
    elif kind == 5:
        lines[at] += " " + random.choice(["0", "1.5", "x", "0 0 0"])
    elif kind == 6:
        words = lines[at].split()
        lines[at] = " ".join(words[:-1])
    elif kind == 7:
        lines.insert(at, random.choice(["", "#", "garbage", "\x00", "1" * 3000000, "x " * 100000]))
    else:
        random.shuffle(lines)
    return text_of(lines)


def encoded_otherwise(data, random):
    text = data.decode("utf-8", "surrogateescape")
    kind = random.randrange(9)
    if kind == 0:
        return b"\xef\xbb\xbf" + data
    if kind == 1:
        return text.encode("utf-16", "surrogatepass")
    if kind == 2:
        return text.encode("utf-16-be", "surrogatepass")
    if kind == 3:
        return data.replace(b"\n", b"\r\n")
    if kind == 4:
        return data.replace(b"\n", b"\r")
    if kind == 5:
        at = random.randrange(len(data) + 1)
        return data[:at] + b"\x00" + data[at:]
    if kind == 6:
        at = random.randrange(len(data) + 1)
        return data[:at] + random.choice([b"\xff", b"\xc3", b"\xa0", b"\x1b[2J", b"\x08"]) + data[at:]
    if kind == 7:
        return packed(data)
    return data.replace(b" ", b"\xc2\xa0")


def separated_otherwise(data, random):
    """Decimal commas, semicolons, tabs, and columns too many, everywhere or in one line."""
    lines = lines_of(data)
    change = random.choice([
        lambda line: line.replace(".", ","), lambda line: line.replace(" ", ";"),
        lambda line: line.replace(" ", ",") if " " in line else line.replace(",", ";"),
        lambda line: line.replace(" ", "\t"), lambda line: line + ",", lambda line: line + " 7",
        lambda line: line.replace(",", ";").replace(".", ",")])
    if random.random() < 0.5:
        lines = [change(line) if line else line for line in lines]
    else:
        at = random.randrange(len(lines))
        lines[at] = change(lines[at])
    return text_of(lines)


TEXT_KINDS = {
    "text: tokens replaced": token_replaced,
    "text: lines changed": lines_changed,
    "text: encoded otherwise": encoded_otherwise,
    "text: separated otherwise": separated_otherwise,
    "text: truncated": cut,
    "text: bytes overwritten": overwritten,
    "text: blocks repeated, deleted, moved": shuffled_blocks,
}

VALUES = TOKENS + [
    "1e9", "1e15", "-5", "100000", "1000000000", "true", "maybe", "/dev/zero", "..", "$env{HOME}",
    "$eval{2*3}", "${X}", "a b c", "0 0 0", "1 1 1", "1e6 1e6 1e6", "1e-9 1e-9 1e-9", "x" * 100000,
    "\u00e4\u00f6", "1e3", "1e-6", "200"]


def value_replaced(data, random):
    lines = lines_of(data)
    keys = [i for i, line in enumerate(lines) if "=" in line and not line.startswith("#")]
    for _ in range(random.randint(1, 2)):
        at = random.choice(keys)
        key, value = lines[at].split("=")[0], random.choice(VALUES)
        if key.strip() == "trials" and value.isdigit():
            value = value[:3]  # work for minutes is no hang
        lines[at] = key + "= " + value
    return text_of(lines)


def structure_changed(data, random):
    lines = lines_of(data)
    at = random.randrange(len(lines))
    kind = random.randrange(9)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(at, lines[random.randrange(len(lines))])
    elif kind == 2:
        lines.insert(at, random.choice(["[nonsense]", "[solvr]", "[", "[]", "]", "key", "= 5", "x =",
                                        "@define A", "@define A b\\", "@include /etc/passwd"]))
    elif kind == 3:
        lines[at] = lines[at].replace("=", " ").replace("]", "")
    elif kind == 4:
        lines[at] += "\\"
    elif kind == 5:
        lines[at:at] = [f"key{i} = {i}" for i in range(20000)]
    elif kind == 6:
        lines[at:at] = [f"[section{i}]" for i in range(20000)]
    elif kind == 7:
        lines[at:at] = ["@define A0 xxxxxxxx"] + [
            f"@define A{i} ${{A{i - 1}}}${{A{i - 1}}}" for i in range(1, 60)]
    else:
        lines[at] = lines[at].upper()
    return text_of(lines)


INI_KINDS = {
    "INI: values": value_replaced,
    "INI: structure": structure_changed,
    "INI: encoded otherwise": encoded_otherwise,
    "INI: bytes overwritten": overwritten,
}

SPECIAL = "special files"


def make_special(path, random):
    """Puts something that is no regular file, or too large a one, at `path`; returns what."""
    kinds = ["folder", "pipe", "missing", "device", "endless device", "empty", "loop of links",
             "socket", "100 GB"]
    kind = random.choice(kinds)
    if kind == "folder":
        os.mkdir(path)
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        os.symlink("/dev/null", path)
    elif kind == "endless device":
        os.symlink("/dev/zero", path)
    elif kind == "empty":
        open(path, "wb").close()
    elif kind == "loop of links":
        os.symlink(path, path)
    elif kind == "socket":
        listener = socket.socket(socket.AF_UNIX)
        here = os.getcwd()
        os.chdir(os.path.dirname(path))  # the name of a socket is short
        listener.bind(os.path.basename(path))
        os.chdir(here)
        listener.close()
    elif kind == "100 GB":
        with open(path, "wb") as file:
            file.truncate(100 << 30)
    return kind
