"""What is wrong with a call is told by an error of Isophote's own, with what mends it, before anything is computed."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.errors import Error
from scenes import plane

TILE = plane(2)
SCENE = iso.Scene([iso.Item(TILE, iso.Matte(0.5))], [iso.Sky("white")], iso.Camera((0, 2, 3), (0, 0, 0)))
RAY = ([(0, 1, 0)], [(0, -1, 0)])


@pytest.mark.parametrize("threads", [0, -1, 1.5, "all", True, 10**6])
@pytest.mark.parametrize(
    "call",
    [
        lambda threads: iso.render(SCENE, iso.PathTrace(1), size=(4, 4), threads=threads),
        lambda threads: iso.Tracer(TILE, threads=threads),
        lambda threads: iso.ambient_occlusion(TILE, samples=1, threads=threads),
        lambda threads: iso.radiosity(SCENE, threads=threads),
        lambda threads: iso.show_tree(TILE, threads=threads),
        lambda threads: iso.explain(SCENE, threads=threads),
        lambda threads: iso.selfcheck(["form-factors"], threads=threads),
    ],
    ids=["render", "Tracer", "ambient_occlusion", "radiosity", "show_tree", "explain", "selfcheck"],
)
def test_a_number_of_threads_that_cannot_be_had_is_refused(call, threads):
    # A million threads with scratch of their own once took all of a machine's memory.
    with pytest.raises(Error, match=r"threads must be a whole number from 1 to 1,024"):
        call(threads)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: iso.radiosity(3), "give a Scene, not a int"),
        (lambda: iso.radiosity(TILE), "iso.studio makes one"),
        (lambda: iso.radiosity(SCENE, iso.PathTrace(1)), r"must be a Radiosity\(...\)"),
        (lambda: iso.tangents(3), "only a Mesh has tangents, not a int"),
        (lambda: iso.unwrap(iso.sphere(1)), "to_mesh makes one"),
        (lambda: iso.displace(iso.sphere(1), iso.PerlinNoise(), 1), "to_mesh makes one"),
        (lambda: iso.brdf_plot(iso.Emitter(1)), "without a body reflects no light"),
        (lambda: iso.measure_brdf(iso.Emitter(1)), "without a body reflects no light"),
    ],
)
def test_a_thing_of_the_wrong_kind_is_refused_by_name(call, told):
    with pytest.raises(Error, match=told):
        call()


def test_a_lamp_with_a_body_is_drawn_as_its_body():
    size = (240, 200)
    lamp, body = (iso.brdf_plot(m, size=size) for m in (iso.Emitter(5, body=iso.Matte(0.4)), iso.Matte(0.4)))
    # All but the title above.
    assert np.array_equal(lamp.channels["colour"][40:], body.channels["colour"][40:])


@pytest.mark.parametrize("number", [-1, 1.5, 10_000, True])
def test_a_bounce_that_there_is_not_is_refused(number):
    found = iso.radiosity(SCENE, iso.Radiosity(patch=1.0))
    with pytest.raises(Error, match="there are bounces 0 to"):
        found.bounce(number)
    with pytest.raises(Error, match="camera must be"):
        found.image("from above")


GREY = iso.ImageTexture(np.zeros((4, 4), np.float32))
POINT_UVS = TILE.with_(attributes={"uv": np.zeros((4, 2))})


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: iso.ImageTexture(np.zeros((2, 2), np.float32), wrap=("repeat",)), "one way, or two for u and v"),
        (lambda: iso.NormalMap(iso.Matte(), GREY), "needs three channels.*iso.Bump takes heights"),
        (lambda: iso.Blend("red", "blue", 3), "amount must be a number from 0 to 1"),
        (lambda: iso.show_tree(TILE, "bvh", levels=[99]), "the bvh has levels 0 to"),
        (lambda: iso.show_tree(TILE, "bvh", levels=[]), "the bvh has levels 0 to"),
        (lambda: iso.bake_occlusion(POINT_UVS, size=8, samples=1), "no face has an area in texture coordinates"),
        (lambda: iso.render(iso.Scene([]), iso.PathTrace(1)), "without items.*give it some"),
        (lambda: iso.Tracer(TILE).closest("here", [(0, -1, 0)]), "origins must be numbers"),
        (lambda: iso.Tracer(TILE).closest(RAY[0], None), "directions must"),
        (lambda: iso.fresnel("steep", 1, 1.5), "angles must be numbers"),
        (lambda: iso.fresnel(0.5, "air", 1.5), "outside must be numbers"),
        (lambda: iso.Radiosity(form_factors="hemicube"), 'belongs to method="gathering" or "shooting"'),
        (lambda: iso.texture_glsl(iso.Marble(), "main"), "no name of a GLSL function"),
        (lambda: iso.selfcheck([]), "no topic is named"),
        (lambda: iso.screen_occlusion(3, SCENE.camera, 1.0), "must be a picture that render made"),
        (lambda: iso.RectLight(size=(1e-20, 1e-20), power=1), "area of 1e-40 m².*use a PointLight"),
        (lambda: iso.RectLight(size=(1e-200, 1e-200)), "area of 0 m².*use a PointLight"),
        (lambda: iso.SphereLight(radius=1e-30), "more than single precision holds"),
        (lambda: iso.DiskLight(radiance=1e38), "more than single precision holds"),
    ],
)
def test_what_has_no_meaning_is_refused_with_what_mends_it(call, told):
    with pytest.raises(Error, match=told):
        call()


def test_levels_deeper_than_the_depth_are_drawn():
    shown = iso.show_tree(iso.to_mesh(iso.sphere(1), cell=0.2), "kdtree", depth=1, levels=[4], size=(64, 48))
    assert len(shown.metadata["boxes by level"].split(",")) > 4


def test_a_displacement_by_texture_coordinates_that_are_not_there_is_told():
    picture = iso.ImageTexture(np.eye(4, dtype=np.float32))
    item = iso.Item(TILE, iso.Matte(0.5), displacement=iso.Displacement(picture, 0.1, edge=0.5))
    scene = SCENE.with_(items=[item])
    with pytest.warns(iso.IsophoteWarning, match=r"items\[0\] has a texture that lies by texture coordinates"):
        iso.render(scene, iso.RayTrace(samples=1), size=(8, 6))


def test_a_picture_that_cannot_be_denoised_is_kept_with_a_warning(monkeypatch):
    from isophote.rendering import denoise

    monkeypatch.setattr(denoise, "_has_oidn", lambda: False)
    method = iso.AmbientOcclusion(samples=4)
    with pytest.warns(iso.IsophoteWarning, match="AmbientOcclusion does not tell what is noise") as found:
        image = iso.render(SCENE, method, size=(16, 12), denoise=True)
    assert [warning.filename for warning in found] == [__file__]
    assert image == iso.render(SCENE, method, size=(16, 12)).with_(metadata=image.metadata)


def test_notebooks_show_what_was_found():
    class Printer(list):
        text = list.append

    mesh = TILE.with_(attributes={"uv": [(0, 0), (0, 1), (1, 1), (1, 0)]})
    assert iso.bake_occlusion(mesh, size=8, samples=1)._repr_png_()[:4] == b"\x89PNG"
    report, told = iso.selfcheck(["form-factors"]), Printer()
    report._repr_pretty_(told, False)
    explanation = iso.explain(SCENE, size=(8, 6))
    explanation._repr_pretty_(told, False)
    assert told == [str(report), str(explanation)]
