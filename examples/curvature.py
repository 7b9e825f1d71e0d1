"""A bumpy torus, coloured by its mean curvature: blue where it bends in, red where it bends out.

isophote render examples/curvature.py -o curvature.png
"""

import numpy as np

import isophote as iso

ACROSS = 96


def bumpy_torus(n: int) -> iso.Mesh:
    """A torus about y with waves along it; 2n × n vertices."""
    u, v = (a.reshape(-1) for a in np.meshgrid(np.arange(2 * n), np.arange(n), indexing="ij"))
    i, j = u, v
    u, v = u * np.pi / n, v * 2 * np.pi / n
    tube = 0.4 + 0.03 * np.cos(9 * u) * np.cos(4 * v)
    around = 1 + tube * np.cos(v)
    points = np.stack([around * np.cos(u), tube * np.sin(v), -around * np.sin(u)], axis=1)
    a, b, c, d = (p % (2 * n) * n + q % n for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    return iso.Mesh(points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


torus = bumpy_torus(ACROSS)
scene = iso.studio(iso.analysis.coloured(torus, iso.analysis.mean_curvature(torus), limits=(-5, 5), name="torus"))
