"""The web page of a field, in a real browser without a window."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import isophote as iso
from isophote.shapes.field.expression import Parameter
from isophote.shapes.field.field import Field
from isophote.shapes.field.rounds import cylinder
from isophote.shapes.field.solids import box, sphere

BROWSER = shutil.which("chromium")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]

pytestmark = [
    pytest.mark.skipif(BROWSER is None, reason="no chromium here"),
    # One browser at a time.
    pytest.mark.xdist_group("browser"),
]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as engine:
        opened = engine.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        yield opened
        opened.close()


def _part() -> Field:
    return (sphere(1) & box(1.5)) - cylinder(Parameter("hole", 0.5, 0.1, 0.7))


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "part & <co>.html"
    iso.save(_part(), path)
    return path


@pytest.fixture
def page(browser: Any, file: Path) -> Iterator[Any]:
    page = browser.new_page(viewport={"width": 240, "height": 180}, has_touch=True)
    page.trouble = []
    page.on("console", lambda message: page.trouble.append(message.text))
    page.on("pageerror", lambda error: page.trouble.append(str(error)))
    page.on("request", lambda request: None if request.url.startswith("file:") else page.trouble.append(request.url))
    page.goto(file.as_uri())
    page.wait_for_function("window.isophote !== undefined")
    yield page
    page.close()


def _picture(page: Any) -> np.ndarray:
    return np.array(page.evaluate("isophote.picture(120, 90)"), np.uint8).reshape(90, 120, 4)[..., :3]


def _drag(page: Any, dx: int, dy: int, key: str | None = None) -> None:
    if key:
        page.keyboard.down(key)
    page.mouse.move(120, 90)
    page.mouse.down()
    page.mouse.move(120 + dx, 90 + dy, steps=3)
    page.mouse.up()
    if key:
        page.keyboard.up(key)


def test_it_draws_without_trouble_and_without_the_network(page: Any) -> None:
    page.wait_for_timeout(500)
    assert page.trouble == []
    picture = _picture(page)
    assert page.locator("#message").is_hidden()
    assert page.title() == "part & <co>"
    # A light body before a darker ground.
    assert picture[45, 50].mean() > picture[:10].mean() + 20


def test_the_slider_changes_the_hole(page: Any) -> None:
    before = _picture(page)
    page.locator("#slider-u_hole").fill("0.2")
    assert page.locator("output").inner_text() == "0.2"
    changed = np.abs(_picture(page).astype(int) - before).max(axis=2) > 10
    assert 20 < changed.sum() < changed.size / 4


def test_dragging_turns_and_double_click_starts_over(page: Any) -> None:
    start = page.evaluate("isophote.view")
    _drag(page, 50, 20)
    turned = page.evaluate("isophote.view")
    assert turned["yaw"] == pytest.approx(start["yaw"] - 0.4)
    assert turned["pitch"] == pytest.approx(start["pitch"] + 0.16)
    assert turned["target"] == start["target"]
    page.mouse.dblclick(120, 90)
    assert page.evaluate("isophote.view") == start


def test_dragging_with_shift_moves_what_is_under_the_pointer(page: Any) -> None:
    start = page.evaluate("isophote.view")
    _drag(page, 30, 0, "Shift")
    moved = page.evaluate("isophote.view")
    shift = np.linalg.norm(np.subtract(moved["target"], start["target"]))
    assert shift == pytest.approx(30 * 2 * start["distance"] * np.tan(start["fov"] / 2) / 180, rel=1e-3)
    assert moved["yaw"] == start["yaw"]


def test_the_wheel_and_keys_zoom(page: Any) -> None:
    start = page.evaluate("isophote.view.distance")
    page.mouse.move(120, 90)
    page.mouse.wheel(0, -200)
    page.wait_for_function(f"isophote.view.distance < {0.9 * start}")
    page.locator("#view").focus()
    page.keyboard.press("Home")
    assert page.evaluate("isophote.view.distance") == start


def test_two_fingers_zoom(page: Any) -> None:
    start = page.evaluate("isophote.view.distance")
    page.evaluate("""() => {
        const send = (name, id, x, y) => document.getElementById("view").dispatchEvent(
            new PointerEvent(name, { pointerId: id, clientX: x, clientY: y, pointerType: "touch", bubbles: true }));
        document.getElementById("view").setPointerCapture = () => {};
        send("pointerdown", 11, 100, 90); send("pointerdown", 12, 140, 90);
        send("pointermove", 11, 80, 90); send("pointermove", 12, 160, 90);
        send("pointerup", 11, 80, 90); send("pointerup", 12, 160, 90);
    }""")
    assert page.evaluate("isophote.view.distance") == pytest.approx(start / 2)


def test_the_resolution_falls_where_frames_are_slow(page: Any) -> None:
    page.set_viewport_size({"width": 1600, "height": 1200})
    for _ in range(4):
        _drag(page, 40, 0)
    page.wait_for_function("isophote.resolution < 0.9")


def test_without_webgl2_it_says_so(browser: Any, file: Path) -> None:
    page = browser.new_page()
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(file.as_uri())
    assert "WebGL 2" in page.locator("#message").inner_text()
    page.close()


def test_an_endless_field_is_refused(tmp_path: Path) -> None:
    with pytest.raises(iso.Error, match="endless"):
        iso.save(cylinder(1), tmp_path / "endless.html")
    assert list(tmp_path.iterdir()) == []
