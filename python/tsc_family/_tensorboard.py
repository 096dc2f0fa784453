"""Event files of TensorBoard, one per training.

Source: the format of TFRecord, and the messages ``Event`` and ``Summary`` of TensorBoard, as protocol buffers.
"""

from __future__ import annotations

import csv
import math
import struct
from collections.abc import Iterable, Iterator
from pathlib import Path

_KINDS = ("training", "validation")
# The column before those of the features of point MDPs, after which those of the metrics come.
_BEFORE = "instances"

# Castagnoli's polynomial, reversed.
_POLYNOMIAL = 0x82F63B78


def _entry(value: int) -> int:
    for _ in range(8):
        value = value >> 1 ^ (_POLYNOMIAL if value & 1 else 0)
    return value


_TABLE = [_entry(value) for value in range(256)]


def _checksum(data: bytes) -> bytes:
    """Returns the masked CRC-32C that follows a part of a record."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc = _TABLE[(crc ^ byte) & 0xFF] ^ crc >> 8
    crc ^= 0xFFFFFFFF
    return struct.pack("<I", ((crc >> 15 | crc << 17) + 0xA282EAD8) & 0xFFFFFFFF)


def _record(data: bytes) -> bytes:
    length = struct.pack("<Q", len(data))
    return length + _checksum(length) + data + _checksum(data)


def _varint(value: int) -> bytes:
    parts = []
    while value > 0x7F:
        parts.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*parts, value])


def _field(number: int, data: bytes) -> bytes:
    return _varint(number << 3 | 2) + _varint(len(data)) + data


def _event(step: int, content: bytes) -> bytes:
    # The clock says nothing here, so that equal trainings give equal files.
    return _record(b"\x09" + struct.pack("<d", float(step)) + b"\x10" + _varint(step) + content)


def _scalar(step: int, name: str, value: float) -> bytes:
    return _event(step, _field(5, _field(1, _field(1, name.encode()) + b"\x15" + struct.pack("<f", value))))


def _trainings(rows: Iterable[dict[str, str]]) -> Iterator[tuple[tuple[str, str, str], list[dict[str, str]]]]:
    """Returns the rows of every training, in order."""
    trainings: dict[tuple[str, str, str], list[dict[str, str]]] = {}
    for row in rows:
        if row["kind"] in _KINDS:
            trainings.setdefault((row["method"], row["point"], row["replicate"]), []).append(row)
    return iter(trainings.items())


def write(records: Path, features: int, folder: Path) -> list[Path]:
    """Writes an event file per training from a table that ``export`` wrote, with so many features; returns the files."""
    with records.open(newline="", encoding="utf-8") as file:
        table = csv.DictReader(file)
        columns = list(table.fieldnames or ())
        measured = columns[columns.index(_BEFORE) + 1 + features :]
        trainings = list(_trainings(table))
    files = []
    for (method, point, replicate), rows in trainings:
        events = [_event(0, _field(3, b"brain.Event:2"))]
        for row in rows:
            for name in measured:
                value = float(row[name] or math.nan)
                if math.isfinite(value):
                    events.append(_scalar(int(row["episode"]), f"{row['kind']}/{name}", value))
        of = folder / method / point / f"replicate-{replicate}"
        of.mkdir(parents=True, exist_ok=True)
        files.append(of / "events.out.tfevents.0.tsc-family")
        files[-1].write_bytes(b"".join(events))
    return files
