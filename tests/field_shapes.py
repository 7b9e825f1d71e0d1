"""Fields for tests, by name, and distances by other ways than the fields' own."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull, cKDTree

import isophote as iso

Floats = npt.NDArray[np.float64]

_BLOCK = iso.box((0.6, 1, 0.4)).translate((0.1, 0.2, 0))
_EGG = iso.ellipsoid((0.3, 0.5, 0.2))
_GRID = iso.sphere(0.1)

# Each operation on something that it changes visibly; those within bounds that are finite.
OPERATIONS = {
    "union": _BLOCK | iso.sphere(0.5) | _EGG.translate((0.5, 0, 0)),
    "intersection": _BLOCK & iso.sphere(0.5),
    "difference": _BLOCK - iso.sphere(0.4) - iso.cylinder(0.1).along("x"),
    "blended union": iso.union(_BLOCK, iso.sphere(0.4), _EGG, blend=0.3),
    "blended intersection": _BLOCK.intersection(iso.sphere(0.5), blend=0.2),
    "blended difference": _BLOCK.difference(iso.sphere(0.4), _EGG, blend=0.1),
    "rounded union": _BLOCK.union(iso.sphere(0.5), round=0.2),
    "rounded intersection": _BLOCK.intersection(iso.sphere(0.5), round=0.2),
    "chamfered union": _BLOCK.union(iso.sphere(0.5), chamfer=0.2),
    "chamfered difference": _BLOCK.difference(iso.cylinder(0.2), chamfer=0.1),
    "round": (_BLOCK - iso.cylinder(0.1)).round(0.05),
    "round prism": iso.prism(5, 0.6, 0.5).round(0.1).scale(1.5),
    "chamfer": iso.cone(0.5, 0.8, 0.3).chamfer(0.1),
    "chamfered union of parts": (iso.box(0.8) | iso.cylinder(0.3, 1.5)).chamfer(0.1),
    "chamfered pyramid": iso.pyramid(1, 1).chamfer(0.1),
    "round octahedron": iso.octahedron(0.8).round(0.1),
    "shell": _BLOCK.shell(0.1),
    "offset": _BLOCK.offset(0.1),
    "offset inwards": _BLOCK.offset(-0.1),
    "elongate": iso.torus(0.3, 0.1).elongate((0.5, 0, 0.3)),
    "rotate": _BLOCK.rotate((1, 2, 3), 0.7),
    "mirror": _BLOCK.mirror((1, 1, 0)),
    "along": iso.cone(0.3, 1).along((1, 1, 1)),
    "scale": _BLOCK.scale((1, 0.5, 2)),
    "affine": _BLOCK.affine([[1, 0.2, 0, 0.1], [0, 0.8, 0, 0], [0.3, 0, 1, 0], [0, 0, 0, 1]]),
    "twist": _BLOCK.twist(2.0),
    "twist left": _EGG.twist(-3),
    "bend": iso.box((0.3, 3, 0.4)).bend(0.8),
    "bend left": iso.cylinder(0.2, 2.0).bend(-1.1),
    "bend a bound": iso.ellipsoid((0.2, 1, 0.3)).translate((0.1, 0.2, 0)).bend(0.9),
    "taper": _BLOCK.taper(0.3),
    "taper between": iso.cylinder(0.5, 1).taper(2.0, -0.2, 0.3),
    "displace": iso.sphere(0.8).displace(iso.waves((0.4, 0.5, 0.6)), 0.05),
    "grid": _GRID.repeat((0.3, 0.4, 0.5), count=(5, 4, 2)),
    "overlapping row": iso.box(0.5).rotate("z", 0.4).repeat((0.2, 0, 0), count=6),
    "grid of bounds": _BLOCK.twist(2.0).scale(0.2).repeat((0.2, 0.3, 0), count=(7, 4, 1)),
    "overlapping row of bounds": _BLOCK.twist(2.0).scale(0.2).repeat((0.1, 0, 0), count=9),
    "ring": iso.box((0.2, 0.3, 0.1)).translate((0.7, 0, 0.1)).repeat_around("y", 7),
    "overlapping ring": iso.box((0.2, 0.3, 0.6)).translate((0.6, 0, 0.1)).repeat_around("y", 9),
    "ring of bounds": _EGG.scale(0.4).translate((0.1, 0.7, 0.2)).repeat_around("z", 8),
    "overlapping ring of bounds": iso.ellipsoid((0.1, 0.3, 0.1)).translate((0, 0.2, 0.5)).repeat_around("x", 12),
    "ring about a middle": iso.box((0.2, 0.3, 0.6)).translate((0.1, 0, 0.1)).repeat_around("x", 5),
    "large grid": _GRID.repeat((0.3, 0.4, 0.5), count=(9, 5, 2)),
    "large grid of bounds": _EGG.scale(0.4).rotate("z", 0.5).repeat((0.2, 0.25, 0), count=(9, 6, 1)),
    "large ring": iso.box((0.1, 0.3, 0.1)).translate((0.7, 0, 0.1)).repeat_around("y", 37),
    "large ring of bounds": _EGG.scale(0.4).translate((0.1, 0.9, 0.2)).repeat_around("z", 43),
    "twisted row": iso.sphere(1)
    .union(iso.box(1).translate((1, 0, 0)), blend=0.3)
    .twist(0.8)
    .repeat((4, 0, 0), count=(3, 1, 1)),
    "row in a ring": _EGG.scale(0.3).repeat((0, 0.4, 0), count=3).translate((0.8, 0, 0)).repeat_around("y", 10),
    "twist of a blend, moved": iso.box(0.6).union(_EGG, blend=0.1).twist(2).translate((0.1, 0, 0)),
}


def to_segments(points: Floats, ends: Floats) -> Floats:
    """(n,) distances of points (n, d) to the nearest of line segments (m, 2, d)."""
    best = np.full(len(points), np.inf)
    for a, b in ends:
        part = np.clip((points - a) @ (b - a) / max((b - a) @ (b - a), 1e-300), 0, 1)
        best = np.minimum(best, np.linalg.norm(points - a - part[:, None] * (b - a), axis=1))
    return best


def to_triangles(points: Floats, corners: Floats) -> Floats:
    """(n,) distances of points (n, 3) to the nearest of triangles (m, 3, 3): to planes where above, else to edges."""
    best = np.full(len(points), np.inf)
    for a, b, c in corners:
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        sides = [np.cross(normal, q - p) @ (points - p).T for p, q in ((a, b), (b, c), (c, a))]
        above = np.all(np.array(sides) >= 0, axis=0)
        best = np.minimum(best, np.where(above, np.abs((points - a) @ normal), np.inf))
        best = np.minimum(best, to_segments(points, np.array([(a, b), (b, c), (c, a)])))
    return best


def to_hull(points: Floats, corners: Floats) -> Floats:
    """(n,) signed distances of points to the convex hull of corners, in the plane or in space."""
    hull = ConvexHull(corners)
    inside = (points @ hull.equations[:, :-1].T + hull.equations[:, -1] <= 0).all(axis=1)
    sides = corners[hull.simplices]
    distances = to_segments(points, sides) if corners.shape[1] == 2 else to_triangles(points, sides)
    return np.where(inside, -distances, distances)


def to_cloud(points: Floats, cloud: Floats) -> Floats:
    """(n,) distances of points to the nearest of a cloud."""
    return np.asarray(cKDTree(cloud).query(points)[0])


def profile(points: Floats) -> Floats:
    """(n, 2) distance from the y axis, and y."""
    return np.column_stack([np.hypot(points[:, 0], points[:, 2]), points[:, 1]])


def _box(size: tuple[float, ...]) -> Floats:
    return np.array(np.meshgrid(*[(-s / 2, s / 2) for s in size])).reshape(len(size), -1).T


def _frame(points: Floats, size: tuple[float, ...], thick: float) -> Floats:
    """Space in cells between the planes of the bars' sides: the distance to the nearest cell of the other kind."""
    cuts = [(-9.0, -s / 2, thick - s / 2, s / 2 - thick, s / 2, 9.0) for s in size]
    best = {True: np.full(len(points), np.inf), False: np.full(len(points), np.inf)}
    for i in np.ndindex(5, 5, 5):
        solid = all(1 <= k <= 3 for k in i) and sum(k in (1, 3) for k in i) >= 2
        low = np.array([cut[k] for cut, k in zip(cuts, i, strict=True)])
        high = np.array([cut[k + 1] for cut, k in zip(cuts, i, strict=True)])
        away = np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0), axis=1)
        best[solid] = np.minimum(best[solid], away)
    return best[True] - best[False]


def _circle(radius: float, y: float) -> Floats:
    turn = np.linspace(0, math.tau, 4000, endpoint=False)
    return np.column_stack([radius * np.cos(turn), y + radius * np.sin(turn)])


def _cone(points: Floats, radius: float, height: float, top: float) -> Floats:
    flat = np.array([[-radius, -height / 2], [radius, -height / 2], [top, height / 2], [-top, height / 2]])
    return to_hull(profile(points), flat)


def _prism(points: Floats, sides: int, radius: float, height: float) -> Floats:
    turn = np.arange(sides) * math.tau / sides
    rim = np.column_stack([np.cos(turn), np.zeros(sides), np.sin(turn)]) * radius
    lid = np.array([0, height / 2, 0])
    return to_hull(points, np.concatenate([rim + lid, rim - lid]))


def _pyramid(points: Floats, base: float, height: float) -> Floats:
    foot = _box((base, base)) @ [[1, 0, 0], [0, 0, 1]] - [0, height / 2, 0]
    return to_hull(points, np.vstack([foot, [0, height / 2, 0]]))


def _arc(angle: float, radius: float) -> Floats:
    turn = np.linspace(-angle / 2, angle / 2, 20_001)
    return np.column_stack([np.cos(turn), np.zeros_like(turn), np.sin(turn)]) * radius


def _stadium(radius: float, reach: float) -> Floats:
    turn = np.linspace(0, math.pi, 8_001)
    arch = np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)]) * radius
    side = np.column_stack([np.full(8_001, radius), np.linspace(-reach, reach, 8_001), np.zeros(8_001)])
    end = np.array([0, reach, 0])
    return np.concatenate([arch + end, -arch - end, side, side * [-1, 1, 1]])


# Fields, and their exact distances, signed, found by another way than the fields': closed forms, polyhedra, curves that
# are sampled so finely that the distance to them is off by less than 1e-5.
EXACT = {
    "sphere": (iso.sphere(0.7), lambda p: np.linalg.norm(p, axis=1) - 0.7),
    "box": (iso.box((1, 0.6, 0.3)), lambda p: to_hull(p, _box((1, 0.6, 0.3)))),
    "rounded box": (iso.rounded_box((1, 0.6, 0.8), 0.2), lambda p: to_hull(p, _box((0.6, 0.2, 0.4))) - 0.2),
    "frame": (iso.frame((1, 1.4, 0.8), 0.15), lambda p: _frame(p, (1, 1.4, 0.8), 0.15)),
    "plane": (iso.plane((1, 2, -1), 0.3), lambda p: p @ np.array([1, 2, -1]) / 6**0.5 - 0.3),
    "slab": (iso.slab(0.4), lambda p: np.abs(p[:, 1]) - 0.2),
    "cylinder": (iso.cylinder(0.5, 1.2), lambda p: to_hull(profile(p), _box((1, 1.2)))),
    "endless cylinder": (iso.cylinder(0.5), lambda p: profile(p)[:, 0] - 0.5),
    "capsule": (iso.capsule(0.3, 1.4), lambda p: to_segments(p, np.array([[(0, -0.4, 0), (0, 0.4, 0)]])) - 0.3),
    "cone": (iso.cone(0.6, 1.1), lambda p: _cone(p, 0.6, 1.1, 0.0)),
    "cone with a lid": (iso.cone(0.6, 1.1, 0.25), lambda p: _cone(p, 0.6, 1.1, 0.25)),
    "cone upside down": (iso.cone(0.2, 0.7, 0.6), lambda p: _cone(p, 0.2, 0.7, 0.6)),
    "rounded cone": (
        iso.rounded_cone(0.5, 0.2, 1.5),
        lambda p: to_hull(profile(p), np.concatenate([_circle(0.5, -0.25), _circle(0.2, 0.55)])),
    ),
    "torus": (iso.torus(0.6, 0.2), lambda p: to_cloud(profile(p), np.array([[0.6, 0]])) - 0.2),
    "capped torus": (iso.capped_torus(0.6, 0.15, 2), lambda p: to_cloud(p, _arc(2, 0.6)) - 0.15),
    "long capped torus": (iso.capped_torus(0.6, 0.15, 5), lambda p: to_cloud(p, _arc(5, 0.6)) - 0.15),
    "link": (iso.link(0.3, 0.1, 1.4), lambda p: to_cloud(p, _stadium(0.3, 0.3)) - 0.1),
    "prism of 3": (iso.prism(3, 0.7, 0.8), lambda p: _prism(p, 3, 0.7, 0.8)),
    "prism of 6": (iso.prism(6, 0.7, 0.8), lambda p: _prism(p, 6, 0.7, 0.8)),
    "prism of 7": (iso.prism(7, 0.6, 1), lambda p: _prism(p, 7, 0.6, 1)),
    "pyramid": (iso.pyramid(1.2, 0.9), lambda p: _pyramid(p, 1.2, 0.9)),
    "steep pyramid": (iso.pyramid(0.5, 1.5), lambda p: _pyramid(p, 0.5, 1.5)),
    "octahedron": (iso.octahedron(0.8), lambda p: to_hull(p, np.vstack([np.eye(3), -np.eye(3)]) * 0.8)),
    "box, rounded": (iso.box(1).round(0.2), lambda p: to_hull(p, _box((0.6, 0.6, 0.6))) - 0.2),
    "cylinder, rounded": (iso.cylinder(0.5, 1).round(0.2), lambda p: to_hull(profile(p), _box((0.6, 0.6))) - 0.2),
}
