"""Lights into one table, with the chances of being aimed at."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import triangulate
from isophote.errors import SceneError
from isophote.kernels.base.table import Packed
from isophote.kernels.light import emitter
from isophote.kernels.light.emitter import LIGHTS
from isophote.kernels.light.environment import ENVIRONMENT
from isophote.lower.light_tree import FEWEST, is_local, no_light_tree, plant
from isophote.lower.painted_lights import Paint, corner_uvs, mean_luminance, paint_fields, paint_rows
from isophote.scene.colour import srgb_to_linear
from isophote.scene.light import (
    DiskLight,
    Environment,
    Light,
    PointLight,
    RectLight,
    Sky,
    SphereLight,
    Sun,
)
from isophote.scene.spot_light import SpotLight
from isophote.shapes.mesh import Mesh
from isophote.shapes.primitive.primitive import Primitive

__all__ = ["LightTable", "rectangle_mesh"]

Colour: TypeAlias = tuple[float, float, float]
Points: TypeAlias = npt.NDArray[np.float64]

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
_COLUMNS = 18
# A quad counts as a parallelogram if its fourth corner is where the others put it, to this part of its size.
_FLAT = 1e-6
# Spheres and disks are round to this part of their size.
_ROUND = 1e-6
# Of lights within the scene, where others are infinitely far away.
_SHARE_OF_TREE = 0.5
# Numbers that pick a light are multiples of one part in so many.
_STEPS = 2**24


def rectangle_mesh(light: RectLight) -> Mesh:
    """The rectangle in the light's own frame, facing −Y."""
    x, z = light.size[0] / 2, light.size[1] / 2
    return Mesh([(-x, 0, -z), (x, 0, -z), (x, 0, z), (-x, 0, z)], [(0, 1, 2, 3)])


class LightTable:
    """Collects lights, many rows at a time."""

    def __init__(self) -> None:
        self._kinds: list[npt.NDArray[np.int32]] = []
        self._rows: list[Points] = []
        self._power: list[npt.NDArray[np.float64]] = []
        self._numbers: list[npt.NDArray[np.int32]] = []
        self._count = 0
        self._constant = np.zeros(3)
        self._picture: Environment | None = None
        self._of_items: list[int] = []
        # By the first light's number: the material, and a row for each light.
        self._painted: dict[int, tuple[int, Points]] = {}
        self._picture_number = -1

    def _add(self, kind: int, power: npt.ArrayLike, number: int = -1, **fields: Any) -> int:
        """Lights of one kind, as many as there are powers; fields are one row for each or one for all.

        Returns the number of the first.
        """
        powers = np.atleast_1d(np.asarray(power, np.float64))
        count = len(powers)
        rows = np.zeros((count, _COLUMNS))
        for name, column in {"place": 0, "edge1": 3, "edge2": 6, "normal": 9, "radiance": 12}.items():
            rows[:, column : column + 3] = fields.get(name, 0)
        for name, column in {"area": 15, "two_sided": 16, "radius": 17}.items():
            rows[:, column] = fields.get(name, 0)
        self._kinds.append(np.full(count, kind, np.int32))
        self._rows.append(rows)
        self._power.append(powers)
        self._numbers.append(np.full(count, number, np.int32))
        first = self._count
        self._count += count
        return first

    def add_mesh(
        self,
        mesh: Mesh,
        matrix: Points,
        radiance: Colour,
        two_sided: bool,
        number: int = -1,
        paint: Paint | None = None,
    ) -> npt.NDArray[np.int32]:
        """The lights that a shining mesh is made of, `number` being that of the mesh for the user; for each of its
        triangles, the number of its light.

        A face that is a parallelogram is one light, any other one light a triangle, and so are all that have `paint`;
        -1 where there is no area.
        """
        cut = triangulate(mesh)
        points = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        sign = -1.0 if np.linalg.det(matrix[:3, :3]) < 0 else 1.0
        if paint is not None:
            numbers = self._flat(points[cut.triangles], 0.5, sign, radiance, two_sided, number)
            self._paint(
                numbers,
                paint,
                points[cut.triangles],
                corner_uvs(mesh, cut.corners),
                np.asarray(np.linalg.inv(matrix), np.float64),
            )
            return numbers.astype(np.int32)
        faces, corners = _parallelograms(mesh, points)
        of_face = np.full(mesh.face_count, -1, np.int64)
        of_face[faces] = self._flat(corners, 1.0, sign, radiance, two_sided, number)
        whole = np.zeros(mesh.face_count, bool)
        whole[faces] = True
        alone = ~whole[cut.face]
        numbers = of_face[cut.face]
        numbers[alone] = self._flat(points[cut.triangles[alone]], 0.5, sign, radiance, two_sided, number)
        return numbers.astype(np.int32)

    def _paint(
        self, numbers: npt.NDArray[np.int64], paint: Paint, corners: Points, uvs: Points, to_own: Points
    ) -> None:
        """Let a texture vary the triangles that were added last."""
        real = numbers >= 0
        self._power[-1] = self._power[-1] * mean_luminance(paint.texture, corners[real], uvs[real], to_own)
        self._painted[self._count - int(real.sum())] = paint.material, paint_rows(uvs[real], to_own)

    def _flat(
        self, corners: Points, part: float, sign: float, radiance: Colour, two_sided: bool, number: int
    ) -> npt.NDArray[np.int64]:
        """Triangles (`part` ½) or parallelograms (1) over two edges from the first of `corners` (n, 3, 3).

        Returns their numbers, −1 for those without area.
        """
        edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        normal = np.cross(edge1, edge2)
        size = np.linalg.norm(normal, axis=1)
        real = size > 0
        area = part * size[real]
        first = self._add(
            emitter.PARALLELOGRAM if part == 1.0 else emitter.TRIANGLE,
            math.pi * area * float(_LUMINANCE @ radiance) * (2 if two_sided else 1),
            number,
            place=corners[real, 0],
            edge1=edge1[real],
            edge2=edge2[real],
            normal=sign * normal[real] / size[real, None],
            radiance=radiance,
            area=area,
            two_sided=two_sided,
        )
        return np.where(real, first + np.cumsum(real) - 1, -1)

    def add(self, light: Light, reach: float, number: int) -> None:
        """A light other than a rectangle, with its number for the user; `reach` is the radius of the scene, by which
        those far away have their power."""
        if isinstance(light, PointLight):
            power = light.power * float(_LUMINANCE @ light.colour)
            self._add(emitter.POINT, power, number, place=light.position, radiance=light.intensity_rgb)
        elif isinstance(light, SpotLight):
            self._add_spot(light, number)
        elif isinstance(light, Sun):
            irradiance = light.irradiance_rgb
            power = math.pi * reach**2 * float(_LUMINANCE @ irradiance)
            self._add(emitter.SUN, power, number, normal=light.unit_direction, radiance=irradiance)
        elif isinstance(light, DiskLight | SphereLight):
            self._add_lamp(light, number)
        elif isinstance(light, Sky):
            self._constant += light.radiance_rgb
        elif isinstance(light, Environment):
            if self._picture is not None:
                raise SceneError("lights: a scene can have one Environment; add the pictures up before")
            self._picture, self._picture_number = light, number
        else:
            raise SceneError(f"lights: a {type(light).__name__} cannot be rendered")

    def _add_spot(self, light: SpotLight, number: int) -> None:
        inner, outer = light.cosines
        self._add(
            emitter.SPOT,
            light.power * float(_LUMINANCE @ light.colour),
            number,
            place=light.position,
            edge1=(inner, outer, light.exponent),
            normal=light.unit_axis,
            radiance=light.intensity_rgb,
        )

    def _add_lamp(self, light: DiskLight | SphereLight, number: int) -> None:
        radiance = light.radiance_rgb
        power = math.pi * light.emitting_area * float(_LUMINANCE @ radiance)
        matrix = light.transform.matrix
        if isinstance(light, SphereLight):
            self._add(emitter.SPHERE, power, number, place=light.position, radius=light.radius, radiance=radiance)
            return
        self._add(
            emitter.DISK,
            power,
            number,
            place=light.position,
            edge1=light.radius * matrix[:3, 0],
            edge2=light.radius * matrix[:3, 2],
            normal=-matrix[:3, 1],
            radiance=radiance,
            area=light.area,
            two_sided=light.two_sided,
        )

    def add_primitive(self, primitive: Primitive, radiance: Colour, two_sided: bool, number: int) -> int:
        """The light that a shining primitive is, where it is a sphere or a round disk; otherwise −1, for it is only met
        by chance. Rays meet it as the item that it is."""
        linear, place = primitive.matrix[:3, :3], primitive.matrix[:3, 3]
        edges = linear if primitive.kind == "ball" else linear[:, [0, 2]]
        radius = float(np.linalg.norm(edges[:, 0]))
        is_round = np.abs(edges.T @ edges - radius**2 * np.eye(edges.shape[1])).max() <= _ROUND * radius**2
        if primitive.kind not in ("ball", "disk") or not is_round:
            return -1
        sides = 2 if two_sided else 1
        luminance = float(_LUMINANCE @ radiance)
        if primitive.kind == "ball":
            power = math.pi * 4 * math.pi * radius**2 * luminance
            light = self._add(emitter.SPHERE, power, number, place=place, radius=radius, radiance=radiance)
        else:
            area = math.pi * radius**2
            normal = np.linalg.inv(linear)[1]
            light = self._add(
                emitter.DISK,
                math.pi * area * sides * luminance,
                number,
                place=place,
                edge1=linear[:, 0],
                edge2=linear[:, 2],
                normal=normal / np.linalg.norm(normal),
                radiance=radiance,
                area=area,
                two_sided=two_sided,
            )
        self._of_items.append(light)
        return light

    def build(self, reach: float) -> Packed:
        """The table; a picture of the sky, if there is one, is its last row."""
        environment, power = _lower_environment(self._constant, self._picture)
        if self._picture is not None:
            self._add(emitter.ENVIRONMENT, math.pi * reach**2 * power, self._picture_number)
        kinds = np.concatenate([np.zeros(0, np.int32), *self._kinds])
        numbers = np.concatenate([np.zeros(0, np.int32), *self._numbers])
        powers = np.concatenate([np.zeros(0), *self._power])
        groups, shares = _groups(kinds, numbers, powers)
        lamps = np.flatnonzero((kinds == emitter.DISK) | (kinds == emitter.SPHERE))
        lamps = np.setdiff1d(lamps, self._of_items)
        values = np.concatenate([np.zeros((0, _COLUMNS)), *self._rows])
        local = is_local(kinds)
        many = local.sum() >= FEWEST
        return LIGHTS.pack(
            kinds=kinds,
            values=values.astype(np.float32),
            cdf=_beside_tree(local, powers) if many else _cumulative(powers),
            tree=plant(kinds, values) if many else no_light_tree(),
            lamps=lamps.astype(np.int32),
            numbers=numbers,
            groups=groups,
            shares=shares,
            environment=environment,
            **paint_fields(self._painted, self._count),
        )


def _groups(
    kinds: npt.NDArray[np.int32], numbers: npt.NDArray[np.int32], power: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.float32]]:
    """Rows that follow each other with the same number, as `Lights.groups`, and each row's start within its group."""
    starts = np.flatnonzero(np.diff(numbers, prepend=-2)) if len(numbers) else np.zeros(0, np.int64)
    counts = np.diff(starts, append=len(numbers))
    weights = np.maximum(power, 1e-12 * power.max(initial=0.0)) + np.finfo(float).tiny
    before = np.concatenate([np.zeros(1), np.cumsum(weights)])
    first = np.repeat(before[starts], counts)
    total = np.repeat(before[starts + counts] - before[starts], counts)
    sized = ~np.isin(kinds[starts], (emitter.POINT, emitter.SUN, emitter.SPOT))
    groups = np.stack([starts, counts, sized, numbers[starts]], axis=1).astype(np.int32)
    return groups, ((before[:-1] - first) / total).astype(np.float32)


def _parallelograms(mesh: Mesh, points: Points) -> tuple[npt.NDArray[np.int64], Points]:
    """Faces that are parallelograms, and three corners of each, (n, 3, 3): the first and its two neighbours."""
    quads = np.flatnonzero(mesh.face_sizes == 4)
    p = points[mesh.indices[mesh.offsets[quads, None] + np.arange(4)]]
    diagonals = np.stack([p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]])
    size = np.linalg.norm(diagonals, axis=2).max(axis=0)
    skew = np.linalg.norm(p[:, 0] + p[:, 2] - p[:, 1] - p[:, 3], axis=1)
    chosen = skew <= _FLAT * size
    return quads[chosen], p[chosen][:, [0, 1, 3]]


def _cumulative(power: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """0 to 1 in steps that grow by each light's share; every light has some.

    Steps are whole multiples of those of the numbers that pick, so that each light is picked as often as it says.
    """
    count = len(power)
    if count == 0:
        return np.zeros(1, np.float32)
    if count > _STEPS:
        raise SceneError(f"{count:,} faces and lights shine, more than the {_STEPS:,} that can be told apart")
    total = power.sum()
    share = power / total if total > 0 else np.full(count, 1 / count)
    share = np.maximum(share, 1e-3 / count)
    wanted = np.rint(np.concatenate([np.zeros(1), np.cumsum(share / share.sum())]) * _STEPS)
    place = np.arange(count + 1)
    rising = np.maximum.accumulate(wanted - place) + place
    steps = np.minimum(rising, _STEPS - place[::-1])
    return (steps / _STEPS).astype(np.float32)


def _beside_tree(local: npt.NDArray[np.bool_], power: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """As `_cumulative` where a tree picks among local lights, whose own steps are 0: all of it lies below the first
    step, half if there are lights infinitely far away, which share the rest by their power."""
    far = _cumulative(power[~local])
    share = np.float32(_SHARE_OF_TREE if len(far) > 1 else 1.0)
    before = np.concatenate([np.zeros(1, np.int64), np.cumsum(~local)])
    steps: npt.NDArray[np.float32] = share + (1 - share) * far[before]
    return steps


def _lower_environment(constant: Points, picture: Environment | None) -> tuple[Packed, float]:
    """The table, and the luminance that comes from all directions together."""
    texels = np.zeros((0, 0, 3)) if picture is None else _texels(picture)
    height, width, _ = texels.shape
    rows, columns = _sky_shares(texels + constant) if picture else (np.zeros(1), np.zeros((0, 1)))
    packed = ENVIRONMENT.pack(
        constant=constant.astype(np.float32),
        texels=np.ascontiguousarray(texels.reshape(-1, 3), np.float32),
        height=height,
        width=width,
        row_shares=rows.astype(np.float32),
        column_shares=columns.astype(np.float32),
        rotation=picture.rotation if picture else 0.0,
    )
    return packed, _sky_power(texels + constant) if picture else 0.0


def _texels(picture: Environment) -> Points:
    """(h, w, 3) linear radiance."""
    image = picture.texture
    width, height = image.size
    pixels = image.pixels.reshape(height, width, -1)
    texels = pixels / 255.0 if pixels.dtype == np.uint8 else pixels.astype(np.float64)
    texels = texels[..., :1].repeat(3, axis=2) if image.channels == 1 else texels[..., :3]
    if image.colour_space == "srgb":
        texels = srgb_to_linear(texels)
    radiance: Points = texels * picture.strength
    return radiance


def _sky_shares(texels: Points) -> tuple[Points, Points]:
    """Cumulative light by rows, and within each row, every texel weighed by its solid angle.

    A texel's share is the most of it and its neighbours, since lookups blend neighbours: nothing that shines must have
    no chance.
    """
    height, _, _ = texels.shape
    light = texels @ _LUMINANCE
    wide = np.maximum(light, np.maximum(np.roll(light, 1, axis=1), np.roll(light, -1, axis=1)))
    tall = wide.copy()
    tall[1:] = np.maximum(tall[1:], wide[:-1])
    tall[:-1] = np.maximum(tall[:-1], wide[1:])
    weight = tall * np.sin(np.pi * (np.arange(height) + 0.5) / height)[:, None] + 1e-12
    columns = np.concatenate([np.zeros((height, 1)), np.cumsum(weight, axis=1)], axis=1)
    rows = np.concatenate([np.zeros(1), np.cumsum(columns[:, -1])])
    columns /= columns[:, -1:]
    rows /= rows[-1]
    return rows, columns


def _sky_power(texels: Points) -> float:
    """Luminance integrated over all directions."""
    height, width, _ = texels.shape
    sines = np.sin(np.pi * (np.arange(height) + 0.5) / height)
    solid_angles = sines * 2 * np.pi**2 / (width * height)
    return float(((texels @ _LUMINANCE).sum(axis=1) * solid_angles).sum())
