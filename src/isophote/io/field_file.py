"""Fields as files: what each ending makes of them."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from isophote.io.files import StrPath, check_writable
from isophote.shapes.field.field import Field

__all__ = ["check_mesh_target", "save_field"]

# Options that `to_mesh` takes; all others are the format's.
_MESHING = ("cell", "tolerance", "bounds", "method", "memory", "threads", "progress")


def save_field(shape: Field, path: StrPath, **options: Any) -> None:
    """Write a field by the ending of the name.

    .html is a web page that stands alone (option `title`). With the ending of a mesh file the field is meshed first, by
    `to_mesh` with its options `cell`, `tolerance`, `bounds`, `method`, `memory`, `threads` and `progress`; without a
    cell or a tolerance, the longest side has 128 cells. Further options are those of the format.
    """
    # Either way brings its own formats, and kernels.
    if Path(path).suffix.lower() == ".html":
        from isophote.io.html import write_html

        write_html(path, shape, **options)
        return
    from isophote.convert.contour import to_mesh
    from isophote.io.mesh_file import save_mesh

    meshing = {name: options.pop(name) for name in _MESHING if name in options}
    check_mesh_target(path, options)
    save_mesh(to_mesh(shape, **meshing), path, **options)


def check_mesh_target(path: StrPath, options: Collection[str]) -> None:
    """Raise what writing a mesh would raise, before it is made: unknown endings and options, no place to write."""
    from isophote.io.mesh_file import encoder_for

    encoder_for(path, options)
    check_writable(path)
