"""A flight without a pilot: JSBSim's Boeing 737 takes off from a runway, climbs through the clouds and levels off.

The flight-dynamics model is JSBSim's; the autopilot, four loops of a line or two each, is ours. Run this file alone to
fly without a server: it prints one line every ten seconds of flight.
"""

import math
from dataclasses import dataclass

import jsbsim

METRES_PER_FOOT = 0.3048
# San Francisco, runway 28R: its threshold and true heading. The ground of the picture is the ellipsoid, so height 0.
RUNWAY_LATITUDE_DEG, RUNWAY_LONGITUDE_DEG, RUNWAY_HEADING_DEG = 37.6115, -122.3570, 298.0
ROTATE_KT, CLIMB_KT = 150.0, 250.0


@dataclass
class State:
    """Where the aircraft is, in the units of the protocol."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    yaw_deg: float
    pitch_deg: float
    roll_deg: float
    velocity_ned_mps: list
    airspeed_kt: float
    airborne: bool


def clamp(value, low, high):
    """`value`, no less than `low` and no more than `high`."""
    return max(low, min(high, value))


class Flight:
    """The aircraft with its autopilot; `step` advances by one step of the model (1/120 s)."""

    def __init__(self, cruise_altitude_m=5000.0):
        self.cruise_altitude_m = cruise_altitude_m
        self.model = jsbsim.FGFDMExec(None)
        self.model.set_debug_level(0)
        self.model.load_model("737")
        self.model.set_dt(1.0 / 120.0)
        start = {
            "ic/lat-geod-deg": RUNWAY_LATITUDE_DEG,
            "ic/long-gc-deg": RUNWAY_LONGITUDE_DEG,
            "ic/psi-true-deg": RUNWAY_HEADING_DEG,
            "ic/terrain-elevation-ft": 0.0,
            "ic/h-agl-ft": 8.0,
        }
        for name, value in start.items():
            self.model[name] = value
        self.model["propulsion/set-running"] = -1
        if not self.model.run_ic():
            raise RuntimeError("JSBSim could not set the starting state")
        self.model["fcs/flap-cmd-norm"] = 0.4
        self.model["gear/gear-cmd-norm"] = 1.0
        self.elevator_trim = 0.0
        self.airborne = False
        self.heading_deg = RUNWAY_HEADING_DEG

    def step(self):
        """One step of autopilot and model."""
        self._autopilot()
        if not self.model.run():
            raise RuntimeError("JSBSim stopped")

    def state(self):
        """The state now."""
        m = self.model
        return State(
            time_s=m["simulation/sim-time-sec"],
            latitude_deg=m["position/lat-geod-deg"],
            longitude_deg=m["position/long-gc-deg"],
            altitude_m=m["position/geod-alt-ft"] * METRES_PER_FOOT,
            yaw_deg=math.degrees(m["attitude/psi-rad"]),
            pitch_deg=math.degrees(m["attitude/theta-rad"]),
            roll_deg=math.degrees(m["attitude/phi-rad"]),
            velocity_ned_mps=[m[f"velocities/v-{axis}-fps"] * METRES_PER_FOOT for axis in ("north", "east", "down")],
            airspeed_kt=m["velocities/vc-kts"],
            airborne=self.airborne,
        )

    def _autopilot(self):
        m, dt = self.model, self.model.get_delta_t()
        height_m = m["position/h-agl-ft"] * METRES_PER_FOOT
        airspeed_kt = m["velocities/vc-kts"]
        self.airborne = self.airborne or height_m > 10.0
        to_cruise_m = self.cruise_altitude_m - m["position/geod-alt-ft"] * METRES_PER_FOOT

        # Power: full for take-off, less for the climb, and at the cruise altitude whatever holds the speed.
        if to_cruise_m > 300.0:
            throttle = 1.0 if height_m < 300.0 else 0.8
        else:
            throttle = clamp(0.6 + 0.02 * (CLIMB_KT - airspeed_kt), 0.1, 1.0)
        for engine in (0, 1):
            m[f"fcs/throttle-cmd-norm[{engine}]"] = throttle

        if height_m > 30.0:
            m["gear/gear-cmd-norm"] = 0.0
        if height_m > 300.0:
            m["fcs/flap-cmd-norm"] = 0.0

        # Pitch: none before rotation; in the climb a little more when fast, less when slow; in cruise by height.
        if airspeed_kt < ROTATE_KT and not self.airborne:
            pitch_deg = 0.0
        else:
            pitch_deg = clamp(10.0 + 0.15 * (airspeed_kt - CLIMB_KT), 6.0, 15.0)
            sink_mps = m["velocities/v-down-fps"] * METRES_PER_FOOT
            pitch_deg = min(pitch_deg, clamp(3.0 + 0.02 * to_cruise_m + 0.3 * sink_mps, -4.0, 15.0))
        error = pitch_deg - math.degrees(m["attitude/theta-rad"])
        if self.airborne:
            self.elevator_trim = clamp(self.elevator_trim + 0.01 * error * dt, -0.5, 0.5)
        rate_deg = math.degrees(m["velocities/q-rad_sec"])
        # A negative elevator command raises the nose.
        gain = 0.05 if self.airborne else 0.12
        m["fcs/elevator-cmd-norm"] = clamp(-(gain * error + self.elevator_trim - 0.03 * rate_deg), -1.0, 1.0)

        # Heading: by the nose wheel and rudder on the ground, by bank in the air; wings are levelled near the heading.
        off_deg = (self.heading_deg - math.degrees(m["attitude/psi-rad"]) + 180.0) % 360.0 - 180.0
        if self.airborne:
            bank_deg = clamp(1.2 * off_deg, -25.0, 25.0)
            m["fcs/rudder-cmd-norm"] = 0.0
        else:
            bank_deg = 0.0
            m["fcs/steer-cmd-norm"] = clamp(0.05 * off_deg, -1.0, 1.0)
            m["fcs/rudder-cmd-norm"] = clamp(-0.05 * off_deg, -1.0, 1.0)
        roll_error = bank_deg - math.degrees(m["attitude/phi-rad"])
        m["fcs/aileron-cmd-norm"] = clamp(0.02 * roll_error - 0.02 * math.degrees(m["velocities/p-rad_sec"]), -1.0, 1.0)


def main():
    """Flies for ten minutes and prints where the aircraft is."""
    flight = Flight()
    next_s = 0.0
    while flight.state().time_s < 600.0:
        flight.step()
        s = flight.state()
        if s.time_s >= next_s:
            next_s += 10.0
            if 120.0 < s.time_s:
                flight.heading_deg = 240.0
            print(
                f"{s.time_s:6.1f} s  {s.altitude_m:7.1f} m  {s.airspeed_kt:5.1f} kt  pitch {s.pitch_deg:5.1f}"
                f"  roll {s.roll_deg:5.1f}  heading {s.yaw_deg:5.1f}  {'air' if s.airborne else 'ground'}"
            )


if __name__ == "__main__":
    main()
