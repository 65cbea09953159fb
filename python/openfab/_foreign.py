# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Meshes of other libraries: trimesh and its scenes, and pyvista. Their attributes identify them, without an import."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._given import short
from .errors import InputError, PrintWarning

_UNITS_MM = {
    "": 1.0, "none": 1.0, "mm": 1.0, "millimeter": 1.0, "millimeters": 1.0, "millimetre": 1.0, "millimetres": 1.0, "cm": 10.0,
    "centimeter": 10.0, "centimeters": 10.0, "m": 1000.0, "meter": 1000.0, "meters": 1000.0, "um": 0.001, "micron": 0.001,
    "microns": 0.001, "micrometers": 0.001, "in": 25.4, "inch": 25.4, "inches": 25.4, "ft": 304.8, "feet": 304.8,
}


@dataclass
class Arrays:
    """The arrays of a Mesh, in millimetres."""

    vertices: NDArray[Any]
    faces: NDArray[Any]
    normals: NDArray[Any] | None = None
    uv: NDArray[Any] | None = None
    vertex: dict[str, NDArray[Any]] = field(default_factory=dict)
    face: dict[str, NDArray[Any]] = field(default_factory=dict)


def arrays_of(value: Any) -> Arrays | None:
    """Returns the arrays of another library's mesh, or None if its type is unknown."""
    if hasattr(value, "geometry") and hasattr(value, "graph"):
        return _of_scene(value)
    if hasattr(value, "vertices") and hasattr(value, "faces"):
        return of_trimesh(value)
    if hasattr(value, "points") and hasattr(value, "cell_data") or hasattr(value, "n_blocks"):
        return _of_pyvista(value)
    return None


def of_trimesh(mesh: Any) -> Arrays:
    """Returns vertices, faces, texture coordinates and vertex colours; the colours are converted to linear light."""
    visual: Any = getattr(mesh, "visual", None)
    uv = getattr(visual, "uv", None)
    attributes = {}
    if getattr(visual, "kind", None) == "vertex":
        srgb = np.asarray(visual.vertex_colors, np.float64)[:, :3] / 255
        attributes["color"] = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    return Arrays(np.asarray(mesh.vertices) * _unit_mm(mesh), np.asarray(mesh.faces), uv=uv, vertex=attributes)


def _unit_mm(thing: Any) -> float:
    try:
        unit = getattr(thing, "units", None)
    except ValueError:  # a scene whose parts disagree
        raise InputError(f"the parts of {short(thing)} have several units; call its `convert_units`") from None
    if unit is None:
        return 1.0
    found = _UNITS_MM.get(str(unit).lower().strip())
    if found is None:
        raise InputError(f"the unit {short(unit)} of {short(thing)} is not known", help="scale it to mm, and set `units` to mm")
    return found


def _of_scene(scene: Any) -> Arrays:
    """Returns all bodies of a scene in their places; the face attribute `part` numbers them in the order of the nodes."""
    parts = []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not hasattr(mesh, "faces"):
            raise InputError(f"`{name}` of the scene is no mesh but {short(mesh)}", help="take it out: `scene.delete_geometry`")
        placed = mesh.copy()
        placed.apply_transform(transform)
        parts.append(of_trimesh(placed))
    if not parts:
        raise InputError("the scene has no mesh")
    for count, part in enumerate(parts):
        part.face["part"] = np.full(len(part.faces), count, np.int32)
    return _merged(parts)


def _merged(parts: list[Arrays]) -> Arrays:
    offsets = np.cumsum([0, *(len(part.vertices) for part in parts)])
    merged = Arrays(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + offset for part, offset in zip(parts, offsets)]),
    )
    if any(part.uv is not None for part in parts):
        _tell_missing("texture coordinates, which are 0 there", [part.uv for part in parts])
        merged.uv = np.concatenate([np.zeros((len(p.vertices), 2)) if p.uv is None else p.uv for p in parts])
    if any("color" in part.vertex for part in parts):
        _tell_missing("colours of vertices, which are white there", [part.vertex.get("color") for part in parts])
        merged.vertex["color"] = np.concatenate([p.vertex.get("color", np.ones((len(p.vertices), 3))) for p in parts])
    merged.face["part"] = np.concatenate([part.face["part"] for part in parts])
    return merged


def _tell_missing(what: str, found: list[Any]) -> None:
    missing = [str(count) for count, one in enumerate(found) if one is None]
    if missing:
        warnings.warn(f"part {', '.join(missing)} of the scene has no {what}", PrintWarning, stacklevel=6)


def _of_pyvista(data: Any) -> Arrays:
    """Returns the triangles of a data set's surface, and all numeric arrays of its points and cells."""
    if hasattr(data, "n_blocks"):
        data = data.combine()
    if not hasattr(data, "faces"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of keywords that versions do not share
            data = data.extract_surface()
    if getattr(data, "n_verts", 0) or getattr(data, "n_lines", 0):
        raise InputError(f"{short(data)} has points or lines besides faces", help="`extract_surface` or `clean` leaves faces")
    if not data.is_all_triangles:
        data = data.triangulate()
    made = Arrays(np.asarray(data.points, np.float64), np.asarray(data.faces).reshape(-1, 4)[:, 1:])
    coordinates = data.point_data.active_texture_coordinates
    made.uv = None if coordinates is None else np.asarray(coordinates)[:, :2]
    names = {str(data.point_data.active_texture_coordinates_name): "", "Normals": "normals"}
    for name, values in dict(data.point_data).items():
        if names.get(name) == "normals":
            made.normals = np.asarray(values)
        elif name not in names:
            _take(made.vertex, name, values, "points")
    for name, values in dict(data.cell_data).items():
        if name != "Normals":
            _take(made.face, name, values, "cells")
    return made


def _take(columns: dict[str, NDArray[Any]], name: str, values: Any, of: str) -> None:
    """Adds an array under a name that is valid in a fablet; warns if the array is unsuitable."""
    if name.startswith("vtkOriginal"):  # what VTK notes for itself
        return
    found = np.asarray(values)
    if found.dtype.kind not in "biuf" or found.ndim > 2 or found.ndim == 2 and not 1 <= found.shape[1] <= 4:
        warnings.warn(
            f"the array `{name}` of {of} is left out: {short(found)} is none of 1 to 4 numbers", PrintWarning, stacklevel=6
        )
        return
    known = re.sub("[^A-Za-z0-9_]", "_", name)
    known = known if re.match("[A-Za-z_]", known) else f"_{known}"
    if known in columns:
        raise InputError(f"two arrays of {of} would be called `{known}`; rename `{name}`")
    columns[known] = found
