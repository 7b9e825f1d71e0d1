"""Scenes: items, the lights on them, and a camera."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, Protocol, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.camera import AnyCamera, Camera, OrthographicCamera
from isophote.scene.displacement import Displacement
from isophote.scene.fields import VectorLike, instance_of, optional
from isophote.scene.light import AreaLight, Environment, Light, PointLight, Sky, Sun
from isophote.scene.material import Matte
from isophote.scene.material_base import Material
from isophote.scene.medium import Medium
from isophote.scene.motion import Motion
from isophote.scene.spot_light import SpotLight
from isophote.scene.transform import Axis, Transform
from isophote.shapes.mesh import Mesh

__all__ = ["Bounds", "Item", "Scene", "Shape", "camera_at", "is_shape", "placed_box", "placed_boxes"]

Bounds: TypeAlias = npt.NDArray[np.float64]

_name = optional(instance_of("a string or None", str))
_camera = optional(instance_of("a Camera, an OrthographicCamera or None", Camera, OrthographicCamera))
_medium = optional(instance_of("a Medium or None", Medium))
_material = instance_of("a material (Matte, Metal, Glass, Emitter, ...)", Material)
# Steps between two placements of a motion at which its box is taken.
_STEPS = 9
_LIGHTS = (PointLight, SpotLight, Sun, AreaLight, Sky, Environment)


class Shape(Protocol):
    """What can stand in a scene: a mesh, or any other shape with `bounds`."""

    @property
    def bounds(self) -> npt.NDArray[Any]:
        """(2, 3): least and greatest corner of a box around the shape, infinite where it is endless."""


def is_shape(value: object) -> bool:
    """Whether a value is a shape, rather than an item, a scene or something else."""
    # Asked of the type, since asking the value would measure the shape.
    return not isinstance(value, Item | Scene) and hasattr(type(value), "bounds")


def _shape(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    if not is_shape(value):
        hint = "; load_mesh reads one from a file" if isinstance(value, str) else ""
        raise SceneError(f"Item: shape must be a shape, such as a Mesh, but is {_described(value)}{hint}")
    if getattr(type(value), "dimension", 3) == 2:
        raise SceneError(
            f"Item: {_described(value)} is a field in the plane, which a scene does not show; extrude or revolve it"
        )


def _displacement(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    if value is None:
        return
    instance_of("a Displacement or None", Displacement)(instance, attribute, value)
    if not isinstance(instance.shape, Mesh):
        raise SceneError(
            f"Item: only a Mesh can have a displacement, but shape is {_described(instance.shape)}; to_mesh makes "
            "a mesh of a field"
        )


def _described(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"a {type(value).__name__}"


@attrs.frozen
class Item:
    """A shape in a scene, with what it is made of and where it stands.

    Items whose `shape` is the same object share its geometry, so a thousand of them cost one. `transform`
    takes the shape to world space, a `Motion` at each time; `name` is for people and files. Where only one placement
    counts (files, baking, radiosity, rays over arrays), an item that moves stands as at its first. A mesh may have a
    `displacement` that moves its surface in pictures; `displace` makes such a mesh.
    """

    shape: Shape = attrs.field(validator=_shape)
    material: Material = attrs.field(factory=Matte, validator=_material)
    transform: Transform | Motion = attrs.field(
        factory=Transform.identity, validator=instance_of("a Transform or a Motion", Transform, Motion)
    )
    name: str | None = attrs.field(default=None, validator=_name)
    displacement: Displacement | None = attrs.field(default=None, validator=_displacement, kw_only=True)

    def at(self, position: VectorLike) -> Item:
        """The item with its shape's origin at `position`, at first if it moves, turned and scaled as it is."""
        matrix = self.transform.matrix.copy()
        if isinstance(self.transform, Motion):
            return self.translate(np.asarray(position, np.float64) - matrix[:3, 3])
        matrix[:3, 3] = 0
        return self.with_(transform=Transform(matrix).translate(position))

    def translate(self, offset: VectorLike) -> Item:
        """The item moved by `offset`."""
        return self.with_(transform=self.transform.translate(offset))

    def rotate(self, axis: Axis, angle: float) -> Item:
        """The item turned about the world's origin; see `Transform.rotate`."""
        return self.with_(transform=self.transform.rotate(axis, angle))

    def scale(self, factor: float | VectorLike) -> Item:
        """The item scaled about the world's origin; see `Transform.scale`."""
        return self.with_(transform=self.transform.scale(factor))

    def with_(self, **changes: Any) -> Item:
        """The item with other fields."""
        return attrs.evolve(self, **changes)

    @property
    def bounds(self) -> Bounds:
        """(2, 3): a box in world space around the shape's own box, placed, wherever it moves."""
        return _item_box(self, np.asarray(self.shape.bounds, np.float64))

    def still(self, time: float) -> Item:
        """The item as it stands at a time; itself where it does not move."""
        return self.with_(transform=self.transform.at(time)) if isinstance(self.transform, Motion) else self


def placed_box(box: Bounds, matrix: npt.NDArray[np.float64]) -> Bounds:
    """Box around a placed box: the only one of `placed_boxes`."""
    bounds: Bounds = placed_boxes(box[None], matrix[None])[0]
    return bounds


def placed_boxes(boxes: npt.NDArray[np.float64], matrices: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """(n, 2, 3): boxes around placed boxes, axis by axis. Source: Arvo, "Transforming axis-aligned bounding boxes",
    1990."""
    linear, offset = matrices[:, None, :3, :3], matrices[:, None, :3, 3]
    # A zero entry ignores its axis, even where the box is infinite along it.
    reach = np.zeros((len(boxes), 2, 3, 3))
    np.multiply(linear, boxes[:, :, None, :], out=reach, where=np.broadcast_to(linear != 0, reach.shape))
    placed: npt.NDArray[np.float64] = np.stack([reach.min(axis=1), reach.max(axis=1)], axis=1).sum(axis=3) + offset
    return placed


def _item_box(item: Item, box: Bounds) -> Bounds:
    """Box around an item of which the shape's own box is known, with room for what a displacement may move."""
    room = 0.0 if item.displacement is None else item.displacement.reach
    return _swept_box(np.stack([box[0] - room, box[1] + room]), item.transform)


def _swept_box(box: Bounds, transform: Transform | Motion) -> Bounds:
    if isinstance(transform, Transform):
        return placed_box(box, transform.matrix)
    times = transform.times
    steps = np.concatenate([np.linspace(*span, _STEPS) for span in pairwise(times)])
    boxes = np.stack([placed_box(box, transform.at(time).matrix) for time in steps.tolist()])
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _items(value: Sequence[Item]) -> tuple[Item, ...]:
    members: tuple[Item, ...] = _members(value, "items", (Item,), "an Item")
    return members


def _lights(value: Sequence[Light]) -> tuple[Light, ...]:
    members: tuple[Light, ...] = _members(value, "lights", _LIGHTS, "a light (PointLight, Sun, RectLight, Sky, ...)")
    return members


def _members(value: Any, field: str, kinds: tuple[type, ...], wanted: str) -> Any:
    if isinstance(value, kinds):
        raise SceneError(f"Scene: {field} must be a list, but is one {type(value).__name__}; write [...] around it")
    if isinstance(value, str | bytes) or not isinstance(value, Iterable):
        raise SceneError(f"Scene: {field} must be a list, but is {_described(value)}")
    members = tuple(value)
    for index, member in enumerate(members):
        if not isinstance(member, kinds):
            hint = "; wrap a shape in Item(...)" if kinds == (Item,) and is_shape(member) else ""
            raise SceneError(f"Scene: {field}[{index}] must be {wanted}, but is {_described(member)}{hint}")
    return members


@attrs.frozen
class Scene:
    """All that a picture shows: `items`, `lights`, and the `camera` that looks at them, if there is one.

    Items with an `Emitter` material shine too. `medium` fills the air, by default with nothing; `PathTrace` shows it.
    Raises `SceneError` for members of other types.
    """

    items: tuple[Item, ...] = attrs.field(converter=_items)
    lights: tuple[Light, ...] = attrs.field(default=(), converter=_lights)
    camera: AnyCamera | None = attrs.field(default=None, validator=_camera)
    name: str | None = attrs.field(default=None, validator=_name)
    medium: Medium | None = attrs.field(default=None, kw_only=True, validator=_medium)

    @property
    def bounds(self) -> Bounds:
        """(2, 3): a box in world space around all items; raises `SceneError` where there are none."""
        if not self.items:
            raise SceneError("a scene without items has no bounds: give it some, or a camera and lights to see by")
        boxes: dict[int, Bounds] = {}
        for item in self.items:
            if id(item.shape) not in boxes:
                boxes[id(item.shape)] = np.asarray(item.shape.bounds, np.float64)
        placed = np.stack([_item_box(item, boxes[id(item.shape)]) for item in self.items])
        return np.stack([placed[:, 0].min(axis=0), placed[:, 1].max(axis=0)])

    @property
    def shutter(self) -> tuple[float, float]:
        """When the camera's shutter opens and closes, in seconds; (0, 0) without a camera."""
        return (0.0, 0.0) if self.camera is None else self.camera.shutter

    @property
    def moves(self) -> bool:
        """Whether anything moves while the shutter is open: an item or the camera."""
        motions = [item.transform for item in self.items if isinstance(item.transform, Motion)]
        if self.camera is not None and self.camera.motion is not None:
            motions.append(self.camera.motion)
        return any(motion.moves(*self.shutter) for motion in motions)

    def still(self, time: float | None = None) -> Scene:
        """The scene at a time, everything in it standing still; halfway between the shutter's opening and closing if
        none is given. A scene in which nothing has a `Motion` is given back as it is."""
        moving = any(isinstance(item.transform, Motion) for item in self.items)
        if not moving and (self.camera is None or self.camera.motion is None):
            return self
        opened, closed = self.shutter
        moment = opened / 2 + closed / 2 if time is None else time
        return self.with_(items=[item.still(moment) for item in self.items], camera=camera_at(self, moment))

    def with_(self, **changes: Any) -> Scene:
        """The scene with other fields: `scene.with_(camera=...)`."""
        return attrs.evolve(self, **changes)


def camera_at(scene: Scene, time: float) -> AnyCamera | None:
    """The camera of a scene as it stands at a time."""
    return None if scene.camera is None else scene.camera.still(time)
