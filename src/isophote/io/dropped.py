"""Saying what a format has no place for."""

from __future__ import annotations

import warnings
from collections.abc import Collection
from os import fspath

from isophote.errors import IsophoteWarning
from isophote.io.files import StrPath
from isophote.shapes.mesh import Mesh

__all__ = ["warn_dropped"]


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
