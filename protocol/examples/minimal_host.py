#!/usr/bin/env python3
"""The least that a host must do: connect, say where the ownship is, and save the first picture of it."""

import json

from frames import unpack
from websockets.sync.client import connect

MESSAGES = [
    {"type": "hello", "protocol": "stormdeck.v1", "role": "host"},
    {"type": "scenario", "action": "pause"},
    {"type": "ownship", "latitude_deg": 46.2, "longitude_deg": 6.1, "altitude_m": 900.0, "yaw_deg": 90.0,
     "pitch_deg": 5.0, "roll_deg": 0.0, "host_frame": 1},
    {"type": "subscribe", "view": "main", "format": "png"},
]

with connect("ws://127.0.0.1:8765/ws", max_size=None) as server:
    for seq, message in enumerate(MESSAGES):
        server.send(json.dumps({**message, "seq": seq}))
    for answer in server:
        if isinstance(answer, str):
            print(answer)
        elif (frame := unpack(answer)).host_frame == 1:
            open("picture.png", "wb").write(frame.picture)
            break
