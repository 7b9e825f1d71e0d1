"""The checks that users run: they pass here, fail where something is wrong, and say so."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import isophote as iso
from command_line import facts, misused, run, succeeds
from isophote.checks import (
    agreement,
    enclosures,
    fields,
    form_factors,
    lights,
    occlusion,
    random_numbers,
    reflectance,
    scatter,
)
from isophote.checks.check import Check, Effort, Measured, mean_of
from isophote.checks.materials import MATERIALS, WHITE_PLACES, material_of
from isophote.checks.report import Finding
from isophote.checks.run import TOPICS
from isophote.cli import selfcheck as verb
from isophote.errors import RenderError


@pytest.mark.parametrize("topic", TOPICS)
def test_everything_passes(topic: str) -> None:
    report = iso.selfcheck(topic, progress=False)
    assert report.passed, str(report)
    assert len(report.findings) >= 6


def kinds(base: type) -> set[type]:
    """All kinds of material below a base, however deep."""
    return {kind for child in base.__subclasses__() for kind in ({child} if child.__module__ else set()) | kinds(child)}


def test_every_kind_of_material_is_checked() -> None:
    checked = {type(material_of(name)) for name in MATERIALS} | {type(one) for one in WHITE_PLACES.values()}
    ours = {kind for kind in kinds(iso.Material) if kind.__module__.startswith("isophote.")}
    # What shines reflects as its body does.
    assert ours - checked == {iso.Emitter}


def test_another_seed_gives_other_numbers_and_threads_the_same() -> None:
    one, two, other = (
        [f.measured for f in iso.selfcheck("occlusion", seed=seed, threads=threads, progress=False).findings]
        for seed, threads in ((0, 1), (0, 2), (1, 2))
    )
    assert one == two
    assert one != other


def test_thorough_runs_allow_less() -> None:
    quick, thorough = (
        {f.name: f for f in iso.selfcheck("random-numbers", thorough=thorough, progress=False).findings}
        for thorough in (False, True)
    )
    assert all(finding.passed for finding in thorough.values())
    assert thorough["independent"].allowed == pytest.approx(quick["independent"].allowed / 4, rel=0.1)


def test_the_closed_forms_are_those_of_the_literature() -> None:
    report = iso.selfcheck(["form-factors"], progress=False)
    exact = {finding.name: finding.exact for finding in report.findings}
    assert exact["unit squares, parallel"] == pytest.approx(0.199824896, abs=5e-10)
    assert exact["unit squares, at right angles"] == pytest.approx(0.200043776, abs=5e-10)


@pytest.mark.parametrize(
    ("measured", "passed"),
    [
        (Measured(1.0, 1.1, 0.2), True),
        (Measured(1.0, 1.1, 0.05), False),
        (Measured(1.2, 1.1, 0.05), False),
        (Measured(0.0, 1.0, 0.01, at_most=True), True),
        (Measured(1.02, 1.0, 0.01, at_most=True), False),
        (Measured(math.nan, 1.0, 0.01), False),
        (Measured(math.nan, 1.0, 0.01, at_most=True), False),
        (Measured(1.0, 1.0, math.nan), False),
    ],
)
def test_what_passes(measured: Measured, passed: bool) -> None:
    assert measured.passed == passed
    assert Finding("topic", "name", *measured, seconds=0.0).passed == passed


def test_means_may_be_off_by_their_noise() -> None:
    found = mean_of([1.0, 3.0] * 200, 2.0, 0.25)
    assert found.measured == 2.0
    assert found.allowed == pytest.approx(0.25 + 4.5 / 20, rel=2e-3)


def broken(effort: Effort) -> Measured:
    raise ValueError("the wall is missing")


def test_what_is_wrong_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = [Check("form factors", "a wall", broken), Check("form factors", "two", lambda effort: Measured(2, 1, 0.5))]
    monkeypatch.setattr(form_factors, "CHECKS", [*form_factors.CHECKS, *wrong])
    report = iso.selfcheck(["form-factors"], progress=False)
    assert [finding.name for finding in report.failures] == ["a wall", "two"]
    assert not report.passed
    result = run("selfcheck", "form-factors")
    assert result.exit_code == 1
    assert "ValueError: the wall is missing" in result.stdout
    assert "9 checks" in result.stdout
    assert "2 FAILED" in result.stdout
    assert "failed: form factors, a wall, form factors, two" in result.stderr
    found = run("selfcheck", "form-factors", "--json")
    assert found.exit_code == 1
    assert '"passed": false' in found.stdout


class Brighter:
    """A result, some of whose values are off."""

    def __init__(self, true: Any, factor: float) -> None:
        self._true, self._factor = true, factor

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._true, name)
        return self._factor * value if name in ("visibility", "value", "distance", "irradiance", "volume") else value

    def __call__(self, *arguments: Any, **settings: Any) -> Any:
        return Brighter(self._true(*arguments, **settings), self._factor)


def off(true: Callable[..., Any], factor: float) -> Callable[..., Any]:
    """A function whose results are off by a factor, in some of their values or in all."""

    def wrong(*arguments: Any, **settings: Any) -> Any:
        found = true(*arguments, **settings)
        return factor * found if isinstance(found, float | np.ndarray) else Brighter(found, factor)

    return wrong


@pytest.mark.parametrize(
    ("topic", "module", "name", "factor", "count"),
    [
        ("form-factors", form_factors, "form_factor", 1.001, 6),
        ("random-numbers", random_numbers, "sample_pattern", 0.97, 10),
        ("materials", scatter, "_power", 1.02, 3),
        ("lights", lights, "greys", 1.01, 9),
        ("enclosures", enclosures, "greys", 1.05, 15),
        ("enclosures", enclosures, "radiosity", 1.02, 2),
        ("occlusion", occlusion, "ambient_occlusion", 1.02, 9),
        ("agreement", agreement, "_settled", 1.05, 2),
        ("fields", fields, "mass_properties", 1.01, 4),
    ],
)
def test_an_error_of_what_is_checked_is_found(
    monkeypatch: pytest.MonkeyPatch, topic: str, module: Any, name: str, factor: float, count: int
) -> None:
    few = [check for check in reflectance.CHECKS if check.name in ("Mirror", "Glass, smooth")]
    monkeypatch.setattr(reflectance, "CHECKS", few)
    monkeypatch.setattr(module, name, off(getattr(module, name), factor))
    report = iso.selfcheck(topic, progress=False)
    assert len(report.failures) >= count, str(report)
    assert all(finding.error is None for finding in report.failures), str(report)


def test_the_command_prints_a_table() -> None:
    page = succeeds("selfcheck", "form-factors")
    assert "unit squares, parallel" in page
    assert "0.199824896  0.199824896  ± 1.0e-09" in page
    assert "all passed" in page
    found = facts("selfcheck", "form-factors")
    assert found["passed"] is True
    assert found["findings"][0]["name"] == "unit squares, parallel"
    assert found["findings"][0]["exact"] == pytest.approx(0.199824896, abs=5e-10)


def test_topics_are_the_same_everywhere() -> None:
    assert list(verb.TOPICS) == list(TOPICS)
    page = succeeds("selfcheck", "--help")
    for topic in TOPICS:
        assert topic in page
    assert "is not one of random-numbers, materials" in misused("selfcheck", "astrology")
    with pytest.raises(RenderError, match="'astrology' is not one of"):
        iso.selfcheck(["astrology"])


def test_progress_is_told() -> None:
    told: list[tuple[str, float]] = []
    iso.selfcheck("form-factors", progress=lambda stage, fraction: told.append((stage, fraction)))
    assert told[0] == ("checking", 0.0)
    assert told[-1] == ("checking", 1.0)
