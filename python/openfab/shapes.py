# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes, and shapes defined by fablets."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _files, _foreign
from ._given import array, floats, integers, plain, short, vector
from ._keys import absolute, check_keys
from .errors import InputError, raise_error
from .fablet import Fablet
from .lattice import Beams
from .primitives import Primitive
from .procedural import Generated, Generator


class Mesh:
    """A closed triangle mesh, in millimetres, z up.

    The arrays are copied; those of the mesh are read-only, since prints read them at any time.

    Parameters
    ----------
    vertices : array_like of float, shape (n, 3)
        Positions in mm.
    faces : array_like of int, shape (m, 3)
        The vertices of each triangle, counter-clockwise seen from outside.
    normals : array_like of float, shape (n, 3), optional
        Normals of vertices; their length does not matter.
    uv : array_like of float, shape (n, 2) or (m, 3, 2), optional
        Texture coordinates of vertices, or of each corner of each face.
    vertex_attributes : mapping of str to array_like of float, shape (n,) or (n, 1 to 4), optional
        Attributes that fablets read under these names, interpolated between vertices.
    face_attributes : mapping of str to array_like of int or float, shape (m,) or (m, 1 to 4), optional
        Attributes that fablets read under these names, constant on each face.

    Raises
    ------
    InputError
        If an array has the wrong shape, a value is not finite, a face has an unknown vertex, or a name is invalid.
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
        """The positions of the vertices in mm, of shape (n, 3)."""
        return self._vertices

    @property
    def faces(self) -> NDArray[np.int32]:
        """The vertices of the triangles, of shape (m, 3)."""
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
        """Makes a mesh from a trimesh.Trimesh.

        Parameters
        ----------
        mesh : trimesh.Trimesh
            Its `units` apply, or mm if it has none. Fablets see texture coordinates as `uv`, and vertex colours as `color`
            in linear light.

        Returns
        -------
        Mesh
            A copy in millimetres.

        Raises
        ------
        InputError
            If its unit is unknown, or its arrays are not a mesh.
        """
        return cls._of(_foreign.of_trimesh(mesh))

    @classmethod
    def _of(cls, found: _foreign.Arrays) -> Mesh:
        return cls(
            found.vertices, found.faces, normals=found.normals, uv=found.uv, vertex_attributes=found.vertex,
            face_attributes=found.face,
        )

    def _spec(self) -> dict[str, Any]:
        path = self._file.path()
        return {"file": str(path), "unit": "mm"}

    def __repr__(self) -> str:
        return f"Mesh({len(self.vertices)} vertices, {len(self.faces)} faces)"


class FileMesh:
    """A mesh file, and how to read it, like `meshes` of a world.

    Parameters
    ----------
    file : str or path
        An OBJ, STL, PLY, 3MF or glTF file. It is read when a print is set up.
    unit : str, optional
        The unit of its lengths: mm, cm, m, um or in. Default: as given in the file, or mm.
    up : str, optional
        The axis that points up in the file, `z` or `y`.
    groups : mapping of str to int, optional
        Numbers for the groups of the file, which fablets see as an attribute.
    **keys
        Other keys of a mesh in a `.fab.json`, such as `body` or `groups_attribute`.

    Raises
    ------
    InputError
        If an argument has a type that a world does not accept.
    """

    def __init__(
        self, file: str | os.PathLike[str], *, unit: str | None = None, up: str | None = None,
        groups: Mapping[str, int] | None = None, **keys: Any,
    ) -> None:
        self.file = Path(file).absolute()
        check_keys(keys, "mesh", "a mesh", ("file",))
        given = {"unit": unit, "up": up, "groups": groups, **keys}
        described = {key: plain(value, f"`{key}` of a mesh") for key, value in given.items() if value is not None}
        self._keys = absolute({"meshes": {"": described}})["meshes"][""]

    def _spec(self) -> dict[str, Any]:
        return {"file": str(self.file), **self._keys}

    def __repr__(self) -> str:
        return f"FileMesh({str(self.file)!r})"


class Shape:
    """A solid that is a function of a point: the @Shape stage of a fablet. `shape` makes one.

    Parameters
    ----------
    fablet : Fablet
        The fablet with the stage.
    box : array_like of float, shape (2, 3)
        Two corners of a box that contains all of it, in mm, the lower corner first.
    uniforms : mapping of str to Any, optional
        Values for the stage if the object has another fablet; otherwise the stage uses those of the object.

    Raises
    ------
    InputError
        If the box is invalid, or the fablet has no such stage or uniform.
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

    def _spec(self) -> dict[str, Any]:
        # The world gives its fablet a name.
        return {"box_mm": self.box.tolist()}

    def __repr__(self) -> str:
        return f"Shape({self.fablet!r}, {self.box.tolist()})"


def shape(
    source: Fablet | str | os.PathLike[str], box: ArrayLike, uniforms: Mapping[str, Any] | None = None,
) -> Shape:
    """Makes a solid from the @Shape or @Grow stage of a fablet, which can be used as a mesh.

    Parameters
    ----------
    source : Fablet, str or path
        The fablet with the stage. A string with a line break or a brace is OpenFL source; any other is a file name.
    box : array_like of float, shape (2, 3)
        Two corners of a box that contains all of it, in mm, the lower corner first.
    uniforms : mapping of str to Any, optional
        Values for the stage if the object has another fablet; otherwise the stage uses those of the object.

    Returns
    -------
    Shape
        A solid for `World.add`, with the same fablet, or with another one that defines its materials.

    Raises
    ------
    CompileError
        If the source is wrong.
    InputError
        If the box is invalid, the file cannot be read, or the fablet has no such stage or uniform.
    """
    if not isinstance(source, Fablet):
        text = isinstance(source, str) and ("\n" in source or "{" in source)
        source = Fablet(text=source) if text else Fablet(source)  # type: ignore[arg-type]
    return Shape(source, box, uniforms)


AnyMesh = Mesh | FileMesh | Primitive | Shape | Beams | Generated


def as_mesh(value: Any) -> AnyMesh:
    """Returns a mesh for anything usable as one: a mesh, a file name, or a mesh of trimesh or pyvista."""
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


_UNITS_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 0.001, "in": 25.4}


def longest_side_mm(mesh: AnyMesh) -> float:
    """Returns the longest side of a mesh's box."""
    if isinstance(mesh, Mesh):
        corners = mesh.vertices[mesh.faces.ravel()]
        size = np.ptp(corners, axis=0) if len(corners) else np.zeros(3)
    elif isinstance(mesh, FileMesh):
        keys = mesh._keys
        found = _core.mesh_size(
            mesh.file, _UNITS_MM.get(keys.get("unit", "")), keys.get("up") == "y", str(keys.get("body", ""))
        )
        if isinstance(found, _core.Error):
            raise_error(found)
        size = np.array(found)
    else:
        raise InputError("`size_mm` is of meshes; other shapes are made in a size, or take a `scale`")
    longest = float(size.max())
    if not longest > 0:
        raise InputError("`size_mm`: the mesh has no size")
    return longest


def _attribute(name: str, element: str) -> str:
    """Returns a name that is valid in a fablet and not that of another argument."""
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
    """Returns an attribute as [element][component]."""
    found = convert(values, what)
    columns = found[:, None] if found.ndim == 1 and components in (0, 1) else found
    widths = (components,) if components else (1, 2, 3, 4)
    if columns.ndim != 2 or len(columns) != count or columns.shape[1] not in widths:
        wanted = f"({count}, {components})" if components else f"({count},), or ({count}, 1 to 4)"
        raise InputError(f"{what} has the shape {found.shape}; it should be {wanted}")
    return columns


def _check_columns(element: str, attributes: Mapping[str, NDArray[Any]], taken: Sequence[str]) -> None:
    """Refuses attributes that would have the same name in a file."""
    owners: dict[str, str] = {}
    for name, values in attributes.items():
        for column, _ in _properties(name, values):
            if column in taken:
                raise InputError(f"a {element} attribute cannot be called `{name}`, which is taken; rename it")
            if column in owners:
                raise InputError(f"the {element} attributes `{owners[column]}` and `{name}` are too alike; rename one")
            owners[column] = name


def _properties(name: str, array: NDArray[Any]) -> list[tuple[str, NDArray[Any]]]:
    """Returns the columns of an attribute, under names that PLY readers combine again."""
    known = {"n": ("nx", "ny", "nz"), "uv": ("u", "v")}
    count = array.shape[1]
    names = known.get(name, (name,) if count == 1 else tuple(f"{name}_{i}" for i in range(count)))
    return [(column, array[:, i]) for i, column in enumerate(names)]


# Names that PLY readers take for components of one vector if they follow each other.
_COMPONENTS = ("u v", "s t", "texture_s texture_t", "nx ny nz", "r g b", "red green blue", "diffuse_red diffuse_green")
_SUFFIXES = ("xyzw", "0123", "rgba", "uv")


def _place_among(name: str) -> int:
    for family in map(str.split, _COMPONENTS):
        if name in family:
            return family.index(name)
    ends = [letters.index(name[-1]) for letters in _SUFFIXES if name[-2:-1] == "_" and name[-1] in letters]
    return ends[0] if ends else 0


def _in_order(attributes: Mapping[str, NDArray[Any]]) -> list[tuple[str, NDArray[Any]]]:
    """Returns attributes in an order in which no two form a vector: scalars first, later components before earlier ones."""
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
