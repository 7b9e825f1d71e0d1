"""A town by night: some thousand street lamps and lit windows, each a light of its own.

Path tracing aims at one light for each surface it meets. Where there are many, a tree over them tells which may send
light to the place, so that thousands cost little more than one, and are hardly noisier.

    isophote render examples/city_lights.py -o city_lights.png --size 640x360 --samples 64
"""

import numpy as np

import isophote as iso

BLOCKS, STEP = 10, 25.0
random = np.random.default_rng(5)


def house(x, z, half, height):
    """Corners of the four walls and the roof of a house, (5, 4, 3), outward."""
    ring = [(x + half, z + half), (x + half, z - half), (x - half, z - half), (x - half, z + half)]
    sides = zip(ring, [*ring[1:], ring[0]], strict=True)
    walls = [[(a, 0, c), (b, 0, d), (b, height, d), (a, height, c)] for (a, c), (b, d) in sides]
    return np.array([*walls, [(a, height, c) for a, c in ring]])


def windows(wall):
    """Some windows of a wall, (n, 4, 3), a little in front of it."""
    corner, along, up = wall[0], wall[1] - wall[0], wall[3] - wall[0]
    out = np.cross(along, up)
    columns, rows = int(np.linalg.norm(along) // 2.2), int(np.linalg.norm(up) // 3)
    places = [(i, j) for i in range(columns) for j in range(rows) if random.random() < 0.2]
    frame = np.array([(0.25, 0.35), (0.75, 0.35), (0.75, 0.8), (0.25, 0.8)])
    quads = [(frame + place) / (columns, rows) @ np.array([along, up]) + corner for place in places]
    return np.array(quads).reshape(-1, 4, 3) + 0.02 * out / np.linalg.norm(out)


def quads(corners):
    """A mesh of separate quadrilaterals, (n, 4, 3)."""
    return iso.Mesh(corners.reshape(-1, 3), np.arange(4 * len(corners)).reshape(-1, 4))


middles = (np.arange(BLOCKS) - (BLOCKS - 1) / 2) * STEP
houses = [
    house(x + dx, z + dz, 3.6, random.choice([6.0, 9.0, 12.0, 18.0], p=[0.4, 0.3, 0.2, 0.1]))
    for x in middles
    for z in middles
    for dx in (-4, 4)
    for dz in (-4, 4)
]
lit = np.concatenate([windows(wall) for block in houses for wall in block[:4]])
warm = random.random(len(lit)) < 0.7
reach = BLOCKS * STEP
ground = quads(np.array([[(-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach), (-reach, 0, -reach)]]))

# Lamps on alternate sides of every street, shining down.
along = np.arange(-reach / 2, reach / 2, 9.0)
posts = [
    (x + side, 5.0, z)
    for x in middles + STEP / 2
    for z, side in zip(along, np.resize([-2, 2], len(along)), strict=True)
]
posts += [(z, y, x) for x, y, z in posts]
lamps = [
    iso.SpotLight((x, y, z), 150, target=(x, 0, z), cone_degrees=150, inner_degrees=60, colour=(1, 0.72, 0.42))
    for x, y, z in posts
]

scene = iso.Scene(
    items=[
        iso.Item(ground, iso.Matte(0.25)),
        iso.Item(quads(np.concatenate(houses)), iso.Matte((0.5, 0.45, 0.4))),
        iso.Item(quads(lit[warm]), iso.Emitter((3.0, 1.9, 0.8))),
        iso.Item(quads(lit[~warm]), iso.Emitter((1.3, 1.7, 2.2))),
    ],
    lights=lamps,
    camera=iso.Camera(eye=(66, 34, 78), target=(8, 0, 0), fov_degrees=34),
    name="City lights",
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=64), size=(640, 360), seed=1, denoise="filter").save("city_lights.png")
