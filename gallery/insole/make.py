#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Makes insole.obj, an outline with a thickness, and pressure.vtu, the pressure under a standing foot on a block of
hexahedra, in metres, like the result of a simulation.

The numbers belong to no person: they are a sum of bell curves under the heel, the ball and the toes.
"""
import math
import struct
import zlib
from pathlib import Path

COLUMNS, ROWS = 12, 28
WIDTH_M, LENGTH_M, HEIGHT_M = 0.108, 0.264, 0.008
# x, y and reach in mm, peak in kPa; y from the heel to the toes, x to the inner side.
BELLS = [(0, 34, 24, 230), (22, 184, 20, 160), (-6, 190, 22, 150), (-28, 172, 18, 110), (20, 234, 12, 130),
         (-6, 240, 14, 50), (-24, 110, 20, 45)]


def pressure_kpa(x, y):
    return sum(peak * math.exp(-((x - u) ** 2 + (y - v) ** 2) / (2 * (reach / 1.5) ** 2)) for u, v, reach, peak in BELLS)


def smoothstep(low, high, x):
    t = min(max((x - low) / (high - low), 0), 1)
    return t * t * (3 - 2 * t)


def lerp(a, b, t):
    return a + t * (b - a)


def write_insole():
    """Writes an outline on both sides of a bent centre line, rounded at both ends; its box is centred at x = y = 0."""
    length, height, steps = 262, 8, 48
    sides = ([], [])
    for i in range(1, steps):
        # Denser towards the ends, where it is round.
        y = length * (0.5 - 0.5 * math.cos(math.pi * i / steps))
        width = lerp(lerp(31, 29, smoothstep(30, 95, y)), lerp(46, 38, smoothstep(185, 228, y)), smoothstep(95, 185, y))
        heel, toes = min(max((30 - y) / 30, 0), 1), min(max((y - 226) / 36, 0), 1)
        width *= math.sqrt(max(1 - heel * heel - toes * toes, 0))
        middle = 6 * smoothstep(150, 250, y) - 3 * smoothstep(60, 150, y)
        for side, sign in zip(sides, (1, -1)):
            side.append((middle + sign * width, y - length / 2))
    ring = [(0, -length / 2)] + sides[0] + [(3, length / 2)] + sides[1][::-1]
    n = len(ring)
    lines = ["# Made by make.py. Units: mm"] + [f"v {x:.3f} {y:.3f} {z}" for z in (0, height) for x, y in ring]
    lines.append("f " + " ".join(str(i) for i in range(n, 0, -1)))
    lines.append("f " + " ".join(str(n + i) for i in range(1, n + 1)))
    lines += [f"f {i + 1} {(i + 1) % n + 1} {n + (i + 1) % n + 1} {n + i + 1}" for i in range(n)]
    Path(__file__).with_name("insole.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_pressure():
    points, pressure = [], []
    for level in range(2):
        for row in range(ROWS + 1):
            for column in range(COLUMNS + 1):
                x, y = (column / COLUMNS - 0.5) * WIDTH_M, row / ROWS * LENGTH_M
                points += [x, y, level * HEIGHT_M]
                pressure.append(pressure_kpa(1000 * x, 1000 * y))
    layer = (COLUMNS + 1) * (ROWS + 1)
    cells = []
    for row in range(ROWS):
        for column in range(COLUMNS):
            a = row * (COLUMNS + 1) + column
            ring = [a, a + 1, a + COLUMNS + 2, a + COLUMNS + 1]
            cells += ring + [layer + i for i in ring]
    count = COLUMNS * ROWS
    data = b""

    def array(name, kind, code, values, components=1):
        nonlocal data
        tag = (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="appended" '
               f'offset="{len(data)}"/>')
        plain = struct.pack(f"<{len(values)}{code}", *values)
        packed = zlib.compress(plain, 9)
        data += struct.pack("<4I", 1, len(plain), 0, len(packed)) + packed
        return tag

    text = (f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
            f'header_type="UInt32" compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>\n'
            f'<Piece NumberOfPoints="{2 * layer}" NumberOfCells="{count}">\n<PointData>\n'
            f'{array("pressure", "Float32", "f", pressure)}\n</PointData>\n<Points>\n'
            f'{array("Points", "Float32", "f", points, 3)}\n</Points>\n<Cells>\n'
            f'{array("connectivity", "Int32", "i", cells)}\n'
            f'{array("offsets", "Int32", "i", [8 * (i + 1) for i in range(count)])}\n'
            f'{array("types", "UInt8", "B", [12] * count)}\n</Cells>\n</Piece>\n</UnstructuredGrid>\n'
            f'<AppendedData encoding="raw">\n_')
    Path(__file__).with_name("pressure.vtu").write_bytes(text.encode() + data + b"\n</AppendedData>\n</VTKFile>\n")


if __name__ == "__main__":
    write_insole()
    write_pressure()
