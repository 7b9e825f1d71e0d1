"""The checks that users run: they pass here, fail where something is wrong, and say so."""

from __future__ import annotations

import math

import pytest

import isophote as iso
from command_line import facts, misused, run, succeeds
from isophote.checks import form_factors
from isophote.checks.check import Check, Effort, Measured, mean_of
from isophote.checks.report import Finding
from isophote.checks.run import TOPICS
from isophote.cli import selfcheck as verb
from isophote.errors import RenderError


def test_everything_passes() -> None:
    report = iso.selfcheck(progress=False)
    assert report.failures == ()
    assert report.passed
    assert {finding.topic.replace(" ", "-") for finding in report.findings} == set(TOPICS)


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


def test_an_error_of_the_code_under_test_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    true = form_factors.form_factor
    monkeypatch.setattr(form_factors, "form_factor", lambda a, b: 1.001 * true(a, b))
    failed = iso.selfcheck(["form-factors"], progress=False).failures
    assert len(failed) == 6


def test_the_command_prints_a_table() -> None:
    page = succeeds("selfcheck", "form-factors")
    assert "unit squares, parallel" in page
    assert "0.199824896    0.199824896  ± 1.0e-09" in page
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
    assert "is not one of form-factors" in misused("selfcheck", "astrology")
    with pytest.raises(RenderError, match="'astrology' is not one of"):
        iso.selfcheck(["astrology"])


def test_progress_is_told() -> None:
    told: list[tuple[str, float]] = []
    iso.selfcheck("form-factors", progress=lambda stage, fraction: told.append((stage, fraction)))
    assert told[0] == ("checking", 0.0)
    assert told[-1] == ("checking", 1.0)
