"""Scenes in which nothing shines: told before a black picture is made."""

from __future__ import annotations

import warnings

from isophote.errors import IsophoteWarning
from isophote.lower.materials import emission_of
from isophote.scene.light import AreaLight, Environment, Light, PointLight, Sky, Sun
from isophote.scene.scene import Scene
from isophote.scene.spot_light import SpotLight

__all__ = ["warn_if_dark", "warn_if_swallowed"]

_MOST_NAMED = 3


def warn_if_dark(scene: Scene) -> None:
    """Warn with an `IsophoteWarning` if no light and no material of a scene shines, saying what mends that."""
    if any(_shines(light) for light in scene.lights):
        return
    if any(max(emission_of(item.material)[0]) > 0 for item in scene.items):
        return
    warnings.warn(_reason(scene), IsophoteWarning, stacklevel=4)


def warn_if_swallowed(scene: Scene) -> None:
    """Warn with an `IsophoteWarning` if all light comes from beyond a medium that fills all space."""
    medium = scene.medium
    if medium is None or medium.bounds is not None or max(*medium.scattering, *medium.absorption) == 0:
        return
    shining = [light for light in scene.lights if _shines(light)]
    if not shining or not all(isinstance(light, Sky | Sun | Environment) for light in shining):
        return
    if any(max(emission_of(item.material)[0]) > 0 for item in scene.items):
        return
    warnings.warn(
        "the scene's medium has no bounds, so no light of skies and suns comes through, and all of it is black: give "
        "Medium(bounds=[(x, y, z), (x, y, z)]), or lights within it",
        IsophoteWarning,
        stacklevel=4,
    )


def _reason(scene: Scene) -> str:
    if not scene.lights:
        return (
            "nothing in the scene shines, so all of it is black: it has no lights, and no material emits; add some, "
            'such as Scene(..., lights=[iso.Sky("white", 1.0)]) or iso.RectLight(size=(1, 1), power=60).at((0, 3, 0)), '
            "or let iso.studio(scene) do so"
        )
    kinds = [type(light).__name__ for light in scene.lights]
    named = ", ".join(f"lights[{k}] ({kind})" for k, kind in enumerate(kinds[:_MOST_NAMED]))
    rest = f" and {len(kinds) - _MOST_NAMED} more" if len(kinds) > _MOST_NAMED else ""
    return (
        f"nothing in the scene shines, so all of it is black: power, strength or colour is 0 of {named}{rest}, and "
        "no material emits; give one of them more, or leave the lights out to have those of iso.studio"
    )


def _shines(light: Light) -> bool:
    """Whether any light at all comes from a light."""
    if isinstance(light, PointLight | SpotLight):
        return max(light.intensity_rgb) > 0
    if isinstance(light, Sun):
        return max(light.irradiance_rgb) > 0
    if isinstance(light, AreaLight | Sky):
        return max(light.radiance_rgb) > 0
    return not isinstance(light, Environment) or (light.strength > 0 and light.texture.pixels.max() > 0)
