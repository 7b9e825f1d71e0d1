"""Measured reflectance."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.fields import ArrayKey, frozen_array, instance_of, optional
from isophote.scene.material_base import Material

__all__ = ["MEASURED_SHAPE", "Measured"]

Values: TypeAlias = npt.NDArray[np.float32]

MEASURED_SHAPE = (90, 90, 180, 3)


def _values(value: Any) -> Values:
    try:
        given = np.asarray(value)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape != MEASURED_SHAPE or given.dtype.kind not in "fiu":
        raise SceneError(f"Measured: values must be an array of shape {MEASURED_SHAPE}, but are {given.shape}")
    values = np.ascontiguousarray(given, np.float32)
    if not np.isfinite(values).all():
        bad = np.argwhere(~np.isfinite(values))[0].tolist()
        raise SceneError(f"Measured: values must be finite, but values{bad} is not")
    return frozen_array(values)


@attrs.frozen(repr=False)
class Measured(Material):
    """Isotropic reflectance by a table, as MERL's database has it.

    `values` is (90, 90, 180, 3) float32: f, per steradian, of the cells of √(θ_h / 90°), θ_d / 90° and φ_d / 180°,
    where θ_h is the angle of the half direction to the normal and (θ_d, φ_d) where light comes from, seen from it
    (Rusinkiewicz, 1998). Values below 0, as in cells that no pair of directions falls in, count as 0. `name` is for
    people. Tables are not checked for reflecting more than comes.
    """

    values: Values = attrs.field(converter=_values, eq=ArrayKey)
    name: str | None = attrs.field(default=None, validator=optional(instance_of("a string or None", str)))

    def __repr__(self) -> str:
        return "<Measured reflectance>" if self.name is None else f"<Measured reflectance: {self.name}>"
