"""Saying what a format has no place for."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Sequence
from os import fspath

from isophote.errors import IsophoteWarning
from isophote.io.files import StrPath
from isophote.scene.scene import Item
from isophote.shapes.mesh import Mesh

__all__ = ["warn_displaced", "warn_dropped"]


def warn_dropped(
    mesh: Mesh, path: StrPath, format_name: str, *, attributes: Collection[str], labels: Collection[str]
) -> None:
    """Warn of every attribute and label of the mesh that is not among those that the format holds."""
    lost = [f'"{name}"' for name in mesh.attributes if name not in attributes]
    lost += [f'labels "{name}"' for name in mesh.labels if name not in labels]
    if lost:
        warnings.warn(
            f"{fspath(path)}: {format_name} has no place for {', '.join(lost)}", IsophoteWarning, stacklevel=5
        )


def warn_displaced(items: Sequence[Item], path: StrPath, format_name: str) -> None:
    """Warn of items that a displacement moves in pictures, and that are written as they are without."""
    numbers = [str(number) for number, item in enumerate(items) if item.displacement is not None]
    if numbers:
        warnings.warn(
            f"{fspath(path)}: {format_name} has no place for the displacement of items {', '.join(numbers)}; "
            "isophote.displace makes meshes that are displaced",
            IsophoteWarning,
            stacklevel=5,
        )
