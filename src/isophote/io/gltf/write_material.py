"""Materials and textures as JSON of glTF files."""

from __future__ import annotations

import math
import warnings
from os import fspath
from typing import Any, TypeAlias

import attrs

from isophote.errors import IsophoteWarning
from isophote.io.files import StrPath
from isophote.io.gltf.build import Builder
from isophote.io.gltf.material import MARK
from isophote.io.texture_png import encode_texture, is_exact, picture_of
from isophote.scene.colour import Colour
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Glass, Principled
from isophote.scene.material_base import Material
from isophote.scene.nearest import nearest_principled
from isophote.scene.texture import Texture

__all__ = ["MaterialWriter"]

Json: TypeAlias = dict[str, Any]

_WRAPS = {"repeat": 10497, "clamp": 33071, "mirror": 33648}
# What enlarges a picture, and what makes it smaller: by means or not.
_FILTERS = {"ewa": (9729, 9987), "trilinear": (9729, 9987), "bilinear": (9729, 9729), "nearest": (9728, 9728)}


@attrs.define
class MaterialWriter:
    """Writes each material and each picture once."""

    path: StrPath
    builder: Builder
    _materials: dict[Material, int] = attrs.field(init=False, factory=dict)
    _textures: dict[tuple[ImageTexture, str], int] = attrs.field(init=False, factory=dict)

    def material(self, material: Material) -> int:
        """The number of a material."""
        if material not in self._materials:
            self._materials[material] = self.builder.add("materials", self._written(material))
        return self._materials[material]

    def _written(self, material: Material) -> Json:
        """The nearest that glTF has; what it has no words for is told beside it."""
        if isinstance(material, Principled):
            return self._principled(material)
        if isinstance(material, Glass):
            return self._glass(material)
        return self._principled(nearest_principled(material)) | {
            "extras": {MARK: {"material": type(material).__name__}}
        }

    def _principled(self, material: Principled) -> Json:
        pbr: Json = {
            "baseColorFactor": [*material.colour, material.opacity],
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        written: Json = {
            "pbrMetallicRoughness": pbr,
            "alphaMode": material.alpha_mode.upper(),
            "doubleSided": material.two_sided,
            **self._emission(material.emission),
        }
        if material.alpha_mode == "mask":
            written["alphaCutoff"] = material.alpha_cutoff
        self._put(pbr, "baseColorTexture", material.colour_texture, "srgb")
        self._put(pbr, "metallicRoughnessTexture", material.metallic_roughness_texture, "linear")
        self._put(written, "normalTexture", material.normal_texture, "linear", scale=material.normal_scale)
        strength = material.occlusion_strength
        self._put(written, "occlusionTexture", material.occlusion_texture, "linear", strength=strength)
        self._put(written, "emissiveTexture", material.emission_texture, "srgb")
        return written

    def _emission(self, emission: Colour) -> Json:
        """Factors up to 1, and beyond that a strength: a power of two, so that the product is exact."""
        largest = max(emission)
        if largest <= 1:
            return {"emissiveFactor": list(emission)} if largest else {}
        name = "KHR_materials_emissive_strength"
        self.builder.extensions.add(name)
        strength = 2.0 ** math.ceil(math.log2(largest))
        return {
            "emissiveFactor": [min(channel / strength, 1.0) for channel in emission],
            "extensions": {name: {"emissiveStrength": strength}},
        }

    def _glass(self, material: Glass) -> Json:
        extensions = {
            "KHR_materials_transmission": {"transmissionFactor": 1.0},
            "KHR_materials_ior": {"ior": material.ior},
        }
        self.builder.extensions |= set(extensions)
        roughness = nearest_principled(material).roughness
        pbr = {"baseColorFactor": [*material.colour, 1.0], "metallicFactor": 0.0, "roughnessFactor": roughness}
        return {"pbrMetallicRoughness": pbr, "extensions": extensions}

    def _put(self, holder: Json, key: str, given: Texture | None, space: str, **factors: float) -> None:
        texture = picture_of(given, self.path)
        if texture is not None:
            holder[key] = {"index": self._texture(texture, space), **factors}

    def _texture(self, texture: ImageTexture, space: str) -> int:
        if (texture, space) not in self._textures:
            sampler = self._sampler(texture)
            view = self.builder.add_bytes(self._png(texture, space))
            image: Json = {"mimeType": "image/png", "bufferView": view}
            if texture.name is not None:
                image["name"] = texture.name
            entry = {"source": self.builder.add("images", image), "sampler": self.builder.add("samplers", sampler)}
            self._textures[texture, space] = self.builder.add("textures", entry)
        return self._textures[texture, space]

    def _sampler(self, texture: ImageTexture) -> Json:
        large, small = _FILTERS[texture.filter]
        across, down = texture.wraps
        found: Json = {"magFilter": large, "minFilter": small, "wrapS": _WRAPS[across], "wrapT": _WRAPS[down]}
        if texture.filter == "trilinear":
            found["extras"] = {MARK: {"filter": "trilinear"}}
        return found

    def _png(self, texture: ImageTexture, space: str) -> bytes:
        if not is_exact(texture, space):
            name = f'the texture "{texture.name}"' if texture.name else "a texture"
            warnings.warn(
                f"{fspath(self.path)}: {name} becomes 8-bit {space}, which glTF wants here",
                IsophoteWarning,
                stacklevel=6,
            )
        return encode_texture(texture, space)
