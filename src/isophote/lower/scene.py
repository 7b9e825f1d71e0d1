"""A scene into the tables that kernels run over."""

from __future__ import annotations

import numpy as np

from isophote.errors import SceneError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.tables import SCENE
from isophote.lower.geometry import Part, lower_geometry, parts_of
from isophote.lower.latest import Latest
from isophote.lower.lights import LightTable, rectangle_mesh
from isophote.lower.materials import MaterialTable, emission_of
from isophote.scene.light import RectLight
from isophote.scene.material import Emitter
from isophote.scene.scene import Scene

__all__ = ["lower_scene"]


_latest = Latest()


def lower_scene(scene: Scene, size: tuple[int, int], threads: int | None = None) -> Packed:
    """The tables of `scene` for a picture of `size` (width, height).

    Items are numbered as they stand in the scene; area lights go on from there, in their order among the lights.
    Tables of the scene lowered last are used again where only the camera or the size differ. Raises `SceneError` for a
    scene without items that can be drawn, or without a camera.
    """
    if scene.camera is None:
        raise SceneError("the scene has no camera; give Scene(camera=...) or use isophote.studio(scene)")
    camera = np.stack(scene.camera.linear_map(size)).astype(np.float32)
    tables = _latest.find(scene)
    if tables is None:
        tables = _tables(scene, threads)
        _latest.keep(scene, tables)
    return SCENE.pack(**tables, camera=camera)


def _tables(scene: Scene, threads: int | None) -> dict[str, Packed]:
    """All tables but the camera's."""
    materials, lights = MaterialTable(), LightTable()
    parts = _parts(scene, materials, lights)
    if not parts:
        raise SceneError("the scene has nothing to draw: no items and no rectangle lights")
    geometry, surfaces, bounds = lower_geometry(parts, threads)
    reach = float(np.linalg.norm(bounds[1] - bounds[0])) / 2
    for number, light in enumerate(scene.lights, start=len(scene.items)):
        if not isinstance(light, RectLight):
            lights.add(light, reach, number)
    material_table, textures = materials.build()
    return {
        "geometry": geometry,
        "surfaces": surfaces,
        "materials": material_table,
        "textures": textures,
        "lights": lights.build(reach),
    }


def _parts(scene: Scene, materials: MaterialTable, lights: LightTable) -> list[Part]:
    parts = []
    for number, (item, mesh) in enumerate(parts_of(scene.items)):
        radiance, two_sided = emission_of(item.material)
        matrix = item.transform.matrix
        shines = max(radiance) > 0
        own = lights.add_mesh(mesh, matrix, radiance, two_sided) if shines else None
        parts.append(Part(mesh, matrix, materials.number(item.material), number, own))
    for number, light in enumerate(scene.lights, start=len(scene.items)):
        if isinstance(light, RectLight):
            mesh, matrix, radiance = rectangle_mesh(light), light.transform.matrix, light.radiance_rgb
            own = lights.add_mesh(mesh, matrix, radiance, light.two_sided)
            material = materials.number(Emitter(radiance, two_sided=light.two_sided))
            parts.append(Part(mesh, matrix, material, number, own))
    return parts
