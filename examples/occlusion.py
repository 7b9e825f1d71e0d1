"""Ambient occlusion of a part, every way: by rays, from the depth of the picture alone, and at points of its mesh.

    isophote render examples/occlusion.py -o occlusion.png --method occlusion --size 480x360

Run as a program, it draws three ways side by side and tells how far they are from each other.
"""

import numpy as np

import isophote as iso

holes = [iso.cylinder(0.42).along(axis) for axis in "xyz"]
part = (iso.sphere(1).shell(0.24) - iso.union(*holes)).rotate("x", 0.35).rotate("y", 0.4)
scene = iso.Scene(
    items=[
        iso.Item(iso.to_mesh(part, cell=0.03), iso.Matte((0.8, 0.78, 0.74)), name="part"),
        iso.Item(iso.plane(), iso.Matte(0.8), name="ground").translate((0, -1.05, 0)),
    ],
    lights=[iso.Sky("white", 1.0)],
    camera=iso.Camera((2.2, 1.6, 3.4), (0, -0.1, 0), fov_degrees=38),
)


def ways(size=(320, 240), reach=0.8):
    """Pictures by rays, by horizons, and by samples of depth."""
    return {by: iso.render(scene, iso.AmbientOcclusion(by=by, max_distance=reach), size=size) for by in WAYS}


WAYS = ("rays", "horizon", "classic")

if __name__ == "__main__":
    pictures = ways()
    exact = pictures["rays"].channels["visibility"]
    for name, image in pictures.items():
        print(f"{name}: RMS difference {np.sqrt(np.mean((image.channels['visibility'] - exact) ** 2)):.3f}")
    sheet = np.concatenate([image.channels["colour"] ** 2.2 for image in pictures.values()], axis=1)
    iso.Image({"colour": sheet}).save("occlusion.png")
    found = iso.ambient_occlusion(scene.items[0], samples=256)
    print(f"at vertices: {found.visibility.mean():.3f} of the sky on average, {found.visibility.min():.3f} at least")
