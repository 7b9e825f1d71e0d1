"""MTL, the materials beside OBJ files. Source: Wavefront, Advanced Visualizer manual, appendix B1."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs

from isophote.scene.colour import Colour

__all__ = ["MtlMaterial", "parse_mtl"]

# How many values follow an option of a map; a number of them where the rest may be left out.
_MAP_OPTIONS = {
    "-blendu": (1, 1),
    "-blendv": (1, 1),
    "-bm": (1, 1),
    "-boost": (1, 1),
    "-cc": (1, 1),
    "-clamp": (1, 1),
    "-imfchan": (1, 1),
    "-mm": (2, 2),
    "-o": (1, 3),
    "-s": (1, 3),
    "-t": (1, 3),
    "-texres": (1, 1),
}
_COLOURS = {"kd": "diffuse", "ks": "specular", "ke": "emission", "tf": "transmission"}
_NUMBERS = {"ni": "ior", "d": "opacity", "illum": "illumination"}


@attrs.frozen
class MtlMaterial:
    """One material as its file states it: colours are linear, None where there is none."""

    diffuse: Colour | None = None
    specular: Colour | None = None
    emission: Colour | None = None
    transmission: Colour | None = None
    ior: float | None = None
    opacity: float = 1.0
    illumination: float = 2.0
    diffuse_map: str | None = None
    clamped: bool = False


def parse_mtl(data: bytes) -> dict[str, MtlMaterial]:
    """The materials of an MTL file by name. What cannot be understood in it is passed over."""
    materials: dict[str, dict[str, Any]] = {}
    current: dict[str, Any] = {}
    for line in data.decode("utf-8", "replace").replace("\\\n", " ").splitlines():
        key, _, rest = (
            line.strip().partition(" ") if "\t" not in line else line.strip().replace("\t", " ").partition(" ")
        )
        key, rest = key.lower(), rest.strip()
        if key == "newmtl":
            current = materials.setdefault(rest, {})
        else:
            current.update(_statement(key, rest))
    return {name: MtlMaterial(**fields) for name, fields in materials.items()}


def _statement(key: str, rest: str) -> dict[str, Any]:
    words = rest.split()
    if key in _COLOURS:
        colour = _colour(words)
        return {} if colour is None else {_COLOURS[key]: colour}
    if key in _NUMBERS or key == "tr":
        number = _number(words[-1:])
        if number is None:
            return {}
        return {"opacity": 1.0 - number} if key == "tr" else {_NUMBERS[key]: number}
    if key == "map_kd":
        name, clamped = _map(rest)
        return {"diffuse_map": name, "clamped": clamped} if name else {}
    return {}


def _number(words: Sequence[str]) -> float | None:
    try:
        number = float(words[0])
    except (IndexError, ValueError):
        return None
    return number if abs(number) < 1e30 else None


def _colour(words: Sequence[str]) -> Colour | None:
    """Three numbers, or one for a grey; negative ones count as 0."""
    numbers = [_number([word]) for word in words[:3]]
    if len(numbers) not in (1, 3) or None in numbers:
        return None
    red, green, blue = (max(number or 0.0, 0.0) for number in (numbers * 3)[:3])
    return red, green, blue


def _map(rest: str) -> tuple[str, bool]:
    """File name, which may have blanks in it, and whether it is clamped; the options come before it."""
    clamped = False
    while rest.startswith("-"):
        option, _, after = rest.partition(" ")
        if option not in _MAP_OPTIONS:
            break
        fewest, most = _MAP_OPTIONS[option]
        rest = after.strip()
        for count in range(most):
            value, _, after = rest.partition(" ")
            if count >= fewest and _number([value]) is None:
                break
            clamped = value == "on" if option == "-clamp" else clamped
            rest = after.strip()
    return rest, clamped
