#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints with the installed package on a system without compiler and build: print_wheel.py parts | postcard WORLD HASH.

`parts` prints a ball, whose kernels are compiled here, and one that reads an array, and expects a plain message for a picture
with alpha while OpenImageIO is not installed; `postcard` expects the recorded hash of the postcard.
"""
import shutil
import sys

import numpy

import openfab
from openfab import mechanics

def ball(uniform, depth):
    """Prints a ball of 6 mm with a core below `depth`, an expression of `uniform`."""
    source = f"""fablet Ball {{
        @uniform {{ Material core, shell; {uniform[0]} tone; }}
        @Volume(@varying {{ VolumeAttributes attr }})
        {{
            MaterialComposition mc;
            mc.Set(-distance(attr.voxelCenter) > {depth} ? core : shell, 1);
            return mc;
        }}
    }}"""
    world = openfab.World(printer="generic", title="ball")
    world.add(
        openfab.sphere(6),
        openfab.Fablet(text=source),
        {"core": openfab.Material("white", "#ffffff"), "shell": openfab.Material("black", "#000000"), "tone": uniform[1]},
        name="ball",
    )
    return openfab.print_world(world, voxel=0.25).array()


def parts():
    codes = ball(("float", 1.0), "tone")
    volumes = sorted((codes == code).sum() * 0.25**3 for code in (1, 2))
    core, whole = (4 / 3 * numpy.pi * radius**3 for radius in (2, 3))
    assert numpy.allclose(volumes, [core, whole - core], rtol=0.05), volumes
    # An array is converted in this process, unless it has alpha.
    picture = numpy.full((4, 4, 4), 255, numpy.uint8)
    looked_up = ball(("ImageTexture2D", picture[..., :3]), "tone.Sample1(float2(0.5, 0.5), 0)")
    assert (looked_up == codes).all()
    try:
        ball(("ImageTexture2D", picture), "tone.Sample1(float2(0.5, 0.5), 0)")
    except openfab.Error as error:
        assert "OpenImageIO" in str(error), error
        print("print_wheel: without OpenImageIO a picture is refused:", error)
    else:
        raise SystemExit("print_wheel: a picture was read without OpenImageIO")
    # The wheel does not carry the program of mechanics, and says what does.
    try:
        mechanics.part("part.fab.json")
    except openfab.Error as error:
        assert ".deb" in str(error), error
        print("print_wheel: without the program mechanics are refused:", error)
    else:
        raise SystemExit("print_wheel: mechanics without its program")


def postcard(world, expected):
    print_ = openfab.print_world(openfab.load(world), printer="generic", voxel=0.5)
    print_.array()
    found = print_.statistics["hash"]
    assert found == expected, f"the postcard's hash is {found}, not {expected}"
    print(f"print_wheel: {openfab.__file__} prints the postcard with the hash {found}")


assert not any(map(shutil.which, ("cc", "c++", "gcc", "g++", "clang"))), "there is a compiler here"
if sys.argv[1] == "parts":
    parts()
else:
    postcard(*sys.argv[2:])
