"""A scene as Mitsuba 3 has it, and its pictures there."""

from __future__ import annotations

import math
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import isophote as iso

__all__ = ["render_mitsuba"]

# What their hard spots need between the cone and its edge, in parts of the angle.
_EDGE = 1e-6


def _mitsuba() -> Any:
    import mitsuba

    if not mitsuba.variant():
        mitsuba.set_variant("llvm_ad_rgb" if os.environ.get("DRJIT_LIBLLVM_PATH") else "scalar_rgb")
    return mitsuba


def _rgb(triple: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(c) for c in triple]}


def _material(material: Any) -> dict[str, Any]:
    if isinstance(material, iso.Matte):
        return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": _rgb(material.colour)}}
    if isinstance(material, iso.Mirror):
        inner = {"type": "conductor", "material": "none", "specular_reflectance": _rgb(material.colour)}
        return {"type": "twosided", "inner": inner}
    if isinstance(material, iso.Glass):
        return _boundary(material)
    if isinstance(material, iso.Metal):
        return {"type": "twosided", "inner": _metal(material)}
    if isinstance(material, iso.Plastic):
        inner = {"type": "plastic", "diffuse_reflectance": _rgb(material.colour), "nonlinear": True}
        return {"type": "twosided", "inner": inner | {"int_ior": material.ior, "ext_ior": 1.0}}
    if isinstance(material, iso.ThinGlass):
        colour = {f"specular_{way}": _rgb(material.colour) for way in ("reflectance", "transmittance")}
        return {"type": "thindielectric", "int_ior": material.ior, "ext_ior": 1.0, **colour}
    if isinstance(material, iso.Mix):
        parts = {"first": _material(material.first), "second": _material(material.second)}
        return {"type": "blendbsdf", "weight": float(material.amount), **parts}
    return {"type": "diffuse", "reflectance": _rgb((0, 0, 0))}


def _roughness(material: iso.Metal | iso.Glass) -> dict[str, Any]:
    """What is added to a smooth kind's description; nothing where it is smooth."""
    along, across = material.roughness
    return {} if along == 0 else {"distribution": "ggx", "alpha_u": along**2, "alpha_v": across**2}


def _metal(material: iso.Metal) -> dict[str, Any]:
    rough = _roughness(material)
    n, k = material.index
    colour = {"specular_reflectance": _rgb(material.colour)}
    return {"type": "roughconductor" if rough else "conductor", "eta": _rgb(n), "k": _rgb(k), **colour, **rough}


def _boundary(material: iso.Glass) -> dict[str, Any]:
    rough = _roughness(material)
    colour = {f"specular_{way}": _rgb(material.colour) for way in ("reflectance", "transmittance")}
    kind = "roughdielectric" if rough else "dielectric"
    return {"type": kind, "int_ior": material.ior, "ext_ior": 1.0, **colour, **rough}


def _shape(item: iso.Item, folder: Path, name: str) -> dict[str, Any]:
    cut = iso.triangulate(item.shape)
    path = folder / f"{name}.ply"
    placed = iso.Mesh(item.transform.apply(item.shape.vertices), cut.triangles)
    if "uv" in item.shape.attributes:
        placed = placed.with_(attributes={"uv": item.shape.attributes["uv"]})
    iso.save(placed, path)
    shape = {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": _material(item.material)}
    if isinstance(item.material, iso.Emitter):
        shape["emitter"] = {"type": "area", "radiance": _rgb(item.material.radiance)}
    return shape


def _light(mi: Any, light: Any, folder: Path) -> dict[str, Any]:
    transform = mi.ScalarTransform4f
    black = _material(None)
    if isinstance(light, iso.PointLight):
        return {"type": "point", "position": list(light.position), "intensity": _rgb(light.intensity_rgb)}
    if isinstance(light, iso.SpotLight):
        return _spot(transform, light)
    if isinstance(light, iso.Sun):
        toward = [-c for c in light.unit_direction]
        return {"type": "directional", "direction": toward, "irradiance": _rgb(light.irradiance_rgb)}
    if isinstance(light, iso.Sky):
        return {"type": "constant", "radiance": _rgb(light.radiance_rgb)}
    if isinstance(light, iso.Environment):
        return _picture(mi, light, folder)
    area = {"type": "area", "radiance": _rgb(light.radiance_rgb)}
    if isinstance(light, iso.SphereLight):
        return {
            "type": "sphere",
            "center": list(light.position),
            "radius": light.radius,
            "bsdf": black,
            "emitter": area,
        }
    # Their rectangles and disks reach from −1 to 1 and face +z; ours face −y.
    across, along = (light.size[0] / 2, light.size[1] / 2) if isinstance(light, iso.RectLight) else (light.radius,) * 2
    place = light.transform.matrix.copy()
    own = np.stack([across * place[:3, 0], along * place[:3, 2], -place[:3, 1], place[:3, 3]], 1)
    kind = "rectangle" if isinstance(light, iso.RectLight) else "disk"
    matrix = transform(np.vstack([own, (0, 0, 0, 1)]))
    return {"type": kind, "to_world": matrix, "bsdf": black, "emitter": area}


def _spot(transform: Any, light: iso.SpotLight) -> dict[str, Any]:
    """A spot with a hard edge; their soft ones fall off otherwise."""
    half = light.cone_degrees / 2
    ahead = np.add(light.position, light.unit_axis).tolist()
    up = [1, 0, 0] if abs(light.unit_axis[1]) > 0.9 else [0, 1, 0]
    place = transform().look_at(list(light.position), ahead, up)
    edge = {"cutoff_angle": half, "beam_width": half * (1 - _EDGE)}
    return {"type": "spot", "to_world": place, "intensity": _rgb(light.intensity_rgb), **edge}


def _picture(mi: Any, light: iso.Environment, folder: Path) -> dict[str, Any]:
    """Their maps lie as ours do, +z in the middle, +x in the left half; but their first and last rows are the poles,
    where ours are half a row away. Rows are therefore resampled, closely enough that nothing else changes."""
    texels = light.texture.pixels[..., :3] * np.float32(light.strength)
    height = len(texels)
    row = np.clip(np.linspace(0, height, 8 * height + 1) - 0.5, 0, height - 1)
    above = np.minimum(row.astype(int), height - 2)
    share = (row - above).astype(np.float32)[:, None, None]
    pixels = np.ascontiguousarray(texels[above] * (1 - share) + texels[above + 1] * share)
    path = folder / "sky.exr"
    mi.Bitmap(pixels).write(str(path))
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], math.degrees(light.rotation))
    return {"type": "envmap", "filename": str(path), "to_world": turn}


def _camera(mi: Any, camera: Any, size: int, samples: int) -> dict[str, Any]:
    look = mi.ScalarTransform4f().look_at(list(camera.eye), list(camera.target), list(camera.up))
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    common = {"film": film, "sampler": {"type": "multijitter", "sample_count": samples}}
    if isinstance(camera, iso.OrthographicCamera):
        half = camera.height / 2
        return {"type": "orthographic", "to_world": look @ mi.ScalarTransform4f().scale([half, half, 1]), **common}
    common |= {"fov": camera.fov_degrees, "to_world": look}
    if camera.lens_radius > 0:
        return {"type": "thinlens", "aperture_radius": camera.lens_radius, "focus_distance": camera.focus, **common}
    return {"type": "perspective", **common}


def render_mitsuba(scene: iso.Scene, size: int, samples: int, depth: int, runs: int) -> np.ndarray:
    """(runs, size, size, 3) pictures of different seeds, by paths of `depth` rays."""
    mi = _mitsuba()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        described: dict[str, Any] = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth, "rr_depth": 100},
            "sensor": _camera(mi, scene.camera, size, samples),
        }
        for k, item in enumerate(scene.items):
            described[f"item{k}"] = _shape(item, folder, f"item{k}")
        for k, light in enumerate(scene.lights):
            described[f"light{k}"] = _light(mi, light, folder)
        loaded = mi.load_dict(described)
    return np.array([np.array(mi.render(loaded, spp=samples, seed=k + 1), np.float64) for k in range(runs)])
