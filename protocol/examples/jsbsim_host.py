#!/usr/bin/env python3
"""A simulator host in Python: flies JSBSim's Boeing 737 from the runway through the cloud deck of a running server.

Sends the ownship 60 times per simulated second, a deck that changes on the way and some strikes; checks every answer;
saves every n-th picture; prints frames a second and the delay from an ownship message to the frame that shows it. Ends
with 1 when something was wrong.
"""

import argparse
import pathlib
import sys
import time

import cigi_flight
from flight import Flight
from link import Link, Wrong

MODEL_STEPS_PER_TICK = 2
TICKS_PER_SECOND = 60
VIEW = "pilot"


def options():
    """What was typed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", default="ws://127.0.0.1:8765/ws", help="address of the server")
    parser.add_argument("--token", help="access token, where the server wants one")
    parser.add_argument("--minutes", type=float, default=6.0, help="simulated minutes from the start of the take-off run")
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds per second, up to 8")
    parser.add_argument("--lockstep", action="store_true", help="wait for the picture of each step instead of for the clock")
    parser.add_argument("--step-rate", type=float, default=10.0, help="pictures per simulated second in lockstep")
    parser.add_argument("--size", default="640x360", help="size of the picture")
    parser.add_argument("--format", choices=["jpeg", "png"], default="jpeg")
    parser.add_argument("--every", type=int, default=100, help="saves every n-th picture; 0 saves none")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("flight"), help="folder for the pictures")
    parser.add_argument("--cigi", choices=["3.3", "4.0"], help="speaks CIGI of this version in place of the WebSocket")
    parser.add_argument("--cigi-to", default="127.0.0.1:8004", help="where the server listens for CIGI")
    parser.add_argument("--cigi-port", type=int, default=8005, help="UDP port to listen on, and to send from")
    parser.add_argument("--cigi-byte-order", choices=["little", "big"], default="little", help="of what is sent")
    parser.add_argument("--cigi-in-step", action="store_true", help="one message for each frame of a synchronous server")
    return parser.parse_args()


def ahead(state, kilometres, right_kilometres=0.0):
    """The place so far ahead of the aircraft and so far to its right, on a locally flat Earth."""
    import math

    yaw = math.radians(state.yaw_deg)
    north = kilometres * math.cos(yaw) - right_kilometres * math.sin(yaw)
    east = kilometres * math.sin(yaw) + right_kilometres * math.cos(yaw)
    latitude_deg = state.latitude_deg + north / 111.2
    return {
        "latitude_deg": latitude_deg,
        "longitude_deg": state.longitude_deg + east / (111.2 * math.cos(math.radians(latitude_deg))),
    }


def deck(coverage_eighths, density, transition_s):
    """A deck of cumulus below a veil of cirrus."""
    cumulus = {
        "cloud_type": "cumulus",
        "base_m": 1100.0,
        "thickness_m": 1200.0,
        "coverage_eighths": coverage_eighths,
        "density": density,
        "wind_speed_mps": 8.0,
        "wind_from_deg": 250.0,
    }
    cirrus = {"cloud_type": "cirrus", "base_m": 9000.0, "thickness_m": 600.0, "coverage_eighths": 3}
    return {"type": "weather", "layers": [cumulus, cirrus], "visibility_m": 40000.0, "transition_s": transition_s}


def strike(state, seed):
    """A flash in the clouds ahead."""
    return {"type": "strike", "flash_type": "intra_cloud", "seed": seed, **ahead(state, 6.0, -2.0)}


# What happens on the way: simulated second, and the message.
EVENTS = [
    (60.0, lambda state: strike(state, 1)),
    (125.0, lambda state: strike(state, 2)),
    (150.0, lambda state: deck(7.5, 1.5, transition_s=30.0)),
    (185.0, lambda state: strike(state, 3)),
    (240.0, lambda state: deck(4, 1.0, transition_s=60.0)),
    (290.0, lambda state: strike(state, 4)),
]


def ownship(state, host_frame, speed):
    """The ownship message. Sped up, the aircraft covers more ground in a second of the server's clock."""
    return {
        "type": "ownship",
        "latitude_deg": state.latitude_deg,
        "longitude_deg": state.longitude_deg,
        "altitude_m": state.altitude_m,
        "yaw_deg": state.yaw_deg,
        "pitch_deg": state.pitch_deg,
        "roll_deg": state.roll_deg,
        "velocity_ned_mps": [speed * v for v in state.velocity_ned_mps],
        "host_frame": host_frame,
    }


def prepare(link, args):
    """Sets the scene before the flight."""
    width, height = (int(n) for n in args.size.split("x"))
    # The server may be playing a scenario with an ownship of its own: an empty one takes its place.
    empty = {"type": "scenario", "protocol": "stormdeck.v1", "name": "flight", "description": "", "duration_s": 86400.0, "entries": []}
    link.ask({"type": "scenario", "action": "load", "document": empty})
    link.ask({"type": "time", "utc": "2026-06-21T17:30:00Z", "rate": 1.0})
    # An earlier host may have left the server in lockstep; only `play` ends that.
    link.ask({"type": "scenario", "action": "pause" if args.lockstep else "play"})
    # The eye is in the cockpit, above and before the centre of mass.
    link.ask(
        {"type": "view", "action": "create", "name": VIEW, "size_px": [width, height], "field_of_view_deg": 70.0,
         "offset_m": [14.0, 0.0, -2.5]}
    )
    link.ask(deck(6, 1.0, transition_s=0.0))
    link.ask({"type": "subscribe", "view": VIEW, "format": args.format, "max_rate_hz": 60.0})


def fly(link, args):
    """The flight: returns where it ended."""
    flight = Flight()
    # The brakes are released when the first picture is there: it waits for tables that are built once.
    # Numbers of this run's own: what the server drew for an earlier host does not look like ours.
    first_host_frame = int(time.time() * 1000) & 0x3FFFFFFF
    link.tell(ownship(flight.state(), first_host_frame, 0.0))
    link.wait_for_frame(first_host_frame)
    began = time.monotonic()
    simulation_began_s = link.simulation_time_s()
    events = list(EVENTS)
    ticks = int(args.minutes * 60 * TICKS_PER_SECOND)
    ticks_per_step = max(1, round(TICKS_PER_SECOND / args.step_rate))
    for tick in range(1, ticks + 1):
        for _ in range(MODEL_STEPS_PER_TICK):
            flight.step()
        state = flight.state()
        if state.time_s > 120.0:
            flight.heading_deg = 240.0
        while events and state.time_s >= events[0][0]:
            link.tell(events.pop(0)[1](state))
        if args.lockstep:
            if tick % ticks_per_step == 0:
                link.tell(ownship(state, first_host_frame + tick, 1.0))
                link.ask({"type": "step", "to_s": simulation_began_s + tick / TICKS_PER_SECOND})
        else:
            link.tell(ownship(state, first_host_frame + tick, args.speed))
            link.wait_until(began + tick / TICKS_PER_SECOND / args.speed)
        if tick % (30 * TICKS_PER_SECOND) == 0:
            print(f"{state.time_s:6.1f} s: {state.altitude_m:6.0f} m, {state.airspeed_kt:3.0f} kt; {link.summary()}", flush=True)
    return flight.state()


def main():
    """Connects, flies, reports."""
    args = options()
    if args.cigi:
        try:
            print(cigi_flight.fly(Flight(), args).summary())
        except cigi_flight.Wrong as wrong:
            sys.exit(f"wrong: {wrong}")
        return
    try:
        with Link(args.to, args.token, args.out if args.every else None, args.every) as link:
            print(f"connected: {link.welcome['server']}, drawn by {link.welcome['executor']}", flush=True)
            prepare(link, args)
            end = fly(link, args)
            link.finish()
            print(f"flown: {end.time_s:.0f} s of simulation, now at {end.altitude_m:.0f} m")
            print(link.summary())
    except Wrong as wrong:
        sys.exit(f"wrong: {wrong}")
    except (OSError, TimeoutError) as error:
        sys.exit(f"the connection failed: {error}")


if __name__ == "__main__":
    main()
