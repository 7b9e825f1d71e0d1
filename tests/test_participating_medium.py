"""Air that scatters light, in path tracing, against closed forms and integrals."""

import numpy as np
import pytest
from scipy.integrate import quad

import isophote as iso

SIZE = (8, 8)
BOX = [(-2, -2, -2), (2, 2, 2)]
# Parallel rays along −Z, all within a hair of the axis.
ALONG = iso.OrthographicCamera((0, 0, 5), (0, 0, 0), height=1e-3)


def _pictures(scene, samples=128, max_depth=2, seeds=16, size=SIZE):
    method = iso.PathTrace(samples=samples, max_depth=max_depth)
    return np.array(
        [iso.render(scene, method, size=size, seed=s, progress=False).channels["colour"] for s in range(seeds)], float
    )


def _is(pictures, expected, least=1e-6):
    """Whether the mean over all pixels of independent pictures is what is expected, by channels, within 4.5 σ."""
    means = pictures.mean(axis=(1, 2))
    error = means.std(axis=0, ddof=1) / np.sqrt(len(means))
    assert (np.abs(means.mean(axis=0) - expected) < 4.5 * error + least).all(), (means.mean(axis=0), expected, error)
    assert (error < 0.02 * np.max(expected)).all()


def _wall(radiance):
    corners = [(-9, -9, -3), (9, -9, -3), (9, 9, -3), (-9, 9, -3)]
    return iso.Item(iso.Mesh(corners, [(0, 1, 2, 3)]), iso.Emitter(radiance))


@pytest.mark.parametrize("bounds", [None, BOX])
def test_what_is_swallowed_is_exponential(bounds):
    medium = iso.Medium(absorption=(0.1, 0.3, 0.6), bounds=bounds)
    way = 8 if bounds is None else 4
    pictures = _pictures(iso.Scene([_wall((1, 2, 3))], camera=ALONG, medium=medium), samples=4, seeds=2)
    expected = np.array([1, 2, 3]) * np.exp(-way * np.array([0.1, 0.3, 0.6]))
    np.testing.assert_allclose(pictures, np.broadcast_to(expected, pictures.shape), rtol=1e-5)


def test_light_that_is_not_scattered_is_exponential_too():
    # One ray a path: what shines, and no scattering.
    medium = iso.Medium(scattering=(0.1, 0.3, 0.6), absorption=0.1, anisotropy=0.4, bounds=BOX)
    pictures = _pictures(iso.Scene([_wall((1, 1, 1))], camera=ALONG, medium=medium), max_depth=1)
    _is(pictures, np.exp(-4 * np.array([0.2, 0.4, 0.7])))


@pytest.mark.parametrize("anisotropy", [-0.5, 0.0, 0.8])
@pytest.mark.parametrize("bounds", [None, [(-9, -9, -9), (9, 9, 9)]])
def test_nothing_is_lost_where_nothing_is_swallowed(anisotropy, bounds):
    """Within a furnace all is as bright as its walls, whatever is scattered on the way."""
    room = iso.Item(iso.box(6), iso.Emitter((1, 1, 1), two_sided=True))
    camera = iso.Camera((0, 0, 2), (0, 0.4, 0), fov_degrees=60)
    medium = iso.Medium(scattering=(0.2, 0.5, 1.0), anisotropy=anisotropy, bounds=bounds)
    _is(_pictures(iso.Scene([room], camera=camera, medium=medium), 32, 256), np.ones(3))


def test_nothing_is_lost_under_a_sky():
    medium = iso.Medium(scattering=(0.3, 0.6, 1.5), anisotropy=0.3, bounds=BOX)
    scene = iso.Scene([iso.Item(iso.sphere(0.5), iso.Matte(1.0))], [iso.Sky("white")], ALONG, medium=medium)
    camera = iso.Camera((0, 1, 6), (0, 0, 0), fov_degrees=50)
    _is(_pictures(scene.with_(camera=camera), 32, 1024), np.ones(3))


def _phase(g, cosine):
    return (1 - g * g) / (4 * np.pi * (1 + g * g - 2 * g * cosine) ** 1.5)


@pytest.mark.parametrize("g", [0.0, 0.6, -0.4])
@pytest.mark.parametrize("bounds", [None, BOX])
def test_single_scattering_of_a_point_light_is_its_integral(g, bounds):
    scattering, absorption = np.array([0.05, 0.2, 0.7]), np.array([0.1, 0.0, 0.05])
    light, power = np.array([0.0, 1.0, -0.5]), 4 * np.pi
    medium = iso.Medium(scattering, absorption, g, bounds=bounds)
    # A black wall far behind ends the view, so that all of it is finite.
    scene = iso.Scene([_wall((0, 0, 0))], [iso.PointLight(light, power)], ALONG, medium=medium)

    def scattered(s, k):
        place = np.array([0, 0, 5 - s])
        way = light - place
        distance = np.linalg.norm(way)
        total = scattering[k] + absorption[k]
        inside = s if bounds is None else s - 3
        return scattering[k] * _phase(g, -way[2] / distance) * np.exp(-total * (inside + distance)) / distance**2

    first, last = (0, 8) if bounds is None else (3, 7)
    expected = [quad(scattered, first, last, args=(k,), points=[5.5])[0] for k in range(3)]
    _is(_pictures(scene), np.array(expected), least=2e-5)


def _round_lamp(lit_by_itself):
    lamp = iso.SphereLight(radius=1.2, radiance=(1, 1, 1)).at((0, 2.2, 0))
    ball = iso.Item(iso.sphere(1.2).translate((0, 2.2, 0)), iso.Emitter((1, 1, 1)))
    return iso.Scene(
        [_wall((0, 0, 0)), *([] if lit_by_itself else [ball])],
        [lamp] if lit_by_itself else [],
        ALONG,
        medium=iso.Medium(0.3, anisotropy=0.7),
    )


def test_lamps_are_aimed_at_and_met_alike():
    """A picture of the sky, which is aimed at, against a constant sky, which is met by chance; and a lamp that is a
    light against one that is an item."""
    white = iso.Environment(iso.ImageTexture(np.ones((8, 16, 3), np.float32)))
    medium = iso.Medium((0.3, 0.5, 0.8), 0.05, 0.6, bounds=BOX)
    ball = [iso.Item(iso.sphere(0.4), iso.Matte(0.5))]
    camera = iso.Camera((0, 1, 6), (0, 0, 0), fov_degrees=40)
    for depth in (2, 6):
        by_chance = _pictures(iso.Scene(ball, [iso.Sky("white")], camera, medium=medium), 64, depth)
        aimed = _pictures(iso.Scene(ball, [white], camera, medium=medium), 64, depth)
        _is(aimed, by_chance.mean(axis=(0, 1, 2)), least=2e-3)
    as_light, as_item = (_pictures(_round_lamp(kind), 64, 3) for kind in (True, False))
    _is(as_light, as_item.mean(axis=(0, 1, 2)), least=1e-3)


def _h_function(albedo, mu, count=64):
    """Chandrasekhar's H for isotropic scattering, at `mu`, by iteration: 1/H = √(1−ω) + ω/2 ∫ x H/(μ+x) dx."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    x, w = (nodes + 1) / 2, weights / 2
    h = np.ones(count)
    for _ in range(2000):
        h = 1 / (np.sqrt(1 - albedo) + albedo / 2 * ((w * x * h) / (x[:, None] + x)).sum(axis=1))
    return 1 / (np.sqrt(1 - albedo) + albedo / 2 * (w * x * h / (mu + x)).sum())


def test_thick_fog_reflects_as_chandrasekhar_says():
    """A deep layer under a constant sky shows 1 − √(1 − ω) H(μ) (Chandrasekhar, "Radiative Transfer", 1960)."""
    albedo = np.array([0.5, 0.8, 0.95])
    deep = iso.Medium(10 * albedo, 10 * (1 - albedo), bounds=[(-40, -40, -8), (40, 40, 0)])
    expected = [1 - np.sqrt(1 - a) * _h_function(a, 1.0) for a in albedo]
    scene = iso.Scene([iso.Item(iso.sphere(0.1).translate((0, 0, -20)))], [iso.Sky("white")], ALONG, medium=deep)
    _is(_pictures(scene, 32, 400), np.array(expected))


def test_glass_holds_none_of_it():
    medium = iso.Medium(absorption=0.5, bounds=BOX)
    pane = iso.Item(iso.box((3, 3, 2)), iso.Glass(ior=1.0))
    pictures = _pictures(iso.Scene([_wall((1, 1, 1)), pane], camera=ALONG, medium=medium), 4, 8, 2)
    np.testing.assert_allclose(pictures, np.exp(-1.0), rtol=1e-4)


def test_clear_air_changes_nothing():
    scene = iso.Scene([iso.Item(iso.sphere(1))], [iso.Sky("white", 0.5), iso.PointLight((2, 3, 4), 50)], ALONG)
    method = iso.PathTrace(samples=4)
    plain, clear = (
        iso.render(one, method, size=SIZE, progress=False).channels["colour"]
        for one in (scene, scene.with_(medium=iso.Medium()))
    )
    np.testing.assert_array_equal(plain, clear)


def test_the_same_seed_gives_the_same_bits_whatever_the_threads():
    scene = _round_lamp(True)
    one, three = (
        iso.render(scene, iso.PathTrace(samples=8), size=(40, 40), threads=t, progress=False).channels["colour"]
        for t in (1, 3)
    )
    np.testing.assert_array_equal(one, three)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"anisotropy": 1.0}, "anisotropy"),
        ({"scattering": -1}, "0 or above|scattering"),
        ({"scattering": "red"}, "1/m"),
        ({"bounds": [(0, 0, 0), (1, 0, 1)]}, "bounds"),
        ({"bounds": 3}, "bounds"),
    ],
)
def test_media_without_sense_are_refused(fields, said):
    with pytest.raises(iso.SceneError, match=said):
        iso.Medium(**fields)


def test_media_compare_and_print():
    medium = iso.Medium(0.5, (0, 0.1, 0.2), 0.3, bounds=BOX)
    assert medium == iso.Medium(0.5, (0, 0.1, 0.2), 0.3, bounds=np.array(BOX, float))
    assert medium != iso.Medium(0.5, (0, 0.1, 0.2), 0.3)
    assert hash(medium) == hash(iso.Medium(0.5, (0, 0.1, 0.2), 0.3, bounds=BOX))
    with pytest.raises(iso.SceneError, match="medium"):
        iso.Scene([], medium=0.5)
