# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Worlds: parts, materials and placements; made in Python, or read from a `.fab.json`."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from . import _core, _files
from ._given import Real, Whole, choice, number, plain, short, whole
from ._keys import absolute, absolute_paths, check_keys
from ._objects import Named, Names, Object, Placement, placed
from ._printers import known_printer
from ._snapshot import Snapshot, allowed_by, settings_of
from .errors import InputError
from .fablet import Fablet
from .lattice import Beams
from .procedural import Generated
from .shapes import Mesh, Shape, as_mesh
from .textures import Texture

class World:
    """A world to print.

    Parameters
    ----------
    printer : str or path, optional
        The name of a printer, or its file.
    title : str, optional
        The name of the print.
    **keys
        Other keys of a `.fab.json`: `tray`, `support`, `arrange`, `groups`, `dither`.

    Attributes
    ----------
    title : str
        The name of the print.

    Raises
    ------
    InputError
        If there is no such printer, a key is unknown, or its value has a type that a world does not accept.

    Examples
    --------
    >>> world = World(printer="j750")
    >>> white, black = Material("white", "#ffffff"), Material("black", "#000000")
    >>> world.add(sphere(12), Fablet("ball.fl"), {"core": white, "shell": black, "skin": 0.5})   # doctest: +SKIP
    """

    def __init__(self, *, printer: str | os.PathLike[str] | None = None, title: str = "world", **keys: Any) -> None:
        self.title = title
        check_keys(keys, "world", "a world", ("openfab", "fablets", "materials", "textures", "meshes", "objects", "build"))
        given = {key: plain(value, f"`{key}` of a world") for key, value in keys.items() if value is not None}
        self._keys = absolute(given if printer is None else {"printer": known_printer(printer, "`printer`"), **given})
        self._objects: dict[str, Object] = {}
        self._placements: list[Placement] = []
        # The snapshot of the last print, whose errors name its file.
        self._last: Snapshot | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_last": None}

    def add(
        self, mesh: Any, fablet: Fablet, uniforms: Mapping[str, Any] | None = None, *, name: str | None = None,
        place: bool = True, priority: Whole | None = None, max_displacement_mm: Real | None = None,
        support: bool | None = None, repair: str | None = None, **keys: Any,
    ) -> Object:
        """Adds an object, and places it.

        Parameters
        ----------
        mesh : Mesh, FileMesh, Primitive, Shape, str, path, or a mesh of trimesh or pyvista
            Its shape; a string is a file name.
        fablet : Fablet
            The fablet that defines its materials.
        uniforms : mapping of str to Any, optional
            Values for the fablet's uniforms; more can be set later. Those without a default are checked by the print.
        name : str, optional
            Its name. Default: that of its fablet.
        place : bool, optional
            Whether to place it; if not, use `Object.place`.
        priority : int, optional
            Where objects overlap, the one with the higher priority is printed.
        max_displacement_mm : float, optional
            The largest displacement of its surface, in mm.
        support : bool, optional
            Whether it gets support material.
        repair : str, optional
            `winding` caps the holes of a mesh and orients its triangles.
        **keys
            Other keys of objects in a `.fab.json`, such as `pieces`, and arguments of `Object.place`, such as
            `size_mm=60`.

        Returns
        -------
        Object
            The new object.

        Raises
        ------
        InputError
            If a value is invalid, or the name is taken; the world is then unchanged.
        """
        own = set(_core.world_keys("object")).difference(("mesh", "fablet", "uniforms"))
        placement = {key: value for key, value in keys.items() if key not in own}
        spec = {
            "priority": None if priority is None else whole(priority, "`priority`"),
            "max_displacement_mm": (
                None if max_displacement_mm is None else number(max_displacement_mm, "`max_displacement_mm`")
            ),
            "support": support, "repair": repair, **{key: value for key, value in keys.items() if key in own},
        }
        given = {key: plain(value, f"`{key}`") for key, value in spec.items() if value is not None}
        given = absolute({"objects": {"": given}})["objects"][""]
        with _files.lock:
            if name is None:
                name, count = fablet.name.lower(), len(self._objects)
                while name in self._objects:
                    name, count = f"{fablet.name.lower()}{count}", count + 1
            if name in self._objects:
                raise InputError(f"the world has an object `{name}` already")
            added = Object(self, name, as_mesh(mesh), fablet, given)
            added.update(uniforms or {})
            placements = [added._placement(**placement)] if place else []
            # Only here, so that an error above leaves the world unchanged.
            self._objects[name] = added
            self._placements += placements
        return added

    def remove(self, name: str) -> None:
        """Removes an object and its placements.

        Parameters
        ----------
        name : str
            Its name.

        Raises
        ------
        InputError
            If the world has no object with that name.
        """
        with _files.lock:
            if name not in self._objects:
                raise InputError(f"the world has no object `{name}`; it has {', '.join(self._objects) or 'none'}")
            removed = self._objects.pop(name)
            self._placements = [one for one in self._placements if one.object is not removed]

    def place_group(self, name: str, *, uniforms: Mapping[str, Any] | None = None, **placement: Any) -> None:
        """Places a group of the world's `groups`.

        Parameters
        ----------
        name : str
            Its name.
        uniforms : mapping of str to Any, optional
            Values for this copy, by `OBJECT.UNIFORM`.
        **placement
            Arguments of `Object.place`.

        Raises
        ------
        InputError
            If the world has no group or no object with that name, or a value is invalid.
        """
        choice(name, "a group of the world", list(self._keys.get("groups", {})))
        own = {}
        for target, value in (uniforms or {}).items():
            of, _, uniform = target.rpartition(".")
            choice(of, f"the object of `{target}`", list(self._objects))
            own[target] = self._objects[of]._checked(uniform, value)
        added = Placement(None, placed("group", name, **placement), own)
        with _files.lock:
            self._placements.append(added)

    @property
    def objects(self) -> Mapping[str, Object]:
        """The objects by name."""
        return dict(self._objects)

    def to_json(self) -> dict[str, Any]:
        """Returns the world as the content of a `.fab.json`.

        Returns
        -------
        dict
            The world. Its arrays are in temporary files, which live as long as their owners.
        """
        with _files.lock:
            return self._describe(Names(), {})[0]

    def _describe(self, names: Names, uniforms: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
        """Returns the content of a `.fab.json`, and values that replace those of some uniforms; their materials are in it."""
        fablets = Named[Fablet | Shape]()
        same: dict[tuple[Path, str], Fablet] = {}

        def first(fablet: Fablet) -> Fablet:
            # The same text given twice is one fablet: a shape has the uniforms of objects with it.
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
        meshes = {name: mesh._spec() for name, mesh in names.meshes.items()}
        for name, mesh in names.meshes.items():
            if isinstance(mesh, Shape):
                # With values of its own, the stage differs from that of objects with the same fablet.
                stage: Fablet | Shape = mesh if mesh.uniforms else first(mesh.fablet)
                key = "grow" if mesh.fablet.has_grow else "shape"
                meshes[name] = {key: fablets.name(stage, mesh.fablet.name), **meshes[name]}
        described: dict[str, dict[str, Any]] = {}
        for name, one_of in fablets.items():
            fablet = one_of.fablet if isinstance(one_of, Shape) else one_of
            described[name] = {"source": str(fablet.source()), "fablet": fablet.name}
            if isinstance(one_of, Shape):
                described[name]["uniforms"] = names.encode_all(one_of.uniforms)
        world: dict[str, Any] = {"openfab": 1, **self._keys}
        world["fablets"] = described
        world["materials"] = {name: material._spec() for name, material in names.materials.items()}
        world["textures"] = {name: texture._spec() for name, texture in names.textures.items()}
        world["meshes"] = meshes
        world["objects"] = objects
        world["build"] = build
        return world, settings

    def _snapshot(self, uniforms: Mapping[str, Any] | None = None) -> Snapshot:
        """Writes the world for one print, with other values for some uniforms."""
        names = Names()
        with _files.lock:
            self._check_all_bound(uniforms or {})
            description, settings = self._describe(names, uniforms or {})
            shapes = [mesh.fablet for _, mesh in names.meshes.items() if isinstance(mesh, Shape)]
            fablets = [*(one.fablet for one in self._objects.values()), *shapes]
            sources = dict.fromkeys(fablet.source() for fablet in fablets)
            generates = any(isinstance(mesh, Generated) for _, mesh in names.meshes.items())
        path = _files.unique(self.title, _files.WORLD)
        text, files = absolute_paths(json.dumps(description, indent=1, allow_nan=False))
        with _files.outside_errors(f"`{path}` cannot be written"):
            path.write_text(text, encoding="utf-8")
        made = Snapshot(
            path, tuple(sources), allowed_by(sorted({file.parent for file in files}), generates), settings_of(settings), description,
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

    def _check_all_bound(self, settings: Mapping[str, Any]) -> None:
        """Raises if a placed object lacks a uniform without a default."""
        for placement in self._placements:
            one = placement.object
            if one is None:  # a group's, whose objects the world of the print reads
                continue
            for name, declared in one.fablet.uniforms.items():
                given = name in one._uniforms or name in placement.uniforms or f"{one.name}.{name}" in settings
                if given or declared.default is not None:
                    continue
                bound = ", ".join(f"`{key}`" for key in one._uniforms) or "nothing"
                raise InputError(
                    f"object `{one.name}` does not bind `{name}`, a `{declared.type}` of `{one.fablet.name}`; it binds {bound}",
                    help=f'give it in `world.add(mesh, fablet, {{"{name}": …}})`, or as `world.objects["{one.name}"]["{name}"] = …`',
                )

    def _setting(self, target: str, value: Any, names: Names) -> Any:
        name, _, uniform = target.rpartition(".")
        one = self._objects.get(name)
        if one is not None:
            value = one._checked(uniform, value)
        return names.encode(value, f"`{target}`")

    def __repr__(self) -> str:
        return f"World({self.title!r}, {len(self._objects)} objects, {len(self._placements)} placements)"


class FileWorld:
    """A world in a `.fab.json` file, which each print reads again; `load` makes it.

    Parameters
    ----------
    file : str or path
        The `.fab.json`.
    allow : sequence of str or path, optional
        Folders that it may read in addition to its own.
    allow_programs : bool, optional
        Whether the programs that it names may run; never allow this for a stranger's world.

    Attributes
    ----------
    file : pathlib.Path
        The `.fab.json`.

    Raises
    ------
    InputError
        If the file cannot be read, or is not a JSON object.
    """

    def __init__(
        self, file: str | os.PathLike[str], *, allow: Sequence[str | os.PathLike[str]] = (), allow_programs: bool = False,
    ) -> None:
        self.file = Path(file).absolute()
        self._allow = [os.fspath(folder) for folder in allow]
        self._programs = bool(allow_programs)
        self.to_json()

    def to_json(self) -> dict[str, Any]:
        """Returns the content of the file.

        Returns
        -------
        dict
            The world in the file.

        Raises
        ------
        InputError
            If the file cannot be read, or is not a JSON object.
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
        """Returns a snapshot of the user's own file, with other values for some uniforms."""
        names = Names()
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
            self.file, tuple(dict.fromkeys(sources)), allowed_by(self._allow, self._programs), settings_of(settings),
            description,
        )

    def __repr__(self) -> str:
        return f"FileWorld({str(self.file)!r})"


AnyWorld = World | FileWorld


def snapshot(world: AnyWorld, uniforms: Mapping[str, Any] | None = None) -> Snapshot:
    """Returns the snapshot of a world that a print reads."""
    if not isinstance(world, (World, FileWorld)):
        raise InputError(f"{short(world)} is no world; pass a World, or openfab.load(FILE)")
    return world._snapshot(uniforms)


def load(
    file: str | os.PathLike[str], *, allow: Sequence[str | os.PathLike[str]] = (), allow_programs: bool = False,
) -> FileWorld:
    """Opens the world in a `.fab.json`.

    Parameters
    ----------
    file : str or path
        The `.fab.json`.
    allow : sequence of str or path, optional
        Folders that it may read in addition to its own.
    allow_programs : bool, optional
        Whether the programs that it names may run; never allow this for a stranger's world.

    Returns
    -------
    FileWorld
        A world that each print reads again.

    Raises
    ------
    InputError
        If the file cannot be read, or is not a JSON object.
    """
    return FileWorld(file, allow=allow, allow_programs=allow_programs)
