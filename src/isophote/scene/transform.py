"""Affine maps of space: where things are placed."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.fields import ArrayKey, VectorLike, frozen_array

__all__ = ["Axis", "Transform", "look_frame", "unit_vector"]

Matrix: TypeAlias = npt.NDArray[np.float64]
Axis: TypeAlias = str | VectorLike

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_LAST_ROW = (0.0, 0.0, 0.0, 1.0)
_PARALLEL = 1e-9

# Matrices that flatten space by so much, or shrink it so far, have no inverse in floating point.
_FLAT = 1e-14
_TINY = 1e-300


def _matrix(value: npt.ArrayLike) -> Matrix:
    try:
        matrix = np.array(value, np.float64)
    except (TypeError, ValueError) as error:
        raise SceneError(f"a transform's matrix must be 4 by 4 numbers: {error}") from None
    if matrix.shape != (4, 4):
        raise SceneError(f"a transform's matrix must be (4, 4), but is {matrix.shape}")
    if not np.isfinite(matrix).all():
        raise SceneError(f"a transform's matrix must be finite, but is {matrix.tolist()}")
    if tuple(matrix[3]) != _LAST_ROW:
        raise SceneError(f"a transform is affine: its last row must be [0, 0, 0, 1], not {matrix[3].tolist()}")
    if _is_singular(matrix[:3, :3]):
        raise SceneError(
            f"a transform must not flatten space, but this matrix is singular: {matrix.tolist()}; "
            "use a small scale instead of 0"
        )
    return frozen_array(matrix)


def _is_singular(linear: Matrix) -> bool:
    values = np.linalg.svd(linear, compute_uv=False)
    return bool(values[2] <= max(_FLAT * values[0], _TINY))


def _three(value: VectorLike, what: str) -> Matrix:
    try:
        three = np.array(value, np.float64)
    except (TypeError, ValueError):
        three = np.empty(0)
    if three.shape != (3,) or not np.isfinite(three).all():
        raise SceneError(f"{what} must be three finite numbers (x, y, z), but is {value!r}")
    return three


def unit_vector(axis: Axis, what: str) -> Matrix:
    """(3,) unit vector along an axis, which `what` names in the message of a `SceneError`."""
    if isinstance(axis, str):
        if axis not in _AXES:
            raise SceneError(f"{what} must be 'x', 'y', 'z' or a vector, but is {axis!r}")
        return np.array(_AXES[axis])
    three = _three(axis, what)
    largest = np.abs(three).max()
    if largest == 0:
        raise SceneError(f"{what} must have a length above zero, but is {axis!r}")
    three /= largest
    return three / float(np.linalg.norm(three))


def look_frame(eye: VectorLike, target: VectorLike, up: VectorLike) -> Matrix:
    """Rows right, up, back (3, 3): the axes of a frame at `eye` that looks down its −Z at `target`.

    Raises `SceneError` where `eye` and `target` coincide or `up` is parallel to the line between them.
    """
    origin, goal = _three(eye, "eye"), _three(target, "target")
    if (origin == goal).all():
        raise SceneError(f"eye and target are both {tuple(origin.tolist())}; they must be apart")
    back = unit_vector(origin - goal, "the view direction")
    across = np.cross(unit_vector(up, "up"), back)
    length = float(np.linalg.norm(across))
    if length < _PARALLEL:
        raise SceneError(
            f"up {tuple(_three(up, 'up').tolist())} is parallel to the view direction {tuple((-back).tolist())}; "
            "choose another up"
        )
    right = across / length
    return np.stack([right, np.cross(back, right), back])


@attrs.frozen(repr=False)
class Transform:
    """An affine map p ↦ M p of points of space.

    `matrix` is (4, 4), float64, for column vectors, its last row [0, 0, 0, 1]. Methods return a new
    transform that does this one first and then what the method says, so
    `Transform.identity().rotate("y", 1).translate((0, 2, 0))` turns about the origin and then lifts.

    Raises `SceneError` for matrices of another shape, and for non-finite and singular ones.
    """

    matrix: Matrix = attrs.field(converter=_matrix, eq=ArrayKey)

    @classmethod
    def identity(cls) -> Transform:
        """The map that leaves everything where it is."""
        return cls(np.eye(4))

    @classmethod
    def look_at(cls, eye: VectorLike, target: VectorLike, up: VectorLike = (0, 1, 0)) -> Transform:
        """Places a frame at `eye` so that its −Z points at `target` and its +Y as nearly as can be along `up`."""
        return cls(_affine(look_frame(eye, target, up).T, _three(eye, "eye")))

    def translate(self, offset: VectorLike) -> Transform:
        """Then move by `offset`."""
        return Transform(_affine(np.eye(3), _three(offset, "offset"))) @ self

    def rotate(self, axis: Axis, angle: float) -> Transform:
        """Then turn about the line through the origin along `axis`, by `angle` radians, right-handed."""
        if not isinstance(angle, int | float | np.number) or not np.isfinite(angle):
            raise SceneError(f"angle must be a finite number of radians, but is {angle!r}")
        x, y, z = unit_vector(axis, "axis")
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        # Rodrigues' formula
        linear = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
        return Transform(_affine(linear)) @ self

    def scale(self, factor: float | VectorLike) -> Transform:
        """Then scale about the origin, by one factor or by one for each axis; 0 is refused."""
        factors = [factor] * 3 if isinstance(factor, int | float | np.number) else factor
        return Transform(_affine(np.diag(_three(factors, "factor")))) @ self

    def mirror(self, axis: Axis) -> Transform:
        """Then mirror at the plane through the origin that is perpendicular to `axis`."""
        normal = unit_vector(axis, "axis")
        return Transform(_affine(np.eye(3) - 2 * np.outer(normal, normal))) @ self

    def then(self, other: Transform) -> Transform:
        """This transform and after it `other`: `other @ self`."""
        return other @ self

    def __matmul__(self, other: Transform) -> Transform:
        """`a @ b` does `b` first, then `a`, as matrices do."""
        if not isinstance(other, Transform):
            return NotImplemented
        return Transform(self.matrix @ other.matrix)

    def inverse(self) -> Transform:
        """The map that undoes this one."""
        linear = np.linalg.inv(self.matrix[:3, :3])
        return Transform(_affine(linear, -linear @ self.matrix[:3, 3]))

    def apply(self, points: npt.ArrayLike) -> Matrix:
        """Images of points, (..., 3), float64."""
        given = np.asarray(points, np.float64)
        if given.ndim == 0 or given.shape[-1] != 3:
            raise SceneError(f"points must have shape (..., 3), but have {given.shape}")
        image: Matrix = given @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return image

    @property
    def is_rigid(self) -> bool:
        """Whether it only turns and moves: no scale, no mirror (to one part in 10⁶)."""
        linear = self.matrix[:3, :3]
        return bool(np.abs(linear @ linear.T - np.eye(3)).max() < 1e-6 and np.linalg.det(linear) > 0)

    def __repr__(self) -> str:
        if (self.matrix == np.eye(4)).all():
            return "Transform.identity()"
        return f"Transform({self.matrix.tolist()})"


def _affine(linear: npt.NDArray[Any], offset: npt.NDArray[Any] | None = None) -> Matrix:
    matrix = np.eye(4)
    matrix[:3, :3] = linear
    if offset is not None:
        matrix[:3, 3] = offset
    return matrix
