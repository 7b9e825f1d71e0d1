"""Fields at arrays of points: values and gradients, threads, kinds of arrays, what is refused."""

from __future__ import annotations

import gc

import numpy as np
import pytest

from field_tapes import SOLIDS, Written
from isophote import GeometryError
from isophote.shapes.field import evaluate
from isophote.shapes.field.functions import exp, length, log, maximum
from isophote.shapes.field.tape import numpy_values, sharing_slots, tape_of

DISC = Written(lambda p: maximum(length(p.x, p.y) - 1.0, p.y), 2)


@pytest.mark.parametrize("count", [0, 1, 15, 16, 17, 127, 128, 129, 1000, 20_000])
def test_any_number_of_points(count: int) -> None:
    points = np.random.default_rng(count).uniform(-2, 2, (count, 3)).astype(np.float32)
    found = evaluate.values(SOLIDS["part"], points)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, numpy_values(SOLIDS["part"], points), atol=1e-6)
    assert evaluate.gradients(SOLIDS["part"], points).shape == (count, 3)


def test_points_in_the_plane() -> None:
    points = np.random.default_rng(1).uniform(-2, 2, (1000, 2)).astype(np.float32)
    found = evaluate.values(DISC, points)
    np.testing.assert_allclose(found, np.maximum(np.hypot(*points.T) - 1, points[:, 1]), atol=1e-6)
    gradients = evaluate.gradients(DISC, points)
    assert gradients.shape == (1000, 2)
    outside = points[:, 1] < found - 1e-3
    np.testing.assert_allclose(gradients[outside], (points.T / np.hypot(*points.T)).T[outside], atol=1e-6)


def test_gradients_are_those_of_differences() -> None:
    points = np.random.default_rng(2).uniform(-1.5, 1.5, (999, 3)).astype(np.float32)
    step = 1e-6 * np.eye(3)
    for form in SOLIDS.values():
        ahead, back = (np.stack([numpy_values(form, points + s * e) for e in step], axis=1) for s in (1, -1))
        wanted = (ahead - back) / 2e-6
        # Differences across an edge, where arms meet, are of neither.
        found = evaluate.gradients(form, points)
        assert (np.abs(found - wanted).max(axis=1) < 1e-4).mean() > 0.99


def test_kinds_of_arrays_give_the_same_values() -> None:
    points = np.random.default_rng(3).integers(-16, 16, (3000, 3)) / 8
    form = SOLIDS["blended"]
    wanted = evaluate.values(form, points)
    for same in (points.astype(np.float32), points.astype(">f8"), np.asfortranarray(points), points.tolist()):
        assert (evaluate.values(form, same) == wanted).all()
    assert (evaluate.values(form, (points * 8).astype(np.int32)) == evaluate.values(form, points * 8)).all()
    assert (evaluate.values(form, points[::-2]) == wanted[::-2]).all()


def test_threads_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.random.default_rng(4).uniform(-2, 2, (50_001, 3))
    monkeypatch.setattr(evaluate, "_WORK_A_THREAD", 1 << 12)
    found = {}
    for threads in (1, 2, 5):
        monkeypatch.setattr(evaluate, "processors", lambda threads=threads: threads)
        found[threads] = evaluate.values(SOLIDS["cut"], points), evaluate.gradients(SOLIDS["cut"], points)
    for threads in (2, 5):
        for one, other in zip(found[1], found[threads], strict=True):
            assert np.array_equal(one, other)


def test_points_that_are_not_finite_have_no_value() -> None:
    points = np.zeros((40, 3))
    points[[3, 17, 39], [0, 1, 2]] = np.nan, np.inf, 1e300
    for form in (SOLIDS["part"], Written(lambda p: maximum(p.x, 0.0))):
        wanted = np.zeros(40, bool)
        wanted[[3, 17, 39]] = True
        assert (np.isnan(evaluate.values(form, points)) == wanted).all()
        assert (np.isnan(evaluate.gradients(form, points)).all(axis=1) == wanted).all()


def test_values_that_are_not_there_pass_through_minima_and_maxima() -> None:
    points = np.array([[-1.0, 0, 0], [1, 0, 0]])
    for write in (
        lambda p: maximum(log(p.x), p.y),
        lambda p: maximum(p.y, log(p.x)),
        lambda p: -maximum(-p.y, -log(p.x)),
        lambda p: maximum(log(p.x), 0.0),
    ):
        assert np.isnan(evaluate.values(Written(write), points)).tolist() == [True, False]


@pytest.mark.parametrize(
    "points", [np.zeros(3), np.zeros((2, 2)), np.zeros((2, 3), complex), [["a", "b", "c"]], [[1, 2, 3], [1, 2]]]
)
def test_what_are_no_points_is_refused(points: object) -> None:
    with pytest.raises(GeometryError, match="points must"):
        evaluate.values(SOLIDS["part"], points)  # type: ignore[arg-type]


def test_tapes_are_kept_as_long_as_their_forms() -> None:
    form = Written(lambda p: exp(p.x))
    evaluate.values(form, np.zeros((1, 3)))
    evaluate.gradients(form, np.zeros((1, 3)))
    assert form in evaluate._prepared
    kept = len(evaluate._prepared)
    del form
    gc.collect()
    assert len(evaluate._prepared) == kept - 1


@pytest.mark.parametrize("name", SOLIDS)
def test_slots_that_are_used_again(name: str) -> None:
    rows = tape_of(SOLIDS[name]).rows
    shared, slots = sharing_slots(rows)
    assert slots < 3 + len(rows)
    held = {0: 0, 1: 1, 2: 2}
    for number, (before, after) in enumerate(zip(rows.tolist(), shared.tolist(), strict=True)):
        # Each argument lies where the row that made it put it, and nothing has been written over it.
        assert [held[slot] for slot in after[2:5]] == before[2:5]
        assert 3 <= after[1] < slots
        held[after[1]] = 3 + number
