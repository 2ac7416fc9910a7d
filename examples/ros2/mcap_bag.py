# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Reads ROS 2 bags in MCAP without ROS.

Chunks that are compressed need python3-zstandard or python3-lz4; all else is Python's own. Messages are decoded by the
definitions that the bag itself holds.
"""

import contextlib
import functools
import os
import pathlib
import re
import stat
import struct

from bag_words import DAMAGE, BagError, FileError, say

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15
MOST_CHUNK = 100_000_000  # bytes, of other records too; writers make chunks of some MB
MOST_PACKED = 1000  # times as many bytes as a file has may be in its chunks, and one chunk more
MOST_NAME = 512  # bytes; ROS has names of up to 255
MOST_TOPICS = 1 << 16
MOST_DEFINITIONS = 1 << 23  # bytes, of all in a file; 100 types have about 1 MB
MOST_VALUES = 1 << 20  # of a message: numbers, fields and bytes of texts, bytes that stay bytes not counted


class Bytes:
    """A record, read from its start."""

    def __init__(self, data):
        self.data, self.at = memoryview(data), 0

    def take(self, count):
        if count > len(self.data) - self.at:
            raise BagError("a record ends early")
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, code):
        return struct.unpack("<" + code, self.take(struct.calcsize(code)))[0]

    def text(self, most=MOST_NAME):
        size = self.number("I")
        if size > most:
            raise BagError(f"a text of {size} bytes is longer than {most}")
        return bytes(self.take(size)).decode("utf-8", "replace")


# --- Containers: records of a file, those inside of chunks included.

def unpacked(compression, data, size):
    """The bytes of a chunk."""
    if compression == "":
        return data
    packages = {"zstd": "zstandard", "lz4": "lz4.frame"}
    if compression not in packages:
        raise BagError(f"chunks are compressed with '{compression}', which is not known")
    try:
        module = __import__(packages[compression], fromlist=["x"])
    except ImportError:
        package = packages[compression].split(".", maxsplit=1)[0]
        raise BagError(f"chunks are compressed with {compression}: install python3-{package}") from None
    check_size(size)
    try:
        if compression == "zstd":
            content = module.ZstdDecompressor().stream_reader(bytes(data)).read(size)
        else:
            content = module.LZ4FrameDecompressor().decompress(bytes(data), max_length=size)
    except Exception as error:  # of either library's own kind
        raise BagError(f"a chunk is damaged: {error}") from None
    if len(content) < size:
        raise BagError("a chunk is damaged: it ends early")
    return content


def check_size(size):
    if size > MOST_CHUNK:
        raise BagError(f"damaged: a record or a chunk is said to have {size} bytes, more than {MOST_CHUNK}")


def records_of(file):
    """(operation code, content) of the records of a file or of a chunk that tell something. Returns whether a file was
    whole."""
    while True:
        head = file.read(9)
        if len(head) < 9:
            return False
        code, size = struct.unpack("<BQ", head)
        if size > file.left() or code == DATA_END:
            return code == DATA_END
        if code not in file.KINDS:
            file.skip(size)
            continue
        check_size(size)
        content = file.read(size)
        if code == CHUNK:
            yield from records_of(file.chunk(Bytes(content)))
        else:
            yield code, content


class View:
    """A chunk as a file."""

    KINDS = (SCHEMA, CHANNEL, MESSAGE)

    def __init__(self, data):
        self.data, self.at = memoryview(data), 0

    def left(self):
        return len(self.data) - self.at

    def skip(self, count):
        self.at += count

    def read(self, count):
        self.at += count
        return self.data[self.at - count:self.at]


class File:
    """A file of known size."""

    KINDS = (SCHEMA, CHANNEL, MESSAGE, CHUNK)

    def __init__(self, file):
        self.file, self.read, self.size = file, file.read, os.fstat(file.fileno()).st_size
        self.room = MOST_PACKED * self.size + MOST_CHUNK

    def left(self):
        return self.size - self.file.tell()

    def skip(self, count):
        self.file.seek(count, os.SEEK_CUR)

    def chunk(self, record):
        """What is in a chunk."""
        record.take(16)
        size, _, compression = record.number("Q"), record.number("I"), record.text()
        self.room -= size
        if self.room < 0:
            raise BagError(f"damaged: its chunks have more than {MOST_PACKED} times its size")
        return View(unpacked(compression, record.take(record.number("Q")), size))


# --- Messages: what a definition in ROS's own form says, in CDR.

NUMBERS = {"bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
           "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}


def fields_of(definition):
    """(type, array, name) of each field; array is None, a fixed number, or "" for a sequence."""
    for line in definition.splitlines():
        words = line.split("#", maxsplit=1)[0].split()
        if len(words) < 2 or "=" in "".join(words[1:2]) or words[2:3] == ["="]:
            continue
        kind, _, array = words[0].partition("[")
        array = None if "[" not in words[0] else array.rstrip("]")
        fixed = int(array) if array and not array.startswith("<=") else None
        yield kind.partition("<=")[0], fixed if fixed is not None else ("" if array is not None else None), words[1]


class Decoder:
    """Reads messages of one schema."""

    def __init__(self, name, encoding, text):
        if encoding != "ros2msg":
            raise BagError(f"{name} is defined in '{encoding}', where ros2msg is read")
        main, *others = re.split(r"^={3,}[ \t]*\n", text.replace("\r\n", "\n"), flags=re.MULTILINE)
        self.name, self.types = name, {}
        self.types[self.short(name)] = list(fields_of(main))
        for other in others:
            head, _, body = other.partition("\n")
            self.types[self.short(head.replace("MSG:", "").strip())] = list(fields_of(body))

    @staticmethod
    def short(name):
        """pkg/msg/Type and pkg/Type -> pkg/Type"""
        return name.replace("/msg/", "/")

    def fields(self, kind, package):
        if "/" not in kind:
            kind = "std_msgs/Header" if kind == "Header" else f"{package}/{kind}"
        kind = self.short(kind)
        if kind not in self.types:
            raise BagError(f"{self.name}: the bag does not define {kind}")
        return kind, self.types[kind]

    def decode(self, data):
        if len(data) < 4 or data[1] not in (0, 1):
            raise BagError(f"{self.name}: a message is not in plain CDR")
        self.order, self.data, self.at = "<" if data[1] == 1 else ">", memoryview(data)[4:], 0
        self.room = min(1000 + 64 * len(data), MOST_VALUES)
        return self.struct(self.short(self.name), "")

    def spend(self, count):
        """Few bytes, or none, may stand for many values."""
        self.room -= count
        if self.room < 0:
            raise BagError(f"{self.name}: a message has too many values for its size, or more than {MOST_VALUES}")

    def number(self, code):
        return self.numbers(code, 1)[0]

    def numbers(self, code, count):
        """An array; that of bytes as they are."""
        size = struct.calcsize("=" + code)
        start = self.at + (-self.at % size if count else 0)
        if start + count * size > len(self.data):
            raise BagError(f"{self.name}: a message ends early")
        self.at = start + count * size
        found = self.data[start:self.at]
        if code == "B":
            return found
        self.spend(count)
        return struct.unpack(f"{self.order}{count}{code}", found)

    def string(self):
        size = self.number("I")
        if size > len(self.data) - self.at:
            raise BagError(f"{self.name}: a message ends early")
        self.spend(size)
        self.at += size
        return bytes(self.data[self.at - size:self.at]).rstrip(b"\0").decode("utf-8", "replace")

    def value(self, kind, package):
        if kind in NUMBERS:
            return self.number(NUMBERS[kind])
        return self.string() if kind == "string" else self.struct(kind, package)

    def struct(self, kind, package):
        kind, fields = self.fields(kind, package)
        package = kind.split("/", maxsplit=1)[0]
        self.spend(1 + len(fields))
        out = {}
        for field, array, name in fields:
            if array is None:
                out[name] = self.value(field, package)
                continue
            count = self.number("I") if array == "" else array
            if count > len(self.data):
                raise BagError(f"{self.name}: a message ends early")
            out[name] = (self.numbers(NUMBERS[field], count) if field in NUMBERS else
                         [self.value(field, package) for _ in range(count)])
        if not fields:
            self.number("B")  # CDR has no empty structures
        return out


# --- Bags: the messages of the topics that are asked for.

def files_of(paths):
    files = []
    for path in map(pathlib.Path, paths):
        found = sorted(path.glob("*.mcap"), key=numeric) if path.is_dir() else [path]
        if not found:
            raise FileError(f"{path}: no MCAP file is there")
        files += found
    return files


def numeric(path):
    """For sorting: run_10 comes behind run_2."""
    return [int(part) if k % 2 else part for k, part in enumerate(re.split(r"([0-9]+)", path.name))]


def topics_of(files):
    """Topic -> type. Tells which files were cut off."""
    topics = {}
    for path in files:
        schemas = {}
        for code, content in bag_records(path, say):
            with named(path):
                record = Bytes(content)
                if code == SCHEMA:
                    number = record.number("H")
                    schemas[number] = record.text()
                elif code == CHANNEL:
                    record.take(2)
                    schema = record.number("H")
                    topics[record.text()] = schemas.get(schema, "")
                    if len(topics) > MOST_TOPICS:
                        raise BagError(f"damaged: it has more than {MOST_TOPICS} topics")
    return topics


def chosen_topic(topics, kinds, given):
    """The topic that is given, or else the only one of the first kind that the bag has."""
    of_kinds = [[topic for topic, name in topics.items() if Decoder.short(name) == Decoder.short(kind)] for kind in kinds]
    if any(given in found for found in of_kinds):
        return given
    first = next((found for found in of_kinds if found), [])
    if given is None and len(first) == 1:
        return first[0]
    listed = ", ".join(f"{topic} ({name})" for topic, name in sorted(topics.items())) or "none"
    wanted = " or ".join(kinds)
    why = (f"{given} is no topic of {wanted}" if given else
           f"{len(first)} topics are {wanted}: name one" if first else f"no topic is {wanted}")
    raise BagError(f"{why}; the bag has {listed}")


def without_waiting(path, flags):
    """For open(): a pipe has no writer yet, or never."""
    return os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)


def check_regular(mode):
    if not stat.S_ISREG(mode):
        kind = "folder" if stat.S_ISDIR(mode) else "pipe" if stat.S_ISFIFO(mode) else "device"
        raise BagError(f"is a {kind}, not a regular file")


def bag_records(path, tell=lambda text: None):
    """The records of a bag; what is wrong names it."""
    try:
        with open(path, "rb", opener=without_waiting) as file:
            check_regular(os.fstat(file.fileno()).st_mode)
            if file.read(len(MAGIC)) != MAGIC:
                raise BagError("is not an MCAP file; `ros2 bag convert` makes one of other bags")
            if not (yield from records_of(File(file))):
                tell(f"{path}: ends early; what came before is used")
    except OSError as error:
        raise FileError(f"{path}: {error.strerror}") from None
    except BagError as error:
        raise FileError(f"{path}: {error}") from None


@contextlib.contextmanager
def named(path):
    """What is wrong names the bag."""
    try:
        yield
    except BagError as error:
        raise FileError(f"{path}: {error}") from None
    except DAMAGE as error:
        raise FileError(f"{path}: damaged, or not as ROS defines it: {type(error).__name__} {error}") from None


def messages_of(files, topic, drop=None):
    """The messages of a topic, in the order of the files. `drop` is told what is wrong with one, which else ends it."""
    for path in files:
        reader = Reader(topic)
        for code, content in bag_records(path):
            message = None
            try:
                with named(path):
                    message = reader.message_in(code, Bytes(content))
            except BagError as error:
                if drop is None or code != MESSAGE:
                    raise
                drop(str(error))
            if message is not None:
                yield message


@functools.lru_cache(maxsize=16)
def decoder_of(name, encoding, text):
    """Each chunk may say again what messages are."""
    return Decoder(name, encoding, text)


class Reader:
    """Reads the messages of a topic in the records of a file."""

    def __init__(self, topic):
        self.topic, self.schemas, self.channels, self.room = topic, {}, {}, MOST_DEFINITIONS

    def message_in(self, code, record):
        """The message that a record is; None of others, which tell what messages are."""
        if code == SCHEMA:
            self.add_schema(record)
        elif code == CHANNEL:
            self.add_channel(record)
        elif code == MESSAGE:
            number = record.number("H")
            if number in self.channels:
                record.take(20)
                return self.channels[number].decode(record.data[record.at:])
        return None

    def add_schema(self, record):
        number = record.number("H")
        if number not in self.schemas:
            self.schemas[number] = (record.text(), record.text(), record.text(self.room))
            self.room -= len(self.schemas[number][2])

    def add_channel(self, record):
        number, schema, name, encoding = record.number("H"), record.number("H"), record.text(), record.text()
        if name != self.topic:
            return
        if encoding != "cdr" or schema not in self.schemas:
            raise BagError(f"{name} is encoded as '{encoding}', where cdr with a definition is read")
        self.channels[number] = decoder_of(*self.schemas[schema])
