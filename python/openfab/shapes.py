# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes and textures: files, primitives and arrays."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _files, _foreign
from ._given import Real, array, choice, floats, integers, is_sequence, number, plain, positive, several, short, vector
from .errors import InputError
from .fablet import Fablet
from .lattice import Beams
from .procedural import Generated, Generator


class Mesh:
    """A closed triangle mesh, in millimetres, z up.

    The arrays are copied; those of the mesh are read-only, since prints read them at any time.

    Parameters
    ----------
    vertices : array_like of float, shape (n, 3)
        Places in mm.
    faces : array_like of int, shape (m, 3)
        The vertices of each triangle, counter-clockwise seen from outside.
    normals : array_like of float, shape (n, 3), optional
        Of vertices; their length does not matter.
    uv : array_like of float, shape (n, 2) or (m, 3, 2), optional
        Texture coordinates of vertices, or of each corner of each face.
    vertex_attributes : mapping of str to array_like of float, shape (n,) or (n, 1 to 4), optional
        What fablets find under these names, between vertices by interpolation.
    face_attributes : mapping of str to array_like of int or float, shape (m,) or (m, 1 to 4), optional
        What fablets find under these names, the same all over a face.

    Raises
    ------
    InputError
        Where a shape is another, a value is not finite, a face has a vertex that is not there, or a name is none.
    """

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        normals: ArrayLike | None = None,
        uv: ArrayLike | None = None,
        vertex_attributes: Mapping[str, ArrayLike] | None = None,
        face_attributes: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        self._vertices: NDArray[np.float64] = floats(vertices, "`vertices`", np.float64)
        self._faces = integers(faces, "`faces`")
        for one, what, wanted in ((self._vertices, "vertices", "(n, 3)"), (self._faces, "faces", "(m, 3)")):
            if one.ndim != 2 or one.shape[1] != 3:
                raise InputError(f"`{what}` has the shape {one.shape}; it should be {wanted}")
            one.setflags(write=False)
        count = len(self._vertices)
        odd = np.argwhere((self._faces < 0) | (self._faces >= count))
        if len(odd):
            face, corner = odd[0]
            raise InputError(
                f"face {face} has the vertex {self._faces[face, corner]}; there are {count}, from 0 to {count - 1}"
            )
        vertex = {
            _attribute(name, "vertex"): _columns(f"vertex attribute `{name}`", floats, values, count)
            for name, values in (vertex_attributes or {}).items()
        }
        if normals is not None:
            vertex["n"] = _columns("`normals`", floats, normals, count, 3)
        face_columns = {
            _attribute(name, "face"): _columns(f"face attribute `{name}`", _as_they_are, values, len(self._faces))
            for name, values in (face_attributes or {}).items()
        }
        corners: NDArray[np.float32] | None = None
        if uv is not None:
            coordinates = floats(uv, "`uv`")
            if coordinates.shape == (count, 2):
                vertex["uv"] = coordinates
            elif coordinates.shape == (len(self._faces), 3, 2):
                corners = coordinates.reshape(-1, 6)
            else:
                raise InputError(
                    f"`uv` has the shape {coordinates.shape}; it should be ({count}, 2), or ({len(self._faces)}, 3, 2) "
                    f"for the corners of each face"
                )
        self._columns = (vertex, corners, face_columns)
        _check_columns("vertex", vertex, ("x", "y", "z"))
        _check_columns("face", face_columns, ("vertex_indices", "texcoord"))
        self._own_file()

    def _own_file(self) -> None:
        faces, vertices, columns = self._faces, self._vertices, self._columns
        self._file = _files.OwnedFile(self, "mesh", ".ply", lambda path: _write_ply(path, vertices, faces, *columns))

    @property
    def vertices(self) -> NDArray[np.float64]:
        """The places of its vertices in mm, of shape (n, 3)."""
        return self._vertices

    @property
    def faces(self) -> NDArray[np.int32]:
        """The vertices of its triangles, of shape (m, 3)."""
        return self._faces

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in vars(self).items() if key != "_file"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        for one in (self._vertices, self._faces):
            one.setflags(write=False)
        self._own_file()

    @classmethod
    def from_trimesh(cls, mesh: Any) -> Mesh:
        """Takes over a trimesh.Trimesh.

        Parameters
        ----------
        mesh : trimesh.Trimesh
            Its `units` count, mm where it has none. Texture coordinates are `uv`; colours of vertices are what fablets
            see as `color`, linear light.

        Returns
        -------
        Mesh
            A copy in millimetres.

        Raises
        ------
        InputError
            Where its unit is not known, or its arrays are no mesh.
        """
        return cls._of(_foreign.of_trimesh(mesh))

    @classmethod
    def _of(cls, found: _foreign.Arrays) -> Mesh:
        return cls(
            found.vertices, found.faces, normals=found.normals, uv=found.uv, vertex_attributes=found.vertex,
            face_attributes=found.face,
        )

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        path = self._file.path()
        allow.add(path.parent)
        return {"file": str(path), "unit": "mm"}

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.faces)} faces)"


class FileMesh:
    """A mesh file, and how to read it: see `meshes` of a world.

    Parameters
    ----------
    file : str or path
        OBJ, STL, PLY, 3MF or glTF. It is read when a print is set up.
    unit : str, optional
        What its lengths are: mm, cm, m, um or in. Else what the file says, or mm.
    up : str, optional
        The axis that points up in it, `z` or `y`.
    groups : mapping of str to int, optional
        Numbers for the groups of an OBJ file, which fablets see as an attribute.

    Raises
    ------
    InputError
        Where an argument is of no kind that a world takes.
    """

    def __init__(
        self, file: str | os.PathLike[str], *, unit: str | None = None, up: str | None = None,
        groups: Mapping[str, int] | None = None,
    ) -> None:
        self.file = Path(file).absolute()
        keys = {"unit": unit, "up": up, "groups": groups}
        self._keys = {key: plain(value, f"`{key}` of a mesh") for key, value in keys.items() if value is not None}

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        allow.add(self.file.parent)
        return {"file": str(self.file), **self._keys}

    def __repr__(self) -> str:
        return f"FileMesh({str(self.file)!r})"


class Primitive:
    """A shape that needs no file and stands on z = 0.

    See box, sphere, cylinder, plane, cone, torus, capsule, extrusion and revolution, which check sizes.

    Parameters
    ----------
    kind : str
        As a `.fab.json` calls it.
    size : Any
        As a `.fab.json` has it, in mm.
    """

    def __init__(self, kind: str, size: Any) -> None:
        self.kind = kind
        self.size = size

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        return {self.kind: self.size}

    def __repr__(self) -> str:
        return f"Primitive({self.kind!r}, {self.size!r})"


def _lengths(**lengths: Any) -> list[float]:
    return [positive(value, f"`{name}`") for name, value in lengths.items()]


def box(width: Real, depth: Real, height: Real) -> Primitive:
    """Makes a box.

    Its faces have the int attribute `face`: 0 +z, 1 -z, 2 -y, 3 +x, 4 +y, 5 -x.

    Parameters
    ----------
    width, depth, height : float
        Along x, y and z, in mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("box", _lengths(width=width, depth=depth, height=height))


def sphere(diameter: Real) -> Primitive:
    """Makes a sphere.

    Parameters
    ----------
    diameter : float
        In mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("sphere", positive(diameter, "`diameter`"))


def cylinder(diameter: Real, height: Real) -> Primitive:
    """Makes a cylinder; `face` is 0 on its top, 1 on its bottom and 2 around it.

    Parameters
    ----------
    diameter, height : float
        In mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("cylinder", _lengths(diameter=diameter, height=height))


def plane(width: Real, depth: Real) -> Primitive:
    """Makes a sheet closed by its own back, for displacement; `face` is 0 in front, 1 on the back.

    Parameters
    ----------
    width, depth : float
        Along x and y, in mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("plane", _lengths(width=width, depth=depth))


def cone(low_diameter: Real, high_diameter: Real, height: Real) -> Primitive:
    """Makes a cone, cut off or, with a diameter of 0, pointed; `face` is 0 on its top, 1 on its bottom and 2 around it.

    Parameters
    ----------
    low_diameter, high_diameter, height : float
        In mm; one of the diameters may be 0.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    low, high = positive(low_diameter, "`low_diameter`", 0), positive(high_diameter, "`high_diameter`", 0)
    if low == high == 0:
        raise InputError("`low_diameter` and `high_diameter` are 0 both; one of them is more")
    return Primitive("cone", [low, high, *_lengths(height=height)])


def torus(diameter: Real, section: Real) -> Primitive:
    """Makes a ring of round section.

    Parameters
    ----------
    diameter, section : float
        The diameters of its middle and of its section, in mm.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("torus", _lengths(diameter=diameter, section=section))


def capsule(diameter: Real, length: Real) -> Primitive:
    """Makes a cylinder along z with a half ball on each end.

    Parameters
    ----------
    diameter, length : float
        In mm; the length includes the ends.

    Returns
    -------
    Primitive
        It stands on z = 0, around the z axis.

    Raises
    ------
    InputError
        Where a size is no number, or not more than 0.
    """
    return Primitive("capsule", _lengths(diameter=diameter, length=length))


def _corners(polygon: Any) -> list[list[float]]:
    return [vector(corner, "a corner of a polygon", (2,)) for corner in polygon]


def extrusion(polygons: Sequence[Any], height: Real) -> Primitive:
    """Makes what an area sweeps from z = 0 up; `face` is 0 on the top, 1 on the bottom and 2 around.

    Parameters
    ----------
    polygons : sequence of array_like of float, shape (n, 2)
        The corners of each polygon in mm. One that lies within another bounds a hole.
    height : float
        In mm.

    Returns
    -------
    Primitive
        It stands on z = 0.

    Raises
    ------
    InputError
        Where a corner is no pair of numbers, or the height is not more than 0.
    """
    corners = [_corners(polygon) for polygon in polygons]
    return Primitive("extrusion", {"polygons": corners, "height": positive(height, "`height`")})


def revolution(polygon: Any) -> Primitive:
    """Makes what a polygon sweeps around the z axis, with 128 facets around.

    `face` is 0 where it faces straight up, 1 straight down and 2 elsewhere.

    Parameters
    ----------
    polygon : array_like of float, shape (n, 2)
        Corners as (distance from the axis, z), in mm.

    Returns
    -------
    Primitive
        It stands where the polygon says.

    Raises
    ------
    InputError
        Where a corner is no pair of numbers.
    """
    return Primitive("revolution", _corners(polygon))


class Shape:
    """A solid that is a function of a point: the @Shape stage of a fablet. `shape` makes one.

    Parameters
    ----------
    fablet : Fablet
        It has the stage.
    box : array_like of float, shape (2, 3)
        Two corners of a box that holds all of it, in mm, the lower first.
    uniforms : mapping of str to Any, optional
        Values for the stage where objects have another fablet; else the stage has those of the object.

    Raises
    ------
    InputError
        Where the box is none, or the fablet has no such stage or uniform.
    """

    def __init__(self, fablet: Fablet, box: ArrayLike, uniforms: Mapping[str, Any] | None = None) -> None:
        if not isinstance(fablet, Fablet):
            raise InputError(f"{short(fablet)} is no fablet")
        if not (fablet.has_shape or fablet.has_grow):
            raise InputError(f"fablet `{fablet.name}` has no @Shape or @Grow stage")
        corners = floats(box, "`box`", np.float64)
        if corners.shape != (2, 3):
            raise InputError(f"`box` has the shape {corners.shape}; it should be (2, 3), two corners")
        if not (corners[0] < corners[1]).all():
            raise InputError("`box` is empty; its lower corner comes first")
        unknown = [f"`{name}`" for name in uniforms or {} if name not in fablet.uniforms]
        if unknown:
            raise InputError(f"`{fablet.name}` has no uniform {', '.join(unknown)}")
        self.fablet = fablet
        self.box = corners
        self.uniforms = dict(uniforms or {})

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        # The name of its fablet is the world's to give.
        return {"box_mm": self.box.tolist()}

    def __repr__(self) -> str:
        return f"Shape({self.fablet!r}, {self.box.tolist()})"


def shape(
    source: Fablet | str | os.PathLike[str], box: ArrayLike, uniforms: Mapping[str, Any] | None = None,
) -> Shape:
    """Makes a solid of a fablet's @Shape stage, or of what its @Grow stage grows, which stands where a mesh does.

    Parameters
    ----------
    source : Fablet, str or path
        What has the stage; a text with a line break is OpenFL itself, any other is the name of a file.
    box : array_like of float, shape (2, 3)
        Two corners of a box that holds all of it, in mm, the lower first.
    uniforms : mapping of str to Any, optional
        Values for the stage where objects have another fablet; else the stage has those of the object.

    Returns
    -------
    Shape
        For `World.add`; with the same fablet, or with another that gives it materials.

    Raises
    ------
    CompileError
        Where the source is wrong.
    InputError
        Where the box is none, the file cannot be read, or the fablet has no such stage or uniform.
    """
    if not isinstance(source, Fablet):
        text = isinstance(source, str) and "\n" in source
        source = Fablet(text=source) if text else Fablet(source)  # type: ignore[arg-type]
    return Shape(source, box, uniforms)


AnyMesh = Mesh | FileMesh | Primitive | Shape | Beams | Generated


def as_mesh(value: Any) -> AnyMesh:
    """Returns what can stand for a mesh: a mesh, a file, or one of trimesh or pyvista."""
    if isinstance(value, (Mesh, FileMesh, Primitive, Shape, Beams, Generated)):
        return value
    if isinstance(value, Generator):
        raise InputError(f"`{value.__name__}` has no box; add `{value.__name__}.within(((x, y, z), (x, y, z)))`")
    if isinstance(value, (str, os.PathLike)):
        return FileMesh(value)
    found = _foreign.arrays_of(value)
    if found is not None:
        return Mesh._of(found)
    raise InputError(f"{short(value)} is no mesh; pass a Mesh, a file, a primitive, a shape, or a mesh of trimesh or pyvista")


def _attribute(name: str, element: str) -> str:
    """A name that fablets may declare, and that is no other argument's."""
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name, re.ASCII):
        raise InputError(
            f"a {element} attribute cannot be called {short(name)}; names are those of fablets: letters, digits and `_`"
        )
    other = {"n": "normals", "uv": "uv"}.get(name) if element == "vertex" else None
    if other is not None:
        raise InputError(f"a vertex attribute cannot be called `{name}`; pass `{other}`")
    return name


def _as_they_are(values: ArrayLike, what: str) -> NDArray[Any]:
    return floats(values, what) if array(values, what).dtype.kind == "f" else integers(values, what)


def _columns(
    what: str, convert: Callable[[ArrayLike, str], NDArray[Any]], values: ArrayLike, count: int, components: int = 0
) -> NDArray[Any]:
    """An attribute as [element][component]."""
    found = convert(values, what)
    columns = found[:, None] if found.ndim == 1 and components in (0, 1) else found
    widths = (components,) if components else (1, 2, 3, 4)
    if columns.ndim != 2 or len(columns) != count or columns.shape[1] not in widths:
        wanted = f"({count}, {components})" if components else f"({count},), or ({count}, 1 to 4)"
        raise InputError(f"{what} has the shape {found.shape}; it should be {wanted}")
    return columns


def _check_columns(element: str, attributes: Mapping[str, NDArray[Any]], taken: Sequence[str]) -> None:
    """Refuses attributes that a file would have under one name."""
    owners: dict[str, str] = {}
    for name, values in attributes.items():
        for column, _ in _properties(name, values):
            if column in taken:
                raise InputError(f"a {element} attribute cannot be called `{name}`, which is taken; rename it")
            if column in owners:
                raise InputError(f"the {element} attributes `{owners[column]}` and `{name}` are too alike; rename one")
            owners[column] = name


def _properties(name: str, array: NDArray[Any]) -> list[tuple[str, NDArray[Any]]]:
    """The columns of an attribute under the names that readers of PLY put together again."""
    known = {"n": ("nx", "ny", "nz"), "uv": ("u", "v")}
    count = array.shape[1]
    names = known.get(name, (name,) if count == 1 else tuple(f"{name}_{i}" for i in range(count)))
    return [(column, array[:, i]) for i, column in enumerate(names)]


# Names that readers of PLY take for the components of one vector, where they follow each other.
_COMPONENTS = ("u v", "s t", "texture_s texture_t", "nx ny nz", "r g b", "red green blue", "diffuse_red diffuse_green")
_SUFFIXES = ("xyzw", "0123", "rgba", "uv")


def _place_among(name: str) -> int:
    for family in map(str.split, _COMPONENTS):
        if name in family:
            return family.index(name)
    ends = [letters.index(name[-1]) for letters in _SUFFIXES if name[-2:-1] == "_" and name[-1] in letters]
    return ends[0] if ends else 0


def _in_order(attributes: Mapping[str, NDArray[Any]]) -> list[tuple[str, NDArray[Any]]]:
    """Attributes in an order in which no two form a vector: scalars first, of those the later parts in front."""
    return sorted(attributes.items(), key=lambda one: (one[1].shape[1] > 1, -_place_among(one[0])))


_Field = tuple[str, NDArray[Any]]
_List = tuple[str, str, NDArray[Any]]


def _write_ply(
    path: Path, vertices: NDArray[np.float64], faces: NDArray[np.int32], vertex: Mapping[str, NDArray[Any]],
    corners: NDArray[np.float32] | None, face: Mapping[str, NDArray[Any]],
) -> None:
    words = {"f": "float", "d": "double", "i": "int"}
    header = ["ply", "format binary_little_endian 1.0"]

    def element(name: str, count: int, fields: list[_Field], lists: list[_List]) -> bytes:
        header.append(f"element {name} {count}")
        kinds: list[Any] = []
        for list_name, kind, values in lists:
            header.append(f"property list uchar {words[kind]} {list_name}")
            kinds += [(f"{list_name} length", "u1"), (list_name, f"<{np.dtype(kind).str[1:]}", (values.shape[1],))]
        for field_name, values in fields:
            header.append(f"property {words[values.dtype.char]} {field_name}")
            kinds.append((field_name, values.dtype.newbyteorder("<")))
        table = np.zeros(count, np.dtype(kinds))
        for list_name, _, values in lists:
            table[f"{list_name} length"] = values.shape[1]
            table[list_name] = values
        for field_name, values in fields:
            table[field_name] = values
        return table.tobytes()

    fields = [(axis, vertices[:, i]) for i, axis in enumerate("xyz")]
    for name, array in _in_order(vertex):
        fields += _properties(name, array)
    body = element("vertex", len(vertices), fields, [])
    lists: list[_List] = [("vertex_indices", "i", faces)]
    if corners is not None:
        lists.append(("texcoord", "f", corners))
    fields = [column for name, array in _in_order(face) for column in _properties(name, array)]
    body += element("face", len(faces), fields, lists)
    path.write_bytes("\n".join([*header, "end_header", ""]).encode() + body)


class Texture:
    """A picture for a fablet's texture; `Texture.volume` makes one of a volume.

    Parameters
    ----------
    picture : str, path or array_like, shape (rows, columns) or (rows, columns, 1 to 4)
        A file, or an array, which is copied, the top row first: of 8 bits, which are sRGB unless `space` says otherwise, or
        of 16 bits or floats, which are light as they are. Of two or four integers the last is alpha.
    wrap : str or sequence of 2 str, optional
        `clamp`, `repeat`, `mirror` or `black`; one, or one along u and one along v.
    filter : str, optional
        `trilinear`, `anisotropic` or `nearest`.
    space : str, optional
        What its numbers are: `srgb`, `linear` or `data`; `auto` goes by the file.
    channels : str, optional
        `all`, `luminance` or `opaque`.

    Attributes
    ----------
    file : pathlib.Path or None
        The file; None of an array.

    Raises
    ------
    InputError
        Where the shape is another, a value is not finite, or a word is none of these.
    """

    def __init__(
        self, picture: str | os.PathLike[str] | ArrayLike, *, wrap: str | Sequence[str] = "repeat",
        filter: str = "anisotropic", space: str = "auto", channels: str = "all",
    ) -> None:
        keys = {"wrap": wrap, "filter": filter, "space": space, "channels": channels}
        self._keys: dict[str, Any] = plain(keys, "a texture")
        _check_choices(self._keys)
        self._array: NDArray[Any] | None = None
        if isinstance(picture, (str, os.PathLike)):
            self._own_file(Path(os.fsdecode(picture)).absolute(), "")
            return
        found = _texels(picture, "a picture")
        pixels = found[:, :, None] if found.ndim == 2 else found
        if pixels.ndim != 3 or not 1 <= pixels.shape[2] <= 4 or not pixels.size:
            raise InputError(f"a picture has the shape {found.shape}; it should be (rows, columns[, 1 to 4])")
        self._array = pixels
        self._own_file(None, ".tif" if pixels.dtype.kind == "f" else ".png")

    def _own_file(self, file: Path | None, suffix: str) -> None:
        self.file = file
        self._suffix = suffix
        self._file: _files.OwnedFile | None = None
        if (texels := self._array) is not None:
            stem, keys = "volume" if suffix == ".npy" else "picture", self._keys
            self._file = _files.OwnedFile(self, stem, suffix, lambda path: _write_texels(path, texels, keys))

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in vars(self).items() if key != "_file"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._own_file(self.file, self._suffix)

    @classmethod
    def volume(
        cls, volume: str | os.PathLike[str] | ArrayLike, *, origin: Sequence[Real] | None = None,
        spacing: Real | Sequence[Real] | None = None, field: str | None = None, unit: str | None = None,
        pitch: Real | None = None, outside: Real | None = None, wrap: str = "clamp", filter: str = "trilinear",
    ) -> Texture:
        """Makes a texture of a volume.

        Parameters
        ----------
        volume : str, path or array_like, shape (z, y, x) or (z, y, x, 1 to 4)
            A file, or an array, which is copied; its first value is at the lowest corner. Integers of 8 and 16 bits without a
            sign are parts of the largest, 0 to 1.
        origin : sequence of 3 floats, optional
            The lowest corner in part space, in mm; else what the file says, or 0.
        spacing : float or sequence of 3 floats, optional
            The size of a texel along x, y and z, in mm; else what the file says, or 1.
        field : str, optional
            Of a file with several fields, the name of the one that is read.
        unit : str, optional
            Of a file's lengths: mm, cm, m, um or in.
        pitch : float, optional
            How fine a file's cells are sampled, in mm.
        outside : float, optional
            The value where a file has none; of an array, where it has NaN.
        wrap : str, optional
            `clamp`, `repeat`, `mirror` or `black`.
        filter : str, optional
            `trilinear` or `nearest`.

        Returns
        -------
        Texture
            For uniforms that are an `ImageTexture3D`.

        Raises
        ------
        InputError
            Where the shape is another, a value is not finite and `outside` is not given, or a word is none of these.
        """
        if isinstance(volume, (str, os.PathLike)):
            self = cls(volume, wrap=wrap, filter=filter)
        else:
            given = {"field": field, "unit": unit, "pitch": pitch}
            wrong = [f"`{key}`" for key, value in given.items() if value is not None]
            if wrong:
                raise InputError(f"{', '.join(wrong)} of a volume: an array has none; files that hold fields do")
            self = cls.__new__(cls)
            self._keys = plain({"wrap": wrap, "filter": filter}, "a texture")
            _check_choices(self._keys)
            texels = _texels(volume, "a volume", None if outside is None else number(outside, "`outside`"))
            outside = None  # which is in the array by now
            if texels.ndim not in (3, 4) or not texels.size or texels.shape[3:] not in ((), (1,), (2,), (3,), (4,)):
                raise InputError(f"a volume has the shape {texels.shape}; it should be (z, y, x[, 1 to 4])")
            self._array = texels
            self._own_file(None, ".npy")
        if origin is not None:
            self._keys["origin_mm"] = vector(origin, "`origin`")
        if spacing is not None:
            one = [spacing] * 3 if not is_sequence(spacing) else spacing
            self._keys["spacing_mm"] = [positive(one, "`spacing`") for one in vector(one, "`spacing`")]
        if pitch is not None:
            self._keys["pitch_mm"] = positive(pitch, "`pitch`")
        if outside is not None:
            self._keys["outside"] = number(outside, "`outside`")
        texts = {"field": field, "unit": unit}
        self._keys.update({key: plain(value, f"`{key}`") for key, value in texts.items() if value is not None})
        return self

    def _spec(self, allow: set[Path]) -> dict[str, Any]:
        path = self._file.path() if self._file is not None else self.file
        assert path is not None
        allow.add(path.parent)
        return {"file": str(path), **self._keys}


_CHOICES = {
    "wrap": ("clamp", "repeat", "mirror", "black"),
    "filter": ("trilinear", "anisotropic", "nearest"),
    "space": ("auto", "srgb", "linear", "data"),
    "channels": ("all", "luminance", "opaque"),
}


def _check_choices(keys: Mapping[str, Any]) -> None:
    for key, value in keys.items():
        every = several(value, f"`{key}`", (1, 2), "one along u and one along v") if isinstance(value, list) else [value]
        for one in every:
            choice(one, f"`{key}` of a texture", _CHOICES[key])


def _texels(values: ArrayLike, what: str, outside: float | None = None) -> NDArray[Any]:
    """Of 8 or 16 bits, or of finite floats; what is no number is `outside`, if that is given."""
    given = array(values, what)
    if given.dtype in (np.uint8, np.uint16):
        return given
    if given.dtype.kind == "f" and np.isnan(given).any():
        if outside is None and what == "a volume":
            place = ", ".join(str(int(one)) for one in np.argwhere(np.isnan(given))[0])
            raise InputError(
                f"{what} has nan at [{place}]; its values should be finite, or `outside` says what they are where they are none"
            )
        given = np.where(np.isnan(given), np.nan if outside is None else outside, given)
    return floats(given, what)


def _write_texels(path: Path, texels: NDArray[Any], keys: Mapping[str, Any]) -> None:
    """Writes an array as a file that a world names, and what the first print would convert it to."""
    if path.suffix == ".npy":
        np.save(path, texels)
        _core.keep_volume(path, np.ascontiguousarray(texels), keys.get("origin_mm"), keys.get("spacing_mm"))
        return
    linear = texels.dtype.itemsize == 2
    data = _files.tiff(texels) if path.suffix == ".tif" else _files.png(texels, level=1, linear=linear)
    path.write_bytes(data)
    # One with alpha takes the converter.
    if texels.shape[2] in (1, 3) and keys["channels"] != "opaque":
        _core.keep_picture(path, np.ascontiguousarray(texels), keys["space"], keys["channels"] == "luminance")
