"""What checks found, as values and as a table."""

from __future__ import annotations

import math
from typing import Any

import attrs

from isophote.checks.check import Measured

__all__ = ["Finding", "SelfcheckReport"]

_HEADINGS = ("measured", "exact", "allowed", "seconds", "")
# Digits that are shown of numbers of which nothing may be off.
_MOST_DECIMALS = 9


@attrs.frozen
class Finding:
    """What one check found.

    `measured`, `exact`, `allowed`: the quantity as it was found, as it should be, and by how much they may differ; with
    `at_most` the quantity may be any smaller. Where the check itself broke off, `error` says why and numbers are NaN.
    """

    topic: str
    name: str
    measured: float
    exact: float
    allowed: float
    at_most: bool
    seconds: float
    error: str | None = None

    @property
    def passed(self) -> bool:
        """Whether what was measured is as it should be."""
        return self.error is None and Measured(self.measured, self.exact, self.allowed, self.at_most).passed


@attrs.frozen
class SelfcheckReport:
    """What `selfcheck` found: `findings` in the order in which they were made; `str` is the table."""

    findings: tuple[Finding, ...]
    seconds: float

    @property
    def passed(self) -> bool:
        """Whether everything is as it should be."""
        return not self.failures

    @property
    def failures(self) -> tuple[Finding, ...]:
        """What is not."""
        return tuple(finding for finding in self.findings if not finding.passed)

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain values, for JSON."""
        found = [{**attrs.asdict(finding), "passed": finding.passed} for finding in self.findings]
        return {"passed": self.passed, "seconds": self.seconds, "findings": found}

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        # What notebooks and IPython show.
        printer.text(str(self))

    def __str__(self) -> str:
        rows = [(finding, _cells(finding)) for finding in self.findings]
        names = max([len(finding.name) for finding in self.findings], default=0) + 2
        widths = [max([len(heading), *(len(cells[k]) for _, cells in rows)]) for k, heading in enumerate(_HEADINGS)]
        lines = [_line("", _HEADINGS, names, widths)]
        topic = None
        for finding, cells in rows:
            if finding.topic != topic:
                topic = finding.topic
                lines.append(topic)
            lines.append(_line(f"  {finding.name}", cells, names, widths))
            if finding.error is not None:
                lines.append(f"    {finding.error}")
        return "\n".join([*lines, self._summary()])

    def _summary(self) -> str:
        count, failed = len(self.findings), len(self.failures)
        outcome = "all passed" if failed == 0 else f"{failed} FAILED"
        return f"{count} checks in {self.seconds:.1f} s: {outcome}"


def _line(name: str, cells: tuple[str, ...], width: int, widths: list[int]) -> str:
    columns = (cell.rjust(size) for cell, size in zip(cells, widths, strict=True))
    return f"{name:<{width}}  {'  '.join(columns)}".rstrip()


def _cells(finding: Finding) -> tuple[str, ...]:
    took = f"{finding.seconds:.2f}"
    outcome = "ok" if finding.passed else "FAILED"
    if finding.error is not None:
        return "", "", "", took, outcome
    return *_numbers(finding), took, outcome


def _numbers(finding: Finding) -> tuple[str, str, str]:
    """What was measured, what is exact and what is allowed, with as many digits as tell them apart."""
    sign = "+" if finding.at_most else "±"
    bound = "≤ " if finding.at_most else ""
    if finding.allowed == 0:
        return f"{finding.measured:.3g}", f"{bound}{finding.exact:.3g}", "0"
    allowed = f"{sign} {finding.allowed:.1e}" if finding.allowed < 1 else f"{sign} {finding.allowed:g}"
    if finding.exact == 0:
        return f"{finding.measured:.2g}", f"{bound}0", allowed
    decimals = _decimals(finding.allowed)
    return f"{finding.measured:.{decimals}f}", f"{bound}{finding.exact:.{decimals}f}", allowed


def _decimals(allowed: float) -> int:
    """Digits after the point that show a tenth of what is allowed."""
    return min(max(0, 1 - math.floor(math.log10(allowed))), _MOST_DECIMALS)
