"""The peers, made ready: Embree by embreex, and Mitsuba.

Mitsuba's vectorised variant compiles with LLVM, which it looks for on the system. Where it finds none, install one
(on Debian: `apt-get install libllvm19`) and name it:

    DRJIT_LIBLLVM_PATH=/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from common import Floats, Ints, missing

_ONE_RAY = np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32)


def embree_scene(positions: Floats, triangles: Ints, *, committed: bool = True) -> Any:
    """An embreex scene of one mesh. Its tree is built by the first query, which has been made if `committed`."""
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError:
        missing("embreex")
    scene = EmbreeScene()
    TriangleMesh(scene, positions, triangles)
    if committed:
        commit(scene)
    return scene


def commit(scene: Any) -> None:
    """Let embreex build the tree of its scene."""
    scene.run(*_ONE_RAY)


def load_mitsuba() -> tuple[ModuleType, bool]:
    """Mitsuba with its fastest variant here, and whether that is the vectorised one."""
    try:
        import mitsuba
    except ImportError:
        missing("mitsuba")
    try:
        mitsuba.set_variant("llvm_ad_rgb")
        # LLVM is looked for when the first thing is computed.
        np.array(mitsuba.Float(1) + 1)
    except (ImportError, RuntimeError) as error:
        print(f"Mitsuba's llvm_ad_rgb does not run ({error}); scalar_rgb stands in, which is slower.\n")
        mitsuba.set_variant("scalar_rgb")
        return mitsuba, False
    return mitsuba, True


def mitsuba_mesh(mitsuba: ModuleType, positions: Floats, triangles: Ints, **parts: dict[str, Any]) -> Any:
    """A Mitsuba mesh with flat faces and `parts` (bsdf, emitter), given as dictionaries."""
    properties = mitsuba.Properties()
    properties["face_normals"] = True
    for name, part in parts.items():
        properties[name] = mitsuba.load_dict(part)
    mesh = mitsuba.Mesh("mesh", len(positions), len(triangles), properties)
    parameters = mitsuba.traverse(mesh)
    parameters["vertex_positions"] = positions.reshape(-1)
    parameters["faces"] = triangles.reshape(-1).astype(np.uint32)
    parameters.update()
    return mesh
