"""Cameras: where pictures are taken from, and how pixels become rays."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError, SceneError
from isophote.scene.fields import (
    Vector,
    as_number,
    as_optional_number,
    as_pair,
    as_vector,
    non_negative,
    optional,
    pair,
    positive,
    vector,
)
from isophote.scene.motion import Motion
from isophote.scene.shutter import moved_camera, rigid_motion, shutter_times
from isophote.scene.transform import Transform, look_frame

__all__ = ["AnyCamera", "Camera", "CameraMap", "OrthographicCamera"]

Array: TypeAlias = npt.NDArray[np.float64]
Size: TypeAlias = tuple[int, int]

_ROTATION_TOLERANCE = 1e-6


class CameraMap(NamedTuple):
    """A camera for pictures of one size, as one map that is linear in film and lens coordinates.

    For the film position (px, py) in pixels, 0 to width and 0 to height, y downward, centres of pixels at
    + 1/2, and the point (a, b) of the unit disk of the lens, the ray has

        origin = o + px ox + py oy + a oa + b ob,  direction = d + px dx + py dy + a da + b db,

    each (3,) float64, in world space. The direction's component along the viewing axis is 1, so that a ray's
    parameter is the depth measured from the plane through the eye.
    """

    o: Array
    ox: Array
    oy: Array
    oa: Array
    ob: Array
    d: Array
    dx: Array
    dy: Array
    da: Array
    db: Array


def _checked_size(size: Size) -> Size:
    try:
        width, height = (int(length) for length in size)
        whole = (width, height) == tuple(size)
    except (TypeError, ValueError):
        whole = False
    if not whole or width < 1 or height < 1:
        raise RenderError(f"a picture's size is (width, height), whole numbers above 0, but is {size!r}")
    return width, height


def _fov(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    positive(instance, attribute, value)
    if value >= 180:
        raise SceneError(f"Camera: fov_degrees must lie between 0 and 180, but is {value}")


def _local(points: npt.ArrayLike, eye: Vector, axes: Array) -> tuple[Array, Array, Array]:
    """Coordinates of points along right, up and the viewing direction, from the eye."""
    given = np.asarray(points, np.float64)
    if given.ndim == 0 or given.shape[-1] != 3:
        raise SceneError(f"points must have shape (..., 3), but have {given.shape}")
    across, along, back = np.moveaxis((given - np.array(eye)) @ axes.T, -1, 0)
    return across, along, -back


@attrs.frozen
class Camera:
    """A perspective camera at `eye` that looks at `target`, with `up` upward in the picture.

    `fov_degrees` is the full vertical angle of view, between 0 and 180. With `lens_radius` above 0, in metres, it is a
    thin lens: sharp where the depth (the distance along the viewing axis) is `focus_distance`, by default that
    of the target. `principal_point` is where the viewing axis meets the picture, as parts of its width and height
    from the top left corner; `pixel_aspect` is the width of a pixel over its height.

    The picture is taken while the `shutter` is open, from one time to another in seconds: what moves, is blurred.
    `motion` moves the camera: rigid placements of its frame, which looks down its −Z (`Transform.look_at`), in place of
    `eye`, `target` and `up`; the focus stays as far away as it is.

    Raises `SceneError` where `eye` is `target`, `up` is parallel to the view, or a number is out of range.
    """

    eye: Vector = attrs.field(converter=as_vector, validator=vector)
    target: Vector = attrs.field(converter=as_vector, validator=vector)
    up: Vector = attrs.field(default=(0.0, 1.0, 0.0), converter=as_vector, validator=vector)
    fov_degrees: float = attrs.field(default=40.0, converter=as_number, validator=_fov)
    lens_radius: float = attrs.field(default=0.0, converter=as_number, validator=non_negative)
    focus_distance: float | None = attrs.field(default=None, converter=as_optional_number, validator=optional(positive))
    principal_point: tuple[float, float] = attrs.field(
        default=(0.5, 0.5), kw_only=True, converter=as_pair, validator=pair
    )
    pixel_aspect: float = attrs.field(default=1.0, kw_only=True, converter=as_number, validator=positive)
    shutter: tuple[float, float] = attrs.field(
        default=(0.0, 0.0), kw_only=True, converter=as_pair, validator=shutter_times
    )
    motion: Motion | None = attrs.field(default=None, kw_only=True, validator=optional(rigid_motion))

    def __attrs_post_init__(self) -> None:
        look_frame(self.eye, self.target, self.up)

    def with_(self, **changes: Any) -> Camera:
        """The camera with other fields: `camera.with_(shutter=(0, 1))`."""
        return attrs.evolve(self, **changes)

    def still(self, time: float) -> Camera:
        """The camera where it is at a time, standing still."""
        return moved_camera(self, time)

    @property
    def axes(self) -> Array:
        """(3, 3) unit rows right, up, back of the camera's frame, in world space."""
        return look_frame(self.eye, self.target, self.up)

    @property
    def transform(self) -> Transform:
        """The camera's frame (x right, y up, looking down −Z) to world space."""
        return Transform.look_at(self.eye, self.target, self.up)

    @property
    def focus(self) -> float:
        """Depth at which a thin lens is sharp: `focus_distance`, or the distance to the target."""
        return math.dist(self.eye, self.target) if self.focus_distance is None else self.focus_distance

    def _pixel(self, size: Size) -> tuple[float, float]:
        """Width and height of a pixel on the plane at depth 1."""
        height = 2 * math.tan(math.radians(self.fov_degrees) / 2) / size[1]
        return height * self.pixel_aspect, height

    def linear_map(self, size: Size) -> CameraMap:
        """The rays of a picture of (width, height) pixels; see `CameraMap`."""
        width, height = _checked_size(size)
        right, up, back = self.axes
        step_x, step_y = self._pixel((width, height))
        cx, cy = self.principal_point[0] * width, self.principal_point[1] * height
        zero = np.zeros(3)
        oa, ob = self.lens_radius * right, self.lens_radius * up
        return CameraMap(
            o=np.array(self.eye),
            ox=zero,
            oy=zero,
            oa=oa,
            ob=ob,
            d=-back - cx * step_x * right + cy * step_y * up,
            dx=step_x * right,
            dy=-step_y * up,
            da=-oa / self.focus,
            db=-ob / self.focus,
        )

    def project(self, points: npt.ArrayLike, size: Size) -> tuple[Array, Array]:
        """Film positions (..., 2) in pixels and depths (...) of points (..., 3), through the lens's centre.

        Film positions of points at depth 0 or behind are NaN.
        """
        width, height = _checked_size(size)
        across, along, depth = _local(points, self.eye, self.axes)
        step_x, step_y = self._pixel((width, height))
        ahead = np.where(depth > 0, depth, np.nan)
        x = self.principal_point[0] * width + across / ahead / step_x
        y = self.principal_point[1] * height - along / ahead / step_y
        return np.stack([x, y], axis=-1), depth

    @classmethod
    def from_opencv(cls, K: npt.ArrayLike, R: npt.ArrayLike, t: npt.ArrayLike, size: Size) -> Camera:
        """The camera of OpenCV's x ~ K (R p + t), for pictures of (width, height) pixels.

        `K` is (3, 3) without skew, `R` a (3, 3) rotation and `t` (3,), from world to camera (x right, y down,
        z ahead); the world is left as it is. OpenCV's pixel (0, 0) has its centre at coordinate 0, so that
        cx = (width − 1) / 2 is the middle; Isophote's film positions are larger by 1/2. Raises `SceneError`
        for skew, focal lengths of 0 or below, and an `R` that is no rotation.
        """
        width, height = _checked_size(size)
        fx, fy, cx, cy = _intrinsics(K)
        rotation, offset = _extrinsics(R, t)
        eye = -rotation.T @ offset
        # As far ahead as the eye is from the origin, so that target − eye cancels no digits.
        ahead = max(1.0, float(np.abs(eye).max()))
        target = eye + ahead * rotation[2]
        return cls(
            eye=eye,
            target=target,
            up=-rotation[1],
            fov_degrees=math.degrees(2 * math.atan(height / (2 * fy))),
            principal_point=((cx + 0.5) / width, (cy + 0.5) / height),
            pixel_aspect=fy / fx,
        )

    def to_opencv(self, size: Size) -> tuple[Array, Array, Array]:
        """OpenCV's (K, R, t), (3, 3), (3, 3) and (3,), of this camera for pictures of (width, height) pixels.

        See `from_opencv` for the conventions; a lens is left out, for OpenCV has none.
        """
        width, height = _checked_size(size)
        step_x, step_y = self._pixel((width, height))
        cx, cy = self.principal_point[0] * width - 0.5, self.principal_point[1] * height - 0.5
        K = np.array([[1 / step_x, 0, cx], [0, 1 / step_y, cy], [0, 0, 1]])
        right, up, back = self.axes
        R = np.stack([right, -up, -back])
        return K, R, -R @ np.array(self.eye)


def _intrinsics(given: npt.ArrayLike) -> tuple[float, float, float, float]:
    K = _matrix(given, (3, 3), "K")
    if K[0, 1] != 0 or K[1, 0] != 0 or tuple(K[2]) != (0, 0, 1):
        raise SceneError(f"K must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew, but is {K.tolist()}")
    fx, fy, cx, cy = float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2])
    if fx <= 0 or fy <= 0:
        raise SceneError(f"the focal lengths in K must be above 0, but are {fx} and {fy}")
    return fx, fy, cx, cy


def _extrinsics(rotation: npt.ArrayLike, offset: npt.ArrayLike) -> tuple[Array, Array]:
    R, t = _matrix(rotation, (3, 3), "R"), _matrix(np.reshape(offset, -1), (3,), "t")
    if np.abs(R @ R.T - np.eye(3)).max() > _ROTATION_TOLERANCE or np.linalg.det(R) < 0:
        raise SceneError(f"R must be a rotation, but is {R.tolist()}; cv2.Rodrigues makes one of a vector")
    return R, t


def _matrix(given: npt.ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    try:
        array = np.array(given, np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != shape or not np.isfinite(array).all():
        raise SceneError(f"{name} must be finite numbers of shape {shape}, but is {given!r}")
    return array


@attrs.frozen
class OrthographicCamera:
    """A camera with parallel rays, from the plane through `eye` toward `target`; `height` is the picture's, in metres.

    `shutter` and `motion` are those of `Camera`. Raises `SceneError` where `eye` is `target`, `up` is parallel
    to the view, or `height` is not above 0.
    """

    eye: Vector = attrs.field(converter=as_vector, validator=vector)
    target: Vector = attrs.field(converter=as_vector, validator=vector)
    up: Vector = attrs.field(default=(0.0, 1.0, 0.0), converter=as_vector, validator=vector)
    height: float = attrs.field(default=2.0, converter=as_number, validator=positive)
    shutter: tuple[float, float] = attrs.field(
        default=(0.0, 0.0), kw_only=True, converter=as_pair, validator=shutter_times
    )
    motion: Motion | None = attrs.field(default=None, kw_only=True, validator=optional(rigid_motion))

    def __attrs_post_init__(self) -> None:
        look_frame(self.eye, self.target, self.up)

    def with_(self, **changes: Any) -> OrthographicCamera:
        """The camera with other fields: `camera.with_(shutter=(0, 1))`."""
        return attrs.evolve(self, **changes)

    def still(self, time: float) -> OrthographicCamera:
        """The camera where it is at a time, standing still."""
        return moved_camera(self, time)

    @property
    def axes(self) -> Array:
        """(3, 3) unit rows right, up, back of the camera's frame, in world space."""
        return look_frame(self.eye, self.target, self.up)

    @property
    def transform(self) -> Transform:
        """The camera's frame (x right, y up, looking down −Z) to world space."""
        return Transform.look_at(self.eye, self.target, self.up)

    def linear_map(self, size: Size) -> CameraMap:
        """The rays of a picture of (width, height) pixels; see `CameraMap`."""
        width, height = _checked_size(size)
        right, up, back = self.axes
        step = self.height / height
        zero = np.zeros(3)
        return CameraMap(
            o=np.array(self.eye) - width / 2 * step * right + height / 2 * step * up,
            ox=step * right,
            oy=-step * up,
            oa=zero,
            ob=zero,
            d=-back,
            dx=zero,
            dy=zero,
            da=zero,
            db=zero,
        )

    def project(self, points: npt.ArrayLike, size: Size) -> tuple[Array, Array]:
        """Film positions (..., 2) in pixels and depths (...) of points (..., 3); depths may be negative."""
        width, height = _checked_size(size)
        across, along, depth = _local(points, self.eye, self.axes)
        step = self.height / height
        return np.stack([width / 2 + across / step, height / 2 - along / step], axis=-1), depth


AnyCamera: TypeAlias = Camera | OrthographicCamera
