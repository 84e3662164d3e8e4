#!/usr/bin/env python3
"""A CIGI host in Python, standard library only: flies a circle under a storm, asks questions and prints the answers.

With a server that listens for CIGI (`stormdeck serve --config config/cigi.json`) on the same machine:

    python3 cigi_host.py --version 4.0 --byte-order big

Ends with 1 when an answer is missing at the end or the image generator never goes into operation.
"""

import argparse
import contextlib
import math
import struct
import sys
import time

from cigi import Port

LATITUDE, LONGITUDE, ALTITUDE, RADIUS_M, SPEED_MPS = 47.26, 11.40, 900.0, 3000.0, 100.0


def options():
    """What was typed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--to", default="127.0.0.1:8004", help="where the image generator listens")
    parser.add_argument("--port", type=int, default=8005, help="port to listen on, and to send from")
    parser.add_argument("--version", choices=["3.3", "4.0"], default="3.3")
    parser.add_argument("--byte-order", choices=["little", "big"], default="little", help="of what is sent")
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--rate", type=float, default=60.0, help="messages a second; 0: one for each Start of Frame (synchronous)")
    parser.add_argument("--patience", type=float, default=60.0, help="seconds to wait for answers at the end")
    return parser.parse_args()


def place(seconds):
    """Position and heading on the circle."""
    angle = SPEED_MPS * seconds / RADIUS_M
    north, east = RADIUS_M * math.cos(angle), RADIUS_M * math.sin(angle)
    latitude = LATITUDE + north / 111_200.0
    longitude = LONGITUDE + east / (111_200.0 * math.cos(math.radians(LATITUDE)))
    return latitude, longitude, (math.degrees(angle) + 90.0) % 360.0


def start(port):
    """Standby, then operation with weather, time and view; waits until the image generator follows."""
    pack = port.packer
    for mode, packets in [
        (0, []),
        (1, [
            pack.celestial(6, 21, 2026, 18, 30),
            pack.atmosphere(30_000.0, temperature=22.0, wind=6.0, wind_from=250.0),
            pack.region(1, LATITUDE, LONGITUDE, 30_000.0, 30_000.0, corner=15_000.0, transition=5_000.0, merge=True),
            pack.weather(1, "cumulonimbus", 1500.0, 7000.0, 60.0, lightning=True, severity=4, scope=1, region=1),
            pack.weather(2, "cirrus", 9500.0, 600.0, 40.0, wind=30.0, wind_from=280.0),
            pack.view_definition(0, -30.0, 30.0, 18.0, -18.0),
            pack.view(0, pitch=5.0),
        ]),
    ]:
        port.send(*packets, mode=mode)
        until = time.monotonic() + 30.0
        while port.mode != mode:
            if time.monotonic() > until:
                sys.exit(f"the image generator does not go into mode {mode}")
            try:
                port.receive()
            except TimeoutError:
                port.send(mode=mode)


def tell(name, fields):
    """Prints an answer."""
    if name == "event":
        current = struct.unpack("<f", struct.pack("<I", fields["data_2"]))[0]
        print(f"event {fields['id']}: strike {fields['data_1']}, {current:.1f} kA, frame {fields['data_3']}")
    else:
        print(name, {key: round(value, 3) if isinstance(value, float) else value for key, value in fields.items()})


def take(port, heard):
    """Takes one message of the image generator; prints answers and counts them. Raises `TimeoutError` when it is silent."""
    for name, fields in port.receive():
        if name != "start_of_frame":
            tell(name, fields)
        heard[name] = heard.get(name, 0) + 1


def fly(port, typed, heard):
    """Circles for the time asked; returns how many seconds had their questions."""
    pack, began, asked = port.packer, time.monotonic(), 0
    port.socket.settimeout(0.2 if typed.rate == 0 else 1e-4)
    while (now := time.monotonic() - began) < typed.seconds:
        latitude, longitude, heading = place(now)
        packets = [pack.entity(latitude, longitude, ALTITUDE, heading, 2.0, 20.0)]
        if now >= asked:
            packets.append(pack.hat_hot_request(asked, latitude, longitude, ALTITUDE))
            packets.append(pack.conditions_request(asked & 0xFF, latitude, longitude, 4000.0))
            packets.append(pack.los_segment(asked, (latitude, longitude, ALTITUDE), (latitude, longitude, 12_000.0)))
            packets.append(pack.strike(100 + asked, LATITUDE, LONGITUDE, 5000.0, -30.0 - asked))
            asked += 1
        port.send(*packets)
        until = time.monotonic() + (1.0 / typed.rate if typed.rate else 0.0)
        while True:
            with contextlib.suppress(TimeoutError):
                take(port, heard)
                if typed.rate == 0:
                    break
            if time.monotonic() >= until:
                break
    return asked


def main():
    """Flies, waits for what has not been answered, and tells."""
    typed = options()
    host, _, number = typed.to.rpartition(":")
    port = Port((host, int(number)), ("", typed.port), typed.version, typed.byte_order)
    start(port)
    heard = {}
    asked = fly(port, typed, heard)
    answers = ("hat_hot_extended", "conditions", "line_of_sight")

    def missing():
        return [f"{asked - heard.get(name, 0)} of {asked} {name}" for name in answers if heard.get(name, 0) < asked]

    # The first answers wait until the clouds are made, which takes a busy machine a while.
    port.socket.settimeout(0.2)
    until = time.monotonic() + typed.patience
    while missing() and time.monotonic() < until:
        port.send()
        with contextlib.suppress(TimeoutError):
            take(port, heard)
    print({"sent": port.frame, **heard})
    if missing():
        sys.exit(f"not answered: {', '.join(missing())}")


if __name__ == "__main__":
    main()
