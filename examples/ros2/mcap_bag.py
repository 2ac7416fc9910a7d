# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Reads ROS 2 bags in MCAP without ROS.

Chunks that are compressed need python3-zstandard or python3-lz4; all else is Python's own. Messages are decoded by the
definitions that the bag itself holds.
"""

import contextlib
import os
import pathlib
import re
import shutil
import struct

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15
MOST_CHUNK = 1 << 28  # bytes; writers make chunks of some MB
# What a message or a definition that is damaged, or not as ROS has it, leads to.
DAMAGE = (ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError, ValueError)


class BagError(Exception):
    """What is wrong with a bag, for the user."""


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

    def text(self):
        return bytes(self.take(self.number("I"))).decode("utf-8", "replace")


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
    if size > MOST_CHUNK:
        raise BagError(f"a chunk is damaged: it is said to have {size} bytes")
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


def records_of(file):
    """(operation code, content) of each record of a file or of a chunk. Returns whether a file was whole."""
    while True:
        head = file.read(9)
        if len(head) < 9:
            return False
        code, size = struct.unpack("<BQ", head)
        content = file.read(size) if size <= file.left() else b""
        if len(content) < size or code == DATA_END:
            return code == DATA_END
        if code == CHUNK:
            chunk = Bytes(content)
            chunk.take(16)
            size, _, compression = chunk.number("Q"), chunk.number("I"), chunk.text()
            yield from records_of(View(unpacked(compression, chunk.take(chunk.number("Q")), size)))
        else:
            yield code, content


class View:
    """Bytes as a file."""

    def __init__(self, data):
        self.data, self.at = memoryview(data), 0

    def left(self):
        return len(self.data) - self.at

    def read(self, count):
        self.at += count
        return self.data[self.at - count:self.at]


class File:
    """A file of known size."""

    def __init__(self, file):
        self.read, self.tell, self.size = file.read, file.tell, os.fstat(file.fileno()).st_size

    def left(self):
        return self.size - self.tell()


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
        return self.struct(self.short(self.name), "")

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
        return found if code == "B" else struct.unpack(f"{self.order}{count}{code}", found)

    def string(self):
        size = self.number("I")
        if size > len(self.data) - self.at:
            raise BagError(f"{self.name}: a message ends early")
        self.at += size
        return bytes(self.data[self.at - size:self.at]).rstrip(b"\0").decode("utf-8", "replace")

    def value(self, kind, package):
        if kind in NUMBERS:
            return self.number(NUMBERS[kind])
        return self.string() if kind == "string" else self.struct(kind, package)

    def struct(self, kind, package):
        kind, fields = self.fields(kind, package)
        package = kind.split("/", maxsplit=1)[0]
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
    for path in map(pathlib.Path, paths):
        yield from sorted(path.glob("*.mcap"), key=numeric) if path.is_dir() else [path]


def numeric(path):
    """For sorting: run_10 comes behind run_2."""
    return [int(part) if part.isdigit() else part for part in re.split(r"([0-9]+)", path.name)]


def topics_of(files):
    """Topic -> type. Tells which files were cut off."""
    topics = {}
    for path in files:
        schemas = {}
        for code, content in bag_records(path, print):
            with named(path):
                record = Bytes(content)
                if code == SCHEMA:
                    number = record.number("H")
                    schemas[number] = record.text()
                elif code == CHANNEL:
                    record.take(2)
                    schema = record.number("H")
                    topics[record.text()] = schemas.get(schema, "")
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


def bag_records(path, tell=lambda text: None):
    """The records of a bag; what is wrong names it."""
    try:
        with open(path, "rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise BagError("is not an MCAP file; `ros2 bag convert` makes one of other bags")
            if not (yield from records_of(File(file))):
                tell(f"{path}: ends early; what came before is used")
    except OSError as error:
        raise BagError(f"{path}: {error.strerror}") from None
    except BagError as error:
        raise BagError(f"{path}: {error}") from None


@contextlib.contextmanager
def named(path):
    """What is wrong names the bag."""
    try:
        yield
    except BagError as error:
        raise BagError(f"{path}: {error}") from None
    except DAMAGE as error:
        raise BagError(f"{path}: damaged, or not as ROS defines it: {type(error).__name__} {error}") from None


def messages_of(files, topic, drop=None):
    """The messages of a topic, in the order of the files. `drop` is told what is wrong with one, which else ends it."""
    for path in files:
        schemas, channels = {}, {}
        for code, content in bag_records(path):
            message = None
            try:
                with named(path):
                    message = message_in(code, Bytes(content), topic, schemas, channels)
            except BagError as error:
                if drop is None or code != MESSAGE:
                    raise
                drop(str(error))
            if message is not None:
                yield message


def message_in(code, record, topic, schemas, channels):
    """The message that a record is; None of others, which tell what messages are."""
    if code == SCHEMA:
        number, name, encoding = record.number("H"), record.text(), record.text()
        schemas[number] = (name, encoding, bytes(record.take(record.number("I"))).decode("utf-8", "replace"))
    elif code == CHANNEL:
        number, schema, name, encoding = record.number("H"), record.number("H"), record.text(), record.text()
        if name != topic:
            return None
        if encoding != "cdr" or schema not in schemas:
            raise BagError(f"{topic} is encoded as '{encoding}', where cdr with a definition is read")
        channels[number] = Decoder(*schemas[schema])
    elif code == MESSAGE:
        number = record.number("H")
        if number in channels:
            record.take(20)
            return channels[number].decode(record.data[record.at:])
    return None


# --- Files that are written.

@contextlib.contextmanager
def written(path):
    """A text file that appears once it is complete; a failure leaves what was there."""
    part = f"{path}.part"
    try:
        with open(part, "w+", encoding="utf-8", newline="") as file:
            yield file
        os.replace(part, path)
    except OSError as error:
        raise BagError(f"cannot write {path}: {error.strerror}") from None
    finally:
        with contextlib.suppress(OSError):
            os.remove(part)


@contextlib.contextmanager
def filled(path):
    """A folder whose files appear once all are complete; one that has files is refused, and a failure leaves what was there."""
    path, part = pathlib.Path(path), pathlib.Path(path) / ".part"
    try:
        is_new = not path.exists()
        if not is_new and next(path.iterdir(), None):
            raise BagError(f"{path} is not empty: name a folder that is empty or new")
        try:
            part.mkdir(parents=True)
            yield part
            for file in list(part.iterdir()):
                os.replace(file, path / file.name)
            is_new = False
        finally:
            shutil.rmtree(part, ignore_errors=True)
            if is_new:
                with contextlib.suppress(OSError):
                    path.rmdir()
    except OSError as error:
        raise BagError(f"cannot write {path}: {error.strerror}") from None


def in_a_line(text):
    """With escapes for line ends and control characters, which the names in a damaged bag have."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def told(program, convert, options):
    """Runs a conversion; what is wrong is told in one line."""
    try:
        convert(options)
        return 0
    except BagError as error:
        what = str(error)
    except DAMAGE as error:
        what = f"{' '.join(options.bag)}: messages are damaged, or not as ROS defines them: {type(error).__name__} {error}"
    return f"{program}: {in_a_line(what)}"
