"""Running the checks."""

from __future__ import annotations

import importlib
import time
from collections.abc import Iterable
from typing import NamedTuple

from isophote.checks.check import Check, Effort, Measured
from isophote.checks.report import Finding, SelfcheckReport
from isophote.errors import RenderError
from isophote.progress import ProgressLike, Reporter, reporter
from isophote.rendering.method import checked_seed
from isophote.rendering.pool import Pool
from isophote.rendering.warm import warm_parts

__all__ = ["STAGE", "TOPICS", "selfcheck"]

STAGE = "checking"


class _Topic(NamedTuple):
    """The module that holds a topic's checks, and what of rendering/warm.py they need."""

    module: str
    parts: tuple[str, ...] = ()


TOPICS = {
    "random-numbers": _Topic("random_numbers"),
    "materials": _Topic("reflectance"),
    "lights": _Topic("lights", ("path", "first hits", "trees")),
    "enclosures": _Topic("enclosures", ("path", "first hits", "trees", "materials")),
    "form-factors": _Topic("form_factors"),
    "occlusion": _Topic("occlusion", ("trees", "fields", "primitives")),
    "rays": _Topic("rays", ("trees",)),
    "fields": _Topic("fields", ("trees", "fields", "primitives")),
    "agreement": _Topic("agreement", ("path", "ray", "waves", "first hits", "trees")),
}
_THOROUGH = 16
_NAN = float("nan")


def selfcheck(
    topics: Iterable[str] | None = None,
    *,
    thorough: bool = False,
    seed: int = 0,
    progress: ProgressLike = None,
    threads: int | None = None,
) -> SelfcheckReport:
    """Measure what is known exactly, and tell what was found: closed forms, laws, and one way against another.

    `topics` picks some of `isophote selfcheck --help`'s, all if None. `thorough` takes sixteen times the samples, and
    allows a quarter of the noise. The same `seed` gives the same numbers for any number of `threads`. `progress` as for
    `render`. Raises `RenderError` for unknown topics; a check that breaks off is a failure in the report.
    """
    chosen = _chosen(topics)
    effort = Effort(_THOROUGH if thorough else 1, checked_seed(seed), Pool(threads).threads)
    began = time.monotonic()
    with reporter(progress) as report:
        _warm(chosen, report)
        findings = _run(_checks(chosen), effort, report)
    return SelfcheckReport(findings, time.monotonic() - began)


def _chosen(topics: Iterable[str] | None) -> tuple[str, ...]:
    if topics is None:
        return tuple(TOPICS)
    asked = (topics,) if isinstance(topics, str) else tuple(topics)
    if not asked:
        raise RenderError(f"selfcheck: no topic is named; leave them out for all of {', '.join(TOPICS)}")
    for topic in asked:
        if topic not in TOPICS:
            raise RenderError(f"selfcheck: {topic!r} is not one of {', '.join(TOPICS)}")
    return tuple(topic for topic in TOPICS if topic in asked)


def _warm(topics: Iterable[str], report: Reporter) -> None:
    warm_parts(report, list(dict.fromkeys(part for topic in topics for part in TOPICS[topic].parts)))


def _checks(topics: Iterable[str]) -> list[Check]:
    found: list[Check] = []
    for topic in topics:
        found += importlib.import_module(f"isophote.checks.{TOPICS[topic].module}").CHECKS
    return found


def _run(checks: list[Check], effort: Effort, report: Reporter) -> tuple[Finding, ...]:
    findings = []
    for k, check in enumerate(checks):
        report(STAGE, k / len(checks))
        findings.append(_finding(check, effort))
    report(STAGE, 1.0)
    return tuple(findings)


def _finding(check: Check, effort: Effort) -> Finding:
    began = time.monotonic()
    error = None
    try:
        found = check.measure(effort)
    except Exception as reason:  # noqa: BLE001 - whatever goes wrong is what a check is there to tell.
        found, error = Measured(_NAN, _NAN, _NAN), f"{type(reason).__name__}: {reason}"
    return Finding(
        check.topic,
        check.name,
        measured=float(found.measured),
        exact=float(found.exact),
        allowed=float(found.allowed),
        at_most=found.at_most,
        seconds=time.monotonic() - began,
        error=error,
    )
