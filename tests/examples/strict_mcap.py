# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Reads a file in MCAP as its specification (mcap.dev/spec) has it, and refuses all else; of kinds of records, those that files
without chunks, index and summary have."""

import json
import struct

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, DATA_END = 1, 2, 3, 4, 5, 15


class Record:
    """The fields of a record, all of which must be taken."""

    def __init__(self, content):
        self.content, self.at = content, 0

    def take(self, count):
        assert self.at + count <= len(self.content), "a field goes beyond its record"
        self.at += count
        return self.content[self.at - count:self.at]

    def number(self, code):
        return struct.unpack("<" + code, self.take(struct.calcsize("<" + code)))[0]

    def text(self):
        return self.take(self.number("I")).decode("utf-8")

    def ends(self):
        assert self.at == len(self.content), "a record is longer than its fields"


def records(data):
    """(kind, fields) of all records between the magic bytes."""
    assert data[:8] == MAGIC and data[-8:] == MAGIC and len(data) >= 16, "magic bytes"
    at, end = 8, len(data) - 8
    while at < end:
        assert at + 9 <= end, "a record ends early"
        kind, length = struct.unpack_from("<BQ", data, at)
        assert at + 9 + length <= end, "a record goes beyond the file"
        yield kind, Record(data[at + 9:at + 9 + length])
        at += 9 + length


def not_json(word):
    raise AssertionError(f"{word} is no JSON")


def read(data):
    """(schemas, channels, messages): {id: (name, schema)}, {id: (topic, schema id)}, [(channel, time, message)]."""
    schemas, channels, messages, kinds = {}, {}, [], []
    for kind, record in records(data):
        kinds.append(kind)
        if kind == HEADER:
            profile, _ = record.text(), record.text()
            assert profile == "", "a profile of others"
        elif kind == SCHEMA:
            number, name, encoding = record.number("H"), record.text(), record.text()
            assert number != 0 and number not in schemas and name and encoding == "jsonschema"
            schemas[number] = (name, json.loads(record.text(), parse_constant=not_json))
        elif kind == CHANNEL:
            number, schema, topic, encoding = record.number("H"), record.number("H"), record.text(), record.text()
            assert number not in channels and schema in schemas and topic and encoding == "json"
            assert record.number("I") == 0, "metadata"
            channels[number] = (topic, schema)
        elif kind == MESSAGE:
            channel, count, logged, published = (record.number(code) for code in "HIQQ")
            assert channel in channels, "a channel that is not there"
            assert count == len(messages) % 2**32 and logged == published
            assert not messages or logged >= messages[-1][1], "times fall"
            messages.append((channel, logged, json.loads(record.take(len(record.content) - 22).decode("utf-8"),
                                                         parse_constant=not_json)))
        elif kind == DATA_END:
            assert record.number("I") == 0, "the sum of bytes, which is not looked at here"
        elif kind == FOOTER:
            assert [record.number(code) for code in "QQI"] == [0, 0, 0], "a summary, which is not there"
        else:
            raise AssertionError(f"record of kind {kind}")
        record.ends()
    assert kinds[0] == HEADER and kinds[-2:] == [DATA_END, FOOTER], "the order of the records"
    assert all(kinds.count(kind) == 1 for kind in (HEADER, DATA_END, FOOTER)), "records that are there once"
    return schemas, channels, messages
