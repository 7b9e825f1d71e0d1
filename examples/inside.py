"""Two slices through one broken mesh, and distances over another.

The mesh is a bumpy sphere with a large hole, and a second one through it. The slice in the middle shows how often it
winds round each point: 0 (blue) outside, 1 (white) inside, 2 (red) where the two overlap, and in the hole all that lies
between. The slice on the left shows the signed distance in bands, which are warm inside; on the right are bands of the
lengths of shortest paths over a torus, from one point.

    python examples/inside.py
    isophote render examples/inside.py -o inside.png
"""

import numpy as np

import isophote as iso


def sphere(radius, centre, across=48):
    """A closed sphere with waves, of squares and triangles."""
    u, v = np.meshgrid(np.arange(2 * across) * np.pi / across, np.arange(1, across) * np.pi / across, indexing="ij")
    unit = np.stack([np.sin(v) * np.cos(u), np.cos(v), -np.sin(v) * np.sin(u)], axis=2).reshape(-1, 3)
    points = np.concatenate([unit * (1 + 0.06 * np.sin(7 * unit).prod(axis=1))[:, None], [[0, 1, 0], [0, -1, 0]]])
    rows, n = across - 1, 2 * across
    i, j = np.meshgrid(np.arange(n), np.arange(rows - 1), indexing="ij")
    a, b = (i * rows + j).reshape(-1), ((i + 1) % n * rows + j).reshape(-1)
    caps = np.arange(n) * rows, np.roll(np.arange(n) * rows, -1)
    top, bottom = np.full(n, len(points) - 2), np.full(n, len(points) - 1)
    faces = [(a, a + 1, b), (b, a + 1, b + 1), (top, *caps), (bottom, caps[1] + rows - 1, caps[0] + rows - 1)]
    return points * radius + np.array(centre), np.concatenate([np.stack(face, axis=1) for face in faces])


def slice_of(low, high, z, across=240):
    """A rectangle of squares in the plane at z."""
    x, y = np.meshgrid(np.linspace(low[0], high[0], across), np.linspace(low[1], high[1], across), indexing="ij")
    points = np.stack([x, y, np.full_like(x, z)], axis=2).reshape(-1, 3)
    k = (np.arange(across - 1)[:, None] * across + np.arange(across - 1)).reshape(-1)
    return iso.Mesh(points, np.stack([k, k + across, k + across + 1, k + 1], axis=1))


def torus(across=80):
    """A torus about an axis that leans toward the camera."""
    u, v = (a.reshape(-1) for a in np.meshgrid(np.arange(2 * across), np.arange(across), indexing="ij"))
    s, t = u * np.pi / across, v * 2 * np.pi / across
    around = 0.75 + 0.35 * np.cos(t)
    points = np.stack([around * np.cos(s), around * np.sin(s), 0.35 * np.sin(t)], axis=1)
    corners = [((u + i) % (2 * across)) * across + (v + j) % across for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return iso.Mesh(points, np.stack(corners, axis=1))


points, faces = sphere(1, (-0.3, 0, 0))
middles = points[faces].mean(axis=1)
faces = faces[np.linalg.norm(middles - (-1.1, 0.6, 0), axis=1) > 0.5]
other, more = sphere(0.65, (0.75, -0.25, 0))
broken = iso.Mesh(np.concatenate([points, other]), np.concatenate([faces, more + len(points)]))

board = slice_of((-1.6, -1.25), (1.7, 1.25), 0)
winding = iso.analysis.winding_number(broken, board.vertices)
far = iso.analysis.signed_distance(broken, board.vertices)
bands = np.where(far < 0, 1, -1) * (0.35 + 0.65 * (np.abs(far) * 8 % 1))
ring = torus()
paths = iso.analysis.geodesic_distance(ring, 20)

scene = iso.Scene(
    items=[
        iso.analysis.coloured(board, winding, limits=(0, 2), name="winding number").translate((0, 1.3, 0)),
        iso.analysis.coloured(board, bands, limits=(-1, 1), name="distance").translate((-3.55, 1.3, 0)),
        iso.analysis.coloured(ring, np.sin(24 * paths), limits=(-1, 1), name="paths").translate((3.0, 1.3, 0)),
        iso.Item(iso.Mesh([(-9, 0, -3), (-9, 0, 5), (9, 0, 5), (9, 0, -3)], [[0, 1, 2, 3]]), iso.Matte("#efe6d8")),
    ],
    lights=[iso.RectLight(size=(5, 5), radiance=7).at((-2, 7, 6), (0, 1, 0)), iso.Sky("white", 0.75)],
    camera=iso.Camera(eye=(-0.5, 1.7, 10), target=(-0.5, 1.2, 0), fov_degrees=19),
)

if __name__ == "__main__":
    found = iso.analysis.self_intersections(broken)
    print(f"{len(found.pairs)} pairs of faces meet; embedded: {found.embedded}")
    walls = iso.analysis.thickness(ring)
    print(f"the torus is {walls.min():.3f} to {walls.max():.3f} thick")
    beside = iso.analysis.closest_point(broken, [(0, 0, 3)])
    print(f"closest to (0, 0, 3): {beside.points[0].round(3).tolist()}, {beside.distance[0]:.3f} away")
