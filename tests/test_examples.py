"""Every example renders from the command line, and says what it shows; every block of the pages runs."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from command_line import succeeds

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_give_pictures(tmp_path: Path, path: Path) -> None:
    out = tmp_path / "out.exr"
    succeeds("render", path, "-o", out, "--size", "64x48", "--samples", 4)
    channels = iso.load_image(out).channels
    colour = channels["colour"]
    assert np.isfinite(colour).all()
    assert 0.02 < colour.mean() < 5
    # More than a sky or a wall: several items, and light that differs over the picture.
    assert len(np.unique(channels["item"])) >= 2
    assert colour.std() > 0.02


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_say_what_they_show_and_how_to_run_them(path: Path) -> None:
    text = ast.get_docstring(ast.parse(path.read_text()))
    assert text is not None
    assert f"examples/{path.name}" in text


def test_rays_answers_as_geometry_does() -> None:
    run = subprocess.run(
        [sys.executable, ROOT / "examples" / "rays.py"], capture_output=True, text=True, check=True, timeout=300
    )
    found = re.fullmatch(r"thickness ([\d.]+) m, .*\nvisible sky ([\d.]+); .*\n", run.stdout)
    assert found is not None, run.stdout
    # The bowl is 0.1 m thick, as far as its flat faces are round; from the middle of the bottom of a half sphere the
    # opening is seen under 45°, and sin² 45° = 1/2.
    assert float(found[1]) == pytest.approx(0.1, abs=1e-3)
    assert float(found[2]) == pytest.approx(0.5, abs=5e-3)


def blocks(page: Path) -> str:
    """The Python of a page, block after block."""
    return "\n".join(re.findall(r"^```python\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL))


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page)], ids=lambda page: page.stem)
def test_pages_run(tmp_path: Path, page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # Pictures of the pages are large; here they only have to come out.
    whole = iso.render

    def small(subject, *method, **options):
        methods = method if isinstance(subject, iso.Field2) else (iso.PathTrace(1),)
        return whole(subject, *methods, **{**options, "size": (8, 6)})

    monkeypatch.setattr(iso, "render", small)
    exec(compile(blocks(page), str(page), "exec"), {"__name__": page.stem})


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_link_to_what_is_there(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text()):
        if "://" not in target:
            assert (page.parent / target).exists(), target


def test_commands_of_the_pages_are_known(tmp_path: Path) -> None:
    verbs = re.findall(r"^(?:\S*/)?isophote (\w+)", "\n".join(page.read_text() for page in PAGES), re.MULTILINE)
    assert verbs
    for verb in set(verbs):
        assert "Usage" in succeeds(verb, "--help")
