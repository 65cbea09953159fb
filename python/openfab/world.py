# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Worlds: what is printed, of what, and where it stands; made in Python, or read from a `.fab.json`."""

from __future__ import annotations

import difflib
import json
import os
import re
from collections.abc import Iterable, Iterator, MutableMapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, Mapping, Sequence, TypeVar

import numpy as np

from . import _core, _files
from ._bound import check_bound
from ._given import Real, Whole, array, choice, is_sequence, number, plain, positive, several, short, vector, whole
from .errors import InputError, raise_error
from .fablet import Fablet, Uniform, programs
from .lattice import Beams
from .procedural import Generated
from .shapes import AnyMesh, Mesh, Shape, as_mesh
from .textures import Texture

T = TypeVar("T")


@dataclass(frozen=True)
class Material:
    """A material of a print.

    Attributes
    ----------
    name : str
        What the world calls it.
    key : str
        Its colour in slices, `#rrggbb`.
    preview : str or None
        Its colour in pictures, `#rrggbb` or `#rrggbbaa`; the key where it is not given.
    density_g_cm3 : float
        In g/cm³, for estimates.
    channel : str or None
        The printer's name for it.

    Raises
    ------
    InputError
        Where a colour is written otherwise, or the density is not more than 0.
    """

    name: str
    key: str
    preview: str | None = None
    density_g_cm3: float = 1.18
    channel: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(f"a material cannot be called {short(self.name)}; its name is a text")
        what = f"of material `{self.name}`"
        for key, value, form in (("key", self.key, _OPAQUE), ("preview", self.preview, _COLOR)):
            if value is None and key == "preview":
                continue
            if not isinstance(value, str) or not re.fullmatch(form, value):
                known = "#rrggbb or #rrggbbaa" if form is _COLOR else "#rrggbb, which is opaque"
                raise InputError(f"`{key}` {what} cannot be {short(value)}; write it as {known}")
        positive(self.density_g_cm3, f"`density_g_cm3` {what}")

    def _spec(self) -> dict[str, Any]:
        spec = {"key": self.key, "preview": self.preview, "density_g_cm3": self.density_g_cm3, "channel": self.channel}
        given = {key: value for key, value in spec.items() if value is not None}
        described: dict[str, Any] = plain(given, f"material `{self.name}`")
        return described


_OPAQUE, _COLOR = "#[0-9a-fA-F]{6}", "#[0-9a-fA-F]{6}([0-9a-fA-F]{2})?"

VOID = "VOID"
"""The material of nothing, for uniforms."""


class Object(MutableMapping[str, Any]):
    """A mesh with a fablet; as a mapping, the uniforms that are bound. `World.add` makes it.

    A uniform takes a number, a sequence of them, a Material or VOID, a Texture or an array of a picture, or an object
    whose distance the fablet asks. InputError is raised where one is set to what its type, its length or its limits refuse.

    Attributes
    ----------
    name : str
        What the world calls it.
    mesh : Mesh, FileMesh, Primitive or Shape
        Its shape.
    fablet : Fablet
        What it is made by.
    """

    def __init__(self, world: World, name: str, mesh: AnyMesh, fablet: Fablet, keys: dict[str, Any]) -> None:
        self._world = world
        self.name = name
        self.mesh = mesh
        self.fablet = fablet
        self._keys = keys
        self._uniforms: dict[str, Any] = {}

    def place(
        self, *, translate: Sequence[Real] | None = None, rotate: Sequence[Real] | None = None,
        scale: Real | Sequence[Real] | None = None, matrix: Any = None, uniforms: Mapping[str, Any] | None = None,
        **keys: Any,
    ) -> Object:
        """Places it once more.

        Parameters
        ----------
        translate : sequence of 2 or 3 floats, optional
            Along x, y and z, in mm.
        rotate : sequence of 3 floats, optional
            About x, then y, then z, in degrees.
        scale : float or sequence of 3 floats, optional
            A factor, or one along x, y and z.
        matrix : array_like of float, shape (3, 4) or (4, 4), optional
            Instead of these; the last of 4 rows is (0, 0, 0, 1). Lengths are in mm.
        uniforms : mapping of str to Any, optional
            Those of this copy.
        **keys
            Further keys of placements in a `.fab.json`, as `grid`, `transforms`, `on_bed`.

        Returns
        -------
        Object
            Itself.

        Raises
        ------
        InputError
            Where a value or a key is none, or the object was removed.
        """
        placed = self._placement(
            translate=translate, rotate=rotate, scale=scale, matrix=matrix, uniforms=uniforms, **keys
        )
        with _files.lock:
            if self._world._objects.get(self.name) is not self:
                raise InputError(f"the world has no object `{self.name}` any more; add it again")
            self._world._placements.append(placed)
        return self

    def _placement(
        self, *, translate: Any = None, rotate: Any = None, scale: Any = None, matrix: Any = None,
        uniforms: Mapping[str, Any] | None = None, **keys: Any,
    ) -> Placement:
        spec: dict[str, Any] = {"object": self.name}
        _check_keys(keys, "placement", "a placement", ("object", "group", "uniforms"))
        spec.update({key: plain(value, f"`{key}` of a placement") for key, value in keys.items()})
        if translate is not None:
            spec["translate_mm"] = vector(translate, "`translate`", (2, 3))
        if rotate is not None:
            spec["rotate_deg"] = vector(rotate, "`rotate`")
        if scale is not None:
            spec["scale"] = vector(scale, "`scale`") if is_sequence(scale) else number(scale, "`scale`")
        if matrix is not None:
            spec["matrix"] = _matrix(matrix)
        own = {name: self._checked(name, value) for name, value in (uniforms or {}).items()}
        return Placement(self, spec, own)

    def _checked(self, name: str, value: Any) -> Any:
        declared = self.fablet.uniforms.get(name)
        if declared is None:
            near = difflib.get_close_matches(name, self.fablet.uniforms, 1)
            hint = f"did you mean `{near[0]}`?" if near else f"it has {', '.join(self.fablet.uniforms) or 'none'}"
            raise InputError(f"`{self.fablet.name}` has no uniform `{name}`", help=hint)
        if declared.kind.startswith("texture") and not isinstance(value, (Texture, str)):
            if declared.array_length == 1:
                return _texture(declared, value)
            every = several(value, f"`{name}`", (declared.array_length,), f"{declared.array_length} textures")
            return [_checked_texture(declared, one) for one in every]
        if isinstance(value, Texture):
            _checked_texture(declared, value)
        encoded = _Names().encode(value, f"`{name}`")  # which raises what is wrong with it
        check_bound(declared, value, encoded)
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


def _check_keys(given: Iterable[str], kind: str, what: str, own: Sequence[str]) -> None:
    """Refuses keys that a `.fab.json` has not, and those that have arguments of their own."""
    known = [key for key in _core.world_keys(kind) if key not in own]
    for key in given:
        choice(key, f"a key of {what}", known)


def _texture(declared: Uniform, array: Any) -> Texture:
    return Texture.volume(array) if declared.kind == "texture3d" else Texture(array)


def _checked_texture(declared: Uniform, value: Any) -> Any:
    if not isinstance(value, (Texture, str)):
        return _texture(declared, value)
    if isinstance(value, Texture) and value._array is not None:
        is_volume = value._suffix == ".npy"
        if declared.kind.startswith("texture") and is_volume != (declared.kind == "texture3d"):
            made = ("a picture", "a volume")[is_volume]
            raise InputError(f"`{declared.name}` cannot be {made}; it is a `{declared.type}`")
    return value


def _matrix(given: Any) -> list[list[float]]:
    found = plain(array(given, "`matrix`"), "`matrix`")
    shape = np.shape(found)
    if shape not in ((3, 4), (4, 4)):
        raise InputError(f"`matrix` has the shape {shape}; it should be (3, 4), or (4, 4)")
    if found[3:] not in ([], [[0, 0, 0, 1]]):
        raise InputError(f"the last row of `matrix` is {found[3]}; it should be [0, 0, 0, 1], of no projection")
    rows: list[list[float]] = found[:3]
    return rows


@dataclass(frozen=True, eq=False)
class Placement:
    """Where an object stands: what a `.fab.json` says of it, and the uniforms of this copy."""

    object: Object
    spec: dict[str, Any]
    uniforms: dict[str, Any]


class World:
    """What is printed.

    Parameters
    ----------
    printer : str or path, optional
        The name of a printer, or its file.
    title : str, optional
        What the print is called.
    **keys
        Further keys of a `.fab.json`: `tray`, `support`, `arrange`, `groups`, `dither`.

    Attributes
    ----------
    title : str
        As above.

    Raises
    ------
    InputError
        Where a key is none, or its value of no kind that a world takes.

    Examples
    --------
    >>> world = World(printer="j750")
    >>> white, black = Material("white", "#ffffff"), Material("black", "#000000")
    >>> world.add(sphere(12), Fablet("ball.fl"), {"core": white, "shell": black, "skin": 0.5})   # doctest: +SKIP
    """

    def __init__(self, *, printer: str | os.PathLike[str] | None = None, title: str = "world", **keys: Any) -> None:
        self.title = title
        self._printer = None if printer is None else os.fsdecode(printer)
        _check_keys(keys, "world", "a world", ("openfab", "fablets", "materials", "textures", "meshes", "objects", "build"))
        self._keys = {key: plain(value, f"`{key}` of a world") for key, value in keys.items() if value is not None}
        self._objects: dict[str, Object] = {}
        self._placements: list[Placement] = []
        # Of the last print, whose errors name its file.
        self._last: Snapshot | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_last": None}

    def add(
        self, mesh: Any, fablet: Fablet, uniforms: Mapping[str, Any] | None = None, *, name: str | None = None,
        place: bool = True, priority: Whole | None = None, max_displacement_mm: Real | None = None,
        support: bool | None = None, repair: str | None = None, **placement: Any,
    ) -> Object:
        """Adds an object, and places it.

        Parameters
        ----------
        mesh : Mesh, FileMesh, Primitive, Shape, str, path, or a mesh of trimesh or pyvista
            Its shape; a text is the name of a file.
        fablet : Fablet
            What it is made by.
        uniforms : mapping of str to Any, optional
            What the fablet takes; more can be set later.
        name : str, optional
            What it is called; else as its fablet.
        place : bool, optional
            Whether it is placed; else `Object.place` does.
        priority : int, optional
            Where objects meet, the higher one is printed.
        max_displacement_mm : float, optional
            How far its surface may be displaced, in mm.
        support : bool, optional
            Whether it is held by support material.
        repair : str, optional
            `winding` closes and turns a mesh that needs it.
        **placement
            As of `Object.place`.

        Returns
        -------
        Object
            It is in the world.

        Raises
        ------
        InputError
            Where a value is none, or the name is taken; then nothing is in the world.
        """
        keys = {
            "priority": None if priority is None else whole(priority, "`priority`"),
            "max_displacement_mm": (
                None if max_displacement_mm is None else number(max_displacement_mm, "`max_displacement_mm`")
            ),
            "support": support, "repair": repair,
        }
        given = {key: plain(value, f"`{key}`") for key, value in keys.items() if value is not None}
        with _files.lock:
            if name is None:
                name, count = fablet.name.lower(), len(self._objects)
                while name in self._objects:
                    name, count = f"{fablet.name.lower()}{count}", count + 1
            if name in self._objects:
                raise InputError(f"the world has an object `{name}` already")
            added = Object(self, name, as_mesh(mesh), fablet, given)
            added.update(uniforms or {})
            placed = [added._placement(**placement)] if place else []
            # Of what is wrong, nothing is in the world.
            self._objects[name] = added
            self._placements += placed
        return added

    def remove(self, name: str) -> None:
        """Takes an object out, with its placements.

        Parameters
        ----------
        name : str
            What it is called.

        Raises
        ------
        InputError
            Where the world has none of that name.
        """
        with _files.lock:
            if name not in self._objects:
                raise InputError(f"the world has no object `{name}`; it has {', '.join(self._objects) or 'none'}")
            removed = self._objects.pop(name)
            self._placements = [one for one in self._placements if one.object is not removed]

    @property
    def objects(self) -> Mapping[str, Object]:
        """Its objects by name."""
        return dict(self._objects)

    def to_json(self) -> dict[str, Any]:
        """Returns the world as a `.fab.json` says it.

        Returns
        -------
        dict
            Arrays are in temporary files, which live as long as their owners.
        """
        with _files.lock:
            return self._describe(_Names(), set(), {})[0]

    def _describe(
        self, names: _Names, allow: set[Path], uniforms: Mapping[str, Any]
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Returns what a `.fab.json` says, and other values of some uniforms, whose materials and textures it has."""
        fablets = _Named[Fablet | Shape]()
        same: dict[tuple[Path, str], Fablet] = {}

        def first(fablet: Fablet) -> Fablet:
            # A text that is given twice is one fablet: a shape has the uniforms of objects with it.
            return same.setdefault((fablet.source(), fablet.name), fablet)

        objects = {}
        for name, one in self._objects.items():
            objects[name] = {
                "mesh": names.meshes.name(one.mesh, name),
                "fablet": fablets.name(first(one.fablet), one.fablet.name),
                **one._keys,
                "uniforms": names.encode_all(one._uniforms),
            }
        build = []
        for placement in self._placements:
            own = names.encode_all(placement.uniforms)
            build.append({**placement.spec, "uniforms": own} if own else placement.spec)
        settings = {target: self._setting(target, value, names) for target, value in uniforms.items()}
        meshes = {name: mesh._spec(allow) for name, mesh in names.meshes.items()}
        for name, mesh in names.meshes.items():
            if isinstance(mesh, Shape):
                # With values of its own the stage is another than that of objects with the same fablet.
                stage: Fablet | Shape = mesh if mesh.uniforms else first(mesh.fablet)
                key = "grow" if mesh.fablet.has_grow else "shape"
                meshes[name] = {key: fablets.name(stage, mesh.fablet.name), **meshes[name]}
        described: dict[str, dict[str, Any]] = {}
        for name, one_of in fablets.items():
            fablet = one_of.fablet if isinstance(one_of, Shape) else one_of
            source = fablet.source()
            allow.add(source.parent)
            described[name] = {"source": str(source), "fablet": fablet.name}
            if isinstance(one_of, Shape):
                described[name]["uniforms"] = names.encode_all(one_of.uniforms)
        world: dict[str, Any] = {"openfab": 1}
        if self._printer is not None:
            world["printer"] = self._printer
        world.update(self._keys)
        dither = self._keys.get("dither")
        if isinstance(dither, dict) and isinstance(dither.get("source"), str):
            source = Path(dither["source"]).absolute()
            world["dither"] = {**dither, "source": str(source)}
            allow.add(source.parent)
        world["fablets"] = described
        world["materials"] = {name: material._spec() for name, material in names.materials.items()}
        world["textures"] = {name: texture._spec(allow) for name, texture in names.textures.items()}
        world["meshes"] = meshes
        world["objects"] = objects
        world["build"] = build
        return world, settings

    def _snapshot(self, uniforms: Mapping[str, Any] | None = None) -> Snapshot:
        """Writes it for one print, with other values of some uniforms."""
        names, allow = _Names(), set[Path]()
        with _files.lock:
            description, settings = self._describe(names, allow, uniforms or {})
            shapes = [mesh.fablet for _, mesh in names.meshes.items() if isinstance(mesh, Shape)]
            fablets = [*(one.fablet for one in self._objects.values()), *shapes]
            sources = dict.fromkeys(fablet.source() for fablet in fablets)
            generates = any(isinstance(mesh, Generated) for _, mesh in names.meshes.items())
        path = _files.unique(self.title, _files.WORLD)
        with _files.outside_errors(f"`{path}` cannot be written"):
            path.write_text(json.dumps(description, indent=1, allow_nan=False), encoding="utf-8")
        made = Snapshot(
            path, tuple(sources), _allowed(sorted(allow), generates), _set_words(settings), description,
            {
                str(thing._file.path()): f"the arrays of {kind} `{name}`"
                for kind, named in (("mesh", names.meshes), ("texture", names.textures))
                for name, thing in named.items()
                if isinstance(thing, (Beams, Mesh, Texture)) and thing._file is not None
            },
            (names.meshes, names.textures),
        )
        _files.remove_with(made, path)
        self._last = made
        return made

    def _setting(self, target: str, value: Any, names: _Names) -> Any:
        name, _, uniform = target.rpartition(".")
        one = self._objects.get(name)
        if one is not None:
            value = one._checked(uniform, value)
        return names.encode(value, f"`{target}`")

    def _repr_png_(self) -> bytes:
        from .display import world_png

        return world_png(self)

    def __repr__(self) -> str:
        return f"World({self.title!r}, {len(self._objects)} objects, {len(self._placements)} placements)"


class FileWorld:
    """A world in a `.fab.json` file, read anew by each print; `load` makes it.

    Parameters
    ----------
    file : str or path
        The `.fab.json`.
    allow : sequence of str or path, optional
        Folders that it may read besides its own.
    allow_programs : bool, optional
        Whether the programs that it names may run: never those of a stranger's world.

    Attributes
    ----------
    file : pathlib.Path
        As above.

    Raises
    ------
    InputError
        Where the file cannot be read, or is no object of JSON.
    """

    def __init__(
        self, file: str | os.PathLike[str], *, allow: Sequence[str | os.PathLike[str]] = (), allow_programs: bool = False,
    ) -> None:
        self.file = Path(file).absolute()
        self._allow = [os.fspath(folder) for folder in allow]
        self._programs = bool(allow_programs)
        self.to_json()

    def to_json(self) -> dict[str, Any]:
        """Returns what the file says.

        Returns
        -------
        dict
            The world as it is in the file.

        Raises
        ------
        InputError
            Where the file cannot be read, or is no object of JSON.
        """
        try:
            said = json.loads(self.file.read_text(encoding="utf-8"))
        except OSError as error:
            raise InputError(f"{self.file}: {error.strerror}", file=str(self.file)) from error
        except json.JSONDecodeError as error:
            raise InputError(
                f"{self.file}:{error.lineno}:{error.colno}: it is no JSON: {error.msg}",
                message=f"it is no JSON: {error.msg}", file=str(self.file), line=error.lineno, column=error.colno,
            ) from error
        except UnicodeDecodeError as error:
            raise InputError(f"{self.file}: it is no UTF-8: {error}", file=str(self.file)) from error
        if not isinstance(said, dict):
            raise InputError(f"{self.file}: a world is an object of JSON", file=str(self.file))
        return said

    def _snapshot(self, uniforms: Mapping[str, Any] | None = None) -> Snapshot:
        """Its file, which is the user's, with other values of some uniforms."""
        names = _Names()
        settings = {target: names.encode(value, f"`{target}`") for target, value in (uniforms or {}).items()}
        if names.textures.items():
            raise InputError(
                "textures of Python do not reach a world that was loaded",
                help=f"put the picture into a file, which {self.file.name} names in `textures`, and give that name",
            )
        description = self.to_json()
        fablets = description.get("fablets")
        try:
            sources = [self.file.parent / one["source"] for one in fablets.values()]  # type: ignore[union-attr]
        except (AttributeError, KeyError, TypeError):
            raise InputError(
                f"{self.file}: `fablets` does not say where their sources are", file=str(self.file)
            ) from None
        if not sources:
            raise InputError(f"{self.file}: the world has no fablets", file=str(self.file))
        return Snapshot(
            self.file, tuple(dict.fromkeys(sources)), _allowed(self._allow, self._programs), _set_words(settings),
            description,
        )

    def _repr_png_(self) -> bytes:
        from .display import world_png

        return world_png(self)

    def __repr__(self) -> str:
        return f"FileWorld({str(self.file)!r})"


AnyWorld = World | FileWorld


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A world as one print reads it: its own file, which nothing changes while the print holds this."""

    path: Path
    sources: tuple[Path, ...]
    allowed: tuple[str, ...]
    """Options: what it may read."""
    settings: tuple[str, ...]
    """Options: other values of uniforms."""
    description: dict[str, Any]
    names: Mapping[str, str] = field(default_factory=dict)
    """What messages call files that were made for it: what the user calls them."""
    kept: tuple[Any, ...] = ()
    """What owns the files that it names."""

    @property
    def words(self) -> list[str]:
        """What names it to a print."""
        return [str(self.path), *self.allowed, *self.settings]

    def program(self, enable_printf: bool = False) -> _core.Program:
        """Returns the kernels of its fablets."""
        return programs.find(self.sources, enable_printf, dither_rule(self.words))[0]


def snapshot(world: AnyWorld, uniforms: Mapping[str, Any] | None = None) -> Snapshot:
    """Returns what a print of a world reads."""
    if not isinstance(world, (World, FileWorld)):
        raise InputError(f"{short(world)} is no world; pass a World, or openfab.load(FILE)")
    return world._snapshot(uniforms)


def _allowed(folders: Iterable[Any], programs: bool) -> tuple[str, ...]:
    return (*(f"--allow={folder}" for folder in folders), *(["--allow-programs"] if programs else []))


def _set_words(settings: Mapping[str, Any]) -> tuple[str, ...]:
    return tuple(
        f"--set={target}={value if isinstance(value, str) else json.dumps(value)}" for target, value in settings.items()
    )


def dither_rule(words: list[str]) -> tuple[str, str] | None:
    """The file and the function of the dither rule that a world names; `words` name the world, and what it may read."""
    rule = _core.world_dither(words)
    if isinstance(rule, _core.Error):
        raise_error(rule)
    return rule


def load(
    file: str | os.PathLike[str], *, allow: Sequence[str | os.PathLike[str]] = (), allow_programs: bool = False,
) -> FileWorld:
    """Opens the world of a `.fab.json`.

    Parameters
    ----------
    file : str or path
        The `.fab.json`.
    allow : sequence of str or path, optional
        Folders that it may read besides its own.
    allow_programs : bool, optional
        Whether the programs that it names may run: never those of a stranger's world.

    Returns
    -------
    FileWorld
        Each print reads it anew.

    Raises
    ------
    InputError
        Where the file cannot be read, or is no object of JSON.
    """
    return FileWorld(file, allow=allow, allow_programs=allow_programs)


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
    """Collects the materials, textures and meshes that a world names."""

    def __init__(self) -> None:
        self.materials: dict[str, Material] = {}
        self.textures = _Named[Texture]()
        self.meshes = _Named[AnyMesh]()

    def encode_all(self, uniforms: Mapping[str, Any]) -> dict[str, Any]:
        # Of a copy: other threads may set some.
        return {name: self.encode(value, f"`{name}`") for name, value in dict(uniforms).items()}

    def encode(self, value: Any, what: str) -> Any:
        if isinstance(value, Material):
            if self.materials.setdefault(value.name, value) != value:
                raise InputError(f"two materials are called `{value.name}`")
            return value.name
        if isinstance(value, Texture):
            return self.textures.name(value, "texture")
        if isinstance(value, Object):
            return value.name
        return plain(value, what, self.encode)
