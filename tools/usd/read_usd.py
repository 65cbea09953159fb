# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""read_usd.py FILE OBJ BYTES: what a USD file shows, as a Wavefront file in mm with z up, its materials and pictures beside it.
`openfab import` runs it in a Python that has USD's own library; the text is within the program."""

import math
import os
import re
import resource
import sys

sys.path[:] = [p for p in sys.path if p not in ("", os.getcwd())]  # a stranger's folder may hold modules

try:
    from pxr import Ar, Gf, Tf, Usd, UsdGeom, UsdShade
except ImportError:
    print(
        "error: USD is read by its own library, which `python3` does not have\n"
        "  = help: `pip install usd-core`, or save it as GLB with Blender, which keeps its colours",
        file=sys.stderr,
    )
    sys.exit(3)

TIME = Usd.TimeCode.EarliestTime()


class Notes:
    """What is left out, each with how often and where first."""

    def __init__(self):
        self.found = {}

    def add(self, what, prim):
        self.found.setdefault(what, []).append(str(prim.GetPath()))

    def tell(self, name):
        for what, places in self.found.items():
            more = "" if len(places) == 1 else f" and {len(places) - 1} more"
            print(f"note: {name}: {what} ({places[0]}{more})", file=sys.stderr)


def srgb(linear):
    """A colour of USD, which is linear light, as Wavefront files hold it."""
    out = []
    for c in linear:
        c = min(max(float(c), 0.0), 1.0)
        out.append(12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055)
    return tuple(out)


def word(text):
    return "".join(c if c > " " else "_" for c in text)


def values_of(prim, name, instance=None):
    """The values of a primvar and by what they are counted; those of its instance where nothing of the prototype has some."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    if instance:
        root, own = instance
        inner = primvar and primvar.HasValue() and primvar.GetAttr().GetPrim().GetPath().HasPrefix(root)
        if name in own and not inner:
            return own[name], "constant"
    if not primvar or not primvar.HasValue():
        return None, ""
    values = primvar.ComputeFlattened(TIME)
    return (values, primvar.GetInterpolation()) if values else (None, "")


def values_of_instances(prim):
    """The primvars of a PointInstancer: the values of an instance by its number, as those of points."""
    found = {}
    for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues():
        values, size = primvar.ComputeFlattened(TIME), max(primvar.GetElementSize(), 1)
        if primvar.GetInterpolation() in ("constant", "uniform"):
            found[primvar.GetPrimvarName()] = lambda i, values=values: values
        elif values:
            found[primvar.GetPrimvarName()] = lambda i, values=values, size=size: values[i * size : (i + 1) * size]
    return lambda i: {name: of(i) for name, of in found.items() if of(i)}


def space_of(picture, stated):
    """What a picture's numbers are, for its line in the library: stated, or by UsdUVTexture's rule where the picture says nothing."""
    if stated in ("raw", "sRGB"):
        return "linear" if stated == "raw" else "srgb"
    if picture.startswith(b"\x89PNG") and not re.search(rb"iCCP|sRGB|gAMA|cICP", picture[: picture.find(b"IDAT")]):
        return "linear" if picture[24] == 16 or picture[25] in (0, 4) else None  # deep or grey: as they are
    return None


def material_of(prim):
    """The material that a renderer without time to spare shows, which is that of its UsdPreviewSurface; and that for finished pictures, if it is another."""
    api = UsdShade.MaterialBindingAPI(prim)
    preview, full = (api.ComputeBoundMaterial(purpose)[0] for purpose in (UsdShade.Tokens.preview, UsdShade.Tokens.full))
    return preview or full, full if preview and full and preview.GetPath() != full.GetPath() else None


def at(values, kind, face, corner, vertex):
    i = {"constant": 0, "uniform": face, "faceVarying": corner}.get(kind, vertex)
    return values[i] if i < len(values) else values[-1]


def source_of(shader, name):
    """The shader that an input follows, through graphs, and the value where it follows none."""
    given = shader.GetInput(name)
    if not given:
        return None, None
    for attribute in given.GetValueProducingAttributes():
        if UsdShade.Output.IsOutput(attribute):
            return UsdShade.Shader(attribute.GetPrim()), None
        return None, attribute.Get(TIME)
    return None, None


class Look:
    """What UsdPreviewSurface says of a surface."""

    def __init__(self, name):
        self.name, self.color, self.opacity = name, None, 1.0
        self.picture, self.clamps, self.primvar, self.space = None, False, None, None
        self.moves = (1.0, 1.0, 0.0, 0.0, 0.0)  # scale in u and v, turn in degrees, shift in u and v

    def key(self):
        return (self.name, self.color, self.opacity, self.picture, self.clamps, self.space)


class Reader:
    def __init__(self, stage, file, folder):
        self.stage, self.file, self.folder = stage, file, folder
        self.notes, self.places = Notes(), UsdGeom.XformCache(TIME)
        self.mm = UsdGeom.GetStageMetersPerUnit(stage) * 1000
        self.y_up = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
        self.obj, self.library, self.faces = [], [], 0
        self.vertices, self.coordinates, self.shapes = 0, 0, []
        self.materials, self.pictures, self.bytes, self.names = {}, {}, {}, {}

    # Looks

    def picture_of(self, shader, prim):
        """Copies the picture of a UsdUVTexture; its name, or none, which is told."""
        _, asset = source_of(shader, "file")
        path = asset.resolvedPath if asset else ""
        if path in self.pictures:
            return self.pictures[path]
        self.pictures[path] = None
        within = os.path.realpath(self.folder) + os.sep
        outer = path.split("[")[0]
        if not path:
            self.notes.add(f"the picture `{asset.path if asset else ''}` is not there", prim)
            return None
        if not os.path.realpath(outer).startswith(within):
            self.notes.add(f"the picture `{asset.path}` lies outside of the file's folder", prim)
            return None
        base = os.path.basename(path.split("[")[-1].rstrip("]"))
        name = f"{len(self.pictures)}_{word(base)}"
        bytes_of = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
        with open(os.path.join(os.path.dirname(self.output), name), "wb") as copy:
            copy.write(bytes_of.GetBuffer())
        self.bytes[name] = bytes(bytes_of.GetBuffer()[:100_000])
        self.pictures[path] = name
        return name

    def take_texture(self, look, shader, prim):
        name = self.picture_of(shader, prim)
        if name is None:
            return
        look.picture = name
        wraps = {source_of(shader, wrap)[1] or "useMetadata" for wrap in ("wrapS", "wrapT")}
        look.clamps = wraps == {"clamp"}
        if not look.clamps and wraps - {"repeat", "useMetadata"}:
            self.notes.add("a picture repeats, and should not in each direction", prim)
        for change, usual in (("scale", (1, 1, 1, 1)), ("bias", (0, 0, 0, 0))):
            value = source_of(shader, change)[1]
            if value is not None and tuple(value) != usual:
                self.notes.add(f"the {change} of a picture's values is left out", prim)
        look.space = space_of(self.bytes[name], source_of(shader, "sourceColorSpace")[1])
        reader = source_of(shader, "st")[0]
        if reader and reader.GetIdAttr().Get() == "UsdTransform2d":
            scale = source_of(reader, "scale")[1] or (1, 1)
            shift = source_of(reader, "translation")[1] or (0, 0)
            look.moves = (scale[0], scale[1], source_of(reader, "rotation")[1] or 0.0, shift[0], shift[1])
            reader = source_of(reader, "in")[0]
        look.primvar = (source_of(reader, "varname")[1] if reader else None) or "st"

    def look_of(self, prim):
        bound, finished = material_of(prim)
        if finished:
            self.notes.add(f"`{bound.GetPath()}`, its material for previews, counts, and not `{finished.GetPath()}`", prim)
        if not bound:
            return None
        look = Look(bound.GetPrim().GetName())
        shader = bound.ComputeSurfaceSource()[0]
        if not shader or shader.GetIdAttr().Get() != "UsdPreviewSurface":
            self.notes.add("a material that is no UsdPreviewSurface: its colour is left out", bound.GetPrim())
            return look
        source, color = source_of(shader, "diffuseColor")
        look.color = srgb(color if color is not None else (0.18, 0.18, 0.18))
        kind = source.GetIdAttr().Get() if source else ""
        if kind == "UsdUVTexture":
            look.color = (1.0, 1.0, 1.0)
            self.take_texture(look, source, bound.GetPrim())
        elif kind.startswith("UsdPrimvarReader_float3") and source_of(source, "varname")[1] == "displayColor":
            look.color = None
        elif kind:
            self.notes.add(f"a colour by `{kind}` is left out", bound.GetPrim())
        source, opacity = source_of(shader, "opacity")
        look.opacity = 1.0 if opacity is None else min(max(float(opacity), 0.0), 1.0)
        if source:
            self.notes.add("an opacity that is not one number is left out", bound.GetPrim())
        threshold = source_of(shader, "opacityThreshold")[1] or 0.0
        if threshold > 0:  # a mask: all there, or not at all
            look.opacity = 1.0 if look.opacity >= threshold else 0.0
        return look

    def material(self, look):
        """The name of a look in the library of materials."""
        key = look.key()
        if key not in self.materials:
            taken = {name for name in self.materials.values()}
            name, n = word(look.name), 2
            while name in taken:
                name, n = f"{word(look.name)}_{n}", n + 1
            self.materials[key] = name
            r, g, b = look.color or (1.0, 1.0, 1.0)
            self.library.append(f"newmtl {name}\nKd {r:.9g} {g:.9g} {b:.9g}\nd {look.opacity:.9g}\n")
            if look.picture:
                ways = ("-clamp on " if look.clamps else "") + (f"-colorspace {look.space} " if look.space else "")
                self.library.append(f"map_Kd {ways}{look.picture}\n")
        return self.materials[key]

    # Shapes

    def name(self, path):
        """The last name of a path that no other shape has."""
        words = path.strip("/").split("/")
        for n in range(1, len(words) + 1):
            name = word("_".join(words[-n:]))
            if self.names.setdefault(name, path) == path:
                return name
        return self.name(path + "_2")

    def point(self, p):
        x, y, z = (c * self.mm for c in p)
        return (x, -z, y) if self.y_up else (x, y, z)

    def add_mesh(self, prim, place, name, instance):
        mesh = UsdGeom.Mesh(prim)
        points = mesh.GetPointsAttr().Get(TIME) or []
        counts = mesh.GetFaceVertexCountsAttr().Get(TIME) or []
        indices = mesh.GetFaceVertexIndicesAttr().Get(TIME) or []
        if any(not 0 <= i < len(points) for i in indices) or sum(counts) != len(indices):
            raise ValueError(f"{prim.GetPath()}: a face names a vertex that is not there")
        holes = set(mesh.GetHoleIndicesAttr().Get(TIME) or [])
        scheme = mesh.GetSubdivisionSchemeAttr().Get(TIME)
        if scheme != "none":
            self.notes.add(f"a mesh to be smoothed (`{scheme}`) is printed with the faces that it has", prim)
        if prim.HasAPI("SkelBindingAPI"):
            self.notes.add("a shape with a skeleton is printed as it was modelled", prim)
        turned = (mesh.GetOrientationAttr().Get(TIME) == "leftHanded") != (place.GetDeterminant() < 0)
        whole = self.look_of(prim)
        looks, sets = {}, {}
        for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
            own = self.look_of(subset.GetPrim())
            for face in subset.GetIndicesAttr().Get(TIME) or []:
                looks[face] = own or whole
        if values_of(prim, "displayOpacity", instance)[0] is not None:
            self.notes.add("an opacity of points or faces (`displayOpacity`) is left out", prim)
        colors, kind = values_of(prim, "displayColor", instance)
        placed = [self.point(place.Transform(Gf.Vec3d(p))) for p in points]
        lines, known, uv_known, current = [f"o {name}\n"], {}, {}, None
        painted, rest, is_plain = Look("displayColor"), Look("default"), self.is_plain(prim, instance)
        corner = 0
        for face, count in enumerate(counts):
            corners = list(range(corner, corner + count))
            corner += count
            if face in holes or count < 3:
                continue
            look = looks.get(face, whole)
            by_color = colors is not None and (look is None or look.color is None)
            shown = look or (painted if by_color else None if is_plain else rest)
            if shown is not current:
                lines.append(f"usemtl {self.material(shown)}\n")
                current = shown
            if look and look.picture and look.primvar not in sets:
                sets[look.primvar] = values_of(prim, look.primvar, instance)
            uvs, uv_kind = sets[look.primvar] if look and look.picture else (None, "")
            if look and look.picture and uvs is None:
                self.notes.add(f"a picture's coordinates `{look.primvar}` are not there", prim)
            text = "f"
            for c in reversed(corners) if turned else corners:
                vertex = indices[c]
                color = srgb(at(colors, kind, face, c, vertex)) if by_color else None
                key = (vertex, color)
                if key not in known:
                    self.vertices += 1
                    known[key] = self.vertices
                    x, y, z = placed[vertex]
                    more = "" if color is None else " {:.9g} {:.9g} {:.9g}".format(*color)
                    lines.append(f"v {x:.9g} {y:.9g} {z:.9g}{more}\n")
                text += f" {known[key]}"
                if uvs is not None:
                    uv = self.moved(look.moves, at(uvs, uv_kind, face, c, vertex))
                    if uv not in uv_known:
                        self.coordinates += 1
                        uv_known[uv] = self.coordinates
                        lines.append(f"vt {uv[0]:.9g} {uv[1]:.9g}\n")
                    text += f"/{uv_known[uv]}"
            lines.append(text + "\n")
            self.faces += 1
        self.obj += lines

    @staticmethod
    def is_plain(prim, instance):
        """Whether no face has a material or a colour."""
        subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
        return not material_of(prim)[0] and not subsets and values_of(prim, "displayColor", instance)[0] is None

    @staticmethod
    def moved(moves, uv):
        width, height, degrees, right, up = moves
        u, v = uv[0] * width, uv[1] * height
        cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        return (u * cos - v * sin + right, u * sin + v * cos + up)

    def add(self, root, outer=None, prefix="", shown=None):
        """Adds what is below a prim; `outer` places it where its own place in the scene does not count, and `shown` are
        the primvars of the instance that it is."""
        instance = (root.GetPath(), shown) if shown else None
        above = self.places.GetParentToWorldTransform(root).GetInverse() if outer is not None else Gf.Matrix4d(1)
        # Prototypes may be classes, or `over` what is not there, which are not shown where they stand.
        shows = Usd.PrimIsActive & Usd.PrimIsLoaded if outer is not None else Usd.PrimDefaultPredicate
        walk = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies(shows)))
        for prim in walk:
            image = UsdGeom.Imageable(prim)
            if image and image.ComputeVisibility(TIME) == UsdGeom.Tokens.invisible:
                self.notes.add("what is invisible is left out", prim)
                walk.PruneChildren()
                continue
            purpose = image.ComputePurpose() if image else ""
            if purpose in (UsdGeom.Tokens.proxy, UsdGeom.Tokens.guide):
                self.notes.add(f"what has the purpose `{purpose}` is not printed", prim)
                walk.PruneChildren()
                continue
            place = self.places.GetLocalToWorldTransform(prim) * above
            if outer is not None:
                place = place * outer
            if prim.IsA(UsdGeom.PointInstancer):
                walk.PruneChildren()
                self.add_instances(UsdGeom.PointInstancer(prim), place, prefix, shown or {})
            elif prim.IsA(UsdGeom.Mesh):
                self.shapes.append((prim, place, self.name(f"{prefix}{prim.GetPath()}"), instance))
            elif prim.IsA(UsdGeom.Gprim):
                self.notes.add(f"`{prim.GetTypeName()}` is no mesh and is left out", prim)

    def add_instances(self, instancer, place, prefix, shown):
        prototypes = [self.stage.GetPrimAtPath(p) for p in instancer.GetPrototypesRel().GetForwardedTargets()]
        of = instancer.GetProtoIndicesAttr().Get(TIME) or []
        places = instancer.ComputeInstanceTransformsAtTime(TIME, TIME, UsdGeom.PointInstancer.ExcludeProtoXform)
        mask = instancer.ComputeMaskAtTime(TIME) or [True] * len(of)
        left = [i for i, is_there in enumerate(mask) if is_there]
        values = values_of_instances(instancer)
        for i, own in zip(left, places):
            self.add(prototypes[of[i]], own * place, f"{prefix}{instancer.GetPath()}/{i}", {**shown, **values(i)})

    def write(self, output):
        self.output = output
        self.add(self.stage.GetPseudoRoot())
        # A material holds for all that follow.
        for shape in sorted(self.shapes, key=lambda shape: not self.is_plain(shape[0], shape[3])):
            self.add_mesh(*shape)
        if not self.faces:
            raise ValueError("no mesh with faces")
        library = os.path.splitext(output)[0] + ".mtl"
        with open(library, "w", encoding="utf-8") as text:
            # A picture's alpha counts where a surface's opacity is connected to it, which is told as left out.
            text.write("# OpenFab: opaque pictures\n")
            text.writelines(self.library)
        with open(output, "w", encoding="utf-8") as text:
            text.write(f"# units: mm\nmtllib {os.path.basename(library)}\n")
            text.writelines(self.obj)


def main(file, output, most_bytes):
    resource.setrlimit(resource.RLIMIT_AS, (int(most_bytes), int(most_bytes)))
    seconds = 60 + 10 * (os.path.getsize(file) // 1_000_000) if os.path.exists(file) else 60
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    try:
        stage = Usd.Stage.Open(file)
        reader = Reader(stage, file, os.path.dirname(os.path.abspath(file)))
        reader.write(output)
    except (Tf.ErrorException, ValueError, MemoryError, TypeError, IndexError) as wrong:
        lines = str(wrong).strip().splitlines() or [type(wrong).__name__]
        reason = re.sub(r"^.* in file \S+ : '(.*)'$", r"\1", lines[-1].strip())
        print(f"error: {file}: USD's library cannot read it: {reason}", file=sys.stderr)
        return 1
    if not stage.HasAuthoredMetadata(UsdGeom.Tokens.metersPerUnit):
        print(f"note: {os.path.basename(file)}: the file states no unit: centimetres, as USD has it", file=sys.stderr)
    reader.notes.tell(os.path.basename(file))
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:4]))
