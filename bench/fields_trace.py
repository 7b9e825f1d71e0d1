"""Fields in pictures: regions with shorter tapes, how soon a new part is seen, and a field against its own mesh.

    python bench/fields_trace.py [--rounds 5] [--parts 1024] [--size 512] [--triangles 1000000]

- 1,024 smoothly blended balls, sphere-traced without shadows: with regions and shorter tapes, and with the whole tape
  everywhere (one region). "Values alone" is what the second one's steps cost if each were a point of `field(points)`,
  the evaluator of arrays, without anything else: the least that a sphere tracer with that tape can take. All on one
  thread; building the regions is told by itself.
- A part of about a hundred operations, another one in each round: from the expression to the finished picture of
  640 × 480 pixels by `SphereTrace()`, with soft shadows and occlusion, on all cores.
- Three shapes path-traced as fields and as their meshes (`to_mesh`), 16 samples, one thread, trees built before.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence

import numpy as np

import isophote as iso
from common import print_machine, print_table, verdict
from isophote.accel import field_tree
from isophote.lower import scene as lowering
from isophote.lower.latest import Latest
from isophote.shapes.field.tape import tape_of

GOAL_PRUNING, GOAL_EDIT, GOAL_MESH = 50, 0.2, 0.3
PLAIN = iso.SphereTrace(shadows="none", occlusion=0.0)


def blobs(count: int) -> iso.Field:
    """Balls in a cube, blended smoothly."""
    rng = np.random.default_rng(1)
    places, radii = rng.uniform(-1, 1, (count, 3)).tolist(), rng.uniform(0.03, 0.08, count).tolist()
    return iso.union(*(iso.sphere(r).translate(p) for p, r in zip(places, radii, strict=True)), blend=0.05)


def bare_scene(shape: iso.Field) -> iso.Scene:
    """A shape in front of a camera, and nothing else."""
    return iso.Scene([iso.Item(shape)], lights=[iso.Sky()], camera=iso.Camera((1.5, 1.2, 3.2), (0, 0, 0)))


def forget() -> None:
    """Let the scene lowered last be lowered again."""
    lowering._latest = Latest()


def traced(scene: iso.Scene, size: int, rounds: int) -> tuple[iso.Image, float, float]:
    """(picture, processor seconds of tracing alone at best, seconds of lowering)."""
    stamps: dict[tuple[str, float], tuple[float, float]] = {}

    def mark(stage: str, fraction: float) -> None:
        stamps.setdefault((stage, fraction), (time.perf_counter(), time.process_time()))

    seconds, lowered = [], 0.0
    for number in range(rounds):
        stamps.clear()
        image = iso.render(scene, PLAIN, size=(size, size), threads=1, progress=mark)
        if number == 0:
            lowered = stamps["building the tree", 1.0][0] - stamps["building the tree", 0.0][0]
        seconds.append(time.process_time() - stamps["building the tree", 1.0][1])
    return image, min(seconds), lowered


def pruning(count: int, size: int, rounds: int) -> None:
    """The table of regions against the whole tape."""
    shape = blobs(count)
    iso.render(bare_scene(blobs(50)), PLAIN, size=(8, 8), progress=False)
    pruned, quick, building = traced(bare_scene(shape), size, rounds + 1)
    short, field_tree._SHORT = field_tree._SHORT, 10**9
    forget()
    whole, slow, _ = traced(bare_scene(shape), size, 1)
    field_tree._SHORT = short
    forget()
    points = np.random.default_rng(2).uniform(-1, 1, (1 << 15, 3)).astype(np.float32)
    shape(points[:64])
    began = time.process_time()
    shape(points)
    alone = (time.process_time() - began) / len(points) * float(whole.channels["steps"].sum())
    a, b = pruned.channels["depth"], whole.channels["depth"]
    both = np.isfinite(a) & np.isfinite(b)
    gap = np.abs(a[both] / b[both] - 1).max()
    operations = len(tape_of(shape.form).rows)
    print(f"{count:,} blended balls, {operations:,} operations, {size} × {size} pixels; building {building:.2f} s\n")
    rows = [
        ["regions", quick, quick / size**2 * 1e9, pruned.channels["steps"].mean(), 1.0, ""],
        ["whole tape, values alone", alone, alone / size**2 * 1e9, whole.channels["steps"].mean(), alone / quick,
         verdict(alone / quick, GOAL_PRUNING)],
        ["whole tape", slow, slow / size**2 * 1e9, whole.channels["steps"].mean(), slow / quick,
         verdict(slow / quick, GOAL_PRUNING)],
    ]  # fmt: skip
    print_table(("tracing with", "CPU s", "ns a ray", "steps a ray", "of regions", "goal"), rows)
    differ = (np.isfinite(a) != np.isfinite(b)).sum()
    print(f"depths differ by {gap:.1e} of themselves at most; {differ} of {size**2:,} pixels see something else\n")


def part(number: int) -> iso.Field:
    """A plate with bosses and holes, other ones for each number."""
    rng = np.random.default_rng(number)
    body = iso.rounded_box((2.0, 0.3, 1.2), 0.05)
    for x in np.linspace(-0.8, 0.8, 5).tolist():
        boss = iso.cylinder(0.14, 0.5).translate((x, 0.1, float(rng.uniform(-0.3, 0.3))))
        body = body.union(boss, blend=0.05) - iso.cylinder(0.07).translate((x, 0.0, float(rng.uniform(-0.3, 0.3))))
    return body - iso.torus(0.4, 0.05).translate((0.0, 0.15, 0.0))


def editing(rounds: int) -> None:
    """The table of how soon a new part is seen."""
    iso.render(part(0), iso.SphereTrace(), progress=False)
    seconds = []
    for number in range(1, rounds + 3):
        began = time.perf_counter()
        shape = part(number)
        iso.render(shape, iso.SphereTrace(), size=(640, 480), progress=False)
        seconds.append(time.perf_counter() - began)
    operations = len(tape_of(part(1).form).rows)
    row = [operations, min(seconds), float(np.median(seconds)), verdict(min(seconds), GOAL_EDIT, at_most=True)]
    print_table(("operations", "s from edit to picture, min", "median", "goal"), [row])


def path_traced(shape: iso.Field | iso.Mesh, size: int = 256, samples: int = 16) -> Callable[[], float]:
    """Processor seconds of path tracing a shape, with everything made before."""
    lights = [iso.Sun((1, 2, 1), 2.0), iso.Sky("white", 0.5)]
    camera = iso.Camera((1.5, 1.2, 3.2), (0, 0, 0))
    scene = iso.Scene([iso.Item(shape, iso.Matte("white"))], lights=lights, camera=camera)
    method, latest = iso.PathTrace(samples=samples, max_depth=8), Latest()
    stamps: dict[str, float] = {}

    def mark(stage: str, fraction: float) -> None:
        stamps[stage] = time.process_time()

    def trace() -> float:
        # What was lowered last is kept for the next picture; here, for each of the two shapes.
        lowering._latest = latest
        iso.render(scene, method, size=(size, size), threads=1, progress=mark)
        return stamps["path tracing"] - stamps["building the tree"]

    return trace


def shapes() -> dict[str, iso.Field]:
    """Shapes of few operations, of a hundred, and of blended balls."""
    classic = (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5) - iso.cylinder(0.5).along("x")
    return {"classic part": classic - iso.cylinder(0.5).along("z"), "plate": part(1), "200 balls": blobs(200)}


def meshes(triangles: int, rounds: int) -> None:
    """The table of fields against their meshes."""
    rows = []
    for name, shape in shapes().items():
        low, high = shape.bounds
        # The triangles of a surface grow with the inverse square of the cell.
        cell = float((high - low).max()) / 128
        few = iso.to_mesh(shape, cell=cell).face_count
        mesh = iso.to_mesh(shape, cell=cell * (few / triangles) ** 0.5)
        sides = path_traced(shape), path_traced(mesh)
        for side in sides:
            side()
        field, other = np.array([[side() for side in sides] for _ in range(rounds)]).T
        paths = 256**2 * 16 / 1e9
        ratio = float(other.min() / field.min())
        rows.append(
            [name, len(tape_of(shape.form).rows), f"{mesh.face_count:,}", field.min() / paths, other.min() / paths,
             ratio, float(np.median(other / field)), verdict(ratio, GOAL_MESH)]
        )  # fmt: skip
    print_table(
        (
            "shape",
            "operations",
            "triangles",
            "field, ns a path",
            "mesh, ns a path",
            "speed of the field",
            "median",
            "goal",
        ),
        rows,
    )


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--parts", type=int, default=1024)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--triangles", type=int, default=1_000_000)
    options = parser.parse_args(arguments)
    print_machine()
    editing(options.rounds)
    meshes(options.triangles, options.rounds)
    pruning(options.parts, options.size, options.rounds)


if __name__ == "__main__":
    main()
