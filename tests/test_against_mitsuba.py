"""The same pictures as Mitsuba 3 makes, where it is installed (extra `bench`); see bench/compare_mitsuba.py."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("mitsuba")

# After the tests' own folder, some of whose names are there too.
sys.path.append(str(Path(__file__).parents[1] / "bench"))
import compare_mitsuba


@pytest.mark.parametrize("name", compare_mitsuba.SCENES)
def test_same_picture(name):
    if name in ("environment", "thin lens", "orthographic") and not compare_mitsuba.has_models():
        pytest.skip("the models are not here")
    found, _, _ = compare_mitsuba.compare(name, size=32, samples=64)
    # 0.2 % and what the noise of the means lets through.
    assert abs(found.ratio - 1) < 0.002 + 3.5 * found.ratio_error
    # 9,216 values, of variances that are estimated themselves.
    assert found.share > 0.99
    assert 0.6 < found.mean_square < 1.25
