"""Formulas of users' own and fields as textures, textures in other spaces, and textures in all methods."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso

Floats = npt.NDArray[np.float64]

RNG = np.random.default_rng(11)
PLACES = RNG.uniform(-2, 2, (400, 3)).astype(np.float32)
TURN = iso.Transform.identity().scale((0.5, 2, 1)).rotate((1, 2, 3), 0.7).translate((1, -2, 0.5))


def colours(texture: iso.Texture, own: npt.ArrayLike = PLACES, **more: npt.ArrayLike) -> npt.NDArray[np.float32]:
    return iso.texture_values(texture, own=own, **more)[:, :3]


def ripples(p: Any) -> Any:
    return 0.5 + 0.5 * np.sin(5 * np.linalg.norm(p[:, :2], axis=1) - p[:, 2])


def tinted(p: Any) -> Any:
    return np.stack([np.where(p[:, 0] > 0, 0.8, 0.1), np.abs(p[:, 1]) / 2, np.cos(3 * p[:, 2]) ** 2], axis=1)


def test_formulas_of_numbers_are_greys() -> None:
    expected = ripples(PLACES.astype(np.float64))
    np.testing.assert_allclose(colours(iso.Formula(ripples)), expected[:, None].repeat(3, axis=1), atol=2e-6)


def test_formulas_of_colours_are_colours() -> None:
    np.testing.assert_allclose(colours(iso.Formula(tinted)), tinted(PLACES.astype(np.float64)), atol=2e-6)


def test_negative_and_infinite_colours_of_formulas_are_finite() -> None:
    extreme = iso.Formula(lambda p: np.stack([-p[:, 0] * p[:, 0], p[:, 1] * 1e30 * 1e30, np.log(p[:, 2])], axis=1))
    found = colours(extreme)
    assert np.isfinite(found).all()
    np.testing.assert_array_equal(found[:, 0], 0)
    np.testing.assert_array_equal(found[PLACES[:, 1] < 0, 1], 0)


@pytest.mark.parametrize("function", [ripples, tinted])
def test_formulas_are_averaged_over_what_is_seen(function: Any) -> None:
    axes = np.array([[0.08, 0.02, 0], [0, -0.03, 0.09]])
    steps = RNG.uniform(-1, 1, (4000, 2))
    means = [function(p.astype(np.float64) + steps @ axes).mean(axis=0) for p in PLACES[:60]]
    expected = np.reshape(means, (60, -1)).repeat(3 if function is ripples else 1, axis=1)
    np.testing.assert_allclose(colours(iso.Formula(function), PLACES[:60], own_axes=axes), expected, atol=0.025)


def test_fields_are_textures_of_their_isolines() -> None:
    field = iso.sphere(1.0).union(iso.box(1.0).translate((1, 0, 0)), blend=0.2)
    stops = [(-0.5, "navy"), (0.0, "white"), (0.0, "gold"), (1.5, "tomato")]
    distances = field(PLACES).astype(np.float64)
    linear = np.array([colour for _, colour in iso.FieldTexture(field, stops).stops])
    below = linear[0] + (linear[1] - linear[0]) * np.clip(distances[:, None] / 0.5 + 1, 0, 1)
    above = linear[2] + (linear[3] - linear[2]) * np.clip(distances[:, None] / 1.5, 0, 1)
    expected = np.where(distances[:, None] < 0, below, above)
    np.testing.assert_allclose(colours(iso.FieldTexture(field, stops)), expected, atol=1e-5)
    bands = colours(iso.FieldTexture(field, [0.0, 1.0], period=0.25))[:, 0]
    np.testing.assert_allclose((bands - distances / 0.25 + 0.5) % 1, 0.5, atol=1e-4)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (3, "function of places"),
        (lambda p: p[:, :2], r"gave float64 \(200, 2\)"),
        (lambda p: p.nothing, "failed on places"),
        (lambda p: np.sort(p[:, 0]), "cannot be written as an expression"),
    ],
)
def test_formulas_that_cannot_be_are_refused(function: Any, message: str) -> None:
    with pytest.raises(iso.SceneError, match=message):
        iso.Formula(function)


def test_transforms_place_patterns_as_items_place_shapes() -> None:
    noise = iso.PerlinNoise(size=0.4)
    found = colours(noise.with_(transform=TURN), TURN.apply(PLACES))
    np.testing.assert_allclose(found, colours(noise), atol=2e-5)
    np.testing.assert_allclose(
        colours(iso.Placed(noise, transform=TURN), TURN.apply(PLACES)), colours(noise), atol=2e-5
    )


def test_spaces_are_the_shapes_own_the_world_and_texture_coordinates() -> None:
    where = iso.Formula(lambda p: np.abs(p))
    uv, own, world = RNG.uniform(0.1, 0.9, (3, 50, 3)).astype(np.float32)
    places = {"uv": uv[:, :2], "own": own, "world": world}
    for space, given in places.items():
        found = iso.texture_values(where.with_(space=space), **places)[:, :3]
        np.testing.assert_array_equal(found[:, : given.shape[1]], given)
        assert (found[:, given.shape[1] :] == 0).all()


def test_footprints_go_with_the_space() -> None:
    """A pattern twice as large is seen as one half as far away; what is beside it keeps its place."""
    stripes = iso.Stripes(1.0, 0.0, 0.5)
    axes = np.array([[0.3, 0, 0], [0, 0, 0.3]])
    larger = stripes.with_(transform=iso.Transform.identity().scale(2))
    np.testing.assert_allclose(
        colours(larger, 2 * PLACES, own_axes=2 * axes), colours(stripes, own_axes=axes), atol=1e-5
    )
    both = iso.Blend(larger, stripes, 0.5)
    np.testing.assert_allclose(
        colours(both, own_axes=axes),
        (colours(larger, own_axes=axes) + colours(stripes, own_axes=axes)) / 2,
        atol=1e-6,
    )


def test_placed_pictures_repeat_and_are_projected() -> None:
    picture = iso.ImageTexture(RNG.uniform(0, 1, (4, 4, 3)).astype(np.float32), filter="nearest")
    uv = RNG.uniform(0, 0.5, (200, 2)).astype(np.float32)
    smaller = iso.Placed(picture, space="uv", transform=iso.Transform.identity().scale(0.5))
    np.testing.assert_array_equal(iso.texture_values(smaller, uv=uv), iso.texture_values(picture, uv=2 * uv))
    own = np.column_stack([uv, RNG.uniform(-1, 1, 200)])
    np.testing.assert_array_equal(iso.texture_values(iso.Placed(picture), own=own), iso.texture_values(picture, uv=uv))


def test_alpha_of_pictures_goes_through_mixtures_and_places() -> None:
    clear = iso.ImageTexture(np.full((1, 1, 4), 0.25, np.float32))
    assert iso.texture_values(iso.Placed(clear))[0, 3] == 0.25
    assert iso.texture_values(iso.Blend(clear, "white", 0.5))[0, 3] == pytest.approx(0.625)


def nested(depth: int) -> iso.Texture:
    texture: iso.Texture = iso.PerlinNoise()
    for _ in range(depth):
        texture = iso.Ramp(texture)
    return texture


def test_textures_within_textures_go_deep_but_not_without_end() -> None:
    np.testing.assert_allclose(colours(nested(90)), colours(iso.PerlinNoise()), atol=1e-6)
    with pytest.raises(iso.SceneError, match="more than 100 deep"):
        colours(nested(200))


BAD: list[tuple[Any, str]] = [
    (lambda: iso.Checker("white", "black", size=0), "Checker: size must be"),
    (lambda: iso.PerlinNoise(seed=-1), "PerlinNoise: seed must be a whole number"),
    (lambda: iso.PerlinNoise(space="object"), "space must be 'own' or 'uv' or 'world'"),
    (lambda: iso.Fbm(iso.PerlinNoise(space="uv")), "give space='uv' to the Fbm"),
    (lambda: iso.Fbm(iso.Checker()), "noise must be"),
    (lambda: iso.Fbm(octaves=0), "octaves must be a whole number from 1 to 32"),
    (lambda: iso.Ramp(iso.PerlinNoise(), []), "there are none"),
    (lambda: iso.Ramp(iso.PerlinNoise(), [(1, "red"), (0, "blue")]), "must ascend"),
    (lambda: iso.Ramp(iso.PerlinNoise(), [(1, "red"), "blue"]), "all colours or all pairs"),
    (lambda: iso.Ramp("red"), "Ramp: texture must be a Texture"),
    (lambda: iso.Ramp(iso.PerlinNoise(), [(float("nan"), "red")]), "finite number"),
    (lambda: iso.Grid(axes="xw"), "letters 'xyz'"),
    (lambda: iso.Waves(axis=(0, 0, 0)), "axis must have a length"),
    (lambda: iso.FieldTexture(iso.circle(1)), "a Field in space"),
    (lambda: iso.WorleyNoise(metric="l2"), "metric must be"),
    (lambda: iso.Blend("white", "nocolour"), "is not a colour"),
]


@pytest.mark.parametrize(("make", "message"), BAD, ids=[message for _, message in BAD])
def test_bad_values_are_refused(make: Any, message: str) -> None:
    with pytest.raises(iso.SceneError, match=message):
        make()


@pytest.mark.parametrize(
    "texture",
    [
        iso.PerlinNoise(size=0.3, seed=7),
        iso.Checker("tomato", iso.Wood(size=0.02), 0.25, transform=iso.Transform.identity().scale(2)),
        iso.Gradient(["red", "white"], "angular", space="uv"),
        iso.Marble(turbulence=2),
        iso.Ramp(iso.WorleyNoise(feature="f2-f1"), [(0, "black"), (0.1, "white")], "smooth"),
    ],
    ids=lambda texture: type(texture).__name__,
)
def test_what_is_printed_can_be_pasted_back(texture: iso.Texture) -> None:
    names = {name: getattr(iso, name) for name in iso.__all__}
    pasted = eval(repr(texture), names)
    assert pasted == texture
    assert hash(pasted) == hash(texture)


def scene_of(texture: iso.Texture) -> iso.Scene:
    """A primitive, a mesh and a field that is marched, of three kinds of materials."""
    items = [
        iso.Item(iso.sphere(0.5), iso.Matte(texture)).at((-0.6, 0.5, 0)),
        iso.Item(iso.to_mesh(iso.box(0.8), cell=0.2), iso.Plastic(texture)).at((0.6, 0.4, 0)),
        iso.Item(iso.torus(0.4, 0.1) | iso.box(0.3), iso.Metal("gold", roughness=texture)).at((0, 0.2, 0.9)),
    ]
    return iso.Scene(
        items, [iso.Sky("white", 0.5), iso.PointLight((1, 3, 2), 30)], iso.Camera((1, 1.5, 3), (0, 0.3, 0))
    )


METHODS = {"path": iso.PathTrace(samples=2), "ray": iso.RayTrace(), "sphere": iso.SphereTrace()}


@pytest.mark.parametrize("name", METHODS)
def test_pictures_are_the_same_for_any_number_of_threads(name: str) -> None:
    scene = scene_of(iso.Marble(size=0.2))
    first, second = (iso.render(scene, METHODS[name], size=(40, 30), seed=2, threads=n) for n in (1, 3))
    assert first.channels["colour"].tobytes() == second.channels["colour"].tobytes()


@pytest.mark.parametrize("name", METHODS)
def test_all_methods_see_the_texture(name: str) -> None:
    """A texture that has one colour everywhere is that colour; one that varies is seen to vary."""
    plain = scene_of(iso.Blend(0.5, 0.5, iso.PerlinNoise()))
    same = iso.render(plain, METHODS[name], size=(40, 30), seed=2).channels["colour"]
    expected = iso.render(_constant(plain), METHODS[name], size=(40, 30), seed=2).channels["colour"]
    np.testing.assert_allclose(same, expected, atol=1e-5)
    varied = iso.render(scene_of(iso.Checker(0.2, 0.8, 0.1)), METHODS[name], size=(40, 30), seed=2).channels["colour"]
    assert np.abs(varied - expected).mean() > 0.01


def _constant(scene: iso.Scene) -> iso.Scene:
    ball, mesh, ring = scene.items
    return scene.with_(
        items=[
            ball.with_(material=iso.Matte(0.5)),
            mesh.with_(material=iso.Plastic(0.5)),
            ring.with_(material=iso.Metal("gold", roughness=0.5)),
        ]
    )


def test_reflectance_is_plotted_with_a_texture() -> None:
    assert iso.brdf_plot(iso.Plastic(iso.Checker(0.2, 0.8), roughness=iso.PerlinNoise())) is not None


@pytest.mark.parametrize(
    "texture",
    [iso.Fbm(), iso.Marble(size=2, turbulence=0.8), iso.Ramp(iso.WorleyNoise(feature="f2-f1"), [(0, 0.0), (0.2, 1.0)])],
    ids=lambda texture: type(texture).__name__,
)
def test_long_footprints_are_cut_into_short_ones(texture: iso.Texture) -> None:
    """Means over long ones come nearer to means of many places than what is seen at their middles does."""
    axes = np.array([[0.06, 0, 0], [0, 0.0, 1.2]])
    steps = RNG.uniform(-1, 1, (400, 2))
    own = PLACES[:150].astype(np.float64)
    means = colours(texture, (own[:, None] + steps @ axes).reshape(-1, 3)).reshape(150, 400, 3).mean(axis=1)
    found, sharp = colours(texture, own, own_axes=axes), colours(texture, own)
    wide = colours(texture, own, own_axes=np.array([[1.2, 0, 0], [0, 0, 1.2]]))
    error = np.sqrt(((found - means) ** 2).mean())
    assert error < 0.4 * np.sqrt(((sharp - means) ** 2).mean())
    assert error < 0.7 * np.sqrt(((wide - means) ** 2).mean())


def test_records_are_put_back_by_what_changes_them() -> None:
    """A second part of a mixture is asked where the first was."""
    axes = np.array([[0.05, 0, 0], [0, 0, 0.9]])
    part = iso.Ramp(iso.PerlinNoise(space="world", transform=TURN), ["red", "blue"])
    both = iso.Blend(part, iso.Blend(part, part, 0.5), 0.5)
    np.testing.assert_allclose(colours(both, own_axes=axes), colours(part, own_axes=axes), atol=1e-6)
