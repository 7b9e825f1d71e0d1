"""The rays of a pixel as a tree of lines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from isophote.rendering.ray_log import LightTerm, LoggedRay, Triple
from isophote.rendering.ray_trace import RayTrace
from isophote.scene.colour import linear_to_srgb
from isophote.scene.scene import Scene

__all__ = ["names_of", "written"]

_WORDS = {
    "camera": "camera ray",
    "reflected": "reflected ray",
    "refracted": "refracted ray",
    "passed": "ray straight on",
}
_ENDED = {"depth": "not traced: the depth is reached", "weight": "not traced: it would add too little"}


def names_of(scene: Scene) -> tuple[list[str], list[str]]:
    """(items, lights): what each is called in explanations."""
    items = [
        f"items[{k}]" + (f' "{item.name}"' if item.name else "") + f", {type(item.shape).__name__}"
        f" of {type(item.material).__name__}"
        for k, item in enumerate(scene.items)
    ]
    lights = [f"lights[{k}], {type(light).__name__}" for k, light in enumerate(scene.lights)]
    return items, lights


def written(
    scene: Scene,
    pixel: tuple[int, int],
    size: tuple[int, int],
    method: RayTrace,
    colour: Triple,
    rays: Sequence[LoggedRay],
) -> str:
    """The whole explanation."""
    items, lights = names_of(scene)
    names = items + lights
    branches: dict[int, list[int]] = {}
    for number, ray in enumerate(rays):
        branches.setdefault(ray.parent, []).append(number)
    lines = [
        f"Pixel {pixel[0]}, {pixel[1]} of {size[0]} × {size[1]}, {method!r}",
        f"colour {_rgb(colour)}, in sRGB {_code(colour)}",
        "= Σ weight · colour of its camera rays; a ray's colour = tint · (emitted + ambient + Σ lights + Σ weight · "
        "colour of its branches)",
    ]
    for number in branches.get(-1, []):
        lines += _tree(number, rays, branches, names)
    return "\n".join(lines)


def _tree(
    number: int, rays: Sequence[LoggedRay], branches: dict[int, list[int]], names: Sequence[str]
) -> Iterator[str]:
    """The lines of a ray and its branches. Trees are as deep as a method's depth, at most a few hundred."""
    ray, below = rays[number], branches.get(number, [])
    yield f"{_WORDS[ray.kind]} {number}, weight {_rgb(ray.weight)}, colour {_rgb(ray.colour)}"
    facts = list(_facts(ray, names))
    for fact in facts:
        yield ("│  " if below else "   ") + fact
    for place, branch in enumerate(below):
        last = place == len(below) - 1
        for row, line in enumerate(_tree(branch, rays, branches, names)):
            yield ("   " if last else "│  ") + line if row else ("└─ " if last else "├─ ") + line


def _facts(ray: LoggedRay, names: Sequence[str]) -> Iterator[str]:
    yield f"from {_xyz(ray.origin)} along {_xyz(ray.direction)}"
    if ray.ended is not None:
        yield _ENDED[ray.ended]
        return
    if ray.met == "nothing":
        yield f"meets nothing; sky {_rgb(ray.emitted)}"
        return
    yield f"meets {_name(names, ray.item)}, at distance {ray.distance:.6g} in {_xyz(ray.place)}"
    if ray.met == "surface":
        place = f"uv {ray.uv[0]:.4f}, {ray.uv[1]:.4f}"
        if ray.barycentric is not None:
            weights = ", ".join(f"{weight:.4f}" for weight in ray.barycentric)
            place = f"face {ray.primitive}, barycentric {weights}, {place}"
        yield place
        smooth = f", shading {_xyz(ray.shading)}" if ray.shading != ray.normal else ""
        yield f"normal {_xyz(ray.normal)}{smooth}"
    if ray.tint != (1.0, 1.0, 1.0):
        yield f"tint {_rgb(ray.tint)}, what the way there left"
    for word, value in (("emitted", ray.emitted), ("ambient", ray.ambient)):
        if any(value):
            yield f"{word} {_rgb(value)}"
    for light in sorted({term.light for term in ray.lights}):
        yield from _light([term for term in ray.lights if term.light == light], _name(names, light))


def _light(terms: Sequence[LightTerm], name: str) -> Iterator[str]:
    total = np.sum([term.colour for term in terms], axis=0)
    seen = sum(term.seen for term in terms)
    if len(terms) == 1:
        term = terms[0]
        sight = "" if term.seen else "; something is in the way"
        factor = f" · {term.factor:.5g}" if term.factor != 1 else ""
        yield f"{name}: arriving {_rgb(term.arriving)} · f cosθ {_rgb(term.value)}{factor} = {_rgb(term.colour)}{sight}"
        return
    yield f"{name}: {seen} of {len(terms)} rays see it, together {_rgb(tuple(total.tolist()))}"
    for term in terms:
        if term.seen:
            yield (
                f"   ray {term.trial}: arriving {_rgb(term.arriving)} · f cosθ {_rgb(term.value)} · {term.factor:.5g}"
                f" = {_rgb(term.colour)}"
            )


def _name(names: Sequence[str], number: int) -> str:
    return names[number] if 0 <= number < len(names) else f"number {number}"


def _rgb(colour: Sequence[float]) -> str:
    return "(" + ", ".join(f"{channel:.6g}" for channel in colour) + ")"


def _xyz(place: Sequence[float]) -> str:
    return "(" + ", ".join(f"{coordinate:.5g}" for coordinate in place) + ")"


def _code(colour: Sequence[float]) -> str:
    shown = np.rint(np.clip(linear_to_srgb(np.array(colour)), 0, 1) * 255).astype(int)
    return "#" + "".join(f"{channel:02x}" for channel in shown)
