# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Beams from arrays, against a comparison with all of them in numpy."""

from __future__ import annotations

import numpy as np
import pytest

import openfab

WHITE, RED = openfab.Material("white", "#ffffff"), openfab.Material("red", "#ff0000")

SKIN = """fablet Skin {
    @uniform { float depth = 0.3; Material core, shell; }
    @Volume(@varying { VolumeAttributes attr, @nearest float heat, @nearest int kind })
    {
        MaterialComposition mc;
        mc.Set(heat > 0.5 && kind != 3 && distance(attr.voxelCenter) < -depth ? core : shell, 1);
        return mc;
    }
}
"""


def distances(points: np.ndarray, a: np.ndarray, b: np.ndarray, ra: np.ndarray, rb: np.ndarray) -> tuple[np.ndarray, ...]:
    """Signed distances to round cones and the places on their axes, in doubles; [point][cone]."""
    along = b - a
    length = np.linalg.norm(along, axis=1)
    ball = length <= np.abs(ra - rb)
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = np.where(length[:, None] > 0, along / length[:, None], 0)
        slope = np.where(ball, 0, (ra - rb) / length)
    tilt = slope / np.sqrt(1 - slope**2)
    d = points[:, None] - a
    y = np.einsum("pcx,cx->pc", d, unit)
    x = np.linalg.norm(d - y[..., None] * unit, axis=2)
    s = np.clip(y - x * tilt, 0, length)
    s = np.where(ball, np.where(ra >= rb, 0, length), s)
    radius = ra + (rb - ra) * np.divide(s, length, out=np.zeros_like(s), where=length > 0)
    return np.hypot(x, y - s) - radius, np.divide(s, length, out=np.zeros_like(s), where=length > 0)


def test_voxels_are_those_of_all_beams_compared() -> None:
    random = np.random.default_rng(4)
    count = 400
    a = random.uniform(-6, 6, (count, 3))
    nodes = np.concatenate([a, a + random.uniform(-2, 2, (count, 3))])
    struts = np.stack([np.arange(count), np.arange(count) + count], axis=1)
    radii = random.uniform(0.05, 0.6, 2 * count)
    heat = random.uniform(0, 1, 2 * count).astype(np.float32)
    kind = random.integers(0, 5, count)
    lattice = openfab.beams(nodes, struts, radii, {"heat": heat, "kind": kind})
    world = openfab.World(printer="generic")
    world.add(lattice, openfab.Fablet(text=SKIN), {"core": RED, "shell": WHITE})
    printed = openfab.print_world(world, voxel=0.2)
    codes = printed.array()
    lowest = (nodes - radii[:, None]).min(axis=0)
    np.testing.assert_allclose(printed.info.origin_mm, np.floor(lowest / 0.2) * 0.2)
    z, y, x = (axis.ravel() for axis in np.indices(codes.shape))
    points = np.array(printed.info.origin_mm) + (np.stack([x, y, z], axis=1) + 0.5) * 0.2
    flat = codes.ravel()
    checked = wrong = 0
    for part in np.array_split(np.arange(len(points)), len(points) // 4000):
        d, t = distances(points[part], nodes[:count], nodes[count:], radii[:count], radii[count:])
        nearest = d.argmin(axis=1)
        least = d[np.arange(len(part)), nearest]
        at = t[np.arange(len(part)), nearest]
        value = heat[:count][nearest] * (1 - at) + heat[count:][nearest] * at
        core = (value > 0.5) & (kind[nearest] != 3) & (least < -0.3)
        want = np.where(least >= 0, 0, np.where(core, 1, 2))
        second = np.partition(d, 1, axis=1)[:, 1]
        # Floats may decide otherwise where a number is all but equal to a limit.
        sure = (np.abs(least) > 1e-5) & (np.abs(least + 0.3) > 1e-5) & (np.abs(value - 0.5) > 1e-4) & (second - least > 1e-5)
        names = np.array([0, *(1 if m.name == "red" else 2 for m in printed.info.materials)])
        wrong += int((names[flat[part]] != want)[sure].sum())
        checked += int(sure.sum())
    assert wrong == 0
    assert checked > 0.99 * len(points) and (flat == 1).sum() > 100 and (flat == 2).sum() > 1000


def test_beams_say_what_is_wrong() -> None:
    nodes, struts = [[0, 0, 0], [5, 0, 0]], [[0, 1]]
    for arguments, words in (
        ((nodes, [[0, 2]], 1), "strut 0 has the node 2; there are 2"),
        ((nodes, [[0, 1, 1]], 1), "`struts` has the shape"),
        ((nodes, [], 1), "shape"),
        ((nodes, struts, [1, 1, 1]), "`radii` has the shape (3,)"),
        ((nodes, struts, -1), "a radius is -1"),
        ((nodes, struts, 0), "has the radius 0 at both ends"),
        ((nodes, struts, 1, {"heat": [1.0]}), "attribute `heat` has the shape (1,)"),
        ((nodes, struts, 1, {"kind": [1, 2]}), "of integers, which are of struts"),
        ((nodes, struts, 1, {"radii": [1.0, 2.0]}), "is taken"),
    ):
        with pytest.raises(openfab.InputError, match=words.replace("(", r"\(").replace(")", r"\)")):
            openfab.beams(*arguments)


def test_an_attribute_may_have_any_name_of_a_fablet() -> None:
    lattice = openfab.beams([[0, 0, 0], [5, 0, 0]], [[0, 1], [0, 0]], 1, {"file": [0.0, 1.0], "heat": [0.0, 1.0], "kind": [1, 2]})
    world = openfab.World(printer="generic")
    world.add(lattice, openfab.Fablet(text=SKIN), {"core": RED, "shell": WHITE})
    assert openfab.print_world(world, voxel=0.5).array().any()
