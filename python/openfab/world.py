# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Worlds: what is printed, of what, and where it stands; made in Python, or read from a `.fab.json`."""

from __future__ import annotations

import difflib
import json
import os
from collections.abc import Iterator, MutableMapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Mapping, Sequence, TypeVar

import numpy as np

from . import _core, _files
from .errors import InputError, raise_error
from .fablet import Fablet, Uniform, programs
from .shapes import AnyMesh, Texture, as_mesh

T = TypeVar("T")


@dataclass(frozen=True)
class Material:
    """A material of a print: its name, its colour in slices, and that with alpha in pictures."""

    name: str
    key: str
    preview: str | None = None
    density_g_cm3: float = 1.18
    channel: str | None = None

    def _spec(self) -> dict[str, Any]:
        spec = {"key": self.key, "preview": self.preview, "density_g_cm3": self.density_g_cm3, "channel": self.channel}
        return {key: value for key, value in spec.items() if value is not None}


VOID = "VOID"
"""The material of nothing, for uniforms."""


class Object(MutableMapping[str, Any]):
    """A mesh with a fablet; as a mapping, the uniforms that are bound.

    A uniform takes a number, a sequence of them, a Material or VOID, a Texture or an array of a picture, or an object
    whose distance the fablet asks.
    """

    def __init__(self, world: World, name: str, mesh: AnyMesh, fablet: Fablet, keys: dict[str, Any]) -> None:
        self._world = world
        self.name = name
        self.mesh = mesh
        self.fablet = fablet
        self._keys = keys
        self._uniforms: dict[str, Any] = {}

    def place(
        self, *, translate: Sequence[float] | None = None, rotate: Sequence[float] | None = None,
        scale: float | Sequence[float] | None = None, matrix: Any = None, uniforms: Mapping[str, Any] | None = None,
        **keys: Any,
    ) -> Object:
        """Places it once more; further keys are those of placements in a `.fab.json`."""
        spec: dict[str, Any] = {"object": self.name, **keys}
        if translate is not None:
            spec["translate_mm"] = [float(x) for x in translate]
        if rotate is not None:
            spec["rotate_deg"] = [float(x) for x in rotate]
        if scale is not None:
            spec["scale"] = np.asarray(scale, float).tolist()
        if matrix is not None:
            spec["matrix"] = np.asarray(matrix, float)[:3, :4].tolist()
        own = {name: self._checked(name, value) for name, value in (uniforms or {}).items()}
        self._world._placements.append((self, spec, own))
        return self

    def _checked(self, name: str, value: Any) -> Any:
        declared = self.fablet.uniforms.get(name)
        if declared is None:
            near = difflib.get_close_matches(name, self.fablet.uniforms, 1)
            hint = f"did you mean `{near[0]}`?" if near else f"it has {', '.join(self.fablet.uniforms) or 'none'}"
            raise InputError(f"`{self.fablet.name}` has no uniform `{name}`", help=hint)
        if declared.kind.startswith("texture") and not isinstance(value, (Texture, str)):
            if declared.array_length == 1:
                return _texture(declared, value)
            return [one if isinstance(one, (Texture, str)) else _texture(declared, one) for one in value]
        return value

    def __getitem__(self, name: str) -> Any:
        return self._uniforms[name]

    def __setitem__(self, name: str, value: Any) -> None:
        self._uniforms[name] = self._checked(name, value)

    def __delitem__(self, name: str) -> None:
        del self._uniforms[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._uniforms)

    def __len__(self) -> int:
        return len(self._uniforms)

    def __hash__(self) -> int:
        return id(self)

    def __eq__(self, other: object) -> bool:
        return self is other

    def __repr__(self) -> str:
        return f"Object({self.name!r}, {self.mesh!r}, {self.fablet!r})"


def _texture(declared: Uniform, array: Any) -> Texture:
    return Texture.volume(array) if declared.kind == "texture3d" else Texture(array)


class World:
    """What is printed.

    >>> world = World(printer="j750")
    >>> white, black = Material("white", "#ffffff"), Material("black", "#000000")
    >>> world.add(sphere(12), Fablet("ball.fl"), {"core": white, "shell": black, "skin": 0.5})   # doctest: +SKIP

    `keys` are further keys of a `.fab.json`: `tray`, `support`, `arrange`, `groups`, `dither`.
    """

    def __init__(self, *, printer: str | os.PathLike[str] | None = None, title: str = "world", **keys: Any) -> None:
        self.title = title
        self._printer = None if printer is None else os.fspath(printer)
        self._keys = keys
        self._objects: dict[str, Object] = {}
        self._placements: list[tuple[Object, dict[str, Any], dict[str, Any]]] = []
        self._file = _files.OwnedFile(self, title, _files.WORLD, lambda path: None)

    def add(
        self, mesh: Any, fablet: Fablet, uniforms: Mapping[str, Any] | None = None, *, name: str | None = None,
        place: bool = True, priority: int | None = None, max_displacement_mm: float | None = None,
        support: bool | None = None, repair: str | None = None, **placement: Any,
    ) -> Object:
        """Adds an object, and places it: `placement` as of Object.place; with `place=False` it does not."""
        name = name or f"{fablet.name.lower()}{len(self._objects) or ''}"
        if name in self._objects:
            raise InputError(f"the world has an object `{name}` already")
        keys = {
            "priority": priority, "max_displacement_mm": max_displacement_mm, "support": support, "repair": repair,
        }
        given = {key: value for key, value in keys.items() if value is not None}
        added = Object(self, name, as_mesh(mesh), fablet, given)
        added.update(uniforms or {})
        self._objects[name] = added
        if place:
            added.place(**placement)
        return added

    @property
    def objects(self) -> Mapping[str, Object]:
        """Its objects by name."""
        return dict(self._objects)

    def to_json(self) -> dict[str, Any]:
        """The world as a `.fab.json` says it; arrays are in temporary files that live as long as their owners."""
        return self._describe(set())

    def _describe(self, allow: set[Path]) -> dict[str, Any]:
        names = _Names()
        fablets = _Named[Fablet]()
        meshes = _Named[AnyMesh]()
        objects = {}
        for name, one in self._objects.items():
            objects[name] = {
                "mesh": meshes.name(one.mesh, "mesh"),
                "fablet": fablets.name(one.fablet, one.fablet.name),
                **one._keys,
                "uniforms": {key: names.encode(value) for key, value in one.items()},
            }
        build = []
        for _, spec, uniforms in self._placements:
            own = {key: names.encode(value) for key, value in uniforms.items()}
            build.append({**spec, "uniforms": own} if own else spec)
        sources = {name: fablet.source() for name, fablet in fablets.items()}
        allow.update(source.parent for source in sources.values())
        world: dict[str, Any] = {"openfab": 1}
        if self._printer is not None:
            world["printer"] = self._printer
        world.update(self._keys)
        dither = self._keys.get("dither")
        if isinstance(dither, dict) and isinstance(dither.get("source"), (str, os.PathLike)):
            source = Path(dither["source"]).absolute()
            world["dither"] = {**dither, "source": str(source)}
            allow.add(source.parent)
        world["fablets"] = {
            name: {"source": str(sources[name]), "fablet": fablet.name} for name, fablet in fablets.items()
        }
        world["materials"] = {name: material._spec() for name, material in names.materials.items()}
        world["textures"] = {name: texture._spec(allow) for name, texture in names.textures.items()}
        world["meshes"] = {name: mesh._spec(allow) for name, mesh in meshes.items()}
        world["objects"] = objects
        world["build"] = build
        return world

    def _write(self) -> tuple[Path, list[Path], list[str]]:
        """Writes it to a file; returns that, the fablets' sources, and options for what it may read."""
        allow: set[Path] = set()
        description = self._describe(allow)
        path = self._file.path()
        path.write_text(json.dumps(description, indent=1), encoding="utf-8")
        sources = list(dict.fromkeys(one.fablet.source() for one in self._objects.values()))
        return path, sources, [f"--allow={folder}" for folder in sorted(allow)]

    def _ready(self, enable_printf: bool) -> tuple[_core.Program, list[str]]:
        return _ready(self, enable_printf)

    def _repr_png_(self) -> bytes:
        from .display import world_png

        return world_png(self)

    def __repr__(self) -> str:
        return f"World({self.title!r}, {len(self._objects)} objects, {len(self._placements)} placements)"


class FileWorld:
    """A world in a `.fab.json` file, read anew by each print."""

    def __init__(self, file: str | os.PathLike[str], *, allow: Sequence[str | os.PathLike[str]] = ()) -> None:
        self.file = Path(file).absolute()
        self._allow = [os.fspath(folder) for folder in allow]
        self.to_json()

    def to_json(self) -> dict[str, Any]:
        """What the file says."""
        try:
            said = json.loads(self.file.read_text(encoding="utf-8"))
        except OSError as error:
            raise InputError(f"{self.file}: {error.strerror}") from error
        except ValueError as error:
            raise InputError(f"{self.file}: it is no JSON: {error}") from error
        if not isinstance(said, dict):
            raise InputError(f"{self.file}: a world is an object of JSON")
        return said

    def _write(self) -> tuple[Path, list[Path], list[str]]:
        """Returns the file, the fablets' sources, and options for what it may read."""
        fablets = self.to_json().get("fablets")
        try:
            sources = [self.file.parent / one["source"] for one in fablets.values()]  # type: ignore[union-attr]
        except (AttributeError, KeyError, TypeError):
            raise InputError(f"{self.file}: `fablets` does not say where their sources are") from None
        if not sources:
            raise InputError(f"{self.file}: the world has no fablets")
        return self.file, list(dict.fromkeys(sources)), [f"--allow={folder}" for folder in self._allow]

    def _ready(self, enable_printf: bool) -> tuple[_core.Program, list[str]]:
        return _ready(self, enable_printf)

    def _repr_png_(self) -> bytes:
        from .display import world_png

        return world_png(self)

    def __repr__(self) -> str:
        return f"FileWorld({str(self.file)!r})"


AnyWorld = World | FileWorld


def _ready(world: AnyWorld, enable_printf: bool) -> tuple[_core.Program, list[str]]:
    """A world's program, and the words that name it to a print."""
    file, sources, allowed = world._write()
    words = [str(file), *allowed]
    program, _ = programs.find(sources, enable_printf, dither_rule(words))
    return program, words


def dither_rule(words: list[str]) -> tuple[str, str] | None:
    """The file and the function of the dither rule that a world names; `words` name the world, and what it may read."""
    rule = _core.world_dither(words)
    if isinstance(rule, _core.Error):
        raise_error(rule)
    return rule


def load(file: str | os.PathLike[str], *, allow: Sequence[str | os.PathLike[str]] = ()) -> FileWorld:
    """Returns the world of a `.fab.json`; `allow` are folders that it may read besides its own."""
    return FileWorld(file, allow=allow)


class _Named(Generic[T]):
    """Names for things that have none, each thing once."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[str, T]] = {}

    def name(self, thing: T, wish: str) -> str:
        if id(thing) not in self._known:
            taken = {name for name, _ in self._known.values()}
            name, count = wish, 1
            while name in taken:
                count += 1
                name = f"{wish}{count}"
            self._known[id(thing)] = (name, thing)
        return self._known[id(thing)][0]

    def items(self) -> list[tuple[str, T]]:
        return list(self._known.values())


class _Names:
    """Collects the materials and textures that uniforms name."""

    def __init__(self) -> None:
        self.materials: dict[str, Material] = {}
        self.textures = _Named[Texture]()

    def encode(self, value: Any) -> Any:
        if isinstance(value, Material):
            if self.materials.setdefault(value.name, value) != value:
                raise InputError(f"two materials are called `{value.name}`")
            return value.name
        if isinstance(value, Texture):
            return self.textures.name(value, "texture")
        if isinstance(value, Object):
            return value.name
        return plain(value, self.encode)


def plain(value: Any, encode: Any = None) -> Any:
    """Returns a value of a uniform as JSON has it."""
    if isinstance(value, (bool, str)):
        return value
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value)
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [(encode or plain)(one) for one in value]
    raise InputError(f"{value!r} is no value of a uniform")
