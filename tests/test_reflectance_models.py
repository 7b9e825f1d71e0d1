"""Each model of reflectance against its formula, in double precision, as its source has it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import njit

import isophote as iso
from isophote.checks.materials import probe_of
from isophote.checks.scatter import direction, sphere_grid
from isophote.kernels.base.vec import store_vec3, vec3
from isophote.kernels.brdf.fresnel import fresnel_conductor
from isophote.scene.metal import METALS
from isophote.scene.spectrum import rgb_of_spectrum

MODELS = Path(__file__).parents[1] / "../shared/models"
RNG = np.random.default_rng(11)


def _above(count: int) -> np.ndarray:
    v = RNG.normal(size=(count, 3))
    v[:, 2] = np.abs(v[:, 2]) + 0.05
    return v / np.linalg.norm(v, axis=1, keepdims=True)


OUT, INTO = _above(3000), _above(3000)
H = (OUT + INTO) / np.linalg.norm(OUT + INTO, axis=1, keepdims=True)
COS_O, COS_I, COS_D = OUT[:, 2], INTO[:, 2], (OUT * H).sum(axis=1)


def found(material: iso.Material) -> np.ndarray:
    """f, (n, 3)."""
    return probe_of(material).evaluate(OUT, INTO).value / COS_I[:, None]


def same(a: np.ndarray, b: np.ndarray) -> None:
    np.testing.assert_allclose(a, np.broadcast_to(b, a.shape), rtol=3e-3, atol=1e-6)


def test_lambert() -> None:
    same(found(iso.Matte((0.9, 0.5, 0.1))), np.array([0.9, 0.5, 0.1]) / np.pi)


def test_oren_nayar_is_fujii_s_form_where_little_light_bounces_twice() -> None:
    rho, r = 1e-4, 0.6
    s = (OUT * INTO).sum(axis=1) - COS_O * COS_I
    t = np.where(s > 0, np.maximum(COS_O, COS_I), 1)
    wanted = rho / np.pi * (1 + r * s / t) / (1 + (1 / 2 - 2 / (3 * np.pi)) * r)
    same(found(iso.OrenNayar(rho, r))[:, 0] / rho, wanted / rho)
    same(found(iso.OrenNayar(0.7, 0.0)), np.array([0.7 / np.pi]))


def test_phong() -> None:
    mirror = OUT * (-1, -1, 1)
    highlight = (20 + 2) / (2 * np.pi) * np.maximum((mirror * INTO).sum(axis=1), 0) ** 20
    same(found(iso.Phong(0.4, 0.3, 20))[:, 0], 0.4 * 0.7 / np.pi + 0.3 * highlight)


def test_blinn() -> None:
    n = 50
    highlight = (n + 2) * (n + 4) / (8 * np.pi * (2 ** (-n / 2) + n)) * H[:, 2] ** n
    same(found(iso.Blinn(0.4, 0.3, n))[:, 0], 0.4 * 0.7 / np.pi + 0.3 * highlight)


@pytest.mark.parametrize("material", [iso.Phong(0.0, 1.0, 30), iso.Blinn(0.0, 1.0, 30)])
def test_a_white_highlight_reflects_all_light_from_above(material: iso.Material) -> None:
    grid, cell = sphere_grid(800, 64)
    total = (probe_of(material).evaluate(direction(0.0), grid).value[:, 0] * cell).sum()
    assert abs(total - 1) < 2e-3


def test_ashikhmin_shirley() -> None:
    u, v, rho, s = 40.0, 7.0, 0.6, 0.2
    exponent = (u * H[:, 0] ** 2 + v * H[:, 1] ** 2) / (1 - H[:, 2] ** 2)
    fresnel = s + (1 - s) * (1 - COS_D) ** 5
    highlight = np.sqrt((u + 1) * (v + 1)) / (8 * np.pi) * H[:, 2] ** exponent * fresnel
    highlight /= COS_D * np.maximum(COS_O, COS_I)
    body = 28 * rho / (23 * np.pi) * (1 - s) * (1 - (1 - COS_O / 2) ** 5) * (1 - (1 - COS_I / 2) ** 5)
    same(found(iso.AshikhminShirley(rho, s, (u, v)))[:, 0], highlight + body)


def test_ward() -> None:
    ax, ay, rho, s = 0.3**2, 0.6**2, 0.6, 0.2
    h = OUT + INTO
    slope2 = ((h[:, 0] / ax) ** 2 + (h[:, 1] / ay) ** 2) / h[:, 2] ** 2
    highlight = s / (np.pi * ax * ay) * np.exp(-slope2) * (h**2).sum(axis=1) / h[:, 2] ** 4
    same(found(iso.Ward(rho, s, (0.3, 0.6)))[:, 0], rho * (1 - s) / np.pi + highlight)


# --- microfacets ----------------------------------------------------------------------------------


def facets(ax: float, ay: float) -> np.ndarray:
    """D(h) of Trowbridge and Reitz."""
    t = (H[:, 0] / ax) ** 2 + (H[:, 1] / ay) ** 2 + H[:, 2] ** 2
    return 1 / (np.pi * ax * ay * t**2)


def masked(v: np.ndarray, ax: float, ay: float) -> np.ndarray:
    """Smith's G1."""
    slope2 = ((ax * v[:, 0]) ** 2 + (ay * v[:, 1]) ** 2) / v[:, 2] ** 2
    return 2 / (1 + np.sqrt(1 + slope2))


def conductor(cosine: np.ndarray, index: complex) -> np.ndarray:
    """Fresnel's equations, in complex numbers."""
    inside = np.sqrt(index**2 - (1 - cosine**2) + 0j)
    perpendicular = np.abs((cosine - inside) / (cosine + inside)) ** 2
    parallel = np.abs((index**2 * cosine - inside) / (index**2 * cosine + inside)) ** 2
    return (perpendicular + parallel) / 2


def test_metal() -> None:
    ax, ay = 0.4**2, 0.8**2
    n, k = METALS["copper"]
    wanted = np.stack([conductor(COS_D, complex(a, b)) for a, b in zip(n, k, strict=True)], 1)
    wanted *= (facets(ax, ay) * masked(OUT, ax, ay) * masked(INTO, ax, ay) / (4 * COS_O * COS_I))[:, None]
    same(found(iso.Metal("copper", (0.4, 0.8), single_bounce=True)), wanted)


@njit
def _conductor(cosines, index, out):
    for i in range(len(cosines)):
        n = vec3(index[0], index[1], index[2])
        store_vec3(out, 3 * i, fresnel_conductor(cosines[i], n, vec3(index[3], index[4], index[5])))


@pytest.mark.parametrize("name", METALS)
def test_fresnel_of_conductors(name: str) -> None:
    cosine = np.linspace(0.001, 1, 500).astype(np.float32)
    n, k = METALS[name]
    out = np.zeros(3 * len(cosine), np.float32)
    _conductor(cosine, np.array([*n, *k], np.float32), out)
    for channel, (a, b) in enumerate(zip(n, k, strict=True)):
        wanted = conductor(cosine.astype(np.float64), complex(a, b))
        np.testing.assert_allclose(out[channel::3], wanted, rtol=0, atol=2e-6)


def test_smooth_metal_reflects_by_fresnel() -> None:
    n, k = METALS["gold"]
    for angle in (0.0, 0.6, 1.3, 1.55):
        branch = probe_of(iso.Metal("gold", 0)).branch(direction(angle), 0)
        wanted = [float(conductor(np.cos(angle), complex(a, b))) for a, b in zip(n, k, strict=True)]
        np.testing.assert_allclose(branch.value[0], wanted, atol=2e-6)
        np.testing.assert_allclose(branch.into[0], direction(-angle), atol=1e-6)


def test_anisotropic_highlights_turn_with_the_tangent() -> None:
    turned = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    for one, other in (
        (iso.Metal("gold", (0.3, 0.7)), iso.Metal("gold", (0.7, 0.3))),
        (iso.Ward(0.2, 0.5, (0.3, 0.7)), iso.Ward(0.2, 0.5, (0.7, 0.3))),
        (iso.AshikhminShirley(0.2, 0.5, (100, 5)), iso.AshikhminShirley(0.2, 0.5, (5, 100))),
        (iso.Glass(roughness=(0.4, 0.7)), iso.Glass(roughness=(0.7, 0.4))),
    ):
        a = probe_of(one).evaluate(OUT, INTO).value
        b = probe_of(other).evaluate(OUT @ turned, INTO @ turned).value
        assert np.abs(a - probe_of(other).evaluate(OUT, INTO).value).max() > 0.1
        np.testing.assert_allclose(a, b, rtol=2e-3, atol=1e-6)


# --- glass, coats ---------------------------------------------------------------------------------


def dielectric(cosine: np.ndarray, n: float) -> np.ndarray:
    """Fresnel's equations, from the side of index 1."""
    inside = np.sqrt(np.maximum(1 - (1 - cosine**2) / n**2, 0))
    parallel = (n * cosine - inside) / (n * cosine + inside)
    perpendicular = (cosine - n * inside) / (cosine + n * inside)
    return np.where((1 - cosine**2) / n**2 > 1, 1.0, (parallel**2 + perpendicular**2) / 2)


@pytest.mark.parametrize("n", [1.5, 0.8])
def test_rough_glass_is_walter_s(n: float) -> None:
    a = 0.7**2
    reflected = dielectric(COS_D, n) * facets(a, a) * masked(OUT, a, a) * masked(INTO, a, a) / (4 * COS_O * COS_I)
    same(found(iso.Glass(n, roughness=0.7))[:, 0], reflected)
    into = INTO * (1, 1, -1)
    h = OUT + n * into
    h /= np.linalg.norm(h, axis=1, keepdims=True) * np.sign(h[:, 2:])
    o, i = (OUT * h).sum(axis=1), (into * h).sum(axis=1)
    t = (h[:, 0] ** 2 + h[:, 1] ** 2) / a**2 + h[:, 2] ** 2
    g = masked(OUT, a, a) * masked(into, a, a)
    wanted = np.abs(i * o) / (COS_O * COS_I) * (1 - dielectric(o, n)) * g / (np.pi * a**2 * t**2) / (o + n * i) ** 2
    told = probe_of(iso.Glass(n, roughness=0.7)).evaluate(OUT, into).value[:, 0] / COS_I
    same(told, np.where((o > 0) & (i < 0), wanted, 0))


def test_smooth_plastic_keeps_light_inside() -> None:
    rho, n = 0.6, 1.5
    mu = (np.arange(200_000) + 0.5) / 200_000
    outside = 2 * (dielectric(mu, n) * mu).mean()
    inside = 1 - (1 - outside) / n**2
    through = (1 - dielectric(COS_O, n)) * (1 - dielectric(COS_I, n))
    same(found(iso.Plastic(rho, 0.0))[:, 0], through * rho / (np.pi * n**2 * (1 - rho * inside)))


def test_a_coat_lets_through_what_it_does_not_reflect() -> None:
    through = (1 - dielectric(COS_O, 1.5)) * (1 - dielectric(COS_I, 1.5))
    same(found(iso.Coated(iso.Ward(0.6), 0.0)), through[:, None] * found(iso.Ward(0.6)))


def test_mixes_are_linear() -> None:
    a, b = iso.Metal("gold", 0.5), iso.Plastic("red", 0.4)
    same(found(iso.Mix(a, b, 0.3)), 0.7 * found(a) + 0.3 * found(b))


def test_textures_multiply_parameters() -> None:
    half = iso.ImageTexture(np.full((2, 2, 3), 0.5, np.float32))
    same(found(iso.Phong(half, half, half)), found(iso.Phong(0.5, 0.5, 0.5)))
    same(found(iso.Metal("gold", half)), found(iso.Metal("gold", 0.5)))
    same(found(iso.Mix(iso.Matte(half), iso.Matte("red"), half)), found(iso.Mix(iso.Matte(0.5), iso.Matte("red"), 0.5)))
    channels = iso.ImageTexture(np.broadcast_to(np.array([0.1, 0.6, 0.3], np.float32), (1, 1, 3)).copy())
    same(
        found(iso.Principled("red", 1.0, 1.0, metallic_roughness_texture=channels)),
        found(iso.Principled("red", metallic=0.3, roughness=0.6)),
    )


# --- spectra --------------------------------------------------------------------------------------


def test_constant_spectra_keep_their_value() -> None:
    assert rgb_of_spectrum([380, 800], [0.7, 0.7]) == pytest.approx((0.7, 0.7, 0.7), abs=1e-12)
    with pytest.raises(iso.SceneError, match="400 to 700"):
        rgb_of_spectrum([500, 600], [1, 1])


def test_red_light_is_red() -> None:
    red, green, blue = rgb_of_spectrum([380, 595, 605, 780], [0, 0, 1, 1])
    assert red > 0.6
    assert abs(green) + abs(blue) < 0.2


@pytest.mark.parametrize(("name", "file"), [("gold", "Au_Johnson.yml"), ("aluminium", "Al_Rakic.yml")])
def test_the_table_of_metals_is_that_of_the_measurements(name: str, file: str) -> None:
    path = MODELS / "ior" / file
    if not path.exists():
        pytest.skip("the models are not here")
    np.testing.assert_allclose(iso.load_metal(path).index, METALS[name], atol=6e-4)


def test_gold_and_copper_have_their_colours() -> None:
    """What they reflect of white light from above, linear (elsewhere about 1, 0.77, 0.34 and 0.95, 0.64, 0.54)."""
    for name, wanted in (("gold", (1.0, 0.77, 0.34)), ("copper", (0.95, 0.64, 0.54)), ("silver", (0.97, 0.96, 0.94))):
        share = probe_of(iso.Metal(name, 0)).branch(direction(0.0), 0).value[0]
        np.testing.assert_allclose(share, wanted, atol=0.06)
