"""Damaged glTF and GLB: every refusal with its reason, and never anything else than a scene or an error."""

from __future__ import annotations

import json
import re
import struct
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import isophote as iso
import isophote.io.gltf.document as container
from gltf_files import (
    ACCESSOR,
    CHECKS,
    ROUGH,
    TRIANGLE,
    Json,
    data_uri,
    document,
    refused,
    with_bytes,
)
from isophote import (
    Error,
    FileError,
    Item,
    Mesh,
    Scene,
    Transform,
)
from isophote.io.gltf.read import read_gltf_mesh, read_gltf_scene
from isophote.io.gltf.write import encode_gltf_scene

FUZZ = settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ({"asset": {"version": "1.0"}}, "only version 2"),
        ({"asset": {}}, "no glTF"),
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "KHR_draco_mesh_compression"),
        ({"nodes": [{"mesh": 0, "children": [0]}]}, "two places"),
        ({"nodes": [{"children": [1]}, {"children": [2]}, {"children": [1]}]}, "two places"),
        ({"nodes": [{"mesh": 7}]}, r"no meshes\[7\]"),
        ({"nodes": [{"mesh": -1}]}, "whole number"),
        ({"nodes": [{"mesh": 0, "matrix": [1, 2]}]}, "16 finite numbers"),
        ({"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 0]}]}, "quaternion"),
        ({"accessors": [{**ACCESSOR, "count": 4}]}, "needs 48 bytes"),
        ({"accessors": [{**ACCESSOR, "count": 10**12}]}, "bytes of a buffer view"),
        ({"accessors": [{**ACCESSOR, "count": 0}]}, "1 or more"),
        ({"accessors": [{**ACCESSOR, "byteOffset": 4}]}, "needs 40 bytes"),
        ({"accessors": [{**ACCESSOR, "type": "VEC2"}]}, "VEC3"),
        ({"accessors": [{**ACCESSOR, "componentType": 5124}]}, "componentType"),
        ({"accessors": [{"componentType": 5126, "count": 10**9, "type": "VEC3"}]}, "far more than the bytes"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 37}]}, "ends at byte 37"),
        ({"bufferViews": [{"buffer": 0, "byteLength": 36, "byteStride": 4}]}, "stride of 4"),
        ({"buffers": [{"byteLength": 99, "uri": data_uri(bytes(36))}]}, "cut short"),
        ({"buffers": [{"byteLength": 36, "uri": "http://example.com/x.bin"}]}, "no file beside"),
        ({"buffers": [{"byteLength": 36, "uri": "data:,%%"}]}, "cut short"),
        ({"buffers": [{"byteLength": 36, "uri": "data:;base64,A!"}]}, "base64"),
        ({"buffers": [{"byteLength": 36, "uri": "none.bin"}]}, "no such file"),
        ({"buffers": [{"byteLength": 36}]}, "no binary chunk"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 9}]}]}, "0 to 6"),
        ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]}, r"no materials\[0\]"),
        ({"cameras": [{"perspective": {"yfov": 4}}], "nodes": [{"camera": 0}]}, "fov_degrees"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_reason(parts: Json, reason: str) -> None:
    assert re.search(reason, refused(document(**parts)))


def test_faces_out_of_range_and_endless_points_are_refused() -> None:
    points = np.zeros((3, 3), "<f4")
    accessors = [ACCESSOR, {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}]
    views = [{"byteLength": 36}, {"byteOffset": 36, "byteLength": 3}]
    mesh_list = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    whole = with_bytes(points.tobytes() + bytes([0, 1, 9]), views, accessors, meshes=mesh_list)
    assert "names vertex 9" in refused(whole)
    points[1, 2] = np.nan
    whole = with_bytes(points.tobytes() + bytes([0, 1, 2]), views, accessors, meshes=mesh_list)
    assert "not finite" in refused(whole)


def test_many_uses_of_few_bytes_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """Primitives of different corners cannot share, and a short file may ask for any number of them."""
    monkeypatch.setattr(container, "_FREE_BYTES", 1 << 20)
    monkeypatch.setattr(container, "_BYTES_PER_BYTE", 1)
    count = 3000
    accessors = [{**ACCESSOR, "count": 3 * count}]
    for i in range(200):
        indices = {"bufferView": 0, "componentType": 5125, "count": 9 * count - 3 * i, "type": "SCALAR"}
        accessors.append(indices)
    primitives = [{"attributes": {"POSITION": 0}, "indices": i + 1} for i in range(200)]
    data = bytes(36 * count)
    whole = with_bytes(data, [{"byteLength": len(data)}], accessors, meshes=[{"primitives": primitives}])
    assert "far more than the bytes" in refused(whole)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "JSON is broken"),
        (b"{", "JSON is broken"),
        (b"[]", "must be an object"),
        (b'{"asset": {"version": "2.0"}, "x": NaN}', "NaN"),
        (b"[" * 100_000, "JSON is broken"),
        (b"\xff\xfe\xff", "JSON is broken"),
        (b"glTF", "cut short"),
        (struct.pack("<4sIIII", b"glTF", 1, 20, 0, 0), "GLB 1"),
        (struct.pack("<4sIIII", b"glTF", 2, 99, 0, 0), "cut short"),
        (struct.pack("<4sIIII", b"glTF", 2, 20, 99, 0x4E4F534A), "ends beyond"),
        (struct.pack("<4sIIII", b"glTF", 2, 20, 0, 7), "must begin with"),
    ],
)
def test_broken_containers_are_refused(data: bytes, reason: str) -> None:
    with pytest.raises(FileError, match=reason):
        read_gltf_scene(Path("x.glb"), data)


def test_a_file_without_triangles_is_no_mesh() -> None:
    with pytest.raises(FileError, match="no triangles"):
        read_gltf_mesh(Path("x.gltf"), b'{"asset": {"version": "2.0"}}')


# Fuzzing: a valid file with everything in it, damaged


def _rich() -> bytes:
    corners = iso.Attribute(np.array([[0, 0], [1, 0], [0, 1.0]]), np.array([0, 1, 2, 2, 1, 0]))
    square = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], attributes={"uv": corners})
    items = [
        Item(square, iso.Matte(CHECKS), Transform.identity().rotate("x", 1), "a"),
        Item(square, iso.Principled(0.5, normal_texture=ROUGH, emission=(9, 9, 1))),
        Item(TRIANGLE, iso.Glass()),
    ]
    scene = Scene(items, [iso.PointLight((0, 1, 0)), iso.Sun((1, 1, 1))], iso.Camera((0, 0, 5), (0, 0, 0)))
    return encode_gltf_scene(scene, Path("x.glb"))


RICH = _rich()
JSON_SIZE = struct.unpack_from("<I", RICH, 12)[0]
VALUES = st.sampled_from(
    [0, 1, -1, 2, 3, 5121, 5126, 255, 2**31, 2**53, 10**12, 1.5, 1e308, None, True, "x", [], {}, [0], {"a": 1}]
)


def opened(data: bytes) -> None:
    """Reading ends in a value or in an error of this package, both ways."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for reader in (read_gltf_scene, read_gltf_mesh):
            try:
                result = reader(Path("x.glb"), data)
            except Error:
                continue
            assert isinstance(result, Scene | Mesh)


def test_the_file_that_is_damaged_below_is_whole() -> None:
    scene = read_gltf_scene(Path("x.glb"), RICH)
    assert len(scene.items) == 3
    assert len(scene.lights) == 2


@FUZZ
@given(st.data())
def test_damaged_bytes_give_a_scene_or_an_error(data: st.DataObject) -> None:
    damaged = bytearray(RICH)
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(damaged) - 1))
        damaged[at : at + 2] = data.draw(st.binary(min_size=1, max_size=3))
    opened(bytes(damaged[: data.draw(st.integers(0, 3 * len(damaged)))]))


def places(value: Any) -> list[tuple[Any, Any]]:
    """Every (container, key) within a JSON value."""
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else []
    return [(value, key) for key in keys] + [place for key in keys for place in places(value[key])]


@FUZZ
@given(st.data())
def test_inflated_and_misplaced_values_give_a_scene_or_an_error(data: st.DataObject) -> None:
    whole = json.loads(RICH[20 : 20 + JSON_SIZE])
    whole["buffers"][0]["uri"] = data_uri(RICH[28 + JSON_SIZE :])
    for _ in range(data.draw(st.integers(1, 3))):
        container, key = data.draw(st.sampled_from(places(whole)))
        container[key] = data.draw(VALUES)
    opened(json.dumps(whole).encode())


@FUZZ
@given(st.sampled_from([b"", RICH[:12], RICH[:20], b'{"asset":{"version":"2.0"},']), st.binary(max_size=200))
def test_noise_gives_a_scene_or_an_error(beginning: bytes, noise: bytes) -> None:
    opened(beginning + noise)
