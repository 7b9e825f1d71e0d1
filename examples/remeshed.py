"""One part four times: as it was meshed, simplified, remeshed, and as points spread over it.

isophote render examples/remeshed.py -o remeshed.png
"""

import isophote as iso

STEP, BALL = 2.1, 0.022


part = (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5) - iso.cylinder(0.5).along("x")
mesh = iso.to_mesh(part, cell=0.06)
points = iso.analysis.sample_points(mesh, 700, "blue-noise", seed=2).points
ball = iso.to_mesh(iso.sphere(BALL), cell=BALL / 3)
shown = [(mesh, "#c84"), (iso.simplify(mesh, 300), "#58a"), (iso.remesh(mesh, 0.16), "#7a5")]
items = [iso.Item(shape, iso.Matte(colour)).translate((STEP * k, 0, 0)) for k, (shape, colour) in enumerate(shown)]
items += [iso.Item(ball, iso.Matte("#a47")).translate(p).translate((3 * STEP, 0, 0)) for p in points]
camera = iso.Camera(eye=(1.5 * STEP, 3.0, 11.0), target=(1.5 * STEP, -0.1, 0), fov_degrees=18)
scene = iso.studio(items).with_(camera=camera)
