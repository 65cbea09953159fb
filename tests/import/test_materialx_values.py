# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What stands around the nodes of MaterialX looks: colour spaces, units, addresses, names, versions. All looks are imported, and
one fablet of their functions prints a value of each, which a formula gives."""

import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import zlib

import pytest

pytest.importorskip("MaterialX")
ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = pathlib.Path(os.environ.get("OPENFAB_TOOL", ROOT / "build" / "release" / "bin" / "openfab"))
sys.path.insert(0, str(ROOT / "python" / "openfab"))
import materialx as looks  # noqa: E402


def srgb(x):
    return ((x + 0.055) / 1.055) ** 2.4 if x > 0.04045 else x / 12.92


FLAT = [200 / 255, 100 / 255, 50 / 255]
LIGHT = [srgb(x) for x in FLAT]


def matrix(rows, v):
    return [sum(row[i] * v[i] for i in range(3)) for row in rows]


ACESCG = [[1.705050992658, -0.621792120657, -0.083258872001], [-0.130256417507, 1.140804736575, -0.010548319068], [-0.024003356805, -0.128968976065, 1.15297233287]]
P3 = [[1.22493029, -0.22492968, 0], [-0.04205868, 1.04205894, 0], [-0.01964128, -0.07864794, 1.09828925]]
ADOBE = [[1.39835574, -0.398355744, 0], [0, 1, 0], [0, -0.0429289893, 1.04292899]]

UNLIT = '<surface_unlit name="S" type="surfaceshader"><input name="emission_color" type="color3" nodegraph="G" output="out"/></surface_unlit>'
LOOK = '<surfacematerial name="Look" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/></surfacematerial>'


def graph(nodes, last="x", attributes="", kind="color3"):
    return f'<nodegraph name="G" {attributes}>{nodes}<output name="out" type="{kind}" nodename="{last}"/></nodegraph>{UNLIT}{LOOK}'


def value(text, kind="color3", attributes=""):
    return f'<input name="{{}}" type="{kind}" value="{text}" {attributes}/>'


def port(name, kind, text, attributes=""):
    return f'<input name="{name}" type="{kind}" value="{text}" {attributes}/>'


def picture(more="", kind="color3", file="flat.ppm", space='colorspace="srgb_texture"', name="x"):
    return f'<image name="{name}" type="{kind}">{port("file", "filename", file, space)}{more}</image>'


def gray(name="f"):
    return f'<convert name="x" type="color3"><input name="in" type="float" nodename="{name}"/></convert>'


def from4(nodes, name="a"):
    return nodes + f'<convert name="x" type="color3"><input name="in" type="color4" nodename="{name}"/></convert>'


def constant(space):
    return graph(f'<constant name="x" type="color3">{port("value", "color3", "0.5, 0.25, 0.75", space)}</constant>')


def length(unit, kind="distance"):
    return graph(f'<constant name="f" type="float">{port("value", "float", 1, f"unit={chr(34)}{unit}{chr(34)} unittype={chr(34)}{kind}{chr(34)}")}</constant>' + gray())


PUBLISHED = '<input name="file" type="filename" interfacename="picture"/>'
RADIAN = 'unit="radian" unittype="angle"'
V = [0.5, 0.25, 0.75]

# Name: the document, the texture coordinates, and the colour there.
CASES = {
    "smoothstep of a colour": (graph('<smoothstep name="x" type="color3">' + port("in", "color3", "0.333333, 0.5, 0.8") + "</smoothstep>"), (0.5, 0.5), [t * t * (3 - 2 * t) for t in (0.333333, 0.5, 0.8)]),
    "smoothstep with limits for each": (graph('<smoothstep name="x" type="color3">' + port("in", "color3", "0.5, 0.5, 0.5") + port("low", "color3", "0, 0, 0.6") + port("high", "color3", "1, 0.4, 1") + "</smoothstep>"), (0.5, 0.5), [0.5, 1, 0]),
    "smoothstep with one limit for all": (graph('<smoothstep name="x" type="color3">' + port("in", "color3", "0.2, 0.5, 0.8") + port("low", "float", 0.1) + port("high", "float", 0.9) + "</smoothstep>"), (0.5, 0.5), [t * t * (3 - 2 * t) for t in (0.125, 0.5, 0.875)]),
    "splittb above": (graph('<splittb name="x" type="color3">' + port("valuet", "color3", "1, 0, 0") + port("valueb", "color3", "0, 0, 1") + port("center", "float", 0.3) + "</splittb>"), (0.5, 0.5), [1, 0, 0]),
    "splittb below": (graph('<splittb name="x" type="color3">' + port("valuet", "color3", "1, 0, 0") + port("valueb", "color3", "0, 0, 1") + port("center", "float", 0.3) + "</splittb>"), (0.5, 0.2), [0, 0, 1]),
    "a picture of the graph's input": (graph('<input name="picture" type="filename" value="flat.ppm"/><image name="x" type="color3">' + PUBLISHED + "</image>"), (0.5, 0.5), FLAT),
    "its colour space": (graph('<input name="picture" type="filename" value="flat.ppm" colorspace="srgb_texture"/><image name="x" type="color3">' + PUBLISHED + "</image>"), (0.5, 0.5), LIGHT),
    "a picture with a prefix of the node": (graph('<image name="x" type="color3" fileprefix="wood/"><input name="file" type="filename" value="flat.ppm"/></image>'), (0.5, 0.5), [0, 0, 1]),
    "a picture with a prefix of the graph": (graph('<input name="picture" type="filename" value="flat.ppm"/><image name="x" type="color3">' + PUBLISHED + "</image>", attributes='fileprefix="wood/"'), (0.5, 0.5), [0, 0, 1]),
    "a picture's name behind a dot": (graph('<dot name="d" type="filename">' + port("in", "filename", "flat.ppm", 'colorspace="srgb_texture"') + '</dot><image name="x" type="color3"><input name="file" type="filename" nodename="d"/></image>'), (0.5, 0.5), LIGHT),
    "a tiled picture of the graph's input": (graph('<input name="picture" type="filename" value="flat.ppm" colorspace="srgb_texture"/><tiledimage name="x" type="color3">' + PUBLISHED + port("uvtiling", "vector2", "3, 3") + "</tiledimage>"), (0.5, 0.5), LIGHT),
    "a node beside the graphs": ('<checkerboard name="x" type="color3">' + port("color1", "color3", "1, 0.5, 0.25") + port("color2", "color3", "0, 0, 0") + port("uvtiling", "vector2", "2, 2") + '</checkerboard><surface_unlit name="S" type="surfaceshader"><input name="emission_color" type="color3" nodename="x"/></surface_unlit>' + LOOK, (0.6, 0.1), [1, 0.5, 0.25]),
    "colours of pictures in g22_rec709": (graph(picture(space='colorspace="g22_rec709"')), (0.5, 0.5), [x**2.2 for x in FLAT]),
    "in gamma18": (graph(picture(space='colorspace="gamma18"')), (0.5, 0.5), [x**1.8 for x in FLAT]),
    "in rec709_display": (graph(picture(space='colorspace="rec709_display"')), (0.5, 0.5), [x**2.4 for x in FLAT]),
    "in lin_ap1_scene": (graph(picture(space='colorspace="lin_ap1_scene"')), (0.5, 0.5), matrix(ACESCG, FLAT)),
    "in adobergb": (graph(picture(space='colorspace="adobergb"')), (0.5, 0.5), matrix(ADOBE, [x ** (563 / 256) for x in FLAT])),
    "in srgb_displayp3": (graph(picture(space='colorspace="srgb_displayp3"')), (0.5, 0.5), matrix(P3, LIGHT)),
    "in srgb with alpha": (graph(from4(picture(kind="color4", name="a"))), (0.5, 0.5), LIGHT),
    "values in srgb": (constant('colorspace="srgb_texture"'), (0.5, 0.5), [srgb(x) for x in V]),
    "values in acescg": (constant('colorspace="acescg"'), (0.5, 0.5), matrix(ACESCG, V)),
    "values in linear light": (constant('colorspace="lin_rec709"'), (0.5, 0.5), V),
    "values of a graph in srgb": (graph(f'<constant name="x" type="color3">{port("value", "color3", "0.5, 0.25, 0.75")}</constant>', attributes='colorspace="srgb_texture"'), (0.5, 0.5), [srgb(x) for x in V]),
    "values of the graph's input in srgb": (graph('<input name="c" type="color3" value="0.5, 0.25, 0.75" colorspace="srgb_texture"/><constant name="x" type="color3"><input name="value" type="color3" interfacename="c"/></constant>'), (0.5, 0.5), [srgb(x) for x in V]),
    "vectors are no colours": (graph(picture(kind="vector3", space="", name="v") + '<convert name="x" type="color3"><input name="in" type="vector3" nodename="v"/></convert>', attributes='colorspace="srgb_texture"'), (0.5, 0.5), FLAT),
    "beyond a picture": (graph(picture(port("default", "color3", "1, 0.5, 0.25") + port("uaddressmode", "string", "constant"))), (1.5, 0.5), [1, 0.5, 0.25]),
    "beyond it in v alone": (graph(picture(port("default", "color3", "1, 0.5, 0.25") + port("vaddressmode", "string", "constant"))), (1.5, 0.5), LIGHT),
    "within it": (graph(picture(port("default", "color3", "1, 1, 1") + port("uaddressmode", "string", "constant"))), (0.5, 0.5), LIGHT),
    "an inch": (length("inch"), (0.5, 0.5), [2.54] * 3),
    "a millimetre": (length("millimeter"), (0.5, 0.5), [0.1] * 3),
    "inches with blanks between": (graph('<constant name="v" type="vector2">' + port("value", "vector2", "1 2", 'unit="inch" unittype="distance"') + '</constant><convert name="x" type="color3"><input name="in" type="vector2" nodename="v"/></convert>'), (0.5, 0.5), [2.54, 5.08, 0]),
    "a radian": (graph('<rotate2d name="r" type="vector2">' + port("in", "vector2", "1, 0") + port("amount", "float", 0.5, RADIAN) + '</rotate2d><convert name="x" type="color3"><input name="in" type="vector2" nodename="r"/></convert>'), (0.5, 0.5), [0.877582562, -0.479425539, 0]),
    "a picture of inches": (graph(picture(kind="float", space='unit="inch" unittype="distance"', name="f") + gray()), (0.5, 0.5), [FLAT[0]] * 3),
    "saturation above one": (graph('<hsvadjust name="x" type="color3">' + port("in", "color3", "0.2, 0.5, 0.8") + port("amount", "vector3", "0, 1.6, 1") + "</hsvadjust>"), (0.5, 0.5), [-0.16, 0.32, 0.8]),
    "burn of colours with alpha": (graph(from4('<burn name="a" type="color4">' + port("fg", "color4", "0.5, 0.75, 1, 1") + port("bg", "color4", "0.5, 0.75, 0, 1") + port("mix", "float", 0.5) + "</burn>")), (0.5, 0.5), [0.25, 0.7083333, 0]),
    "hsv of colours with alpha": (graph(from4('<rgbtohsv name="a" type="color4">' + port("in", "color4", "0.2, 0.2, 0.8, 1") + "</rgbtohsv>")), (0.5, 0.5), [2 / 3, 0.75, 0.8]),
    "alpha of luminance": (graph('<luminance name="h" type="color4">' + port("in", "color4", "0.2, 0.5, 0.8, 0.3") + '</luminance><extract name="f" type="float"><input name="in" type="color4" nodename="h"/>' + port("index", "integer", 3) + "</extract>" + gray()), (0.5, 0.5), [0.3] * 3),
    "alpha of saturate": (graph('<saturate name="h" type="color4">' + port("in", "color4", "0.2, 0.5, 0.8, 0.3") + port("amount", "float", 0.5) + '</saturate><extract name="f" type="float"><input name="in" type="color4" nodename="h"/>' + port("index", "integer", 3) + "</extract>" + gray()), (0.5, 0.5), [0.3] * 3),
    "the closest texel": (graph(picture(port("filtertype", "string", "closest"), file="four.ppm", space="")), (0.45, 0.9), [1, 0, 0]),
    "coordinates that are written": (graph(picture(port("texcoord", "vector2", "0, 0") + port("filtertype", "string", "closest"), file="four.ppm", space="")), (0.75, 0.25), [1, 1, 1]),
    "pictures of one name": (graph(picture(file="metal/flat.ppm", space="", name="a") + picture(file="wood/flat.ppm", space="", name="b") + '<splitlr name="x" type="color3"><input name="valuel" type="color3" nodename="a"/><input name="valuer" type="color3" nodename="b"/></splitlr>'), (0.7, 0.5), [0, 0, 1]),
    "the first of them": (graph(picture(file="metal/flat.ppm", space="", name="a") + picture(file="wood/flat.ppm", space="", name="b") + '<splitlr name="x" type="color3"><input name="valuel" type="color3" nodename="a"/><input name="valuer" type="color3" nodename="b"/></splitlr>'), (0.2, 0.5), [1, 0, 0]),
    "a picture with alpha": (graph(picture(file="quarter.png")), (0.5, 0.5), LIGHT),
    "whole numbers": (graph('<divide name="f" type="float">' + port("in1", "float", 1) + port("in2", "float", 4) + "</divide>" + gray()), (0.5, 0.5), [0.25] * 3),
    "integers become floats": (graph('<constant name="i" type="integer">' + port("value", "integer", 1) + '</constant><convert name="c" type="float"><input name="in" type="integer" nodename="i"/></convert><divide name="f" type="float"><input name="in1" type="float" nodename="c"/>' + port("in2", "float", 4) + "</divide>" + gray()), (0.5, 0.5), [0.25] * 3),
    "names of OpenFL": (graph('<constant name="inout" type="color3">' + port("value", "color3", "0.2, 0.5, 0.8") + '</constant><rgbtohsv name="mx_rgb_to_hsv" type="color3"><input name="in" type="color3" nodename="inout"/></rgbtohsv><hsvtorgb name="lerp" type="color3"><input name="in" type="color3" nodename="mx_rgb_to_hsv"/></hsvtorgb><mix name="x" type="color3"><input name="fg" type="color3" nodename="lerp"/><input name="bg" type="color3" nodename="inout"/>' + port("mix", "float", 0.5) + "</mix>"), (0.5, 0.5), [0.2, 0.5, 0.8]),
}


def png(width, height, pixels):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    rows = b"".join(b"\0" + pixels for _ in range(height))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def pictures(folder):
    for name, color in (("", (200, 100, 50)), ("metal", (255, 0, 0)), ("wood", (0, 0, 255))):
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "flat.ppm").write_bytes(b"P6 2 2 255 " + bytes(color * 4))
    (folder / "four.ppm").write_bytes(b"P6 2 2 255 " + bytes([255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255]))
    (folder / "quarter.png").write_bytes(png(2, 2, bytes([200, 100, 50, 64] * 2)))


def write(folder, text, name="looks"):
    folder.mkdir(exist_ok=True)
    pictures(folder)
    file = folder / f"{name}.mtlx"
    file.write_text(f'<?xml version="1.0"?><materialx version="1.39">{text}</materialx>')
    return file


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    """Returns the colour of each case, from compiled code."""
    folder = tmp_path_factory.mktemp("values")
    functions, calls, textures = "", "", {}
    for i, (text, at, _) in enumerate(CASES.values()):
        looks.import_looks(write(folder / f"c{i}", text), folder / f"c{i}" / "made")
        made = folder / f"c{i}" / "made"
        function = re.search(r"    float3 base_color\((.*?)\)\n    {\n.*?\n    }\n", (made / "looks.fl").read_text(), re.S)
        body = function[0].replace("base_color", f"case_{i}")
        for name, texture in json.loads((made / "looks.fab.json").read_text()).get("textures", {}).items():
            body = re.sub(rf"\b{name}\.Sample", f"t{i}_{name}.Sample", body)
            textures[f"t{i}_{name}"] = {**texture, "file": f"c{i}/made/{texture['file']}"}
        functions += body
        calls += f'        printf("{i} %.9g\\n", case_{i}({"float2(%r, %r)" % at if "uv" in function[1] else ""}));\n'
    shutil.copy(pathlib.Path(looks.__file__).with_name("materialx.fl"), folder)
    uniforms = "".join(f" ImageTexture2D {name};" for name in textures)
    (folder / "v.fl").write_text("import color;\nimport materialx;\nfablet V {\n    @uniform { Material a;" + uniforms + " }\n" + functions + "    @Volume(@varying { VolumeAttributes attr })\n    {\n" + calls + "        MaterialComposition mc;\n        mc.Set(a, 1);\n        return mc;\n    }\n}\n")
    (folder / "v.fab.json").write_text(json.dumps({"openfab": 1, "printer": "generic", "fablets": {"f": {"source": "v.fl", "fablet": "V"}}, "materials": {"a": {"key": "#ffffff"}}, "textures": textures, "meshes": {"m": {"box": [1, 1, 1]}},
                                                   "objects": {"o": {"mesh": "m", "fablet": "f", "uniforms": {"a": "a", **{name: name for name in textures}}}}, "build": [{"object": "o"}]}))
    done = subprocess.run([TOOL.with_name("openflc"), "run", "--prints", "--print-lines", "1000", folder / "v.fl", folder / "v.fab.json", "--voxel", "1mm", "--progress", "none", "-o", folder / "v.npy"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    found = {}
    for line in done.stderr.splitlines():
        if "mm: " in line:
            which, *numbers = line.split("mm: ")[1].split()
            found[int(which)] = [float(one) for one in numbers]
    return found


@pytest.mark.parametrize("name", CASES)
def test_a_value_is_what_its_formula_says(printed, name):
    assert printed[list(CASES).index(name)] == pytest.approx(CASES[name][2], abs=2e-5)


def shaded(category, *ports, version=""):
    return f'<{category} name="S" type="surfaceshader" {version}>{"".join(ports)}</{category}>{LOOK}'


def source(tmp_path, text, name="looks"):
    notes = looks.import_looks(write(tmp_path, text, name), tmp_path / "made")
    return next((tmp_path / "made").glob("*.fab.json")).with_suffix("").with_suffix(".fl").read_text(), notes


def returned(text, function):
    return re.search(rf"float {function}\(.*?return (.*?);", text, re.S)[1]


@pytest.mark.parametrize("mode, alpha", [("", None), ("0", None), ("1", "0.3 >= 0.4 ? 1.0 : 0.0"), ("2", "0.3")])
def test_alpha_of_gltf_is_what_its_mode_says(tmp_path, mode, alpha):
    ports = [port("alpha", "float", 0.3), port("alpha_cutoff", "float", 0.4)] + ([port("alpha_mode", "integer", mode)] if mode else [])
    text, notes = source(tmp_path, shaded("gltf_pbr", *ports))
    assert ("opacity" in text) == (alpha is not None)
    if alpha:
        assert returned(text, "opacity") == alpha
    else:
        assert any("`alpha` is not used" in note for note in notes)
    # What decides is not left out; a limit without a mask is.
    assert any("`alpha_cutoff`" in note for note in notes) == (mode != "1")
    assert not any("`alpha_mode` has" in note for note in notes)


@pytest.mark.parametrize("mode", ["0", "1"])
@pytest.mark.parametrize("threshold, opacity", [(None, "0.3"), ("0", "0.3"), ("0.4", "0.3 >= 0.4 ? 1.0 : 0.0")])
def test_a_threshold_of_a_preview_surface_is_a_mask(tmp_path, mode, threshold, opacity):
    """As the library's graph has it: all where the opacity reaches a threshold above 0, whatever the mode."""
    ports = [port("opacity", "float", 0.3), port("opacityMode", "integer", mode)] + ([port("opacityThreshold", "float", threshold)] if threshold else [])
    text, notes = source(tmp_path, shaded("UsdPreviewSurface", *ports))
    assert returned(text, "opacity") == opacity
    assert not any("opacity" in note for note in notes)


def test_the_weight_is_that_of_the_model_s_version(tmp_path):
    text, _ = source(tmp_path, shaded("standard_surface", port("base_color", "color3", "0.5, 0.5, 0.5"), version='version="1.0.0"'))
    assert returned(text, "base_weight") == "0.8"


@pytest.mark.parametrize("model, name", [("standard_surface", "transmission"), ("open_pbr_surface", "transmission_weight"), ("gltf_pbr", "transmission"), ("disney_principled", "specTrans"), ("surface_unlit", "transmission")])
def test_what_light_goes_through_is_clear(tmp_path, model, name):
    text, notes = source(tmp_path, shaded(model, port(name, "float", 0.75)))
    assert returned(text, "transmission") == "0.75" and "mc.Add(clear, 1 - cover)" in text
    assert any("printed as `clear`" in note for note in notes)


def test_displacement_by_vectors_counts_along_the_normal(tmp_path):
    def moved(value, kind):
        return shaded("standard_surface") .replace(LOOK, "") + f'<displacement name="D" type="displacementshader">{port("displacement", kind, value)}{port("scale", "float", 0.5)}</displacement><surfacematerial name="Look" type="material"><input name="surfaceshader" type="surfaceshader" nodename="S"/><input name="displacementshader" type="displacementshader" nodename="D"/></surfacematerial>'

    along, _ = source(tmp_path, moved("0.05", "float"))
    shutil.rmtree(tmp_path / "made")
    vector, _ = source(tmp_path, moved("0, 0, 0.05", "vector3"))
    assert along == vector
    shutil.rmtree(tmp_path / "made")
    with pytest.raises(looks.LooksError, match="displacement by vectors"):
        source(tmp_path, moved("0.1, 0, 0.05", "vector3"))


def test_names_of_files_materials_and_pictures_are_free(tmp_path):
    nodes = f'<image name="x" type="color3">{port("file", "filename", "white.ppm")}</image>'
    text = graph(nodes).replace(LOOK, LOOK.replace("Look", "gold_1") + LOOK.replace("Look", "gold1"))
    file = write(tmp_path, text, "color")
    shutil.copy(tmp_path / "flat.ppm", tmp_path / "white.ppm")
    looks.import_looks(file, tmp_path / "made")
    fablet = next((tmp_path / "made").glob("*.fab.json")).with_suffix("").with_suffix(".fl")
    done = subprocess.run([TOOL.with_name("openflc"), "check", fablet], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("nodes, words", [
    (picture(space='colorspace="lin_rec2020"'), "the colour space `lin_rec2020`"),
    (picture(port("uaddressmode", "string", "tiled")), "the address mode `tiled`"),
    ('<constant name="f" type="float">' + port("value", "float", 1, 'unit="league" unittype="distance"') + "</constant>" + gray(), "Unit definition does not exist"),
])
def test_what_is_not_known_is_refused_by_name(tmp_path, nodes, words):
    with pytest.raises(looks.LooksError, match=words):
        source(tmp_path, graph(nodes))


def test_graphs_of_included_files_are_prepared_too(tmp_path):
    write(tmp_path, graph(picture()), "inner")
    text, _ = source(tmp_path, '<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="inner.mtlx"/>')
    assert "mx_from_srgb" in text


def test_a_graph_that_is_named_as_a_node_is_refused(tmp_path):
    text = graph(f'<constant name="x" type="color3">{port("value", "color3", "1, 0, 0")}</constant>')
    with pytest.raises(looks.LooksError, match="reads `G`, which is no node"):
        source(tmp_path, text.replace('nodegraph="G"', 'nodename="G"'))


def test_options_that_mean_nothing_for_looks_are_refused(tmp_path):
    file = write(tmp_path, constant(""))
    (tmp_path / "openfab").mkdir()
    (tmp_path / "openfab" / "__init__.py").touch()
    for one in (ROOT / "python" / "openfab").glob("materialx*"):
        shutil.copy(one, tmp_path / "openfab")
    (tmp_path / "part.obj").write_text("v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")

    def run(*options):
        path = pathlib.Path(sys.executable).parent
        return subprocess.run([TOOL, "import", file, "-o", tmp_path / "made", *options], capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": str(tmp_path), "PATH": f"{path}:{os.environ['PATH']}"})

    done = run("--unit", "20mm", "--mesh", tmp_path / "part.obj")
    assert done.returncode == 0, done.stderr
    world = json.loads((tmp_path / "made" / "looks.fab.json").read_text())
    assert world["meshes"] == {"part": {"file": "part.obj"}}
    assert next(iter(world["objects"].values()))["uniforms"]["unit"] == 20
    shutil.rmtree(tmp_path / "made")
    for option in (["--list"], ["--size", "20mm"], ["--fablet", "shell"], ["--up", "y"], ["--memory", "1GB"]):
        done = run(*option)
        assert done.returncode == 2 and option[0] in done.stderr, done.stderr
        assert not (tmp_path / "made").exists()
    done = subprocess.run([TOOL, "import", tmp_path / "part.obj", "-o", tmp_path / "made", "--unit", "20mm"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "20mm" in done.stderr
