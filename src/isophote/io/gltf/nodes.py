"""The node tree of a glTF file: what is placed where."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from os import fspath
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, IsophoteWarning, SceneError
from isophote.io.gltf.document import Document
from isophote.io.gltf.field import Field
from isophote.io.gltf.material import MARK
from isophote.scene.camera import AnyCamera, Camera, OrthographicCamera
from isophote.scene.light import Light, PointLight, Sun
from isophote.scene.spot_light import SpotLight

__all__ = ["PlacedNode", "read_camera", "read_light", "scene_name", "walk"]

Matrix: TypeAlias = npt.NDArray[np.float64]

_LIGHTS = "KHR_lights_punctual"


class PlacedNode(NamedTuple):
    """A node and its matrix (4, 4) to world space."""

    field: Field
    matrix: Matrix


def walk(document: Document) -> Iterator[PlacedNode]:
    """The nodes of the file's scene, parents first, in the order in which they are listed.

    Raises `FileError` where a node is its own ancestor or hangs in two places.
    """
    pending = [(index, np.eye(4)) for index in reversed(_roots(document))]
    seen: set[int] = set()
    while pending:
        index, parent = pending.pop()
        field = document.root.entry("nodes", index)
        if index in seen:
            field.fail("hangs in two places of the tree, or within itself; nodes must form a tree")
        seen.add(index)
        with np.errstate(over="ignore", invalid="ignore"):
            matrix = parent @ _local(field)
        if not np.isfinite(matrix).all():
            field.fail("is placed beyond all numbers; its transforms multiply to infinity")
        yield PlacedNode(field, matrix)
        pending.extend((child, matrix) for child in reversed(field.indices("children")))


def scene_name(document: Document) -> str | None:
    """The name of the file's scene, if it has one."""
    root = document.root
    return root.entry("scenes", root.integer("scene", 0)).text("name") if root.array("scenes") else None


def _roots(document: Document) -> list[int]:
    root = document.root
    if root.array("scenes"):
        return root.entry("scenes", root.integer("scene", 0)).indices("nodes")
    below = {child for node in root.children("nodes") for child in node.indices("children")}
    return [index for index in range(len(root.array("nodes"))) if index not in below]


def _local(field: Field) -> Matrix:
    """A node's own matrix: as given, or translation · rotation · scale."""
    if "matrix" in field:
        matrix = np.array(field.numbers("matrix", 16, ())).reshape(4, 4).T
        if np.abs(matrix[3] - (0, 0, 0, 1)).max() > 1e-6:
            field.fail("must have 0, 0, 0, 1 as its last row", "matrix")
        matrix[3] = 0, 0, 0, 1
        return matrix
    matrix = np.eye(4)
    matrix[:3, :3] = _rotation(field) * field.numbers("scale", 3, (1.0, 1.0, 1.0))
    matrix[:3, 3] = field.numbers("translation", 3, (0.0, 0.0, 0.0))
    return matrix


def _rotation(field: Field) -> Matrix:
    """(3, 3) of the quaternion (x, y, z, w), brought to length 1."""
    quaternion = np.array(field.numbers("rotation", 4, (0.0, 0.0, 0.0, 1.0)))
    length = float(np.linalg.norm(quaternion))
    if not 1e-12 < length < 1e150:
        field.fail("must be a quaternion of length 1", "rotation")
    x, y, z, w = quaternion / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def read_camera(document: Document, node: PlacedNode) -> AnyCamera | None:
    """The camera at a node, looking along the node's −Z, or None. Its aspect and its near and far are not kept."""
    if "camera" not in node.field:
        return None
    field = document.root.entry("cameras", node.field.integer("camera"))
    perspective, orthographic = field.child("perspective"), field.child("orthographic")
    extras = _extras(field)
    reach = extras.number("target_distance", 1.0)
    eye, back, up = node.matrix[:3, 3], _unit(node.matrix[:3, 2]), node.matrix[:3, 1]
    target = eye - (reach if reach > 0 else 1.0) * back
    if perspective is None and orthographic is None:
        field.fail("must be perspective or orthographic")
    try:
        if perspective is None:
            return OrthographicCamera(eye, target, up, height=2 * _number(orthographic, "ymag"))
        return Camera(
            eye,
            target,
            up,
            math.degrees(_number(perspective, "yfov")),
            lens_radius=extras.number("lens_radius", 0.0),
            focus_distance=extras.number("focus_distance", 0.0) or None,
            principal_point=extras.numbers("principal_point", 2, (0.5, 0.5)),
            pixel_aspect=extras.number("pixel_aspect", 1.0),
        )
    except SceneError as error:
        raise FileError(document.path, str(error), field.place) from error


def _number(field: Field | None, key: str) -> float:
    return 0.0 if field is None else field.number(key, 0.0)


def _extras(field: Field) -> Field:
    """What files written here say beside glTF, and nothing for other files."""
    extras = field.value.get("extras")
    mark = extras.get(MARK) if isinstance(extras, dict) else None
    return Field(field.path, mark if isinstance(mark, dict) else {}, f"{field.place}.extras.{MARK}")


def _unit(vector: Matrix) -> Matrix:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else np.array([0.0, 0.0, 1.0])


def read_light(document: Document, node: PlacedNode) -> Light | None:
    """The light at a node, or None. Candela and lux are taken for W/sr and W/m². Source: KHR_lights_punctual."""
    held, listed = node.field.extension(_LIGHTS), document.root.extension(_LIGHTS)
    if held is None:
        return None
    if listed is None:
        held.fail("names a light, but the file lists none")
    field = listed.entry("lights", held.integer("light"))
    kind, intensity = field.text("type"), field.number("intensity", 1.0)
    colour = field.numbers("color", 3, (1.0, 1.0, 1.0))
    try:
        if kind == "point":
            return PointLight(node.matrix[:3, 3], 4 * math.pi * intensity, colour)
        if kind == "directional":
            return Sun(_unit(node.matrix[:3, 2]), intensity, colour)
        if kind == "spot":
            return _spot(node, field, intensity, colour)
    except SceneError as error:
        raise FileError(document.path, str(error), field.place) from error
    reason = f"a light of type {str(kind)[:40]!r} cannot be read and is left out"
    warnings.warn(f"{fspath(field.path)}, {field.place}: {reason}", IsophoteWarning, stacklevel=2)
    return None


def _spot(node: PlacedNode, field: Field, intensity: float, colour: tuple[float, ...]) -> SpotLight:
    """A spot that shines along the node's −Z. glTF's angles are half of ours; its light falls off otherwise between the
    cones, by the square of what is linear in the cosine, which readers may choose."""
    cone = field.child("spot")
    inner = 0.0 if cone is None else cone.number("innerConeAngle", 0.0)
    outer = math.pi / 4 if cone is None else cone.number("outerConeAngle", math.pi / 4)
    if not 0 <= inner < outer <= math.pi / 2 + 1e-6:
        field.fail("must have 0 ≤ innerConeAngle < outerConeAngle ≤ π/2", "spot")
    extras = _extras(field)
    reach = extras.number("target_distance", 1.0)
    position = node.matrix[:3, 3]
    hard = extras.number("hard", 0.0) != 0
    return SpotLight.of_intensity(
        position,
        intensity,
        colour=colour,
        target=position - (reach if reach > 0 else 1.0) * _unit(node.matrix[:3, 2]),
        cone_degrees=min(2 * math.degrees(outer), 180.0),
        inner_degrees=None if hard else 2 * math.degrees(inner),
        exponent=extras.number("exponent", 0.0),
    )
