# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""MaterialX looks against MaterialX's own shaders: each graph is imported, and compiled code prints its values. The expected
values at the same points come from MaterialX's GLSL for the same graph, compiled as C++."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

mx = pytest.importorskip("MaterialX")
from MaterialX import PyMaterialXGenGlsl as glsl  # noqa: E402
from MaterialX import PyMaterialXGenShader as gen  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = pathlib.Path(os.environ.get("OPENFAB_TOOL", ROOT / "build" / "release" / "bin" / "openfab"))
sys.path.insert(0, str(ROOT / "python" / "openfab"))
import materialx as looks  # noqa: E402

# Sines, powers and logarithms of a library differ in the last bits, and noise of what differs more.
MOST = 2e-5


def port(name, kind, value=None, node=None):
    held = f'nodename="{node}"' if node else f'value="{value}"'
    return f'<input name="{name}" type="{kind}" {held}/>'


P = port("position", "vector3", node="pos")


def gray(kind, name="x"):
    """Adds a node that makes a colour from the value of `x`."""
    if kind == "float":
        return f'<combine3 name="last" type="color3">{port("in1", "float", node=name)}{port("in2", "float", node=name)}{port("in3", "float", node=name)}</combine3>'
    return f'<convert name="last" type="color3">{port("in", kind, node=name)}</convert>'


def node(category, kind, *ports, name="x"):
    return f'<{category} name="{name}" type="{kind}">{"".join(ports)}</{category}>'


F = node("noise3d", "float", port("amplitude", "float", 1), P, name="f")
V = node("noise3d", "vector3", port("amplitude", "vector3", "1, 1, 1"), P, name="v")
C = node("noise3d", "color3", port("amplitude", "vector3", "0.5, 0.5, 0.5"), port("pivot", "float", 0.5), P, name="c")
XY = '<separate3 name="s" type="multioutput">' + port("in", "vector3", node="pos") + '</separate3><combine2 name="uv" type="vector2"><input name="in1" type="float" nodename="s" output="outx"/><input name="in2" type="float" nodename="s" output="outy"/></combine2>'
UV = port("texcoord", "vector2", node="uv")


def unary(category):
    return F + node(category, "float", port("in", "float", node="f")) + gray("float")


def binary(category, second=0.37):
    return F + node(category, "float", port("in1", "float", node="f"), port("in2", "float", second)) + gray("float")


def mixed(category):
    return F + C + node(category, "color3", port("fg", "color3", node="c"), port("bg", "color3", "0.2, 0.5, 0.7"), port("mix", "float", node="f")).replace('name="x"', 'name="last"')


CASES = {
    "noise3d float": F + gray("float", "f"), "noise3d vector": V + gray("vector3", "v"), "noise3d colour": C.replace('name="c"', 'name="last"'),
    "noise2d float": XY + node("noise2d", "float", UV) + gray("float"), "noise2d vector": XY + node("noise2d", "vector3", UV) + gray("vector3"),
    "fractal3d float": node("fractal3d", "float", port("octaves", "integer", 4), port("lacunarity", "float", 2.1), P) + gray("float"),
    "fractal3d vector": node("fractal3d", "vector3", port("octaves", "integer", 3), P) + gray("vector3"),
    "cellnoise3d": node("cellnoise3d", "float", P) + gray("float"), "cellnoise2d": XY + node("cellnoise2d", "float", UV) + gray("float"),
    "worleynoise3d": node("worleynoise3d", "float", port("jitter", "float", 0.8), P) + gray("float"),
    "worleynoise3d vector": node("worleynoise3d", "vector3", P) + gray("vector3"),
    "worleynoise3d cells": node("worleynoise3d", "float", port("style", "integer", 1), P) + gray("float"),
    "worleynoise2d": XY + node("worleynoise2d", "float", UV) + gray("float"), "worleynoise2d vector": XY + node("worleynoise2d", "vector3", UV) + gray("vector3"),
    **{name: unary(name) for name in ("absval", "floor", "ceil", "sin", "cos", "tan", "exp", "fract", "sign", "invert", "saturate", "trianglewave") if name != "saturate"},
    **{name: binary(name) for name in ("add", "subtract", "multiply", "divide", "modulo", "min", "max")},
    "power": F + node("absval", "float", port("in", "float", node="f"), name="a") + node("power", "float", port("in1", "float", node="a"), port("in2", "float", 1.7)) + gray("float"),
    "safepower": binary("safepower", 1.3),
    "atan2": F + node("atan2", "float", port("iny", "float", node="f"), port("inx", "float", 0.3)) + gray("float"),
    "clamp": F + node("clamp", "float", port("in", "float", node="f"), port("low", "float", -0.2), port("high", "float", 0.3)) + gray("float"),
    "smoothstep": F + node("smoothstep", "float", port("in", "float", node="f"), port("low", "float", -0.3), port("high", "float", 0.4)) + gray("float"),
    "remap": F + node("remap", "float", port("in", "float", node="f"), port("inlow", "float", -1), port("inhigh", "float", 1), port("outlow", "float", 0.2), port("outhigh", "float", 3)) + gray("float"),
    "range": F + node("range", "float", port("in", "float", node="f"), port("inlow", "float", -1), port("inhigh", "float", 1), port("gamma", "float", 1.5), port("doclamp", "boolean", "true")) + gray("float"),
    "contrast": C + node("contrast", "color3", port("in", "color3", node="c"), port("amount", "float", 1.8)).replace('name="x"', 'name="last"'),
    "ifgreater": F + node("ifgreater", "float", port("value1", "float", node="f"), port("value2", "float", 0.1), port("in1", "float", 0.9), port("in2", "float", node="f")) + gray("float"),
    "dotproduct": V + node("dotproduct", "float", port("in1", "vector3", node="v"), port("in2", "vector3", "1, 2, 3")) + gray("float"),
    "crossproduct": V + node("crossproduct", "vector3", port("in1", "vector3", node="v"), port("in2", "vector3", "1, 2, 3")) + gray("vector3"),
    "magnitude": V + node("magnitude", "float", port("in", "vector3", node="v")) + gray("float"),
    "normalize": V + node("normalize", "vector3", port("in", "vector3", node="v")) + gray("vector3"),
    "rotate3d": V + node("rotate3d", "vector3", port("in", "vector3", node="v"), port("amount", "float", 33), port("axis", "vector3", "1, 2, 0.5")) + gray("vector3"),
    "rotate2d": XY + node("rotate2d", "vector2", port("in", "vector2", node="uv"), port("amount", "float", 20), name="r") + node("noise2d", "float", port("texcoord", "vector2", node="r")) + gray("float"),
    "place2d": XY + node("place2d", "vector2", UV, port("scale", "vector2", "0.5, 2"), port("rotate", "float", 25), port("offset", "vector2", "0.1, 0.2"), name="r") + node("noise2d", "float", port("texcoord", "vector2", node="r")) + gray("float"),
    "ramplr": XY + node("ramplr", "color3", port("valuel", "color3", "1, 0, 0.2"), port("valuer", "color3", "0, 1, 0.5"), UV, name="last"),
    "ramptb": XY + node("ramptb", "color3", port("valuet", "color3", "1, 0, 0.2"), port("valueb", "color3", "0, 1, 0.5"), UV, name="last"),
    "ramp4": XY + node("ramp4", "color3", port("valuetl", "color3", "1, 0, 0.2"), port("valuetr", "color3", "0, 1, 0.5"), port("valuebl", "color3", "0.3, 0.4, 1"), port("valuebr", "color3", "0, 0, 0"), UV, name="last"),
    **{name: mixed(name) for name in ("mix", "plus", "minus", "difference", "screen", "overlay", "burn", "dodge")},
    "luminance": C + node("luminance", "color3", port("in", "color3", node="c"), name="last"),
    "rgbtohsv": C + node("rgbtohsv", "color3", port("in", "color3", node="c"), name="last"),
    "hsvtorgb": C + node("hsvtorgb", "color3", port("in", "color3", node="c"), name="last"),
    "hsvadjust": C + node("hsvadjust", "color3", port("in", "color3", node="c"), port("amount", "vector3", "0.2, 0.8, 1.1"), name="last"),
    "saturate": C + node("saturate", "color3", port("in", "color3", node="c"), port("amount", "float", 0.4), name="last"),
    "switch": F + node("switch", "float", port("in1", "float", 0.3), port("in2", "float", node="f"), port("in3", "float", 0.9), port("which", "float", 1)) + gray("float"),
    "checkerboard": XY + node("checkerboard", "color3", port("uvtiling", "vector2", "2, 3"), UV, name="last"),
    "unifiednoise3d": node("unifiednoise3d", "float", P, port("type", "integer", 3), port("freq", "vector3", "1, 2, 1")) + gray("float"),
}


def document(nodes):
    return ('<?xml version="1.0"?><materialx version="1.39"><nodegraph name="G"><position name="pos" type="vector3"/>' + nodes +
            '<output name="out" type="color3" nodename="last"/></nodegraph><surface_unlit name="S" type="surfaceshader"><input name="emission_color" type="color3" nodegraph="G" output="out"/></surface_unlit>'
            '<surfacematerial name="Look" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial></materialx>')


def function_of(folder, name):
    """Returns the source of the look's colour under another name."""
    text = (folder / "looks.fl").read_text()
    return re.search(r"    float3 base_color\(.*?\n    }\n", text, re.S).group().replace("base_color", name)


def printed(openflc, folder, functions):
    """Returns points, and the value of each function there from compiled code."""
    prints = "".join(f'            printf("{i} %.9g %.9g", p, {name}({"p" if "(float3 p" in text else ""}));\n' for i, (name, text) in enumerate(functions.items()))
    shutil.copy(pathlib.Path(looks.__file__).with_name("materialx.fl"), folder)
    (folder / "points.fl").write_text("import color;\nimport materialx;\n\nfablet Points {\n    @uniform { Material a; }\n" + "".join(functions.values()) +
                                      "    @Volume(@varying { VolumeAttributes attr })\n    {\n        float3 p = attr.voxelCenter * 0.37 - float3(1.1, 0.4, 2);\n" + prints +
                                      "        MaterialComposition mc;\n        mc.Set(a, 1);\n        return mc;\n    }\n}\n")
    (folder / "points.fab.json").write_text('{"openfab": 1, "printer": "generic", "fablets": {"p": {"source": "points.fl", "fablet": "Points"}}, "materials": {"a": {"key": "#ffffff"}}, '
                                            '"meshes": {"m": {"box": [9, 9, 9]}}, "objects": {"o": {"mesh": "m", "fablet": "p", "uniforms": {"a": "a"}}}, "build": [{"object": "o"}]}')
    done = subprocess.run([openflc, "run", "--prints", "--print-lines", "400", folder / "points.fl", folder / "points.fab.json", "--voxel", "1.37mm", "--progress", "none", "-o", folder / "x.ofr"],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    values = [[] for _ in functions]
    for line in done.stderr.splitlines():
        if "mm: " in line:
            which, *numbers = line.split("mm: ")[1].split()
            values[int(which)].append([float(one) for one in numbers])
    return values


def shader(file):
    """Returns MaterialX's shader for the colour, with the values of its uniforms."""
    doc = mx.createDocument()
    mx.readFromXmlFile(doc, str(file))
    doc.importLibrary(looks.library())
    generator = glsl.EsslShaderGenerator.create()
    context = gen.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    made = generator.generate("look", doc.getNodeGraph("G").getOutput("out"), context)
    code = made.getSourceCode("pixel")
    for block in made.getStage("pixel").getUniformBlocks().values():
        for one in block:
            if one.getValue() is not None:
                text = one.getValue().getValueString()
                code = re.sub(rf"uniform (\w+) {re.escape(one.getVariable())};", lambda m, v=text, n=one.getVariable(): f"const {m[1]} {n}({v});", code)
    return code


# GLSL in C++, as much as these shaders want.
GLSL = r"""
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
using uint = uint32_t;
#define VEC(N, T, NAME) struct NAME { T v[N]; NAME() : v{} {} template <typename S, typename = decltype(T(S()))> explicit NAME(S s) { for (T& one : v) one = T(s); } \
    T& operator[](int i) { return v[i]; } const T& operator[](int i) const { return v[i]; }
VEC(2, float, vec2) vec2(float a, float b) : v{a, b} {} };
VEC(3, float, vec3) vec3(float a, float b, float c) : v{a, b, c} {} vec3(vec2 a, float c) : v{a[0], a[1], c} {} };
VEC(4, float, vec4) vec4(float a, float b, float c, float d) : v{a, b, c, d} {} vec4(vec3 a, float d) : v{a[0], a[1], a[2], d} {} vec4(vec2 a, vec2 b) : v{a[0], a[1], b[0], b[1]} {} };
VEC(2, int, ivec2) };
VEC(3, uint, uvec3) };
VEC(3, bool, bvec3) };
#define EACH(N, V) \
    static V operator+(V a, V b) { for (int i = 0; i < N; ++i) a[i] += b[i]; return a; } static V operator-(V a, V b) { for (int i = 0; i < N; ++i) a[i] -= b[i]; return a; } \
    static V operator*(V a, V b) { for (int i = 0; i < N; ++i) a[i] *= b[i]; return a; } static V operator/(V a, V b) { for (int i = 0; i < N; ++i) a[i] /= b[i]; return a; } \
    static V operator+(V a, float b) { return a + V(b); } static V operator-(V a, float b) { return a - V(b); } static V operator*(V a, float b) { return a * V(b); } static V operator/(V a, float b) { return a / V(b); } \
    static V operator+(float a, V b) { return V(a) + b; } static V operator-(float a, V b) { return V(a) - b; } static V operator*(float a, V b) { return V(a) * b; } static V operator/(float a, V b) { return V(a) / b; } \
    static V operator-(V a) { return V(0.0f) - a; } \
    template <typename S> static V& operator+=(V& a, S b) { return a = a + b; } template <typename S> static V& operator-=(V& a, S b) { return a = a - b; } template <typename S> static V& operator*=(V& a, S b) { return a = a * b; } \
    static float dot(V a, V b) { float s = 0; for (int i = 0; i < N; ++i) s += a[i] * b[i]; return s; } static float length(V a) { return std::sqrt(dot(a, a)); } static V normalize(V a) { return a / length(a); } \
    static V mix(V a, V b, float t) { return a * (1 - t) + b * t; } \
    static V mix(V a, V b, V t) { return a * (1 - t) + b * t; }
EACH(2, vec2) EACH(3, vec3) EACH(4, vec4)
static float frac_(float x) { return x - std::floor(x); }
static float mod_(float x, float y) { return x - y * std::floor(x / y); }
static float sign_(float x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }
#define ONE(NAME, F) static float NAME(float a) { return F(a); } static vec2 NAME(vec2 a) { for (float& x : a.v) x = F(x); return a; } static vec3 NAME(vec3 a) { for (float& x : a.v) x = F(x); return a; } static vec4 NAME(vec4 a) { for (float& x : a.v) x = F(x); return a; }
#define TWO(NAME, F) static float NAME(float a, float b) { return F(a, b); } static vec2 NAME(vec2 a, vec2 b) { for (int i = 0; i < 2; ++i) a[i] = F(a[i], b[i]); return a; } static vec3 NAME(vec3 a, vec3 b) { for (int i = 0; i < 3; ++i) a[i] = F(a[i], b[i]); return a; } \
    static vec2 NAME(vec2 a, float b) { return NAME(a, vec2(b)); } static vec3 NAME(vec3 a, float b) { return NAME(a, vec3(b)); }
namespace glsl {
ONE(abs, std::fabs) ONE(floor, std::floor) ONE(ceil, std::ceil) ONE(sin, std::sin) ONE(cos, std::cos) ONE(tan, std::tan) ONE(exp, std::exp) ONE(log, std::log) ONE(sqrt, std::sqrt) ONE(fract, frac_) ONE(sign, sign_) ONE(trunc, std::trunc) ONE(round, std::nearbyint) ONE(asin, std::asin) ONE(acos, std::acos)
TWO(min, std::fmin) TWO(max, std::fmax) TWO(pow, std::pow) TWO(mod, mod_)
static float atan(float y, float x) { return std::atan2(y, x); }
static float radians(float d) { return d * 0.017453292519943295f; }
template <typename V, typename S> static V clamp(V x, S low, S high) { return min(max(x, low), high); }
static float mix(float a, float b, float t) { return a * (1 - t) + b * t; }
using ::mix;
static float smoothstep(float a, float b, float x) { float t = clamp((x - a) / (b - a), 0.0f, 1.0f); return t * t * (3 - 2 * t); }
static vec3 cross(vec3 a, vec3 b) { return vec3(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]); }
static bvec3 greaterThan(vec3 a, vec3 b) { bvec3 r; for (int i = 0; i < 3; ++i) r[i] = a[i] > b[i]; return r; }
static vec3 mix(vec3 a, vec3 b, bvec3 t) { for (int i = 0; i < 3; ++i) if (t[i]) a[i] = b[i]; return a; }
static float dFdx(float) { return 0; }
static float dFdy(float) { return 0; }
static vec2 xy(vec3 a) { return vec2(a[0], a[1]); }
"""


def as_cpp(code, space):
    """Returns the shader as a namespace whose `look` returns a colour."""
    code = re.sub(r"#version.*|precision .*?;|^#define (material|mx_inverse|mx_mod|EDF|mx_inversesqrt|mx_float_bits_to_int) .*$|^struct .*$|^.*mx_matrix_mul.*$|^#define DIRECTIONAL.*$", "", code, flags=re.M)
    code = re.sub(r"^in (\w+ \w+);", r"static \1;", code, flags=re.M)
    code = re.sub(r"^out (\w+ \w+);", r"static \1;", code, flags=re.M)
    code = re.sub(r"\b(?:in)?out (\w+) (\w+)", r"\1& \2", code)
    code = re.sub(r"\b(\w+(?:\([^()]*\))?)\.xy\b", r"xy(\1)", code)
    for i, letters in enumerate(("xr", "yg", "zb", "wa")):
        code = re.sub(rf"(?<=[\w)\]])\.[{letters}]\b(?!\()", f"[{i}]", code)
    code = re.sub(r"#define M_FLOAT_EPS.*|#define M_PI .*|#define mx_\w+ \w+", "", code)
    names = "\n".join(f"#define mx_{one} {one}" for one in ("sin", "cos", "tan", "asin", "acos", "atan", "radians"))
    return f"namespace {space} {{\n#define M_FLOAT_EPS 1e-8\n#define M_PI 3.1415926535897932\n#define mx_mod mod\n{names}\n{code}\n}}\n".replace("void main()", "void look()")


@pytest.fixture(scope="module")
def values(tmp_path_factory):
    """Returns, by case, the values of this package and of MaterialX at the same points."""
    folder = tmp_path_factory.mktemp("looks")
    functions, spaces, text = {}, {}, GLSL
    for i, (name, nodes) in enumerate(CASES.items()):
        file = folder / f"case{i}" / "looks.mtlx"
        file.parent.mkdir()
        file.write_text(document(nodes))
        looks.import_looks(file, file.parent / "made")
        functions[name] = function_of(file.parent / "made", f"case_{i}")
        text += as_cpp(shader(file), f"case_{i}")
        spaces[name] = f"case_{i}"
    ours = {}
    names = list(functions)
    for begin in range(0, len(names), 12):
        group = names[begin:begin + 12]
        made = folder / f"points{begin}"
        made.mkdir()
        ours |= dict(zip(group, printed(TOOL.with_name("openflc"), made, {spaces[one]: functions[one] for one in group})))
    cases = "".join(f"        if (which == {i}) {{ {space}::positionObject = p; {space}::look(); out = {space}::out1; }}\n" if f"static vec3 positionObject" in text else "" for i, space in enumerate(spaces.values()))
    text += "}\nint main() { int which; vec3 p; using namespace glsl; vec4 out;\n    while (std::scanf(\"%d %f %f %f\", &which, &p[0], &p[1], &p[2]) == 4) {\n" + cases + "        std::printf(\"%.9g %.9g %.9g\\n\", out[0], out[1], out[2]);\n    }\n}\n"
    source = folder / "reference.cpp"
    source.write_text(text)
    built = subprocess.run(["g++", "-std=c++17", "-O0", "-w", "-fsingle-precision-constant", "-ffp-contract=off", source, "-o", folder / "reference"], capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr[:4000]
    asked = "".join(f"{i} {' '.join(repr(x) for x in point[:3])}\n" for i, name in enumerate(names) for point in ours[name])
    answers = iter(subprocess.run([folder / "reference"], input=asked, capture_output=True, text=True, check=True).stdout.splitlines())
    theirs = {name: [[float(x) for x in next(answers).split()] for _ in ours[name]] for name in names}
    return ours, theirs, functions


@pytest.mark.parametrize("name", CASES)
def test_a_look_is_what_materialx_says(values, name):
    ours, theirs, functions = values
    assert len(ours[name]) > 200
    worst = max(abs(a - b) / max(1, abs(b)) for mine, right in zip(ours[name], theirs[name]) for a, b in zip(mine[3:], right))
    assert worst <= MOST, functions[name]


def refused(tmp_path, nodes, words):
    file = tmp_path / "looks.mtlx"
    file.write_text(document(nodes))
    with pytest.raises(looks.LooksError, match=words):
        looks.import_looks(file, tmp_path / "made")
    assert not (tmp_path / "made").exists()


def test_what_cannot_be_had_is_an_error_with_its_place(tmp_path):
    refused(tmp_path, '<image name="last" type="color3"><input name="file" type="filename" value="gone.png"/></image>', "G/last: there is no picture `gone.png`")
    refused(tmp_path, '<blackbody name="last" type="color3"/>', "G/last: nodes of the kind `blackbody`")
    (tmp_path / "broken.mtlx").write_text("<materialx")
    with pytest.raises(looks.LooksError, match="cannot be read"):
        looks.import_looks(tmp_path / "broken.mtlx", tmp_path / "made")


def test_displacement_opacity_and_pictures_print(tmp_path):
    (tmp_path / "dots.ppm").write_bytes(b"P6 2 2 255 " + bytes([255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255]))
    (tmp_path / "looks.mtlx").write_text('<?xml version="1.0"?><materialx version="1.39" colorspace="lin_rec709"><nodegraph name="G">'
        '<image name="dots" type="color3"><input name="file" type="filename" value="dots.ppm" colorspace="srgb_texture"/><input name="uaddressmode" type="string" value="clamp"/></image>'
        '<position name="p" type="vector3"/><noise3d name="bumps" type="float"><input name="position" type="vector3" nodename="p"/></noise3d>'
        '<output name="color" type="color3" nodename="dots"/><output name="height" type="float" nodename="bumps"/></nodegraph>'
        '<standard_surface name="S" type="surfaceshader"><input name="base_color" type="color3" nodegraph="G" output="color"/><input name="opacity" type="color3" value="0.5, 0.5, 0.5"/><input name="specular_roughness" type="float" value="0.3"/></standard_surface>'
        '<displacement name="D" type="displacementshader"><input name="displacement" type="float" nodegraph="G" output="height"/><input name="scale" type="float" value="0.05"/></displacement>'
        '<surfacematerial name="Dots" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/><input name="displacementshader" type="displacementshader" nodename="D"/></surfacematerial></materialx>')
    notes = looks.import_looks(tmp_path / "looks.mtlx", tmp_path / "made")
    assert any("specular_roughness" in note for note in notes)
    world = tmp_path / "made" / "looks.fab.json"
    done = subprocess.run([TOOL, "print", world, "-o", tmp_path / "x.ofr", "--draft", "8", "--stats", tmp_path / "s.json", "--progress", "none"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    stats = __import__("json").loads((tmp_path / "s.json").read_text())
    by = stats["voxels_by_material"]
    assert abs(by["clear"] / stats["voxels_solid"] - 0.5) < 0.02
    assert min(by["cyan"], by["magenta"], by["yellow"]) > 0
