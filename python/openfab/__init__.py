# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""OpenFab: programmable, voxel-level multi-material 3D printing.

A fablet defines the material of each voxel (Fablet, compile). A world lists the parts and their places (World, load).
print_world yields slices, sample evaluates mixtures in any box at any pitch, and preview draws pictures.
"""

from __future__ import annotations

from importlib.metadata import version as _version
from pathlib import Path as _Path

from . import _core, display, procedural
from ._objects import Object
from ._printers import Printer, printers
from .errors import (
    CompileError,
    CompilerWarning,
    Diagnostic,
    Edit,
    Error,
    InputError,
    InternalError,
    Note,
    OutsideError,
    Place,
    PrintWarning,
)
from .estimating import Estimate, MaterialEstimate, estimate
from .fablet import Fablet, Uniform, Varying, compile
from .fitting import Fit, FitGoal, fit
from .lattice import Beams, beams
from .materials import VOID, Material
from .previewing import preview
from .primitives import Primitive, box, capsule, cone, cylinder, extrusion, plane, revolution, sphere, torus
from .printing import Print, print_world
from .reading import VoxelBox, Voxels, read
from .sampling import PointSamples, Samples, sample, sample_at
from .shapes import FileMesh, Mesh, Shape, shape
from .slices import PrintInfo, PrintMaterial, Slice
from .textures import Texture
from .world import FileWorld, World, load

__version__ = _version("openfab")

_core.set_line_opener(procedural._open)
display.show_in_notebooks()
_core.set_converter(_Path(_core.__file__).parent / "bin" / "openfab-texture")

__all__ = [
    "VOID",
    "Beams",
    "CompileError",
    "CompilerWarning",
    "Diagnostic",
    "Edit",
    "Error",
    "Estimate",
    "Fablet",
    "FileMesh",
    "FileWorld",
    "Fit",
    "FitGoal",
    "InputError",
    "InternalError",
    "Material",
    "MaterialEstimate",
    "Mesh",
    "Note",
    "Object",
    "OutsideError",
    "Place",
    "PointSamples",
    "Primitive",
    "Print",
    "PrintInfo",
    "PrintMaterial",
    "PrintWarning",
    "Printer",
    "Samples",
    "Shape",
    "Slice",
    "Texture",
    "Uniform",
    "Varying",
    "VoxelBox",
    "Voxels",
    "World",
    "beams",
    "box",
    "capsule",
    "compile",
    "cone",
    "cylinder",
    "estimate",
    "extrusion",
    "fit",
    "load",
    "plane",
    "preview",
    "print_world",
    "printers",
    "procedural",
    "read",
    "revolution",
    "sample",
    "sample_at",
    "shape",
    "sphere",
    "torus",
]
