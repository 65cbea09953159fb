# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Objects of worlds: their meshes, fablets and placements, and the names of their materials and textures."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from . import _files
from ._bound import check_bound
from ._given import Real, array, is_sequence, number, plain, positive, several, vector
from ._keys import absolute, check_keys
from .errors import InputError
from .fablet import Fablet, Uniform
from .materials import Material
from .shapes import AnyMesh, longest_side_mm
from .textures import Texture

if TYPE_CHECKING:
    from .world import World

T = TypeVar("T")


class Object(MutableMapping[str, Any]):
    """A mesh with a fablet, and a mapping of its bound uniforms. `World.add` makes it.

    A uniform takes a number, a sequence of numbers, a Material or VOID, a Texture or the array of a picture, or an object
    whose distance the fablet queries. A value of the wrong type or length, or beyond its limits, raises InputError.

    Attributes
    ----------
    name : str
        Its name in the world.
    mesh : Mesh, FileMesh, Primitive or Shape
        Its shape.
    fablet : Fablet
        The fablet that defines its materials.
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
        scale: Real | Sequence[Real] | None = None, size_mm: Real | None = None, matrix: Any = None,
        uniforms: Mapping[str, Any] | None = None, **keys: Any,
    ) -> Object:
        """Places the object once more.

        Parameters
        ----------
        translate : sequence of 2 or 3 floats, optional
            Along x, y and z, in mm.
        rotate : sequence of 3 floats, optional
            About x, then y, then z, in degrees.
        scale : float or sequence of 3 floats, optional
            A factor, or three along x, y and z.
        size_mm : float, optional
            The size of the longest side of its mesh, in mm, instead of a factor.
        matrix : array_like of float, shape (3, 4) or (4, 4), optional
            A matrix instead of these, with lengths in mm. The last of 4 rows is (0, 0, 0, 1).
        uniforms : mapping of str to Any, optional
            Values for this copy.
        **keys
            Other keys of placements in a `.fab.json`, such as `grid`, `transforms` or `on_bed`.

        Returns
        -------
        Object
            The object itself.

        Raises
        ------
        InputError
            If a value or a key is invalid, or the object was removed.
        """
        placement = self._placement(
            translate=translate, rotate=rotate, scale=scale, size_mm=size_mm, matrix=matrix, uniforms=uniforms, **keys
        )
        with _files.lock:
            if self._world._objects.get(self.name) is not self:
                raise InputError(f"the world has no object `{self.name}` any more; add it again")
            self._world._placements.append(placement)
        return self

    def _placement(self, *, size_mm: Any = None, uniforms: Mapping[str, Any] | None = None, **keys: Any) -> Placement:
        if size_mm is not None:
            if keys.get("scale") is not None or keys.get("matrix") is not None:
                raise InputError("`size_mm` and `scale` or `matrix` both set the size; give one of them")
            keys["scale"] = positive(size_mm, "`size_mm`") / longest_side_mm(self.mesh)
        own = {name: self._checked(name, value) for name, value in (uniforms or {}).items()}
        return Placement(self, placed("object", self.name, **keys), own)

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
        encoded = Names().encode(value, f"`{name}`")  # which raises what is wrong with it
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


def placed(
    kind: str, name: str, *, translate: Any = None, rotate: Any = None, scale: Any = None, matrix: Any = None, **keys: Any,
) -> dict[str, Any]:
    """Returns a placement of an object or a group as a `.fab.json` has it, without values of uniforms."""
    spec: dict[str, Any] = {kind: name}
    check_keys(keys, "placement", "a placement", ("object", "group", "uniforms"))
    given = {key: plain(value, f"`{key}` of a placement") for key, value in keys.items()}
    if given:
        spec.update(absolute({"build": [given]})["build"][0])
    if translate is not None:
        spec["translate_mm"] = vector(translate, "`translate`", (2, 3))
    if rotate is not None:
        spec["rotate_deg"] = vector(rotate, "`rotate`")
    if scale is not None:
        spec["scale"] = vector(scale, "`scale`") if is_sequence(scale) else number(scale, "`scale`")
    if matrix is not None:
        spec["matrix"] = _matrix(matrix)
    return spec


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
    """A placement of an object, or of a group, as a `.fab.json` describes it, and the uniforms of this copy."""

    object: Object | None
    spec: dict[str, Any]
    uniforms: dict[str, Any]


class Named(Generic[T]):
    """Unique names for things without a name."""

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


class Names:
    """Collects the materials, textures and meshes that a world names."""

    def __init__(self) -> None:
        self.materials: dict[str, Material] = {}
        self.textures = Named[Texture]()
        self.meshes = Named[AnyMesh]()

    def encode_all(self, uniforms: Mapping[str, Any]) -> dict[str, Any]:
        # A copy, since other threads may set uniforms.
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
