"""3MF: meshes survive the way through a file, other programs' packages are understood, damaged ones refused."""

from __future__ import annotations

import contextlib
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
import trimesh

import isophote as iso

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
MATERIALS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"

TETRAHEDRON = iso.Mesh(
    [(0.1, 0, 0), (1, 1 / 3, 0), (0, 1, 0), (0, 0, 2e-7)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
)
CORNERS = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in [(0, 0, 0), (1, 0, 0), (0, 1, 0)])
TRIANGLE = f'<mesh><vertices>{CORNERS}</vertices><triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh>'


def package(path: Path, resources: str, build: str, **parts: str) -> Path:
    """A 3MF file with these resources and items, and further parts by their names."""
    spaces = f'xmlns="{CORE}" xmlns:m="{MATERIALS}" xmlns:p="{PRODUCTION}"'
    model = f"<model {spaces}><resources>{resources}</resources><build>{build}</build></model>"
    relation = '<Relationship Target="/3D/main.model" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("_rels/.rels", f"<Relationships>{relation}</Relationships>")
        archive.writestr("3D/main.model", model)
        for name, text in parts.items():
            archive.writestr(f"3D/{name}.model", f"<model {spaces}><resources>{text}</resources><build/></model>")
    return path


@pytest.mark.parametrize("ending", [".3mf", ".3MF", ".3mf.gz"])
def test_a_mesh_comes_back_exactly(tmp_path: Path, ending: str) -> None:
    iso.save(TETRAHEDRON, tmp_path / f"t{ending}")
    assert iso.load_mesh(tmp_path / f"t{ending}") == TETRAHEDRON


def test_equal_meshes_give_equal_files(tmp_path: Path) -> None:
    iso.save(TETRAHEDRON, tmp_path / "a.3mf")
    iso.save(TETRAHEDRON, tmp_path / "b.3mf")
    assert (tmp_path / "a.3mf").read_bytes() == (tmp_path / "b.3mf").read_bytes()


def test_polygons_are_cut(tmp_path: Path) -> None:
    iso.save(iso.Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)]), tmp_path / "q.3mf")
    assert iso.load_mesh(tmp_path / "q.3mf").faces.shape == (2, 3)


@pytest.mark.parametrize("unit", ["millimeter", "inch"])
def test_the_unit_is_told_and_numbers_stay(tmp_path: Path, unit: str) -> None:
    path = tmp_path / "t.3mf"
    iso.save(TETRAHEDRON, path, unit=unit)
    assert f'unit="{unit}"' in zipfile.ZipFile(path).read("3D/3dmodel.model").decode()
    assert np.array_equal(iso.load_mesh(path).vertices, TETRAHEDRON.vertices)


def test_units_that_3mf_does_not_know_are_refused(tmp_path: Path) -> None:
    with pytest.raises(iso.FileError, match="unit must be one of micron, millimeter"):
        iso.save(TETRAHEDRON, tmp_path / "t.3mf", unit="parsec")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("width", [3, 4])
def test_colours_of_eight_bits_come_back(tmp_path: Path, width: int) -> None:
    levels = np.array([[0, 0, 0, 255], [255, 0, 128, 9], [1, 2, 3, 77], [255, 0, 128, 9]])[:, :width]
    coded = levels / 255
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    linear[:, 3:] = coded[:, 3:]
    path = tmp_path / "c.3mf"
    iso.save(TETRAHEDRON.with_(attributes={"colour": linear.astype(np.float32)}), path)
    back = iso.load_mesh(path).colours
    assert back is not None
    assert back.indices is not None
    np.testing.assert_allclose(back.values[back.indices], linear[TETRAHEDRON.indices], rtol=0, atol=1e-7)


def test_corners_without_a_colour_have_none(tmp_path: Path) -> None:
    red = iso.Attribute(np.array([[1.0, 0, 0]], np.float32), np.array([0, 0, 0] + [-1] * 9))
    iso.save(TETRAHEDRON.with_(attributes={"colour": red}), tmp_path / "c.3mf")
    back = iso.load_mesh(tmp_path / "c.3mf").colours
    assert back is not None
    assert back.indices is not None
    assert back.indices.tolist() == [0, 0, 0] + [-1] * 9


def test_materials_keep_their_names(tmp_path: Path) -> None:
    labels = iso.FaceLabels(('wood & "steel"', "<glass>"), np.array([0, 1, -1, 1]))
    path = tmp_path / "m.3mf"
    iso.save(TETRAHEDRON.with_(labels={"material": labels}), path)
    back = iso.load_mesh(path).labels["material"]
    names = [back.names[i] if i >= 0 else None for i in back.index.tolist()]
    assert names == ['wood & "steel"', "<glass>", None, "<glass>"]


def test_what_has_no_place_is_named(tmp_path: Path) -> None:
    with pytest.warns(iso.IsophoteWarning, match='3MF has no place for "uv"'):
        iso.save(TETRAHEDRON.with_(attributes={"uv": np.zeros((4, 2))}), tmp_path / "t.3mf")


def test_another_reader_sees_the_same_solid(tmp_path: Path) -> None:
    pytest.importorskip("lxml")
    pytest.importorskip("networkx")
    iso.save(TETRAHEDRON, tmp_path / "t.3mf")
    other = trimesh.load(tmp_path / "t.3mf", force="mesh", process=False)
    np.testing.assert_allclose(other.vertices[other.faces], TETRAHEDRON.vertices[TETRAHEDRON.faces], rtol=1e-12)


def test_objects_of_objects_stand_in_their_places(tmp_path: Path) -> None:
    """Rows times a matrix: first that of the component, then that of the item."""
    component = '<component objectid="1" transform="1 0 0 0 1 0 0 0 1 10 0 0"/>'
    resources = f'<object id="1">{TRIANGLE}</object><object id="2"><components>{component}</components></object>'
    quarter = '<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 0 0 5"/>'
    mesh = iso.load_mesh(package(tmp_path / "o.3mf", resources, quarter + '<item objectid="1"/>'))
    assert mesh.vertices.tolist() == [[0, 10, 5], [0, 11, 5], [-1, 10, 5], [0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_a_mirrored_object_keeps_its_outside(tmp_path: Path) -> None:
    item = '<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>'
    mesh = iso.load_mesh(package(tmp_path / "m.3mf", f'<object id="1">{TRIANGLE}</object>', item))
    a, b, c = mesh.vertices[mesh.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0


def test_objects_may_lie_in_other_parts(tmp_path: Path) -> None:
    component = '<component objectid="7" p:path="/3D/other.model"/>'
    resources = f'<object id="2"><components>{component}</components></object>'
    path = package(tmp_path / "p.3mf", resources, '<item objectid="2"/>', other=f'<object id="7">{TRIANGLE}</object>')
    assert iso.load_mesh(path).face_count == 1


def test_properties_are_inherited_from_the_object(tmp_path: Path) -> None:
    group = '<m:colorgroup id="5"><m:color color="#000000"/><m:color color="#FF0000"/></m:colorgroup>'
    path = package(
        tmp_path / "i.3mf", f'{group}<object id="1" pid="5" pindex="1">{TRIANGLE}</object>', '<item objectid="1"/>'
    )
    colours = iso.load_mesh(path).colours
    assert colours is not None
    assert colours.indices is not None
    assert colours.values[colours.indices].tolist() == [[1, 0, 0]] * 3


ITEM = '<item objectid="1"/>'


@pytest.mark.parametrize(
    ("resources", "build", "reason"),
    [
        ("", "", "no mesh in the file"),
        (f'<object id="1">{TRIANGLE}</object>', '<item objectid="9"/>', "no object '9'"),
        (f'<object id="1">{TRIANGLE.replace("v3=", "v4=")}</object>', ITEM, "lacks its attribute 'v3'"),
        ('<object id="1">' + TRIANGLE.replace('v3="2"', 'v3="3"') + "</object>", ITEM, "names vertex 3"),
        (f'<object id="1">{TRIANGLE.replace("x=", "y=")}</object>', ITEM, "XML is broken"),
        (f'<object id="1">{TRIANGLE}', ITEM, "XML is broken"),
        (f'<object id="1">{TRIANGLE}</object>', '<item objectid="1" transform="1 0"/>', "12 numbers"),
        (f'<object id="1">{TRIANGLE}</object>', '<item objectid="1" transform="a b c d e f g h i j k l"/>', "number"),
        (f'<object id="1">{TRIANGLE.replace("0", "nan", 1)}</object>', ITEM, "not finite"),
        ('<object id="1"><components><component objectid="1"/></components></object>', ITEM, "lies in itself"),
        ('<m:colorgroup id="2"><m:color color="red"/></m:colorgroup>', ITEM, "'red' is no colour"),
    ],
)  # fmt: skip
def test_damaged_models_are_refused(tmp_path: Path, resources: str, build: str, reason: str) -> None:
    with pytest.raises(iso.FileError, match=reason):
        iso.load_mesh(package(tmp_path / "d.3mf", resources, build))


def test_objects_that_repeat_each_other_without_end_are_refused(tmp_path: Path) -> None:
    """Thirty objects, each twice the one before: a few kilobytes that mean a billion triangles."""
    objects = f'<object id="0">{TRIANGLE}</object>'
    for k in range(1, 31):
        twice = f'<component objectid="{k - 1}"/>' * 2
        objects += f'<object id="{k}"><components>{twice}</components></object>'
    with pytest.raises(iso.FileError, match="repeats its objects"):
        iso.load_mesh(package(tmp_path / "bomb.3mf", objects, '<item objectid="30"/>'))


def test_document_types_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.3mf"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("_rels/.rels", "<Relationships/>")
        archive.writestr("3D/3dmodel.model", '<!DOCTYPE m [<!ENTITY a "b">]><model/>')
    with pytest.raises(iso.FileError, match="no document types"):
        iso.load_mesh(path)


def test_what_is_no_package_is_refused(tmp_path: Path) -> None:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as archive:
        archive.writestr("readme", "no model here")
    for name, data in (("a", b"no zip"), ("b", b""), ("c", whole.getvalue()), ("d", whole.getvalue()[:30])):
        path = tmp_path / f"{name}.3mf"
        path.write_bytes(data)
        with pytest.raises(iso.FileError):
            iso.load_mesh(path)


@pytest.mark.parametrize("cut", range(0, 700, 37))
def test_files_cut_short_or_changed_are_refused_or_read(tmp_path: Path, cut: int) -> None:
    """Never another exception than a `FileError`."""
    path = tmp_path / "t.3mf"
    iso.save(TETRAHEDRON, path)
    data = bytearray(path.read_bytes())
    data[cut % len(data)] ^= 0x55
    path.write_bytes(bytes(data))
    with contextlib.suppress(iso.FileError):
        iso.load_mesh(path)
    path.write_bytes(bytes(data[:cut]))
    with pytest.raises(iso.FileError):
        iso.load_mesh(path)
