"""The JSBSim flight over CIGI in place of the WebSocket: `jsbsim_host.py --cigi 3.3` or `--cigi 4.0`.

Sends the aircraft 60 times a second (with `--cigi-in-step` once for each Start of Frame of a synchronous server that
makes 60 a second), weather and strikes on the way, and asks for its height above the ground once a
second; checks that answers come back, that heights agree with the model's, and prints what it has counted.
"""

import math
import time

from cigi import Port

TICKS_PER_SECOND, MODEL_STEPS_PER_TICK = 60, 2
# JSBSim's altitude is above mean sea level on its own globe; ours is above the ellipsoid, which is sea level here.
HEIGHT_TOLERANCE_M = 0.01


class Wrong(Exception):
    """The image generator's mistake."""


def scene(pack, coverage):
    """Time, air and clouds."""
    return [
        pack.celestial(6, 21, 2026, 17, 30),
        pack.atmosphere(40_000.0, temperature=18.0),
        pack.weather(1, "cumulus", 1100.0, 1200.0, coverage, wind=8.0, wind_from=250.0),
        pack.weather(2, "cirrus", 9000.0, 600.0, 37.5),
        pack.view(0, offset=(14.0, 0.0, -2.5)),
        pack.view_definition(0, -35.0, 35.0, 21.5, -21.5),
    ]


class Watch:
    """What came back."""

    def __init__(self, port):
        self.port, self.frames, self.echo_delays, self.asked, self.worst_m = port, 0, [], {}, 0.0
        self.counts = {}

    def take(self):
        """Everything that has arrived."""
        self.port.socket.setblocking(False)
        while self.take_one():
            pass

    def take_one(self):
        """One message of the image generator; false when none came in time."""
        try:
            packets = self.port.receive()
        except (BlockingIOError, TimeoutError):
            return False
        self.count(packets)
        return True

    def wait(self, seconds):
        """The next Start of Frame. Raises `Wrong` when the image generator is silent for so long."""
        self.port.socket.settimeout(seconds)
        if not self.take_one():
            raise Wrong(f"no Start of Frame in {seconds} s; {self.summary()}")
        self.take()

    def count(self, packets):
        """What one message says."""
        for name, fields in packets:
            self.counts[name] = self.counts.get(name, 0) + 1
            if name == "start_of_frame":
                self.echo_delays.append(self.port.frame - fields["host_frame"])
            elif name == "hat_hot_extended":
                altitude = self.asked.pop(fields["id"], None)
                if altitude is None or not fields["flags"] & 1:
                    raise Wrong(f"an answer to no question: {fields}")
                # Above the ground, and the ground above sea level.
                self.worst_m = max(self.worst_m, abs(fields["hat"] + fields["hot"] - altitude))

    def summary(self):
        """One line of numbers."""
        delays = sorted(self.echo_delays) or [0]
        return (f"{self.counts}; host messages on the way: median {delays[len(delays) // 2]}, most {delays[-1]}; "
                f"heights within {self.worst_m:.2g} m; {len(self.asked)} questions open")


def until(port, mode, *packets):
    """Asks for a mode until the image generator is in it."""
    port.socket.settimeout(0.1)
    for _ in range(100):
        port.send(*packets, mode=mode)
        try:
            port.receive()
        except TimeoutError:
            continue
        if port.mode == mode:
            return
    raise Wrong(f"the image generator does not go into mode {mode}")


def fly(flight, args):
    """Flies; returns the watch. Raises `Wrong`."""
    host, _, number = args.cigi_to.rpartition(":")
    port = Port((host, int(number)), ("", args.cigi_port), args.cigi, args.cigi_byte_order)
    watch, pack = Watch(port), port.packer
    until(port, 0)
    until(port, 1, *scene(pack, 75.0))
    began = time.monotonic()
    for tick in range(1, int(args.minutes * 60 * TICKS_PER_SECOND) + 1):
        for _ in range(MODEL_STEPS_PER_TICK):
            flight.step()
        state = flight.state()
        if state.time_s > 120.0:
            flight.heading_deg = 240.0
        place = (state.latitude_deg, state.longitude_deg, state.altitude_m)
        packets = [pack.entity(*place, state.yaw_deg % 360.0, state.pitch_deg, state.roll_deg)]
        second, rest = divmod(tick, TICKS_PER_SECOND)
        if rest == 0:
            packets.append(pack.hat_hot_request(second, *place))
            watch.asked[second] = state.altitude_m
            packets.append(pack.conditions_request(second & 0xFF, *place))
        if rest == 0 and second % 60 == 5:
            yaw = math.radians(state.yaw_deg)
            north, east = 6.0 * math.cos(yaw), 6.0 * math.sin(yaw)
            longitude = state.longitude_deg + east / (111.2 * math.cos(math.radians(state.latitude_deg)))
            packets.append(pack.strike(second, state.latitude_deg + north / 111.2, longitude, 1800.0, -35.0))
        if tick == 150 * TICKS_PER_SECOND:
            packets += scene(pack, 95.0)
        port.send(*packets)
        if args.cigi_in_step:
            watch.wait(120.0)
        else:
            watch.take()
            time.sleep(max(0.0, began + tick / TICKS_PER_SECOND - time.monotonic()))
        if rest == 0 and second % 30 == 0:
            print(f"{state.time_s:6.1f} s: {state.altitude_m:6.0f} m, {state.airspeed_kt:3.0f} kt; {watch.summary()}", flush=True)
    # What was asked last has its answer soon; a server in step wants a message for each frame.
    end = time.monotonic() + 30.0
    while watch.asked and time.monotonic() < end:
        port.send()
        watch.wait(30.0)
    if watch.worst_m > HEIGHT_TOLERANCE_M or watch.asked or not watch.counts.get("conditions"):
        raise Wrong(watch.summary())
    return watch
