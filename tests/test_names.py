"""Public names: all can be had, and none is that of a module, which would replace it once it is imported."""

from __future__ import annotations

import pkgutil

import pytest

import isophote as iso


@pytest.mark.parametrize("package", [iso, iso.analysis], ids=lambda package: package.__name__)
def test_every_public_name_is_there_and_is_no_module(package: object) -> None:
    modules = {module.name for module in pkgutil.iter_modules(package.__path__)}
    for name in package.__all__:
        assert getattr(package, name) is not None
    assert modules.isdisjoint(set(package.__all__) - {"analysis"})
