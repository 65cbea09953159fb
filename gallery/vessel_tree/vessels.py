#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Grows the vessels of vessels.txt: a tree in which each vessel forks into two, by Murray's law, inside a block."""

import math
import random

HALF = (17.0, 11.0, 13.0)  # of the room that it may fill, mm; z from 1
random.seed(8)
nodes: list[tuple[float, float, float, float, float]] = []  # x, y, z, radius, depth
struts: list[tuple[int, int]] = []


def inside(p: list[float]) -> bool:
    return abs(p[0]) < HALF[0] and abs(p[1]) < HALF[1] and 1 < p[2] < 1 + 2 * HALF[2]


def turned(d: list[float], angle: float, around: float) -> list[float]:
    """Returns a direction at an angle to another one, turned around it."""
    side = [0.0, 0.0, 1.0] if abs(d[2]) < 0.9 else [1.0, 0.0, 0.0]
    u = [d[1] * side[2] - d[2] * side[1], d[2] * side[0] - d[0] * side[2], d[0] * side[1] - d[1] * side[0]]
    n = math.sqrt(sum(x * x for x in u))
    u = [x / n for x in u]
    v = [d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0]]
    c, s = math.cos(angle), math.sin(angle)
    return [c * a + s * (math.cos(around) * b + math.sin(around) * e) for a, b, e in zip(d, u, v)]


def grow(at: int, d: list[float], radius: float, around: float) -> None:
    """Grows a vessel from a node: some struts that wander, then a fork."""
    x, y, z, _, depth = nodes[at]
    p = [x, y, z]
    for _ in range(4):
        d = turned(d, random.uniform(0, 0.22), random.uniform(0, 2 * math.pi))
        q = [a + 1.25 * radius**0.55 * b for a, b in zip(p, d)]
        for _ in range(40):  # near a wall it looks for a way back
            if inside(q):
                break
            d = turned(d, 0.6, random.uniform(0, 2 * math.pi))
            q = [a + 1.25 * radius**0.55 * b for a, b in zip(p, d)]
        else:
            return
        nodes.append((*q, radius, depth + 1))
        struts.append((at, len(nodes) - 1))
        p, at, depth = q, len(nodes) - 1, depth + 1
    if radius < 0.22:
        return
    share = random.uniform(0.4, 0.6)  # of the flow; radii go by its cube root
    for part, sign in ((share, 0.0), (1 - share, math.pi)):
        grow(at, turned(d, 0.35 + 0.5 * (1 - part), around + sign), radius * part ** (1 / 3), around + 1.9)


nodes.append((0.0, 0.0, 0.0, 1.5, 0.0))
grow(0, [0.0, 0.0, 1.0], 1.5, 0.4)
deepest = max(node[4] for node in nodes)
print("# Made by vessels.py.\nattribute depth float")
for x, y, z, r, depth in nodes:
    print(f"node {x:.3f} {y:.3f} {z:.3f} {r:.3f} {depth / deepest:.3f}")
for a, b in struts:
    print("strut", a, b)
