"""Compiled kernels are kept under a digest of all that they are made of."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import isophote.kernels
from isophote.kernels.base import cache

KERNELS = Path(isophote.kernels.__file__).parent
FILES = sorted(KERNELS.rglob("*.py"))


def _modules(file: Path) -> set[str]:
    """Modules and names below `isophote.kernels` that a file imports, read by Python's own parser."""
    names = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    return {name for name in names if name.startswith("isophote.kernels")}


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_no_import_is_missed(file: Path) -> None:
    sources = cache.sources_of(file)
    assert file in sources
    for name in _modules(file):
        place = KERNELS.joinpath(*name.split(".")[2:])
        for found in (place.with_suffix(".py"), place / "__init__.py"):
            assert not found.is_file() or set(cache.sources_of(found)) <= set(sources)


def test_what_is_not_imported_does_not_count() -> None:
    sources = {path.stem for path in cache.sources_of(KERNELS / "forms" / "triangle.py")}
    assert "vec" in sources or "simd" in sources
    assert "path" not in sources
