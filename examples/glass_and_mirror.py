"""A bumpy sphere computed with NumPy between one of glass and one of polished metal, on a striped floor.

Meshes are arrays: here a grid over the sphere whose radius waves, with smooth normals. Glass refracts, so the light
under it gathers into a bright spot.

    isophote render examples/glass_and_mirror.py -o glass.png --size 640x360 --samples 256
"""

import numpy as np

import isophote as iso


def ball(radius, rows=96, bumps=0.0):
    """A closed sphere of quadrilaterals, triangles at its poles, with normals; `bumps` is how far its radius waves."""
    columns = 2 * rows
    polar = np.linspace(0, np.pi, rows + 1)[1:-1, None]
    around = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None, :]
    ring = np.sin(polar)
    outward = np.stack(np.broadcast_arrays(ring * np.sin(around), np.cos(polar), ring * np.cos(around)), axis=-1)
    length = radius * (1 + bumps * np.sin(7 * around) * np.sin(9 * polar) * ring**2)
    poles = np.array([(0, radius, 0), (0, -radius, 0)])
    points = np.concatenate([(length[..., None] * outward).reshape(-1, 3), poles])

    here = np.arange((rows - 1) * columns).reshape(rows - 1, columns)
    there = np.roll(here, -1, axis=1)
    sides = np.stack([here[:-1], here[1:], there[1:], there[:-1]], axis=-1).reshape(-1, 4)
    top = [(len(points) - 2, a, b) for a, b in zip(here[0], there[0], strict=True)]
    bottom = [(len(points) - 1, b, a) for a, b in zip(here[-1], there[-1], strict=True)]
    return iso.Mesh(points, [*sides, *top, *bottom], attributes={"normal": normals(points, sides)})


def normals(points, sides):
    """(n, 3) mean of the normals of the quadrilaterals around each point; at the poles straight up and down."""
    across, along = points[sides[:, 2]] - points[sides[:, 0]], points[sides[:, 3]] - points[sides[:, 1]]
    total = np.zeros_like(points)
    np.add.at(total, sides.reshape(-1), np.repeat(np.cross(across, along), 4, axis=0))
    total[-2:] = points[-2:]
    return total / np.linalg.norm(total, axis=1, keepdims=True)


def floor(reach, stripes=16):
    """A square floor with a striped texture."""
    corners = [(-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach), (-reach, 0, -reach)]
    texture = iso.ImageTexture(np.array([[(168, 160, 146), (96, 108, 112)]], np.uint8), filter="nearest")
    square = np.array([(0, 0), (stripes, 0), (stripes, stripes), (0, stripes)])
    return iso.Item(iso.Mesh(corners, [(0, 1, 2, 3)], attributes={"uv": square}), iso.Matte(texture))


scene = iso.Scene(
    items=[
        floor(8),
        iso.Item(ball(0.5, bumps=0.08), iso.Matte("tomato")).translate((0, 0.55, -0.5)),
        iso.Item(ball(0.5), iso.Glass(ior=1.5)).translate((-1.05, 0.505, 0.15)),
        iso.Item(ball(0.5), iso.Mirror((0.95, 0.85, 0.6))).translate((1.05, 0.505, 0.15)),
    ],
    lights=[
        iso.RectLight(size=(2.4, 2.4), power=150).at((-3, 3.5, 1.5), target=(0, 0.4, 0)),
        iso.Sky("lightsteelblue", 0.6),
    ],
    camera=iso.Camera(eye=(0, 1.5, 5), target=(0, 0.5, 0), fov_degrees=28),
    name="Glass and mirror",
)

if __name__ == "__main__":
    iso.render(scene, iso.PathTrace(samples=256), size=(640, 360), seed=1).save("glass.png")
