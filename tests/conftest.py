"""What all tests share: in continuous integration, properties are tried on the same examples every time, and random
numbers never depend on which tests ran before."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

settings.register_profile("integration", derandomize=True, deadline=None)
if os.environ.get("CI"):
    settings.load_profile("integration")

_states: dict[tuple[str, str], Any] = {}


@pytest.fixture(autouse=True)
def _random_numbers_start_anew(request: pytest.FixtureRequest) -> None:
    """A module's generators stand before every test where they stood after the import."""
    for name in ("RANDOM", "RNG"):
        generator = getattr(request.module, name, None)
        if isinstance(generator, np.random.Generator):
            state = _states.setdefault((request.module.__name__, name), generator.bit_generator.state)
            generator.bit_generator.state = state
