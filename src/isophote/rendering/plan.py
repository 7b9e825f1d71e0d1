"""How a picture is sampled, as kernels are told it."""

from __future__ import annotations

from isophote.kernels.base.table import Packed
from isophote.kernels.trace.tables import PLAN
from isophote.rendering.method import Job
from isophote.rendering.passes import PATTERNS
from isophote.rendering.pixel_filter import FilterTable

__all__ = ["plan_of"]


def plan_of(
    job: Job,
    table: FilterTable,
    *,
    samples: int,
    pattern: str,
    depth: int,
    roulette: int | None = None,
    inside: int = 0,
) -> Packed:
    """The plan of a job: `samples` for a pixel by `pattern`, spread by the filter of `table`, in paths of at most
    `depth` rays, which from `roulette` on may end by chance, from a camera in the media `inside`."""
    width, height = job.size
    return PLAN.pack(
        width=width,
        height=height,
        samples=samples,
        seed=job.seed,
        pattern=PATTERNS[pattern],
        offsets=table.offsets,
        crossings=table.crossings,
        inside=inside,
        max_depth=depth,
        roulette_depth=depth if roulette is None else roulette,
    )
