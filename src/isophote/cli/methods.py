"""The rendering methods that the command line knows, and their settings."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import TYPE_CHECKING

import attrs
import typer

if TYPE_CHECKING:
    from isophote.rendering.method import Method

__all__ = ["METHODS", "new_method"]

# Name on the command line → module in isophote.rendering, and class there.
METHODS = {
    "occlusion": ("occlusion.picture", "AmbientOcclusion"),
    "path": ("path_trace", "PathTrace"),
    "radiosity": ("radiosity.method", "Radiosity"),
    "ray": ("ray_trace", "RayTrace"),
    "sphere": ("sphere_trace", "SphereTrace"),
    "visits": ("visits", "Visits"),
}

# Options that are called otherwise than the settings that they are: --method is the rendering method itself.
_FIELDS = {"solver": "method"}


def new_method(name: str, settings: Mapping[str, object]) -> Method:
    """The method of a name with its settings; those that are None are left to the method.

    Raises `typer.BadParameter` for settings that the method does not have, `RenderError` for values without meaning.
    """
    module, class_name = METHODS[name]
    kind = getattr(importlib.import_module(f"isophote.rendering.{module}"), class_name)
    given = {key: value for key, value in settings.items() if value is not None}
    known = {field.name for field in attrs.fields(kind)}
    for key in given:
        if _FIELDS.get(key, key) not in known:
            raise typer.BadParameter(f"the method {name} has no --{key.replace('_', '-')}")
    method: Method = kind(**{_FIELDS.get(key, key): value for key, value in given.items()})
    return method
