"""Any material as the nearest that glTF's words can say, for files and methods that know no other."""

from __future__ import annotations

import math

import attrs
import numpy as np
import numpy.typing as npt

from isophote.scene.colour import WHITE, Colour, srgb_to_linear
from isophote.scene.compound import Coated, Mix, Plastic
from isophote.scene.cutout import ALPHA, Cutout, alpha_channel
from isophote.scene.gloss import AshikhminShirley, Blinn, Phong, Ward
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Emitter, Glass, Mirror, Principled
from isophote.scene.material_base import ColourParameter, Material, NumberParameter
from isophote.scene.measured import Measured
from isophote.scene.metal import Metal
from isophote.scene.relief import Bump, NormalMap
from isophote.scene.texture import Texture

__all__ = ["nearest_principled"]

_TYPICAL = 0.3


def nearest_principled(material: Material) -> Principled:
    """The `Principled` that looks most like a material; textures but that of the colour are left out."""
    if isinstance(material, Principled):
        return material
    if isinstance(material, Emitter):
        black = Principled(0.0, roughness=1.0)
        body = black if material.body is None else nearest_principled(material.body)
        shining = attrs.evolve(body, emission=material.radiance, two_sided=material.two_sided)
        return attrs.evolve(shining, emission_texture=material.texture)
    if isinstance(material, NormalMap):
        base = nearest_principled(material.material)
        return attrs.evolve(base, normal_texture=material.texture, normal_scale=material.scale)
    if isinstance(material, Bump):
        return nearest_principled(material.material)
    if isinstance(material, Cutout):
        return _cut(material)
    if isinstance(material, Coated):
        return attrs.evolve(nearest_principled(material.base), roughness=_number(material.roughness))
    if isinstance(material, Mix):
        chosen = material.first if _number(material.amount) < 0.5 else material.second
        return nearest_principled(chosen)
    metallic = 1.0 if isinstance(material, Metal | Mirror) else 0.0
    colour = _colour(material)
    rough = _roughness(material)
    if isinstance(colour, Texture):
        return Principled(1.0, metallic, rough, colour_texture=colour, two_sided=True)
    return Principled(colour, metallic, rough, two_sided=True)


def _cut(cutout: Cutout) -> Principled:
    """The material with the opacity that a number says, or in the fourth channel of the texture of its colour, where
    both fit together."""
    whole = nearest_principled(cutout.material)
    if not isinstance(cutout.alpha, Texture):
        return attrs.evolve(whole, opacity=cutout.alpha, alpha_mode=cutout.mode, alpha_cutoff=cutout.cutoff)
    texture = _with_alpha(whole.colour_texture, cutout.alpha)
    if texture is None:
        return whole
    return attrs.evolve(whole, colour_texture=texture, opacity=1.0, alpha_mode=cutout.mode, alpha_cutoff=cutout.cutoff)


def _with_alpha(colour: Texture | None, alpha: Texture) -> ImageTexture | None:
    """A picture of both, in 8 bits, or None where they are no pictures of one size."""
    if alpha == colour and isinstance(alpha, ImageTexture) and alpha_channel(alpha) == ALPHA:
        return alpha
    if not isinstance(alpha, ImageTexture) or not isinstance(colour, ImageTexture | None):
        return None
    base = colour or attrs.evolve(
        alpha, pixels=np.full((*alpha.pixels.shape[:2], 3), 255, np.uint8), colour_space="srgb"
    )
    if base.size != alpha.size or base.pixels.dtype != np.uint8:
        return None
    planes = base.pixels.reshape(*base.pixels.shape[:2], -1)
    red_green_blue = np.broadcast_to(planes[..., :1], (*planes.shape[:2], 3)) if base.channels == 1 else planes[..., :3]
    return attrs.evolve(base, pixels=np.concatenate([red_green_blue, _opacities(alpha)[..., None]], axis=2))


def _opacities(alpha: ImageTexture) -> npt.NDArray[np.uint8]:
    """(h, w): what a picture says of opacity, in 8 bits."""
    channel = alpha_channel(alpha)
    plane = alpha.pixels.reshape(*alpha.pixels.shape[:2], -1)[..., channel]
    values = plane / 255 if plane.dtype == np.uint8 else plane
    if channel != ALPHA and alpha.colour_space == "srgb":
        values = srgb_to_linear(values)
    return np.asarray(np.round(np.clip(values, 0, 1) * 255), np.uint8)


def _colour(material: Material) -> ColourParameter:
    if isinstance(material, Metal):
        return _facing(material)
    if isinstance(material, Measured):
        return _body(material)
    colour: ColourParameter = getattr(material, "colour", WHITE)
    return colour


def _body(measured: Measured) -> Colour:
    """Albedo of what lies below the highlight, as far as a table tells: where half directions are flat."""
    halves, differences = measured.values.shape[0] // 2, measured.values.shape[1] * 2 // 3
    mean = math.pi * measured.values[halves:, :differences].mean(axis=(0, 1, 2), dtype=float)
    red, green, blue = mean.clip(0.0, 1.0).tolist()
    return red, green, blue


def _number(parameter: NumberParameter) -> float:
    return _TYPICAL if isinstance(parameter, Texture) else parameter


def _facing(metal: Metal) -> Colour:
    """What a metal reflects of light from above."""
    n, k = metal.index
    colour = (1.0, 1.0, 1.0) if isinstance(metal.colour, Texture) else metal.colour
    red, green, blue = (c * ((a - 1) ** 2 + b**2) / ((a + 1) ** 2 + b**2) for a, b, c in zip(n, k, colour, strict=True))
    return red, green, blue


def _roughness(material: Material) -> float:
    """Such that highlights are about as wide."""
    if isinstance(material, Mirror):
        return 0.0
    if isinstance(material, Metal | Ward | Glass):
        return math.sqrt(_number(material.roughness[0]) * _number(material.roughness[1]))
    if isinstance(material, Plastic):
        return _number(material.roughness)
    if isinstance(material, Phong):
        # The mirror direction turns twice as far as the half direction.
        return _of_exponent(4 * _number(material.exponent))
    if isinstance(material, Blinn):
        return _of_exponent(_number(material.exponent))
    if isinstance(material, AshikhminShirley):
        return _of_exponent(math.sqrt(_number(material.exponents[0]) * _number(material.exponents[1])))
    return 1.0


def _of_exponent(n: float) -> float:
    """α² = 2 / (n + 2), α = roughness²."""
    return math.sqrt(math.sqrt(2 / (n + 2)))
