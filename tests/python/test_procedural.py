# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Functions that make geometry as a print comes near, against the same geometry from arrays."""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

import openfab
from openfab.procedural import ROOT, Bound, Lines, beam, beams, generator, mesh, more, place

WHITE, RED = openfab.Material("white", "#ffffff"), openfab.Material("red", "#ff0000")
BOX = ((-8, -8, -8), (8, 8, 8))

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
PLAIN = """fablet Plain {
    @uniform { Material core, shell; }
    @Volume(@varying { VolumeAttributes attr, @nearest int kind })
    {
        MaterialComposition mc;
        mc.Set(kind == 1 ? core : shell, 1);
        return mc;
    }
}
"""
UNIFORMS = {"core": RED, "shell": WHITE}


def arrays() -> tuple[np.ndarray, ...]:
    """Returns random struts in 32-bit floats."""
    random = np.random.default_rng(4)
    count = 300
    a = random.uniform(-6, 6, (count, 3)).astype(np.float32)
    b = (a + random.uniform(-1.5, 1.5, (count, 3))).astype(np.float32)
    radii = random.uniform(0.05, 0.5, (count, 2)).astype(np.float32)
    heat = random.uniform(0, 1, (count, 2)).astype(np.float32)
    return a, b, radii, heat, random.integers(0, 5, count)


def in_boxes(split: bool) -> openfab.procedural.Generator:
    """Returns a generator of all struts at once, or in eight boxes by their places."""
    a, b, radii, heat, kind = arrays()
    octant = ((a + b > 0) * (1, 2, 4)).sum(axis=1)

    @generator(attributes={"heat": "float", "kind": "int"})
    def made(bound: Bound) -> Iterable[Lines]:
        if split and bound.key == ROOT:
            for i in range(8):
                yield more(i, *BOX)
            return
        these = octant == int(bound.key) if split else np.full(len(a), True)
        yield beams(a[these], b[these], radii[these], heat=heat[these], kind=kind[these])

    return made


def printed(solid: object, fablet: str = SKIN, **options: object) -> np.ndarray:
    world = openfab.World(printer="generic")
    world.add(solid, openfab.Fablet(text=fablet), UNIFORMS)
    return openfab.print_world(world, voxel=0.1, **options).array()  # type: ignore[arg-type]


def of_box(codes: np.ndarray) -> np.ndarray:
    """Returns the array without empty margins."""
    found = np.argwhere(codes)
    low, high = found.min(axis=0), found.max(axis=0) + 1
    return codes[tuple(slice(*ends) for ends in zip(low, high))]


def test_beams_print_as_those_of_arrays() -> None:
    a, b, radii, heat, kind = arrays()
    count = len(a)
    data = openfab.beams(
        np.concatenate([a, b]), np.stack([np.arange(count), np.arange(count) + count], axis=1), radii,
        {"heat": heat.T.ravel(), "kind": kind},
    )
    expected = of_box(printed(data))
    assert (expected == 1).sum() > 1000 and (expected == 2).sum() > 1000
    for split in (False, True):
        np.testing.assert_array_equal(of_box(printed(in_boxes(split).within(BOX))), expected)
    np.testing.assert_array_equal(of_box(printed(in_boxes(True).within(BOX), threads=1)), expected)


def cube(low: np.ndarray, side: float) -> tuple[np.ndarray, np.ndarray]:
    corners = low + side * np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
    faces = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
             [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
    return corners, np.array(faces)


def test_meshes_and_copies_print_as_data() -> None:
    random = np.random.default_rng(8)
    lows = random.uniform(-6, 4, (40, 3))

    @generator(attributes={"kind": "int"})
    def meshes(_: Bound) -> Iterable[Lines]:
        for i, low in enumerate(lows):
            yield mesh(*cube(low, 1.3), kind=i % 2)

    @generator(attributes={"kind": "int"}, places=["brick"])
    def copies(_: Bound) -> Iterable[Lines]:
        for i, low in enumerate(lows):
            yield place("brick", low + (0.65, 0.65, 0), ((0, 1, 0), (0, 0, 1), (1, 0, 0)) if i == 7 else None, scale=1.3, kind=i % 2)

    lows[7] = (-7.92, -7.92, 6.53)  # turned about its foot it is elsewhere
    z, y, x = np.indices((160, 160, 160)) * 0.1 - 7.95
    inside = np.zeros(z.shape, bool)
    for i, low in enumerate(lows):
        if i != 7:
            here = np.logical_and.reduce([(p > at) & (p < at + 1.3) for p, at in zip((x, y, z), low)])
            inside |= here
    made = printed(meshes.within(BOX), PLAIN)
    seventh = np.logical_and.reduce([(p > at) & (p < at + 1.3) for p, at in zip((x, y, z), lows[7])])
    np.testing.assert_array_equal(made != 0, inside | seventh)
    world = openfab.World(printer="generic")
    plain = openfab.Fablet(text=PLAIN)
    world.add(openfab.box(1, 1, 1), plain, UNIFORMS, name="brick", place=False)
    world.add(copies.within(BOX), plain, UNIFORMS)
    copied = openfab.print_world(world, voxel=0.1).array()
    turned = (np.abs(x - (-7.27 + 0.65)) < 0.65) & (np.abs(y + 7.27) < 0.65) & (np.abs(z - 6.53) < 0.65)
    np.testing.assert_array_equal(copied != 0, inside | turned)
    apart = [i for i, low in enumerate(lows) if all(np.abs(low - other).max() > 1.3 for j, other in enumerate(lows) if j != i)]
    assert len(apart) > 5
    for i in apart:
        at = np.floor((lows[i] + 0.65 + 8) / 0.1).astype(int)
        assert made[at[2], at[1], at[0]] == (1 if i % 2 == 1 else 2) or i == 7


def test_a_file_is_a_program(tmp_path: Path) -> None:
    (tmp_path / "made.py").write_text(
        "from openfab.procedural import beam, generator\n"
        "print('this is no answer')\n"
        "@generator(attributes={'kind': 'int'})\n"
        "def made(bound):\n"
        "    print('nor this')\n"
        "    yield beam((0, 0, 0), (0, 0, 5), (1, 0.5), kind=1)\n"
        "if __name__ == '__main__':\n"
        "    made.serve()\n".replace("print('this is no answer')\n", "")
    )
    (tmp_path / "plain.fl").write_text(PLAIN)
    (tmp_path / "w.fab.json").write_text(json.dumps({
        "openfab": 1, "printer": "generic",
        "fablets": {"plain": {"source": "plain.fl", "fablet": "Plain"}},
        "materials": {"white": {"key": "#ffffff"}, "red": {"key": "#ff0000"}},
        "meshes": {"made": {"program": [sys.executable, "made.py"], "box_mm": BOX, "attributes": {"kind": "int"}}},
        "objects": {"a": {"mesh": "made", "fablet": "plain", "uniforms": {"core": "red", "shell": "white"}}},
        "build": [{"object": "a"}],
    }))
    with pytest.raises(openfab.InputError, match="`allow_programs`"):
        openfab.print_world(openfab.load(tmp_path / "w.fab.json"), voxel=0.2).array()
    codes = openfab.print_world(openfab.load(tmp_path / "w.fab.json", allow_programs=True), voxel=0.2).array()
    # A cone of 1 to 0.5 mm over 5 mm, with balls.
    assert (codes != 0).sum() * 0.008 == pytest.approx(np.pi * (5 * 1.75 / 3 + 2 / 3 * (1 + 0.125)), rel=0.05)


def test_the_same_function_prints_twice_and_in_threads() -> None:
    solid = in_boxes(True).within(BOX)
    world = openfab.World(printer="generic")
    world.add(solid, openfab.Fablet(text=SKIN), UNIFORMS)
    first, second = openfab.print_world(world, voxel=0.2), openfab.print_world(world, voxel=0.2)
    np.testing.assert_array_equal(first.array(), second.array())


@pytest.mark.parametrize(
    ("yields", "says"),
    [
        (lambda bound: [1], "yields 1"),
        (lambda bound: 1 / 0, "ZeroDivisionError"),
        (lambda bound: [beam((0, 0, 0), (0, 0, 9), 1, kind=1)], "outside"),
        (lambda bound: [beam((0, 0, 0), (0, 0, 1), 1)], "without `kind`"),
        (lambda bound: [beam((0, 0, 0), (0, 0, 1), 1, kind=1, age=2)], "`age`"),
        (lambda bound: [place("leaf", (0, 0, 0), kind=1)], "places"),
        (lambda bound: [more("again", *BOX)], "1000 levels"),
        (lambda bound: [mesh(*cube(np.zeros(3), 1), kind=0.5)], "kind"),
    ],
)
def test_errors_say_what_is_wrong(yields: object, says: str) -> None:
    made = generator(attributes={"kind": "int"})(yields)  # type: ignore[arg-type]
    with pytest.raises(openfab.InputError, match=says):
        printed(made.within(BOX), PLAIN)


def test_arguments_are_checked() -> None:
    with pytest.raises(openfab.InputError, match="no word"):
        more("a b", (0, 0, 0), (1, 1, 1))
    with pytest.raises(openfab.InputError, match="shape"):
        beams(np.zeros((3, 3)), np.zeros((2, 3)), 1)
    with pytest.raises(openfab.InputError, match="one of"):
        generator(attributes={"a": "double"})
        generator(attributes={"a": "double"})(lambda bound: [])
    with pytest.raises(openfab.InputError, match="within"):
        openfab.World().add(generator(lambda bound: []), openfab.Fablet(text=PLAIN))
    with pytest.raises(openfab.InputError, match="lower corner"):
        generator(lambda bound: []).within(((0, 0, 0), (1, 0, 1)))


def test_answers_are_lines() -> None:
    @generator(attributes={"age": "float", "tint": "float3", "kind": "int"}, places=["leaf"])
    def made(bound: Bound) -> Iterable[Lines]:
        assert bound == Bound("root", (0, 0, 0), (1, 2, 3.5))
        yield beam((0, 0, 0), (0, 0, 1), 1, age=(0.5, 1), tint=(1, 2, 3), kind=7)
        yield place("leaf", (1, 2, 3), age=0.25, tint=(1, 0, 0), kind=-1)
        yield more("more", (0, 0, 0), (1, 1, 1))

    answers = io.StringIO()
    made.serve(io.StringIO("grow root 0 0 0 1 2 3.5\n"), answers)
    assert answers.getvalue().splitlines() == [
        "beam 0 0 0 0 0 1 1 1 0.5 1 2 3 1 1 2 3 7",
        "place leaf 1 2 3 1 0 0 0 1 0 0 0 1 0.25 1 0 0 -1",
        "more more 0 0 0 1 1 1",
        "done",
    ]
