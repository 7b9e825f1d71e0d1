"""Fields as files: what each ending makes of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from isophote.errors import FileError
from isophote.io.files import StrPath
from isophote.io.html import write_html
from isophote.shapes.field.field import Field

__all__ = ["save_field"]

_WRITERS = {".html": write_html}


def save_field(shape: Field, path: StrPath, **options: Any) -> None:
    """Write a field by the ending of the name: .html is a web page that stands alone (option `title`)."""
    ending = Path(path).suffix.lower()
    if ending not in _WRITERS:
        raise FileError(path, f'"{ending}" is no ending for a field; use one of {", ".join(_WRITERS)}')
    _WRITERS[ending](path, shape, **options)
