# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Converts MaterialX looks to fablets: pattern graphs to OpenFL, base colour and opacity to inks, displacement to a surface.

    python3 -m openfab.materialx looks.mtlx -o FOLDER [--mesh part.obj] [--unit 10mm] [--printer j750]

`openfab import looks.mtlx` runs this. It needs only the package MaterialX from PyPI, and also runs as a file in a clone.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

if __package__:
    from .materialx_document import Prepared, flatten
    from .materialx_nodes import FORMULAS, RESERVED, TYPES, LooksError, Writer, Written, address_mode, bracket, literal, name_of, number
else:
    from materialx_document import Prepared, flatten  # type: ignore[import-not-found, no-redef]
    from materialx_nodes import FORMULAS, RESERVED, TYPES, LooksError, Writer, Written, address_mode, bracket, literal, name_of, number  # type: ignore[import-not-found, no-redef]

# Shading models: the inputs for colour, its weight, opacity and the share of light that goes through.
MODELS = {
    "standard_surface": ("base_color", "base", "opacity", "transmission"),
    "open_pbr_surface": ("base_color", "base_weight", "geometry_opacity", "transmission_weight"),
    "UsdPreviewSurface": ("diffuseColor", None, "opacity", None),
    "gltf_pbr": ("base_color", None, "alpha", "transmission"),
    "disney_principled": ("baseColor", None, None, "specTrans"),
    "surface_unlit": ("emission_color", "emission", "opacity", "transmission"),
}

LIGHT = re.compile(r"specular|rough|metal|sheen|coat|subsurface|transmission|thin|emission|emissive|fuzz|normal|tangent|ior|occlusion|clearcoat|iridescence")


class Looks:
    """The textures of a file's materials, and notes on what was left out."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.notes: list[str] = []
        self.textures: list[dict[str, Any]] = []
        self.fablets: set[str] = set()

    def note(self, node: Any, text: str) -> None:
        line = f"{node.getNamePath()}: {text}"
        if line not in self.notes:
            self.notes.append(line)

    def texture(self, name: str, node: Any) -> str:
        """Returns the uniform of a picture as a node reads it: four numbers, which nodes behind it take for colours."""
        path = (self.file.parent / name).resolve()
        if not path.is_file():
            raise LooksError(f"{node.getNamePath()}: there is no picture `{name}` beside `{self.file.name}`")
        wraps = {"periodic": "repeat", "clamp": "clamp", "mirror": "mirror", "constant": "clamp"}
        modes = [address_mode(node, which) for which in ("uaddressmode", "vaddressmode")]
        for mode in modes:
            if mode not in wraps:
                raise LooksError(f"{node.getNamePath()}: the address mode `{mode}` is not known; {', '.join(wraps)} are")
        port = node.getInput("filtertype")
        look = {"path": path, "wrap": [wraps[mode] for mode in modes], "nearest": port is not None and port.getValueString() == "closest"}
        for texture in self.textures:
            if all(texture[key] == value for key, value in look.items()):
                return str(texture["uniform"])
        uniform = name_of(path.stem, {texture["uniform"] for texture in self.textures} | RESERVED)
        copies = {texture["path"]: texture["copy"] for texture in self.textures}
        copy, i = copies.get(path, path.name), 2
        while path not in copies and copy.lower() in {one.lower() for one in copies.values()}:
            copy, i = f"{path.stem}_{i}{path.suffix}", i + 1
        self.textures.append({**look, "uniform": uniform, "copy": copy})
        return uniform


def shaders_of(document: Any) -> list[tuple[str, Any, Any]]:
    """Returns name, surface shader and displacement of each material; for a file without materials, its shaders."""
    found = []
    for material in document.getMaterialNodes():
        shaders = [port.getConnectedNode() if port is not None else None for port in map(material.getInput, ("surfaceshader", "displacementshader"))]
        if shaders[0] is not None:
            found.append((material.getName(), shaders[0], shaders[1]))
    if not found:
        found = [(node.getName(), node, None) for node in document.getNodes() if node.getCategory() in MODELS]
    return found


def fablet_name(text: str, taken: set[str]) -> str:
    base = "".join(word[:1].upper() + word[1:] for word in re.split(r"[\W_]+", text) if word)
    if not base or base[0].isdigit() or base in ("Material", "Object", "MaterialComposition"):
        base = "Look" + base
    name, i = base, 2
    while name in taken:
        name, i = f"{base}_{i}", i + 1
    taken.add(name)
    return name


class Fablet:
    """One material as a fablet."""

    def __init__(self, looks: Looks, document: Any, name: str, shader: Any, displacement: Any) -> None:
        self.name, self.looks = fablet_name(name, looks.fablets), looks
        first = len(looks.textures)
        color, weight, opacity, through = MODELS.get(shader.getCategory(), (None, None, None, None))
        if color is None:
            raise LooksError(f"{shader.getNamePath()}: the shading model `{shader.getCategory()}` is not known; {', '.join(MODELS)} are")
        self.functions: list[tuple[str, str, Written]] = []
        self.write(document, shader, color, "float3", "base_color")
        if weight and self.matters(shader, weight, 1):
            self.write(document, shader, weight, "float", "base_weight")
        if opacity and self.matters(shader, opacity, 1) and self.opens(shader):
            self.write(document, shader, opacity, "float", "opacity", after=self.cut_out(shader))
        if through and self.matters(shader, through, 0):
            self.write(document, shader, through, "float", "transmission")
            looks.note(shader, f"`{through}` is printed as `clear`, without a tint")
        if displacement is not None:
            self.displace(document, displacement)
        for port in shader.getInputs():
            if port.getName() not in (color, weight, opacity, through, *self.about_alpha(shader)):
                what = "is about light, not material" if LIGHT.search(port.getName()) else "has no place in a print"
                looks.note(shader, f"`{port.getName()}` {what}; left out")
        self.textures = [one["uniform"] for one in looks.textures if one in looks.textures[first:] or self.uses(one["uniform"])]

    def uses(self, uniform: str) -> bool:
        return any(re.search(rf"\b{uniform}\.Sample", " ".join(w.lines) + w.result) for _, _, w in self.functions)

    def matters(self, shader: Any, name: str, neutral: float) -> bool:
        """Returns whether an input is written, or has another default than the neutral one, as in older versions of a model."""
        if shader.getInput(name) is not None:
            return True
        definition = shader.getNodeDef()
        port = definition.getActiveInput(name) if definition is not None else None
        value = port.getValue() if port is not None else None
        return value is not None and (value if isinstance(value, (int, float)) else value[0]) != neutral

    def mode(self, shader: Any) -> int:
        """Returns what glTF makes of alpha: 0 opaque, 1 a mask, 2 blended."""
        if shader.getCategory() != "gltf_pbr":
            return 2
        port = shader.getInput("alpha_mode")
        if port is not None and (port.getConnectedNode() is not None or port.getConnectedOutput() is not None):
            raise LooksError(f"{shader.getNamePath()}: `alpha_mode` has a wire; write its number")
        return int(port.getValue() or 0) if port is not None else 0

    def opens(self, shader: Any) -> bool:
        if self.mode(shader) == 0 and shader.getInput("alpha") is not None:
            self.looks.note(shader, "`alpha` is not used: `alpha_mode` is 0, opaque")
        return self.mode(shader) != 0

    def about_alpha(self, shader: Any) -> tuple[str, ...]:
        """Returns the inputs that say how an alpha counts; how a renderer shows what is between all and nothing is one of them."""
        if shader.getCategory() == "UsdPreviewSurface":
            return ("opacityMode", "opacityThreshold")
        if shader.getCategory() != "gltf_pbr":
            return ()
        return ("alpha_mode", "alpha_cutoff") if self.mode(shader) == 1 else ("alpha_mode",)

    def cut_out(self, shader: Any) -> str:
        """Returns the formula that makes all or nothing of an alpha; empty where it is blended."""
        model = shader.getCategory()
        if model not in ("gltf_pbr", "UsdPreviewSurface") or self.mode(shader) == 0:
            return ""
        name, usual = ("alpha_cutoff", 0.5) if model == "gltf_pbr" else ("opacityThreshold", 0.0)
        port = shader.getInput(name)
        if port is not None and port.getValue() is None:
            raise LooksError(f"{shader.getNamePath()}: `{name}` has a wire; write its number")
        least = usual if port is None else port.getValue()
        masks = self.mode(shader) == 1 if model == "gltf_pbr" else least > 0
        return f"{{}} >= {literal(least, 'float')} ? 1.0 : 0.0" if masks else ""

    def write(self, document: Any, shader: Any, port: str, kind: str, name: str, after: str = "") -> None:
        """Writes a function of one input; `after` is a formula of its value."""
        writer = Writer(self.looks, document, self.name)
        found = shader.getInput(port)
        if found is None:
            definition = shader.getNodeDef()
            found = definition.getActiveInput(port)
        has = TYPES[found.getType()]
        result = writer.value(found, has)
        writer.out.result = f"dot({result}, float3(1) / 3)" if (has, kind) == ("float3", "float") else writer.convert(result, has, kind)
        if after:
            writer.out.result = after.format(bracket(writer.out.result))
        self.functions.append((kind, name, writer.out))

    def displace(self, document: Any, node: Any) -> None:
        if node.getCategory() != "displacement":
            raise LooksError(f"{node.getNamePath()}: `{node.getCategory()}` is no displacement that is known here")
        kind = TYPES[node.getInput("displacement").getType()] if node.getInput("displacement") is not None else "float"
        scale = node.getInput("scale")
        if scale is not None and scale.getConnectedNode() is not None:
            raise LooksError(f"{node.getNamePath()}: `scale` has a wire; multiply the displacement itself")
        factor = number(scale.getValue()) if scale is not None and scale.getValue() is not None else "1"
        after = "" if factor == "1" else f"{{}} * {factor}"
        if kind == "float":
            self.write(document, node, "displacement", kind, "displacement", after)
            return
        # A vector counts along dPdu, dPdv and the normal.
        writer = Writer(self.looks, document, self.name)
        result = writer.value(node.getInput("displacement"), kind)
        held = next((line.split(" = ", 1)[1].rstrip(";") for line in writer.out.lines if line.startswith(f"{kind} {result} = ")), result)
        parts = re.fullmatch(r"float3\(0(?:\.0)?, 0(?:\.0)?, (.*)\)|float3\((0)(?:\.0)?\)", held)
        if parts is None:
            raise LooksError(f"{node.getNamePath()}: displacement by vectors is in the directions of texture coordinates, which surfaces do not have here; let the third component, along the normal, be a displacement of type float")
        writer.out.result = after.format(bracket(parts[1] or "0.0")) if after else parts[1] or "0.0"
        self.functions.append(("float", "displacement", writer.out))

    def has(self, function: str) -> bool:
        return any(name == function for _, name, _ in self.functions)

    def reads(self, function: str) -> set[str]:
        return next((written.reads for _, name, written in self.functions if name == function), set())

    def call(self, name: str, point: str, normal: str) -> str:
        values = {"p": point, "uv": "uv", "n": normal}
        return f"{name}({', '.join(values[one] for one in ('p', 'uv', 'n') if one in self.reads(name))})"

    def text(self, profile: bool) -> str:
        reads = {one for name in ("base_color", "base_weight", "opacity", "transmission") for one in self.reads(name)}
        moves = self.has("displacement")
        uv_below = "uv" in reads
        parameters = {"p": "float3 p", "uv": "float2 uv", "n": "float3 n"}
        out = [f"fablet {self.name} {{", "    @uniform {"]
        out.append('        float unit = 10 [[ float min = 0.001, string help = "of the look, mm: its patterns are as large as this says" ]];')
        out.append('        float depth = 0.5 [[ float min = 0, string help = "thickness of the coloured skin, mm" ]];')
        if not profile:
            out.append('        float density = 1.2 [[ float min = 0.1, string help = "optical density of a skin of pure ink" ]];')
        for texture in self.textures:
            out.append(f"        ImageTexture2D {texture};")
        if profile:
            out.append('        ImageTexture3D profile [[ string help = "the amounts of inks for a colour, of `openfab color bake`" ]];')
        out.append(f"        Material cyan, magenta, yellow, black, white{', clear' if self.has_clear() else ''};")
        out.append("    }\n")
        for kind, name, written in self.functions:
            out.append(f"    {kind} {name}({', '.join(parameters[one] for one in ('p', 'uv', 'n') if one in written.reads)})\n    {{")
            out += [f"        {line}" for line in written.lines] + [f"        return {written.result};", "    }\n"]
        if moves or uv_below:
            needs_uv = uv_below or "uv" in self.reads("displacement")
            varyings = "SurfaceAttributes attr" + (", float2 uv" if needs_uv else "") + (", out float2 uvOut" if uv_below else "")
            out.append(f"    @Surface(@varying {{ {varyings} }})\n    {{")
            if uv_below:
                out.append("        uvOut = uv;")
            push = "0"
            if moves:
                call = self.call("displacement", "attr.p / unit", "attr.n")
                push = f"attr.n * ({call} * unit)"
            out += [f"        return {push};", "    }\n"]
        out.append(f"    @Volume(@varying {{ VolumeAttributes attr{', @nearest float2 uv' if uv_below else ''} }})\n    {{")
        out.append("        float4 ink = 0;")
        point = "attr.voxelCenter / unit"
        normal = "nearest(attr.voxelCenter).normal"
        out.append("        if (-distance(attr.voxelCenter) <= depth) {")
        weight = f" * {self.call('base_weight', point, normal)}" if self.has("base_weight") else ""
        out.append(f"            float3 rgb = saturate({self.call('base_color', point, normal)}{weight});")
        out.append(f"            ink = {'ink_amounts(profile, rgb)' if profile else 'ink_limit(rgb_to_cmyk(rgb, density, 0.8), 1)'};")
        out.append("        }")
        mixture = "inks(cyan, magenta, yellow, black, white, ink)"
        if self.has_clear():
            factors = [f"saturate({self.call('opacity', point, normal)})"] if self.has("opacity") else []
            factors += [f"(1 - saturate({self.call('transmission', point, normal)}))"] if self.has("transmission") else []
            out.append(f"        float cover = {' * '.join(factors)};")
            out.append(f"        MaterialComposition mc = {mixture} * cover;\n        mc.Add(clear, 1 - cover);\n        return mc;")
        else:
            out.append(f"        return {mixture};")
        return "\n".join(out + ["    }", "}"]) + "\n"

    def has_clear(self) -> bool:
        return self.has("opacity") or self.has("transmission")

    def needs_uv(self) -> bool:
        return any("uv" in written.reads for _, _, written in self.functions)


PLAQUE = """v -20 -20 0\nv 20 -20 0\nv 20 20 0\nv -20 20 0\nv -20 -20 3\nv 20 -20 3\nv 20 20 3\nv -20 20 3
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
f 4/4 3/3 2/2 1/1\nf 5/1 6/2 7/3 8/4\nf 1/1 2/2 6/2 5/1\nf 2/2 3/3 7/3 6/2\nf 3/3 4/4 8/4 7/3\nf 4/4 1/1 5/1 8/4
"""

MATERIALS = {
    "white": ("#ffffff", "#f4f2ecff"), "cyan": ("#00a0e0", "#0098dcff"), "magenta": ("#e0007a", "#d9006eff"),
    "yellow": ("#ffe000", "#f7d900ff"), "black": ("#000000", "#161616ff"), "clear": ("#c0c0c0", "#e8f0f040"),
}


def package() -> Any:
    """Returns the package MaterialX, which has no type annotations."""
    try:
        return importlib.import_module("MaterialX")
    except ImportError:
        raise LooksError("looks of MaterialX want its package: python3 -m pip install MaterialX") from None


@functools.cache
def library() -> Any:
    """Returns the definitions of all nodes."""
    mx = package()
    made = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), made)
    return made


def read(file: Path) -> Any:
    mx = package()
    document = mx.createDocument()
    try:
        mx.readFromXmlFile(document, str(file))
    except Exception as error:  # its own kinds differ by version
        raise LooksError(f"`{file}` cannot be read: {error}") from None
    document.importLibrary(library())
    fine, messages = document.validate()
    if not fine:
        raise LooksError(f"`{file}` is not valid: {messages.strip().splitlines()[0]}")
    return document


def import_looks(file: str | Path, folder: str | Path, *, mesh: str | Path | None = None, unit_mm: float = 10, printer: str = "generic", profile: str | Path | None = None) -> list[str]:
    """Makes a folder with a fablet for each material of a file, and a world that prints them side by side.

    Parameters
    ----------
    file : str or path
        A document of MaterialX.
    folder : str or path
        The folder to make; it must not exist.
    mesh : str or path, optional
        The mesh for the looks. Default: a ball of 12 mm radius, or a plaque for looks that need texture coordinates.
    unit_mm : float
        The length in mm of one unit of the looks' positions.
    printer : str
        A name listed by `openfab printers`.
    profile : str or path, optional
        A table of inks from `openfab color bake`. Default: a formula mixes the inks.

    Returns
    -------
    list of str
        Notes on what was left out, one per line.
    """
    file, folder = Path(file), Path(folder)
    if folder.exists():
        raise LooksError(f"`{folder}` exists already; choose another name")
    document = read(file)
    looks = Looks(file)
    Prepared(document, library(), unit_mm, looks.note)
    flatten(document, library(), lambda category: category in FORMULAS or hasattr(Writer, "of_" + category), MODELS)
    shaders = shaders_of(document)
    if not shaders:
        raise LooksError(f"`{file}` has no material with a surface")
    fablets = [Fablet(looks, document, *one) for one in shaders]
    name = re.sub(r"\W+", "_", file.stem)
    if name in ("materialx", "color"):
        name = "looks"
    needs_uv = any(one.needs_uv() for one in fablets)
    source = "// Made by `openfab import` of " + file.name + ".\nimport color;\nimport materialx;\n\n" + "\n".join(one.text(profile is not None) for one in fablets)
    objects, build = {}, []
    for i, one in enumerate(fablets):
        uniforms: dict[str, Any] = {m: m for m in MATERIALS if m != "clear" or one.has_clear()}
        uniforms.update({texture: texture for texture in one.textures})
        if profile is not None:
            uniforms["profile"] = "profile"
        objects[one.name] = {"mesh": "part", "fablet": one.name, "uniforms": {"unit": unit_mm, **uniforms}}
        build.append({"object": one.name, "translate_mm": [45 * i, 0]})
    used = {m for one in objects.values() for m in one["uniforms"] if m in MATERIALS}
    world: dict[str, Any] = {
        "$schema": "fab_world.schema.json", "openfab": 1, "printer": printer,
        "fablets": {one.name: {"source": f"{name}.fl", "fablet": one.name} for one in fablets},
        "materials": {m: {"key": key, "preview": preview} for m, (key, preview) in MATERIALS.items() if m in used},
    }
    textures: dict[str, Any] = {}
    for texture in looks.textures:
        textures[texture["uniform"]] = {"file": texture["copy"], "wrap": texture["wrap"], "space": "data", **({"filter": "nearest"} if texture["nearest"] else {})}
    if profile is not None:
        textures["profile"] = {"file": Path(profile).name}
    if textures:
        world["textures"] = textures
    folder.mkdir(parents=True)
    if mesh is not None:
        shutil.copy(mesh, folder)
        world["meshes"] = {"part": {"file": Path(mesh).name}}
    elif needs_uv:
        (folder / "plaque.obj").write_text(PLAQUE)
        world["meshes"] = {"part": {"file": "plaque.obj"}}
    else:
        world["meshes"] = {"part": {"sphere": 12}}
    world |= {"objects": objects, "build": build}
    for texture in looks.textures:
        shutil.copy(texture["path"], folder / texture["copy"])
    if profile is not None:
        shutil.copy(profile, folder)
    shutil.copy(Path(__file__).with_name("materialx.fl"), folder)
    (folder / f"{name}.fl").write_text(source)
    (folder / f"{name}.fab.json").write_text(json.dumps(world, indent=4) + "\n")
    return looks.notes


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="openfab import", description="make a world of the looks of a MaterialX document")
    parser.add_argument("file")
    parser.add_argument("-o", "--output", help="the folder to make")
    parser.add_argument("--mesh", help="what the looks are put on")
    parser.add_argument("--unit", default="10mm", help="the length of one unit of the looks, as 20mm (default: 10mm)")
    parser.add_argument("--printer", default="generic")
    parser.add_argument("--profile", help="a table of inks of `openfab color bake`")
    options = parser.parse_args(words)
    unit = re.fullmatch(r"([0-9.]*)\s*(mm|cm|m|um|in|)", options.unit)
    length = float(unit[1] or "1") * {"mm": 1, "": 1, "cm": 10, "m": 1000, "um": 0.001, "in": 25.4}[unit[2]] if unit else 0
    if not length > 0:
        parser.error("--unit is a length, as 10mm")
    folder = options.output or Path(options.file).stem
    try:
        notes = import_looks(options.file, folder, mesh=options.mesh, unit_mm=length, printer=options.printer, profile=options.profile)
    except (LooksError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1 if isinstance(error, LooksError) else 3
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    name = next(Path(folder).glob("*.fab.json"))
    print(f"made {name}\nprint it: openfab print {name} -o {name.name.split('.')[0]}.ofr", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
