#!/usr/bin/env bash
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# MaterialX 1.39.5 (PyPI), GLSL: the unit of a picture of lengths, such as heights for a displacement.
#
# Guess: `unit` and `unittype` on the `file` of an <image> convert what is read, as they convert a value: MaterialX' own test suite
# has pictures with them (stdlib/units/image_unit.mtlx), and a number of 1 inch becomes 2.54 in a scene of centimetres.
# Seen: the shader with the unit is the shader without it, letter by letter: heights in inches are read as centimetres. A value
# with the same attributes, in the same shader generation context, is multiplied.
# What helps: a <multiply> behind the picture.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q MaterialX==1.39.5
venv/bin/python - << 'PY'
import sys

import MaterialX as mx
from MaterialX import PyMaterialXGenGlsl as glsl
from MaterialX import PyMaterialXGenShader as gen

INCH = 'unit="inch" unittype="distance"'
library = mx.createDocument()
mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)


def shader(node):
    """The fragment shader of a float as a surface's glow, in a scene of centimetres."""
    document = mx.createDocument()
    mx.readFromXmlString(
        document,
        f'<materialx version="1.39"><nodegraph name="g">{node}<output name="out" type="float" nodename="n"/></nodegraph></materialx>',
    )
    document.setDataLibrary(library)
    valid, why = document.validate()
    assert valid, why
    generator = glsl.GlslShaderGenerator.create()
    units = gen.UnitSystem.create(generator.getTarget())
    units.loadLibrary(library)
    registry = mx.UnitConverterRegistry.create()
    distance = library.getUnitTypeDef("distance")
    registry.addUnitConverter(distance, mx.LinearUnitConverter.create(distance))
    units.setUnitConverterRegistry(registry)
    generator.setUnitSystem(units)
    context = gen.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    context.getOptions().targetDistanceUnit = "centimeter"
    made = generator.generate("s", document.getNodeGraph("g").getOutput("out"), context)
    return made.getSourceCode(gen.PIXEL_STAGE), made.getStage(gen.PIXEL_STAGE).getUniformBlock("PublicUniforms")


def picture(unit):
    return f'<image name="n" type="float"><input name="file" type="filename" value="heights.exr" {unit}/></image>'


def value(unit):
    return f'<constant name="n" type="float"><input name="value" type="float" value="1" {unit}/></constant>'


def numbers(made):
    return [float(p.getValue().getData()) for p in made[1] if p.getValue() and p.getType().getName() == "float"]


plain, inches = shader(picture("")), shader(picture(INCH))
same = plain[0] == inches[0] and numbers(plain) == numbers(inches)
one, converted = shader(value("")), shader(value(INCH))
print("a picture of inches: the shader is", "the same as without the unit" if same else "another one")
print("a value of 1 inch:", numbers(one), "->", numbers(converted), "" if one[0] == converted[0] else "and another shader")
if not same:
    sys.exit("changed: the unit of a picture has an effect")
if one[0] == converted[0] and numbers(one) == numbers(converted):
    sys.exit("changed: the unit of a value has no effect, so that this shows nothing")
PY
