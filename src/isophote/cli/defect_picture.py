"""A picture of what is wrong with meshes: their defects marked, from before and behind."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.topology import topology
from isophote.cli.progress import progress
from isophote.convert.markers import balls, tubes
from isophote.errors import IsophoteWarning, SceneError
from isophote.rendering.image import Image
from isophote.rendering.path_trace import PathTrace
from isophote.rendering.render import render
from isophote.scene.material import Matte
from isophote.scene.scene import Item, Scene
from isophote.scene.studio import frame, studio
from isophote.shapes.mesh import Mesh

__all__ = ["COLOURS", "draw_defects"]

COLOURS = {
    "boundary_edges": "blue",
    "non_manifold_edges": "red",
    "turned_edges": "lime",
    "non_manifold_vertices": "magenta",
}
"""What is marked, and the colour that it has in the picture."""

_CLAY = Matte((0.72, 0.66, 0.56))
_BEHIND = (-0.453, 0.423, -0.785)
# Of the size of what is shown.
_TUBE = 0.003
_BALL = 0.009
_MOST = 50_000
_SAMPLES = 32


def draw_defects(scene: Scene, path: Path, size: tuple[int, int]) -> None:
    """Write a picture of the meshes of a scene, their defects marked in `COLOURS`, from two sides.

    `size` is that of each of the two views, which stand side by side.
    """
    meshes = [item for item in scene.items if isinstance(item.shape, Mesh)]
    if not meshes:
        raise SceneError("a picture of defects shows meshes, and this scene has none")
    bounds = Scene(meshes).bounds
    reach = float(np.linalg.norm(bounds[1] - bounds[0])) or 1.0
    items = [item.with_(material=_CLAY) for item in meshes]
    for item in meshes:
        items.extend(_markers(item, reach))
    shown = studio(items, aspect=size[0] / size[1])
    behind = shown.with_(camera=frame(bounds, _BEHIND, aspect=size[0] / size[1]))
    views = [render(view, PathTrace(_SAMPLES), size=size, progress=progress()) for view in (shown, behind)]
    Image({"colour": np.concatenate([view.channels["colour"] for view in views], axis=1)}).save(path)


def _markers(item: Item, reach: float) -> Iterator[Item]:
    mesh = item.shape
    assert isinstance(mesh, Mesh)
    found = topology(mesh)
    points = mesh.vertices @ item.transform.matrix[:3, :3].T + item.transform.matrix[:3, 3]
    for name, colour in COLOURS.items():
        where = _first(getattr(found, name), name)
        if len(where) == 0:
            continue
        if where.ndim == 2:
            shape = tubes(points[where[:, 0]], points[where[:, 1]], _TUBE * reach)
        else:
            shape = balls(points[where], _BALL * reach)
        yield Item(shape, Matte(colour), name=name)


def _first(where: npt.NDArray[np.integer], name: str) -> npt.NDArray[np.integer]:
    if len(where) > _MOST:
        text = f"the picture marks the first {_MOST:,} of {len(where):,} {name.replace('_', ' ')}"
        warnings.warn(text, IsophoteWarning, stacklevel=2)
    return where[:_MOST]
