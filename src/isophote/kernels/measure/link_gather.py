"""Light along links: what arrives at nodes from the nodes that they are linked to."""

from __future__ import annotations

from isophote.kernels.base.jit import kernel

__all__ = ["gather_links"]


@kernel
def gather_links(starts, sources, factors, light, arriving, first, last):
    """arriving[p] = Σ factors[k] light[sources[k]] over the links starts[p] ≤ k < starts[p + 1] of nodes
    first ≤ p < last; `light`, `arriving` (n, 3)."""
    for p in range(first, last):
        r, g, b = 0.0, 0.0, 0.0
        for k in range(starts[p], starts[p + 1]):
            q, factor = sources[k], factors[k]
            r += factor * light[q, 0]
            g += factor * light[q, 1]
            b += factor * light[q, 2]
        arriving[p, 0] = r
        arriving[p, 1] = g
        arriving[p, 2] = b
