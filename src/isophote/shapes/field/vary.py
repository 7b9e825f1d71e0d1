"""Fields with other values of their parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs

from isophote.shapes.field.expression import Parameter
from isophote.shapes.field.form import Form

__all__ = ["with_values"]


def with_values(form: Form, values: Mapping[str, float]) -> Form:
    """The form with the parameters of these names at other values, as plain numbers; others stay."""
    varied: Form = _varied(form, values)
    return varied


def _varied(thing: Any, values: Mapping[str, float]) -> Any:
    if isinstance(thing, Parameter):
        return float(values.get(thing.name, thing)) if thing.name in values else thing
    if isinstance(thing, tuple):
        return tuple(_varied(member, values) for member in thing)
    if not isinstance(thing, Form):
        return thing
    kind: Any = type(thing)
    names = [field.name for field in attrs.fields(kind) if field.init]
    return kind(**{name.lstrip("_"): _varied(getattr(thing, name), values) for name in names})
