"""Six meshes and what topology says of them: handles, boundaries, one-sided bands, and things that are wrong.

Drilled plates, made by `boolean`, have a genus; a band has boundary loops, and a Möbius band no sides. Of the three in
front one has an edge of four faces, one a vertex that joins two fans, one a face the wrong way round.

    python examples/topology.py
    isophote render examples/topology.py -o topology.png
    isophote info examples/topology.py --picture defects.png
"""

import numpy as np

import isophote as iso

CUBE = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)


def box(size, corner=(0, 0, 0)):
    """A box with its least corner at `corner`."""
    return iso.Mesh(CORNERS * size + corner, CUBE)


def drilled(holes):
    """A plate with square holes: a solid of genus `holes`."""
    plate = box((2, 0.4, 1), (-1, 0, -0.5))
    for x in np.linspace(-1, 1, holes + 2)[1:-1]:
        plate = iso.analysis.boolean(plate, box((0.24, 1, 0.5), (x - 0.12, -0.3, -0.25)), "difference")
    return plate


def band(turns, count=96):
    """A band around a circle, turned over `turns` times by half a turn on its way."""
    angle = 2 * np.pi * np.arange(count) / count
    out = np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
    lean = (np.pi / 2 + turns * angle / 2)[:, None]
    across = 0.3 * (np.cos(lean) * out + np.sin(lean) * (0, 1, 0))
    centre = 0.7 * out + (0, 0.4, 0)
    points = np.concatenate([centre - across, centre + across])
    here = np.arange(count)
    there = np.roll(here, -1)
    quads = np.stack([here, there, there + count, here + count], axis=1)
    if turns % 2:
        quads[-1] = (count - 1, count, 0, 2 * count - 1)
    return iso.Mesh(points, quads)


def joined(corner, shared):
    """Two cubes that have some vertices in common: `shared` pairs one of the first with one of the second."""
    same = {second + 8: first for first, second in shared}
    faces = CUBE + [tuple(same.get(v + 8, v + 8) for v in face) for face in CUBE]
    both = iso.Mesh(np.concatenate([CORNERS, CORNERS + corner]) * 0.6, faces)
    # The other cube's copies of shared vertices are left without a face.
    return iso.analysis.repair(both, weld=None, duplicates=False, split=False, holes=False)[0]


meshes = {
    "plate of genus 3": drilled(3),
    "band": band(0),
    "Möbius band": band(1),
    "four faces on an edge": joined((1, 0, 1), [(5, 0), (7, 2)]),
    "two fans at a vertex": joined((1, 1, 1), [(7, 0)]),
    "a face turned over": iso.Mesh(CORNERS, [CUBE[0], *(face[::-1] for face in CUBE[1:2]), *CUBE[2:]]),
}
PLACES = [(-2.6, 0, -2), (0, 0, -2.2), (2.6, 0, -2.2), (-2.8, 0, 0.2), (-0.6, 0, 0.2), (2, 0, 0.2)]
COLOURS = ["#c9a227", "#4f86c6", "#c8553d", "#8d99ae", "#8d99ae", "#8d99ae"]

items = [
    iso.Item(mesh, iso.Matte(colour), name=name).translate((x, y + 0.01, z))
    for (name, mesh), colour, (x, y, z) in zip(meshes.items(), COLOURS, PLACES, strict=True)
]
scene = iso.Scene(
    items=[*items, iso.Item(box((8, 0.2, 5.4), (-4, -0.2, -3.6)), iso.Matte("#efe6d8"), name="table")],
    lights=[iso.RectLight(size=(4, 4), radiance=12).at((-4, 6, 4), (0, 0, -1)), iso.Sky("white", 0.6)],
    camera=iso.Camera(eye=(0, 5, 7), target=(0, 0.2, -0.8), fov_degrees=42),
)

if __name__ == "__main__":
    for name, mesh in meshes.items():
        found = iso.analysis.topology(mesh)
        genus = "-" if found.genus is None else found.genus
        print(
            f"{name:22} V {found.vertices:3}  E {found.edges:3}  F {found.faces:3}  χ {found.euler:2}  genus {genus}  "
            f"loops {found.loop_count}  closed {found.closed}  manifold {found.manifold}  oriented {found.oriented}"
        )
