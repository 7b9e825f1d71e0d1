"""Materials and textures of glTF files."""

from __future__ import annotations

import math
import warnings
from os import fspath
from typing import Any, TypeAlias
from urllib.parse import unquote

import attrs
import numpy.typing as npt

from isophote.errors import FileError, IsophoteWarning, SceneError
from isophote.io.gltf.document import Document
from isophote.io.gltf.field import Field
from isophote.io.gltf.geometry import UvMap
from isophote.io.texture_file import decode_picture
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Emitter, Glass, Matte, Mirror, Principled
from isophote.scene.material_base import Material

Pixels: TypeAlias = npt.NDArray[Any]

__all__ = ["MARK", "MaterialReader"]

MARK = "isophote"
"""The key under "extras" where files written here say what glTF has no words for."""

_WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
_NEAREST, _WITHOUT_MEANS = (9728, 9984, 9986), (9728, 9729)
_SURE = 0.9
"""From here on a material is plainly glass."""


@attrs.define
class MaterialReader:
    """Reads each material and each picture of a document once.

    Pictures that are missing or damaged are replaced by `ImageTexture.missing`, with an `IsophoteWarning`; with
    `strict` they raise `FileError`.
    """

    document: Document
    strict: bool
    _materials: dict[int, Material] = attrs.field(init=False, factory=dict)
    _pictures: dict[int, Pixels | None] = attrs.field(init=False, factory=dict)
    _textures: dict[tuple[int, str], ImageTexture] = attrs.field(init=False, factory=dict)
    _uv_maps: dict[int, UvMap] = attrs.field(init=False, factory=dict)

    def material(self, primitive: Field) -> Material:
        """The material of a primitive, glTF's default where it names none."""
        if "material" not in primitive:
            return Principled(1.0, metallic=1.0, roughness=1.0)
        index = primitive.integer("material")
        if index not in self._materials:
            field = self.document.root.entry("materials", index)
            try:
                self._materials[index] = self._read(field)
            except SceneError as error:
                raise FileError(self.document.path, str(error), field.place) from error
        return self._materials[index]

    def uv_map(self, primitive: Field) -> UvMap:
        """The texture coordinates that the material of a primitive uses."""
        if "material" not in primitive:
            return UvMap()
        index = primitive.integer("material")
        if index not in self._uv_maps:
            self._uv_maps[index] = _uv_map(self.document.root.entry("materials", index))
        return self._uv_maps[index]

    def _read(self, field: Field) -> Material:
        principled = self._principled(field)
        return _as_written(field, principled) or _as_glass(field, principled) or _as_emitter(principled) or principled

    def _principled(self, field: Field) -> Principled:
        pbr = field.child("pbrMetallicRoughness") or Field(field.path, {}, field.place)
        normal, occlusion = field.child("normalTexture"), field.child("occlusionTexture")
        red, green, blue, opacity = pbr.numbers("baseColorFactor", 4, (1.0, 1.0, 1.0, 1.0))
        strength = field.extension("KHR_materials_emissive_strength")
        glow = 1.0 if strength is None else strength.number("emissiveStrength", 1.0)
        er, eg, eb = field.numbers("emissiveFactor", 3, (0.0, 0.0, 0.0))
        return Principled(
            (red, green, blue),
            metallic=pbr.number("metallicFactor", 1.0),
            roughness=pbr.number("roughnessFactor", 1.0),
            emission=(er * glow, eg * glow, eb * glow),
            opacity=opacity,
            alpha_mode=(field.text("alphaMode") or "OPAQUE").lower(),
            alpha_cutoff=field.number("alphaCutoff", 0.5),
            two_sided=field.flag("doubleSided"),
            colour_texture=self._texture(pbr.child("baseColorTexture"), "srgb"),
            metallic_roughness_texture=self._texture(pbr.child("metallicRoughnessTexture"), "linear"),
            normal_texture=self._texture(normal, "linear"),
            normal_scale=1.0 if normal is None else normal.number("scale", 1.0),
            occlusion_texture=self._texture(occlusion, "linear"),
            occlusion_strength=1.0 if occlusion is None else occlusion.number("strength", 1.0),
            emission_texture=self._texture(field.child("emissiveTexture"), "srgb"),
        )

    def _texture(self, info: Field | None, space: str) -> ImageTexture | None:
        if info is None:
            return None
        index = info.integer("index")
        if (index, space) not in self._textures:
            self._textures[index, space] = self._read_texture(self.document.root.entry("textures", index), space)
        return self._textures[index, space]

    def _read_texture(self, field: Field, space: str) -> ImageTexture:
        webp = field.extension("EXT_texture_webp")
        holder = field if webp is None or "source" in field else webp
        index = holder.integer("source")
        image = self.document.root.entry("images", index)
        name = image.text("name") or _uri_name(image)
        pixels = self._pixels(image, index)
        if pixels is None:
            return ImageTexture.missing(name or image.place)
        wrap, filtering = self._sampler(field)
        return ImageTexture(pixels, space, wrap, filtering, name=name)

    def _pixels(self, image: Field, index: int) -> Pixels | None:
        """The pixels of a picture, or None where there are none and `strict` does not mind."""
        if index not in self._pictures:
            try:
                pixels: Pixels | None = decode_picture(self._picture(image), self.document.path, image.place).pixels
            except FileError as error:
                if self.strict:
                    raise
                warnings.warn(f"{error}; magenta stands for it", IsophoteWarning, stacklevel=2)
                pixels = None
            self.document.spend(0 if pixels is None else pixels.nbytes, image.place)
            self._pictures[index] = pixels
        return self._pictures[index]

    def _picture(self, image: Field) -> bytes:
        uri = image.text("uri")
        if uri is not None:
            return self.document.resource(uri, image.place)
        data, _ = self.document.view(image.integer("bufferView"))
        return bytes(data)

    def _sampler(self, texture: Field) -> tuple[tuple[str, str], str]:
        """Ways beyond the unit square, and the filter: what does without means is "bilinear", what leaves it open or
        asks for means is "ewa", which is the sharpest."""
        if "sampler" not in texture:
            return ("repeat", "repeat"), "ewa"
        sampler = self.document.root.entry("samplers", texture.integer("sampler"))
        across, down = sampler.integer("wrapS", 10497), sampler.integer("wrapT", 10497)
        if across not in _WRAPS or down not in _WRAPS:
            sampler.fail(f"wrapS and wrapT must be among {list(_WRAPS)}")
        wrap = _WRAPS[across], _WRAPS[down]
        if sampler.integer("magFilter", 9729) in _NEAREST:
            return wrap, "nearest"
        if sampler.integer("minFilter", 9987) in _WITHOUT_MEANS:
            return wrap, "bilinear"
        return wrap, "trilinear" if _mark(sampler).get("filter") == "trilinear" else "ewa"


def _uri_name(image: Field) -> str | None:
    uri = image.text("uri")
    return None if uri is None or uri[:5].lower() == "data:" else unquote(uri)


def _mark(field: Field) -> dict[str, Any]:
    """What this project wrote under "extras"."""
    extras = field.value.get("extras")
    mark = extras.get(MARK) if isinstance(extras, dict) else None
    return mark if isinstance(mark, dict) else {}


def _as_written(field: Field, principled: Principled) -> Material | None:
    """The material that this project wrote as the nearest that glTF has."""
    kind = _mark(field).get("material")
    if kind == "Matte":
        return Matte(principled.colour_texture or principled.colour)
    if kind == "Mirror":
        return Mirror(principled.colour)
    if kind == "Emitter":
        return Emitter(principled.emission, principled.two_sided, texture=principled.emission_texture)
    return None


def _as_glass(field: Field, principled: Principled) -> Glass | None:
    """Glass, where a material lets all light through."""
    transmission = field.extension("KHR_materials_transmission")
    if transmission is None:
        return None
    clear = transmission.number("transmissionFactor", 0.0) >= _SURE and "transmissionTexture" not in transmission
    dielectric = principled.metallic <= 1 - _SURE
    plain = principled.colour_texture is None and principled.metallic_roughness_texture is None
    if not (clear and dielectric and plain):
        return None
    ior = field.extension("KHR_materials_ior")
    index = 1.5 if ior is None else ior.number("ior", 1.5)
    # 0 stands for an endless index: full reflection, which is no glass.
    roughness = principled.roughness if principled.roughness > 1 - _SURE else 0.0
    return Glass(index, principled.colour, roughness=roughness) if index > 0 else None


def _as_emitter(principled: Principled) -> Emitter | None:
    """An emitter, where a material shines and reflects nothing."""
    black = not any(principled.colour) and principled.colour_texture is None
    if not black or not any(principled.emission) or principled.emission_texture is not None:
        return None
    return Emitter(principled.emission, principled.two_sided)


def _uv_map(material: Field) -> UvMap:
    """The coordinates of the first texture of a material; a mesh has one set, so the others must share it."""
    pbr = material.child("pbrMetallicRoughness") or Field(material.path, {}, material.place)
    infos = [pbr.child("baseColorTexture"), pbr.child("metallicRoughnessTexture")]
    infos += [material.child(key) for key in ("emissiveTexture", "normalTexture", "occlusionTexture")]
    maps = [_texture_uv_map(info) for info in infos if info is not None]
    if any(other != maps[0] for other in maps[1:]):
        _warn(material, "its textures use different coordinates; those of the first are used for all")
    return maps[0] if maps else UvMap()


def _texture_uv_map(info: Field) -> UvMap:
    """Source: KHR_texture_transform: translation · rotation · scale."""
    coordinates = info.integer("texCoord", 0)
    transform = info.extension("KHR_texture_transform")
    if transform is None:
        return UvMap(coordinates)
    x, y = transform.numbers("offset", 2, (0.0, 0.0))
    sx, sy = transform.numbers("scale", 2, (1.0, 1.0))
    angle = transform.number("rotation", 0.0)
    c, s = math.cos(angle), math.sin(angle)
    return UvMap(transform.integer("texCoord", coordinates), ((c * sx, s * sy, x), (-s * sx, c * sy, y)))


def _warn(field: Field, reason: str) -> None:
    warnings.warn(f"{fspath(field.path)}, {field.place}: {reason}", IsophoteWarning, stacklevel=2)
