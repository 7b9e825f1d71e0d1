"""A scene into the tables that kernels run over."""

from __future__ import annotations

from collections.abc import Sequence, Set
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.tables import SCENE
from isophote.lower.displaced import displaced
from isophote.lower.field_table import FieldPart, endless, no_fields
from isophote.lower.geometry import Part, lower_geometry
from isophote.lower.lamps import lamp_primitive, many_lamps
from isophote.lower.latest import LatestScene
from isophote.lower.lights import LightTable, rectangle_mesh
from isophote.lower.materials import MaterialTable, aimed_emission_of, emission_texture_of, is_mapped
from isophote.lower.media import lower_media
from isophote.lower.own_space import own_spaces
from isophote.lower.painted_lights import Paint
from isophote.lower.primitive_table import PrimitivePart, no_primitives, primitive_of
from isophote.scene.camera import AnyCamera
from isophote.scene.light import DiskLight, RectLight
from isophote.scene.material import Emitter
from isophote.scene.material_base import Material
from isophote.scene.scene import Bounds, Scene, placed_box
from isophote.shapes.mesh import Mesh
from isophote.shapes.primitive.extent import boxes_around
from isophote.shapes.primitive.primitive import Primitive

if TYPE_CHECKING:
    from isophote.shapes.field.field import Field

__all__ = ["Parts", "camera_rows", "lights_of", "lower_scene", "parts_of", "tables_of"]


_latest: LatestScene[dict[str, Packed]] = LatestScene()


def lower_scene(
    scene: Scene,
    size: tuple[int, int],
    threads: int | None = None,
    accelerator: str = "bvh",
    *,
    marched: bool = False,
) -> Packed:
    """The tables of `scene` for a picture of `size` (width, height), with the accelerator of a name.

    Fields of one simple solid become exact primitives, unless they shall be `marched`.

    Items are numbered as they stand in the scene; area lights go on from there, in their order among the lights. Tables
    of the scene lowered last are used again where only the camera or the size differ. What moves, stands as halfway
    between the shutter's opening and closing. Endless fields reach as far as lower/fields.py says. Raises `SceneError`
    for a scene without items that can be drawn, or without a camera.
    """
    scene = displaced(scene.still(), size)
    camera = camera_rows(scene.camera, size)
    way = accelerator, marched, scene.medium
    tables = _latest.find(scene, way)
    if tables is None:
        parts = parts_of(scene, marched)
        tables, _ = tables_of(scene, parts, threads, accelerator)
        _latest.keep(scene, way, tables, one_view=endless(parts.fields))
    return SCENE.pack(**tables, camera=camera)


def camera_rows(camera: AnyCamera | None, size: tuple[int, int]) -> npt.NDArray[np.float32]:
    """(10, 3): the rays of a scene's camera, as kernels/trace/camera.py has them."""
    if camera is None:
        raise SceneError("the scene has no camera; give Scene(camera=...) or use isophote.studio(scene)")
    return np.stack(camera.linear_map(size)).astype(np.float32)


class Parts(NamedTuple):
    """The items of a scene by kind, the materials and lights among them so far, and the numbers of lights that are
    there as primitives."""

    meshes: list[Part]
    fields: list[FieldPart]
    primitives: list[PrimitivePart]
    materials: MaterialTable
    lights: LightTable
    lamps: frozenset[int] = frozenset()


def tables_of(
    scene: Scene, parts: Parts, threads: int | None, accelerator: str, around: Sequence[Bounds] = ()
) -> tuple[dict[str, Packed], float]:
    """All tables of a still scene but the camera's, by the names of SCENE, and the radius of what is finite in it and
    in the boxes `around`."""
    if not parts.meshes and not parts.fields and not parts.primitives:
        raise SceneError("the scene has nothing to draw: no items and no rectangle lights")
    labels = [(part.material, part.public, -1) for part in parts.fields]
    labels += [(part.material, part.public, part.light) for part in parts.primitives]
    geometry, surfaces, bounds = lower_geometry(parts.meshes, labels, threads, accelerator)
    finite = _finite_bounds(scene, bounds, parts, around)
    fields = _fields(parts, finite, threads, accelerator)
    reach = float(np.linalg.norm(finite[1] - finite[0])) / 2
    material_table, textures = parts.materials.build(lambda: own_spaces(_matrices(scene), surfaces))
    tables = {
        "geometry": geometry,
        "surfaces": surfaces,
        "fields": fields,
        "primitives": _primitives(parts, accelerator, threads),
        "materials": material_table,
        "media": lower_media(parts.materials.materials, scene.medium),
        "textures": textures,
        "lights": lights_of(scene, parts, reach),
    }
    return tables, reach


def _matrices(scene: Scene) -> npt.NDArray[np.float64]:
    return np.array([item.transform.matrix for item in scene.items]).reshape(-1, 4, 4)


def lights_of(scene: Scene, parts: Parts, reach: float) -> Packed:
    """The table of all lights, those of a still scene added to those of its parts; `reach` is the scene's radius."""
    for number, light in enumerate(scene.lights, start=len(scene.items)):
        if not isinstance(light, RectLight) and number not in parts.lamps:
            parts.lights.add(light, reach, number)
    return parts.lights.build(reach)


def _fields(parts: Parts, finite: npt.NDArray[np.float64], threads: int | None, accelerator: str) -> Packed:
    if not parts.fields:
        return no_fields()
    # Loaded where it is needed: pictures of meshes come sooner without.
    from isophote.lower.fields import lower_fields

    return lower_fields(parts.fields, len(parts.meshes), finite, threads, accelerator)


def _primitives(parts: Parts, accelerator: str, threads: int | None) -> Packed:
    if not parts.primitives:
        return no_primitives()
    from isophote.lower.primitives import lower_primitives

    return lower_primitives(parts.primitives, len(parts.meshes) + len(parts.fields), accelerator, threads)


def _finite_bounds(
    scene: Scene, meshes: npt.NDArray[np.float32], parts: Parts, around: Sequence[Bounds]
) -> npt.NDArray[np.float64]:
    """(2, 3): a box around all that is finite: meshes, primitives, fields as far as they have bounds, the boxes
    `around`, and, where some fields have no bounds or nothing is finite, the camera and what it looks at."""
    fields = parts.fields
    bounds = [np.asarray(part.field.bounds, np.float64) for part in fields]
    boxes = [placed_box(np.where(np.isfinite(b), b, 0.0), p.matrix) for b, p in zip(bounds, fields, strict=True)]
    finite = [meshes.astype(np.float64)] if np.isfinite(meshes).all() else []
    finite += [*boxes, *(box for box in around if np.isfinite(box).all())]
    finite += [box for box in boxes_around([part.primitive for part in parts.primitives]) if np.isfinite(box).all()]
    if (endless(fields) or not finite) and scene.camera is not None:
        finite += [np.array([place, place]) for place in (scene.camera.eye, scene.camera.target)]
    return np.stack([np.min([box[0] for box in finite], axis=0), np.max([box[1] for box in finite], axis=0)])


def parts_of(scene: Scene, marched: bool = False, moving: Set[int] = frozenset()) -> Parts:
    """The items of a still scene; `moving` are the numbers of those that will be moved (lower/moments.py)."""
    parts = Parts([], [], [], MaterialTable(), LightTable())
    for number, item in enumerate(scene.items):
        matrix, material = item.transform.matrix, parts.materials.number(item.material)
        if isinstance(item.shape, Mesh):
            radiance, two_sided = aimed_emission_of(item.material)
            own, texture = None, emission_texture_of(item.material)
            if max(radiance) > 0:
                paint = None if texture is None else Paint(texture, material)
                own = parts.lights.add_mesh(item.shape, matrix, radiance, two_sided, number, paint)
            parts.meshes.append(
                Part(item.shape, matrix, material, number, own, number in moving, is_mapped(item.material))
            )
            continue
        primitive = None if marched and _is_field(item.shape) else primitive_of(item.shape)
        if primitive is None:
            parts.fields.append(FieldPart(_field(item.shape, number), matrix, material, number))
        else:
            parts.primitives.append(_primitive_part(parts, item.material, primitive.placed(matrix), number))
    for number, light in enumerate(scene.lights, start=len(scene.items)):
        if isinstance(light, RectLight):
            mesh, matrix, radiance = rectangle_mesh(light), light.transform.matrix, light.radiance_rgb
            own = parts.lights.add_mesh(mesh, matrix, radiance, light.two_sided, number)
            material = parts.materials.number(Emitter(radiance, two_sided=light.two_sided))
            parts.meshes.append(Part(mesh, matrix, material, number, own))
    return parts if marched else _with_lamps(parts, scene)


def _with_lamps(parts: Parts, scene: Scene) -> Parts:
    """With disk and sphere lights among the primitives, where there are many."""
    lamps = many_lamps(scene)
    for number, light in lamps.items():
        emitter = Emitter(light.radiance_rgb, two_sided=isinstance(light, DiskLight) and light.two_sided)
        parts.primitives.append(_primitive_part(parts, emitter, lamp_primitive(light), number))
    return parts._replace(lamps=frozenset(lamps))


def _primitive_part(parts: Parts, shown: Material, placed: Primitive, number: int) -> PrimitivePart:
    """A primitive where it stands. Those that shine are aimed at where they are spheres or disks without a texture;
    others are met by chance."""
    radiance, two_sided = aimed_emission_of(shown)
    aimed = max(radiance) > 0 and emission_texture_of(shown) is None
    light = parts.lights.add_primitive(placed, radiance, two_sided, number) if aimed else -1
    return PrimitivePart(placed, parts.materials.number(shown), number, light)


def _is_field(shape: object) -> bool:
    from isophote.shapes.field.field import Field

    return isinstance(shape, Field)


def _field(shape: object, number: int) -> Field:
    """A shape that is neither a mesh nor a primitive. Raises `SceneError` unless it is a field in space."""
    from isophote.shapes.field.field import Field

    if isinstance(shape, Field):
        return shape
    raise SceneError(
        f"items[{number}]: a {type(shape).__name__} cannot be rendered; give a Mesh, a Field, a Polygon, a Disk or a "
        "Quadric"
    )
