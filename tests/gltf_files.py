"""What the tests of glTF share: small files spelled out, and the way there and back."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from isophote import (
    FileError,
    ImageTexture,
    Mesh,
    Scene,
    load_scene,
    save,
)
from isophote.io.gltf.read import read_gltf_scene
from mesh_files import MODELS

Json = dict[str, Any]

GLTF = MODELS / "gltf"
FILES = sorted(path.relative_to(GLTF).as_posix() for path in GLTF.rglob("*.gl*"))
SOLID = [name for name in FILES if not re.search(r"Mode_0[0-3]", name)]
needs_models = pytest.mark.skipif(not MODELS.exists(), reason="the shared models are not here")

TRIANGLE = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
ACCESSOR = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
CHECKS = ImageTexture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3), name="checks", wrap="mirror", filter="nearest")
ROUGH = ImageTexture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3)[::-1].copy(), "linear", wrap="clamp")


def document(**parts: Any) -> Json:
    """A file of one triangle, which `parts` change."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    whole: Json = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)}],
        "buffers": [{"byteLength": len(points), "uri": data_uri(points)}],
    }
    return whole | parts


def data_uri(data: bytes) -> str:
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def read(whole: Json, **options: Any) -> Scene:
    return read_gltf_scene(Path("x.gltf"), json.dumps(whole).encode(), **options)


def with_bytes(data: bytes, views: list[Json], accessors: list[Json], **parts: Any) -> Json:
    buffers = [{"byteLength": len(data), "uri": data_uri(data)}]
    return document(
        buffers=buffers, bufferViews=[{"buffer": 0, **view} for view in views], accessors=accessors, **parts
    )


def refused(whole: Json) -> str:
    with pytest.raises(FileError) as caught:
        read(whole)
    return str(caught.value)


def there_and_back(scene: Scene, folder: Path, ending: str = ".glb") -> Scene:
    save(scene, folder / f"scene{ending}")
    return load_scene(folder / f"scene{ending}")
