"""A room lit by a lamp, solved by radiosity: the balance of light on patches, seen from anywhere at once.

Run as a program, it draws the room after each of the first bounces of light, and the patches.

    isophote render examples/radiosity.py -o room.png --method radiosity --size 480x480
"""

import numpy as np

import isophote as iso


def wall(*corners):
    """One parallelogram."""
    return iso.Mesh(corners, [(0, 1, 2, 3)])


WHITE, RED, BLUE = iso.Matte((0.75, 0.73, 0.7)), iso.Matte((0.6, 0.09, 0.06)), iso.Matte((0.1, 0.2, 0.5))
CUBE = iso.to_mesh(iso.box(1), cell=0.25)

scene = iso.Scene(
    items=[
        iso.Item(wall((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)), WHITE, name="floor"),
        iso.Item(wall((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)), WHITE, name="ceiling"),
        iso.Item(wall((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)), WHITE, name="back"),
        iso.Item(wall((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), RED, name="left"),
        iso.Item(wall((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), BLUE, name="right"),
        iso.Item(CUBE, WHITE, name="tall").scale((0.55, 1.2, 0.55)).rotate("y", 0.3).translate((-0.35, 0.6, -0.3)),
        iso.Item(CUBE, WHITE, name="low").scale(0.55).rotate("y", -0.3).translate((0.4, 0.275, 0.35)),
    ],
    lights=[iso.RectLight(size=(0.6, 0.5), radiance=(11, 9.5, 7.5)).at((0, 1.99, 0))],
    camera=iso.Camera((0, 1, 4.3), (0, 1, 0), fov_degrees=34),
    name="A room by radiosity",
)


def bounces(found, camera):
    """The room with what shines alone, after one bounce, two bounces, all of them."""
    counts = (0, 1, 2, found.bounce_count)
    return [found.image(camera, (240, 240), bounce=k).channels["colour"] for k in counts]


def patches(found, camera):
    """Each patch in a colour of its own, by its area: small ones where light changes fast."""
    image = found.image(camera, (240, 240))
    number = image.channels["patch"]
    shades = np.random.default_rng(1).uniform(0.25, 0.9, (number.max() + 2, 3)) * (1, 0.9, 0.8)
    return np.where(number[..., None] >= 0, shades[number], 0).astype(np.float32)


if __name__ == "__main__":
    solution = iso.radiosity(scene, iso.Radiosity(patch=0.04), progress=False)
    print(solution)
    pictures = bounces(solution, scene.camera)
    sheet = np.concatenate([*pictures, patches(solution, scene.camera)], axis=1)
    iso.Image({"colour": sheet}).save("radiosity.png")
    solution.save("room.glb")
