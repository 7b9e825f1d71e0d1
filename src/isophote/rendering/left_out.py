"""What a method leaves out of a scene: told before its picture is made."""

from __future__ import annotations

import warnings

from isophote.errors import IsophoteWarning
from isophote.lower.materials import is_cut, is_mapped
from isophote.scene.cutout import Cutout
from isophote.scene.material import Emitter, Matte
from isophote.scene.material_base import Material, parts_of
from isophote.scene.relief import Bump, NormalMap
from isophote.scene.scene import Scene

__all__ = ["warn_of_left_out"]


def warn_of_left_out(
    scene: Scene, method: str, *, holes: bool = False, relief: bool = False, gloss: bool = False
) -> None:
    """Warn with an `IsophoteWarning` of a medium in the scene, of which the method named `method` knows nothing, and
    of holes, relief and gloss where it leaves those out."""
    told = []
    if scene.medium is not None:
        told.append(f"{method} knows of no fog: the scene's medium is left out; PathTrace shows it")
    materials = [item.material for item in scene.items]
    if holes and any(cut := [is_cut(material) for material in materials]):
        told.append(f"{method} takes surfaces for whole: the holes of {_named(cut)} are left out")
    if relief and any(bumpy := [_has_relief(material) for material in materials]):
        told.append(f"{method} knows of no relief: the normal maps and bumps of {_named(bumpy)} are left out")
    if gloss and any(glossy := [not isinstance(_base(material), Matte | None) for material in materials]):
        kinds = ", ".join(
            sorted({type(_base(one)).__name__ for one, yes in zip(materials, glossy, strict=True) if yes})
        )
        told.append(f"{method} knows only diffuse surfaces: {_named(glossy)} ({kinds}) taken for Matte of their colour")
    for text in told:
        # At the call of iso.render.
        warnings.warn(text, IsophoteWarning, stacklevel=4)


def _base(material: Material) -> Material | None:
    """What reflects, below holes and relief; None of what only shines."""
    if isinstance(material, Cutout | Bump | NormalMap):
        return _base(material.material)
    if isinstance(material, Emitter):
        return None if material.body is None else _base(material.body)
    return material


def _has_relief(material: Material) -> bool:
    return is_mapped(material) or any(isinstance(part, Bump) for part in parts_of(material))


def _named(which: list[bool]) -> str:
    rest = sum(which) - 1
    return f"items[{which.index(True)}]" + (f" and {rest} other{'s' if rest > 1 else ''}" if rest else "")
