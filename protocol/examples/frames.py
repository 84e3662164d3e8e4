"""Unpacks a binary frame message (protocol/frames.md): the header's fields, then the picture."""

import struct
from dataclasses import dataclass

HEADER = struct.Struct("<4sHHHHIIIQ32sdQQQQQQII")
FORMATS = {0: "raw", 1: "png", 2: "jpeg"}


@dataclass
class Frame:
    """One picture and what a host needs to know of it; times in microseconds on the server's clock."""

    format: str
    size_px: tuple
    host_frame: int
    number: int
    view: str
    simulation_time_s: float
    received_us: int
    sent_us: int
    dropped: int
    picture: bytes


def unpack(message):
    """The frame of a message; ValueError when it is none."""
    if len(message) < HEADER.size:
        raise ValueError(f"a frame message of {len(message)} bytes is cut off")
    (magic, version, begin, code, _flags, width, height, host_frame, number, view, time_s,
     received_us, _snapshot_us, _submitted_us, _finished_us, _encoded_us, sent_us, dropped, length) = HEADER.unpack_from(message)
    if magic != b"SDFR" or version != 1 or code not in FORMATS or len(message) != begin + length:
        raise ValueError(f"no frame message of version 1: {message[:16]!r}")
    return Frame(FORMATS[code], (width, height), host_frame, number, view.rstrip(b"\0").decode(), time_s,
                 received_us, sent_us, dropped, message[begin:])
