# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Writes JSON messages to a file in MCAP, which Foxglove opens. Needs Python alone."""

import json
import struct

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, DATA_END = 1, 2, 3, 4, 5, 15


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def nanoseconds(seconds):
    """The time of a message, of which none is before 0."""
    return max(0, round(seconds * 1e9))


class McapWriter:
    """One topic of one schema in a file that is open for writing bytes; the file is whole where `with` ends, however it ends."""

    def __init__(self, file, topic, schema_name, schema):
        self.file, self.count = file, 0
        file.write(MAGIC)
        self.record(HEADER, text("") + text("hybrid"))
        self.record(SCHEMA, struct.pack("<H", 1) + text(schema_name) + text("jsonschema") + text(json.dumps(schema)))
        self.record(CHANNEL, struct.pack("<HH", 1, 1) + text(topic) + text("json") + struct.pack("<I", 0))

    def record(self, code, content):
        self.file.write(struct.pack("<BQ", code, len(content)) + content)

    def write(self, seconds, message):
        time = nanoseconds(seconds)
        content = json.dumps(message, allow_nan=False).encode()
        self.record(MESSAGE, struct.pack("<HIQQ", 1, self.count, time, time) + content)
        self.file.flush()
        self.count += 1

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.record(DATA_END, struct.pack("<I", 0))
        self.record(FOOTER, struct.pack("<QQI", 0, 0, 0))
        self.file.write(MAGIC)
