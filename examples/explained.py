"""Why a pixel has its colour: the rays behind it, told and drawn; and the boxes of a tree around a mesh.

    isophote explain examples/explained.py --pixel 335,250 -o rays.png
    isophote render examples/explained.py -o explained.png --method ray

Run as a program, it does both and draws three levels of a kd-tree.
"""

import isophote as iso

scene = iso.Scene(
    items=[
        iso.Item(iso.plane(), iso.Matte(0.6), name="floor"),
        iso.Item(iso.sphere(0.5), iso.Plastic("tomato"), name="red ball").translate((-0.7, 0.5, 0)),
        iso.Item(iso.sphere(0.5), iso.Glass(ior=1.5), name="glass ball").translate((0.5, 0.5, 0.3)),
        iso.Item(iso.box(0.6), iso.Metal("gold"), name="gold box").translate((0.3, 0.3, -0.9)),
    ],
    lights=[iso.RectLight(size=(1, 1), power=60).at((0, 3, 0.5)), iso.PointLight((3, 2, 2), 60), iso.Sky("white", 0.2)],
    camera=iso.Camera((0.8, 1.4, 4), (0, 0.4, 0), fov_degrees=40),
)

if __name__ == "__main__":
    found = iso.explain(scene, (335, 250))
    print(found)
    found.picture().save("rays.png")
    ball = iso.to_mesh(iso.sphere(1) - iso.cylinder(0.4), cell=0.05)
    iso.show_tree(ball, "kdtree", depth=3).save("tree.png")
