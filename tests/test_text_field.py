"""Text as fields: outlines, advance widths and kerning of fonts made here, and of those installed, against FreeType."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fontTools.feaLib.builder import addOpenTypeFeaturesFromString
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.t2CharStringPen import T2CharStringPen
from fontTools.pens.ttGlyphPen import TTGlyphPen
from PIL import Image, ImageDraw, ImageFont, features

import isophote as iso
from isophote.shapes.field import font_files
from isophote.shapes.field.font import CUBIC_TOLERANCE
from isophote.shapes.field.tape import numpy_values

# Letters of the fonts that are made here, and their advance widths; an em has 1000 units.
WIDTHS = {"A": 700, "V": 600, "O": 800, "space": 250}
LEFT = {"A": 100, "V": 50, "O": 100}
KERN = "feature kern { pos A V -120; pos [O] [A V] -40; } kern;"
CLASSES = "@round = [O]; @slant = [A V]; feature kern { pos A V -120; pos @round @slant -40; } kern;"
# The reach of the control points that make a circle of radius 300 of four cubics: 4 (√2 − 1) / 3 of it, rounded.
REACH = 166


def triangle(pen: Any, up: bool) -> None:
    points = [(100, 0), (600, 0), (350, 700)] if up else [(50, 700), (300, 0), (550, 700)]
    pen.moveTo(points[0])
    for point in points[1:]:
        pen.lineTo(point)
    pen.closePath()


def squares(pen: Any) -> None:
    """Two squares that overlap, both clockwise."""
    for x in (100, 300):
        pen.moveTo((x, 0))
        for point in ((x, 400), (x + 400, 400), (x + 400, 0)):
            pen.lineTo(point)
        pen.closePath()


def circle(pen: Any) -> None:
    """A circle of four cubics about (400, 300), of radius 300."""
    k = REACH
    pen.moveTo((700, 300))
    pen.curveTo((700, 300 + k), (400 + k, 600), (400, 600))
    pen.curveTo((400 - k, 600), (100, 300 + k), (100, 300))
    pen.curveTo((100, 300 - k), (400 - k, 0), (400, 0))
    pen.curveTo((400 + k, 0), (700, 300 - k), (700, 300))
    pen.closePath()


def built(path: Path, features: str = "", cubic: bool = False, legacy: dict[Any, int] | None = None) -> Path:
    """A font with the letters A, V, O and a blank: O is two overlapping squares, or a circle of cubics."""
    builder = FontBuilder(1000, isTTF=not cubic)
    names = [".notdef", *WIDTHS]
    builder.setupGlyphOrder(names)
    builder.setupCharacterMap({ord("A"): "A", ord("V"): "V", ord("O"): "O", ord(" "): "space"})
    draw = {"A": lambda p: triangle(p, True), "V": lambda p: triangle(p, False), "O": circle if cubic else squares}
    glyphs = {}
    for name in names:
        pen = T2CharStringPen(WIDTHS.get(name, 500), None) if cubic else TTGlyphPen(None)
        draw.get(name, lambda p: None)(pen)
        glyphs[name] = pen.getCharString() if cubic else pen.glyph()
    if cubic:
        builder.setupCFF("Made", {"FullName": "Made Regular"}, glyphs, {})
    else:
        builder.setupGlyf(glyphs)
    builder.setupHorizontalMetrics({name: (WIDTHS.get(name, 500), LEFT.get(name, 0)) for name in names})
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupNameTable({"familyName": "Made Here", "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    if features:
        addOpenTypeFeaturesFromString(builder.font, features)
    if legacy:
        from fontTools.ttLib import newTable
        from fontTools.ttLib.tables._k_e_r_n import KernTable_format_0

        table = newTable("kern")
        table.version = 0
        pairs = KernTable_format_0()
        pairs.coverage, pairs.format, pairs.kernTable = 1, 0, legacy
        table.kernTables = [pairs]
        builder.font["kern"] = table
    builder.save(path)
    return path


@pytest.fixture
def font(tmp_path):
    return built(tmp_path / "made.ttf")


def at(field: Any, points: Any) -> Any:
    return numpy_values(field.form, np.asarray(points, np.float64))


# --- outlines -------------------------------------------------------------------------------------


def test_a_letter_is_its_outline(font):
    """A is a triangle; kept exactly, with its baseline at y = 0 and its own space before it."""
    field = iso.text("A", font, size=2.0)
    corners = np.array([(0.1, 0.0), (0.6, 0.0), (0.35, 0.7)]) * 2
    points = np.random.default_rng(0).uniform(-1, 3, (2000, 2))
    assert np.abs(at(field, points) - at(iso.polygon(corners), points)).max() < 3e-7
    assert field.bounds == pytest.approx(np.array([[0.2, 0.0], [1.2, 1.4]]), abs=1e-6)
    assert field.exactness.name == "EXACT"


def test_overlapping_contours_are_one_shape(font):
    field = iso.text("O", font)
    points = np.random.default_rng(1).uniform(-0.5, 1.5, (3000, 2))
    rectangle = iso.rectangle((0.6, 0.4)).translate((0.4, 0.2))
    assert np.abs(at(field, points) - at(rectangle, points)).max() < 3e-7


def test_cubic_outlines_are_within_the_tolerance(tmp_path):
    """The circle of cubics lies within a thousandth of its radius."""
    field = iso.text("O", built(tmp_path / "made.otf", cubic=True))
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    k = REACH / 1000
    t = np.linspace(0, 1, 100)[:, None]
    quarter = (
        (1 - t) ** 3 * np.array([0.3, 0])
        + 3 * t * (1 - t) ** 2 * np.array([0.3, k])
        + 3 * t**2 * (1 - t) * np.array([k, 0.3])
        + t**3 * np.array([0, 0.3])
    )
    for turn in range(4):
        c, s = np.cos(turn * np.pi / 2), np.sin(turn * np.pi / 2)
        on = np.array([0.4, 0.3]) + quarter @ np.array([[c, s], [-s, c]])
        assert np.abs(at(field, on)).max() < CUBIC_TOLERANCE
    for radius in (0.1, 0.25, 0.5):
        ring = np.column_stack([0.4 + radius * np.cos(angle), 0.3 + radius * np.sin(angle)])
        assert np.abs(at(field, ring) - (radius - 0.3)).max() < CUBIC_TOLERANCE + 0.3e-3


# --- setting --------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["none", "pairs", "classes", "legacy"])
def test_advance_widths_and_kerning(tmp_path, kind):
    features = {"pairs": KERN, "classes": CLASSES}.get(kind, "")
    legacy = {("A", "V"): -120, ("O", "A"): -40, ("O", "V"): -40} if kind == "legacy" else None
    font = built(tmp_path / "made.ttf", features, legacy=legacy)
    text = "AVOA"
    kern = {"AV": -0.12, "OA": -0.04} if kind != "none" else {}
    starts, x = [], 0.0
    for before, character in zip(" " + text, text, strict=False):
        x += kern.get(before + character, 0.0)
        starts.append(x)
        x += WIDTHS[character] / 1000
    parts = [iso.text(c, font).translate((start, 0)) for c, start in zip(text, starts, strict=True)]
    points = np.random.default_rng(2).uniform((-0.5, -0.5), (3.2, 1.2), (3000, 2))
    whole = at(iso.text(text, font), points)
    expected = at(iso.union(*parts), points)
    # Outside, the union of letters is exact too.
    assert np.abs(whole - expected)[expected > 0].max() < 1e-6
    assert (np.sign(whole) == np.sign(expected)).all()


@pytest.mark.parametrize(("align", "part"), [("left", 0.0), ("centre", 0.5), ("right", 1.0)])
def test_lines_and_alignment(font, align, part):
    field = iso.text("A A\nV", font, size=0.5, align=align, leading=1.5)
    left = [-part * 0.5 * (0.7 + 0.25 + 0.7), -part * 0.5 * 0.6]
    letters = [
        iso.text("A", font, size=0.5).translate((left[0], 0)),
        iso.text("A", font, size=0.5).translate((left[0] + 0.5 * 0.95, 0)),
        iso.text("V", font, size=0.5).translate((left[1], -0.75)),
    ]
    points = np.random.default_rng(3).uniform((-1.5, -1.5), (1.5, 1), (2000, 2))
    expected = at(iso.union(*letters), points)
    assert np.abs(at(field, points) - expected)[expected > 0].max() < 1e-6


def test_it_pastes_back(font):
    field = iso.text("A\nV", font, size=2, align="right", leading=1.5)
    assert eval(repr(field), {"text": iso.text}) == field
    assert repr(iso.text("A", str(font))) == f"text('A', font={str(font)!r})"


# --- installed fonts ------------------------------------------------------------------------------


def installed() -> Path:
    try:
        return font_files.find_font(None)
    except iso.GeometryError:
        pytest.skip("no font is installed")


@pytest.mark.parametrize("text", ["Isophote", "nHm%", "g&@8"])
def test_installed_fonts_against_freetype(text):
    """Where FreeType covers a pixel fully, or not at all, the pixel's middle is inside, or outside."""
    path = installed()
    size = 200
    free = ImageFont.truetype(str(path), size, layout_engine=ImageFont.Layout.BASIC)
    image = Image.new("L", (int(free.getlength(text)) + 2 * size, 2 * size))
    ImageDraw.Draw(image).text((size // 2, 3 * size // 2), text, font=free, fill=255, anchor="ls")
    cover = np.asarray(image)
    rows, columns = np.indices(cover.shape)
    points = np.stack([(columns + 0.5 - size / 2) / size, (3 * size / 2 - rows - 0.5) / size], axis=-1).reshape(-1, 2)
    v = iso.text(text, path)(points).reshape(cover.shape) * size
    # FreeType sets glyphs on whole pixels, so that each may be off by half a pixel more than the one before.
    clear = np.abs(v) > 1 + 0.5 * len(text)
    assert clear.mean() > 0.8
    assert (cover > 250).sum() > 1000
    assert ((v < 0) == (cover > 128))[clear].all()


@pytest.mark.parametrize("text", ["Isophote", "AVAToy P.", "W. Te, 11"])
def test_widths_of_installed_fonts_are_those_of_harfbuzz(text):
    """The width of a line is how far it moves from the left to the right of x = 0. Asked at 2048 pixels an em, which
    is what most fonts have, HarfBuzz rounds nothing."""
    path = installed()
    if not features.check("raqm"):
        pytest.skip("Pillow comes without HarfBuzz")
    free = ImageFont.truetype(str(path), 2048, layout_engine=ImageFont.Layout.RAQM)
    left, right = (iso.text(text, path, align=align).bounds[0, 0] for align in ("left", "right"))
    assert left - right == pytest.approx(free.getlength(text) / 2048, abs=2e-3)


def test_fonts_by_name(tmp_path, monkeypatch):
    folder = tmp_path / "fonts" / "deeper"
    folder.mkdir(parents=True)
    path = built(folder / "mh-font1.ttf")
    monkeypatch.setattr(font_files, "font_folders", lambda: [tmp_path / "nowhere", tmp_path / "fonts"])
    for name in ("mh-font1", "MH Font1", "Made Here", "made here regular"):
        assert font_files.find_font(name) == path
    with pytest.raises(iso.GeometryError, match="no font named 'Comic' is installed; give font= the path"):
        iso.text("A", "Comic")
    with pytest.raises(iso.GeometryError, match="none of the usual fonts is installed in"):
        iso.text("A")
    built(tmp_path / "fonts" / "LiberationSans-Regular.ttf")
    assert repr(iso.text("A")) == "text('A')"


# --- bad input ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("string", "options", "message"),
    [
        ("", {}, "draws nothing"),
        ("  \n ", {}, "draws nothing"),
        ("A漢", {}, r"made.ttf has no glyph for '漢' \(U\+6F22\); choose another font="),
        (3, {}, "must be a str"),
        ("A", {"size": 0}, "size must be a finite number above 0"),
        ("A", {"align": "middle"}, '"left", "centre" or "right"'),
        ("A", {"leading": -1}, "leading"),
        ("A" * 30_000, {}, "make several texts"),
    ],
)
def test_text_that_cannot_be_set_is_refused(font, string, options, message):
    with pytest.raises(iso.GeometryError, match=message):
        iso.text(string, font, **options)


def test_files_that_are_no_fonts_are_refused(tmp_path, font):
    with pytest.raises(iso.FileError, match="there is no such font file"):
        iso.text("A", tmp_path / "none.ttf")
    with pytest.raises(iso.GeometryError, match="font must be a path or a name"):
        iso.text("A", 3)
    (tmp_path / "text.ttf").write_text("no font")
    with pytest.raises(iso.FileError, match="cannot be read"):
        iso.text("A", tmp_path / "text.ttf")


def test_damaged_fonts_never_crash(tmp_path, font):
    whole = font.read_bytes()
    rng = np.random.default_rng(4)
    for number in range(120):
        damaged = bytearray(whole[: rng.integers(20, len(whole))] if number % 2 else whole)
        for _ in range(number % 7):
            damaged[rng.integers(len(damaged))] = rng.integers(256)
        path = tmp_path / f"damaged{number}.ttf"
        path.write_bytes(bytes(damaged))
        try:
            iso.text("AVO", path)
        except iso.Error:
            continue
