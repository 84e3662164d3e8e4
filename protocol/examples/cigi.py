"""CIGI 3.3 and 4.0 with nothing but Python's own library: the packets that a small host needs, packed and unpacked.

Every packet is a line of `struct` codes with one table for each version; the byte order is a prefix. What the fields mean
stands in ../cigi-3.3.md and ../cigi-4.0.md.
"""

import socket
import struct
import time

# What follows the header (3.3: id and size, one byte each; 4.0: size and id, two bytes each). `x` is a reserved byte.
PACKETS = {
    "3.3": {
        "ig_control": (1, "BbBxHIII4x"),
        "entity_control": (2, "HBBBxHHfffddd"),
        "celestial": (9, "BBB3xIf"),
        "atmosphere": (10, "BBffffff4x"),
        "region": (11, "HB3xddfffff4x"),
        "weather": (12, "HBBBBffffffffffff"),
        "view_control": (16, "HBBHffffff"),
        "view_definition": (21, "HBBBxffffff"),
        "component": (4, "HHBBIIIIII"),
        "hat_hot_request": (24, "HBBHddd"),
        "conditions_request": (28, "BB4xddd"),
        "los_segment": (25, "HBBHddddddIBxH"),
    },
    "4.0": {
        "ig_control": (0x0000, "BbBBIII4x"),
        "entity_control": (0x0025, "BBHBBHBBBB"),
        "entity_position": (0x0001, "BxHH2xfffddd"),
        "celestial": (0x0008, "BxBBfIf4x"),
        "atmosphere": (0x0009, "B3xffffff"),
        "region": (0x000A, "BxHddfffff4x"),
        "weather": (0x000B, "BBBBH2xffffffffffffff4x"),
        "view_control": (0x000F, "BBHH2xffffff4x"),
        "view_definition": (0x0014, "HBBB3xffffff4x"),
        "component": (0x0003, "HBBH6xIIIIII"),
        "hat_hot_request": (0x0017, "HHBB6xddd"),
        "conditions_request": (0x001B, "BB2xddd"),
        "los_segment": (0x0018, "HHBBHB3xddddddI4x"),
    },
}
ANSWERS = {
    "3.3": {
        101: ("start_of_frame", "bBBHIII4x", "database status flags magic frame timestamp host_frame"),
        102: ("hat_hot", "HB3xd", "id flags height"),
        103: ("hat_hot_extended", "HB3xddIff4x", "id flags hat hot material azimuth elevation"),
        104: ("line_of_sight", "HBBHd", "id flags count entity range"),
        109: ("conditions", "BBffffff4x", "id humidity temperature visibility wind updraft from_deg pressure"),
        110: ("aerosol", "BBf", "id layer concentration"),
        116: ("event", "HIII", "id data_1 data_2 data_3"),
    },
    "4.0": {
        0xFFFF: ("start_of_frame", "bxBIIIBB2x", "database flags frame timestamp host_frame state_high state_low"),
        0x0FFF: ("hat_hot", "BxHd", "flags id height"),
        0x0FFE: ("hat_hot_extended", "BxHddIff4x", "flags id hat hot material azimuth elevation"),
        0x0FFD: ("line_of_sight", "HHBB6xd", "id entity flags count range"),
        0x0FF8: ("conditions", "BB2xffffff", "id humidity temperature visibility wind updraft from_deg pressure"),
        0x0FF7: ("aerosol", "BB2xf4x", "id layer concentration"),
        0x0FF1: ("event", "H2xIII4x", "id data_1 data_2 data_3"),
    },
}
CLOUD_TYPES = {"altocumulus": 1, "altostratus": 2, "cirrocumulus": 3, "cirrostratus": 4, "cirrus": 5, "cumulonimbus": 6,
               "cumulus": 7, "nimbostratus": 8, "stratocumulus": 9, "stratus": 10}
STRIKE_COMPONENT, CLASS_SYSTEM = 0x4C53, 13


class Packer:
    """Packets of one version in one byte order, as bytes."""

    def __init__(self, version="3.3", byte_order="little"):
        self.version, self.order = version, "<" if byte_order == "little" else ">"

    def pack(self, name, *fields):
        """One packet with its header."""
        number, codes = PACKETS[self.version][name]
        body = struct.pack(self.order + codes, *fields)
        if self.version == "3.3":
            return struct.pack(self.order + "BB", number, len(body) + 2) + body
        return struct.pack(self.order + "HH", len(body) + 4, number) + body

    def ig_control(self, frame, last_ig_frame, mode=1, database=0, timestamp=None):
        """The first packet of a message; the time stamp counts 10 microseconds."""
        stamp = int(time.monotonic() * 1e5) & 0xFFFFFFFF if timestamp is None else timestamp
        if self.version == "3.3":
            return self.pack("ig_control", 3, database, 3 << 4 | 0xC | mode, 0x8000, frame, stamp, last_ig_frame)
        return self.pack("ig_control", 4, database, 0, 0xC | mode, frame, last_ig_frame, stamp)

    def entity(self, latitude, longitude, altitude, yaw, pitch, roll, number=0):
        """An active entity; number 0 is the ownship. It moves on between messages."""
        if self.version == "3.3":
            return self.pack("entity_control", number, 1, 0x10, 255, 0, 0, roll, pitch, yaw, latitude, longitude, altitude)
        state = self.pack("entity_control", 0x11, 255, number, 0, 0, 0, 0, 0, 0, 0)
        return state + self.pack("entity_position", 0, number, 0, roll, pitch, yaw, latitude, longitude, altitude)

    def celestial(self, month, day, year, hour, minute, running=True):
        """Date and time in UTC, with sun, moon and stars."""
        flags, date = 0x1E | running, month * 1_000_000 + day * 10_000 + year
        if self.version == "3.3":
            return self.pack("celestial", hour, minute, flags, date, 100.0)
        return self.pack("celestial", flags, hour, minute, 0.0, date, 100.0)

    def atmosphere(self, visibility, temperature=15.0, humidity=60, wind=0.0, wind_from=0.0, pressure=1013.25):
        """The air where no layer says otherwise."""
        rest = (temperature, visibility, wind, 0.0, wind_from, pressure)
        return self.pack("atmosphere", *((0, humidity) if self.version == "3.3" else (humidity,)), *rest)

    def weather(self, layer, cloud_type, base, thickness, coverage, visibility=0.0, wind=0.0, wind_from=0.0,
                lightning=False, severity=0, scope=0, region=0, humidity=80, temperature=5.0):
        """One cloud layer; coverage in per cent, heights in metres above mean sea level."""
        flags = 1 | lightning << 3 | CLOUD_TYPES.get(cloud_type, 0) << 4
        head = (layer, humidity, flags, scope | severity << 2)
        body = (temperature, visibility, 0.0, coverage, base, thickness, 0.0, wind, 0.0, wind_from, 1013.25, 0.0)
        if self.version == "3.3":
            return self.pack("weather", region, *head, *body)
        return self.pack("weather", *head, region, *body, 0.0, 0.0)

    def region(self, number, latitude, longitude, size_x, size_y, corner=0.0, rotation=0.0, transition=0.0, merge=False):
        """A rounded rectangle with its own weather."""
        state, place = 1 | merge << 2, (latitude, longitude, size_x, size_y, corner, rotation, transition)
        return self.pack("region", *((number, state) if self.version == "3.3" else (state, number)), *place)

    def view(self, number, yaw=0.0, pitch=0.0, roll=0.0, entity=0, offset=(0.0, 0.0, 0.0)):
        """Attaches a view to an entity and turns it."""
        head = (number, 0, 0x3F, entity) if self.version == "3.3" else (0, 0x3F, number, entity)
        return self.pack("view_control", *head, *offset, roll, pitch, yaw)

    def view_definition(self, number, left, right, top, bottom, mirror=0):
        """The frustum of a view as half-angles."""
        return self.pack("view_definition", number, 0, 0x3C | mirror << 6, 0, 1.0, 1e5, left, right, top, bottom)

    def strike(self, number, latitude, longitude, altitude, current_ka):
        """Lightning by Component Control; a negative current is the usual polarity."""
        words = struct.unpack(">6I", struct.pack(">ddff", latitude, longitude, altitude, current_ka))
        if self.version == "3.3":
            return self.pack("component", STRIKE_COMPONENT, number, CLASS_SYSTEM, 1, *words)
        return self.pack("component", STRIKE_COMPONENT, CLASS_SYSTEM, 1, number, *words)

    def hat_hot_request(self, number, latitude, longitude, altitude, kind=2, period=0):
        """Asks for heights; kind 0 is HAT, 1 HOT, 2 both."""
        if self.version == "3.3":
            return self.pack("hat_hot_request", number, kind, period, 0, latitude, longitude, altitude)
        return self.pack("hat_hot_request", number, 0, kind, period, latitude, longitude, altitude)

    def los_segment(self, number, source, destination, alpha=128, period=0):
        """Asks what hides one geodetic point from another."""
        mask = 0xFFFFFFFF
        if self.version == "3.3":
            return self.pack("los_segment", number, 0, alpha, 0, *source, *destination, mask, period, 0)
        return self.pack("los_segment", number, 0, 0, alpha, 0, period, *source, *destination, mask)

    def conditions_request(self, number, latitude, longitude, altitude):
        """Asks for weather and aerosols at a point."""
        head = (12, number)
        return self.pack("conditions_request", *head, latitude, longitude, altitude)


def unpack(message):
    """The packets of an answer as `(name, fields)`; its version and byte order are found out from its first bytes."""
    if message[:3] == b"\x65\x18\x03":
        version, order = "3.3", "<" if message[6:8] == b"\x00\x80" else ">"
    elif message[:5] in (b"\x18\x00\xff\xff\x04", b"\x00\x18\xff\xff\x04"):
        version, order = "4.0", "<" if message[0] == 0x18 else ">"
    else:
        raise ValueError(f"no Start of Frame: {message[:8].hex()}")
    packets, at = [], 0
    while at < len(message):
        if version == "3.3":
            number, size, header = message[at], message[at + 1], 2
        else:
            (size, number), header = struct.unpack_from(order + "HH", message, at), 4
        if size < 8 or size % 8 or at + size > len(message):
            raise ValueError(f"packet {number} of {size} bytes at {at} of {len(message)}")
        if number in ANSWERS[version]:
            name, codes, fields = ANSWERS[version][number]
            # The major version stands first in a Start of Frame; it was looked at above.
            values = struct.unpack_from(order + ("B" if name == "start_of_frame" else "") + codes, message, at + header)
            packets.append((name, dict(zip(fields.split(), values[name == "start_of_frame":]))))
        at += size
    return packets


class Port:
    """A UDP port of a host: sends messages, takes answers, keeps both frame counters."""

    def __init__(self, to, listen=("", 0), version="3.3", byte_order="little"):
        self.packer, self.to = Packer(version, byte_order), to
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(listen)
        self.socket.settimeout(1.0)
        self.frame = self.ig_frame = 0
        self.mode = None

    def send(self, *packets, mode=1):
        """One message: an IG Control and these packets."""
        self.frame += 1
        self.socket.sendto(b"".join((self.packer.ig_control(self.frame, self.ig_frame, mode), *packets)), self.to)

    def receive(self):
        """The next message of the image generator; raises `TimeoutError` when it is silent."""
        packets = unpack(self.socket.recv(65536))
        first = packets[0][1]
        self.ig_frame, self.mode = first["frame"], first["flags"] & 3
        return packets
