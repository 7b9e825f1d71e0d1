"""What scenes know of primitives before any is lowered: light to load, for scenes without them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.table import Packed
from isophote.kernels.primitive.layout import PRIMITIVES
from isophote.lower.boxes import no_boxes
from isophote.shapes.primitive.primitive import Primitive

__all__ = ["PrimitivePart", "no_primitives", "primitive_of"]


class PrimitivePart(NamedTuple):
    """An item that is an exact primitive: its material's number, its number for the user, and that of the light that it
    is, or −1."""

    primitive: Primitive
    material: int
    public: int
    light: int = -1


def primitive_of(shape: object) -> Primitive | None:
    """What a shape is as an exact primitive, or None: fields of one simple solid, and shapes that say so."""
    own = getattr(shape, "primitive", None)
    if isinstance(own, Primitive):
        return own
    from isophote.shapes.field.field import Field

    if isinstance(shape, Field):
        # Loaded where it is needed: pictures of meshes come sooner without.
        from isophote.shapes.primitive.recognise import primitive_of_form

        return primitive_of_form(shape.form)
    return None


def no_primitives() -> Packed:
    """The table of a scene without primitives: nothing is loaded or compiled for it."""
    return PRIMITIVES.pack(
        numbers=np.zeros((0, 2), np.int32),
        entries=np.zeros((0, 3), np.int64),
        reach=np.zeros((0, 6), np.float32),
        values=np.zeros(0),
        to_object=np.zeros((0, 12)),
        to_world=np.zeros((0, 12)),
        alone=np.zeros(0, np.int32),
        top_nodes=np.zeros(0, np.float32),
        top_items=np.zeros(0, np.int32),
        boxes=no_boxes(),
        boxed=np.zeros(0, np.int32),
        trace=0,
        trace_lanes=0,
        surface=0,
    )
