"""Motions: what lies between placements, against rotations and stretches that are known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

import isophote as iso

ANGLES = st.floats(-3.0, 3.0)
NUMBERS = st.floats(-10, 10)
STRETCHES = st.floats(0.1, 10)
AXES = st.tuples(NUMBERS, NUMBERS, NUMBERS).filter(lambda axis: np.linalg.norm(axis) > 0.1)
PARTS = st.floats(0, 1)
IDENTITY = iso.Transform.identity()


def _rotation(axis, angle):
    return Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis))


def _placement(rotation, offset=(0, 0, 0), stretch=None):
    matrix = np.eye(4)
    matrix[:3, :3] = rotation.as_matrix() @ (np.eye(3) if stretch is None else stretch)
    matrix[:3, 3] = offset
    return iso.Transform(matrix)


@given(AXES, AXES, ANGLES, ANGLES, PARTS)
def test_rotations_follow_the_arc_between_them(axis1, axis2, angle1, angle2, part):
    a, b = _rotation(axis1, angle1), _rotation(axis2, angle2)
    if (a.inv() * b).magnitude() > math.pi - 1e-4:
        return
    motion = iso.Motion({0.0: _placement(a), 2.0: _placement(b)})
    expected = Slerp([0, 2], Rotation.concatenate([a, b]))(2 * part).as_matrix()
    np.testing.assert_allclose(motion.at(2 * part).matrix[:3, :3], expected, atol=1e-9)


@given(AXES, ANGLES, st.tuples(STRETCHES, STRETCHES, STRETCHES), AXES, NUMBERS, PARTS)
def test_stretch_and_offset_go_straight_beside_the_rotation(axis, angle, sizes, frame_axis, x, part):
    frame = _rotation(frame_axis, 1.0).as_matrix()
    stretch = frame @ np.diag(sizes) @ frame.T
    motion = iso.Motion({0: IDENTITY, 1: _placement(_rotation(axis, angle), (x, 1, 2), stretch)})
    between = motion.at(part).matrix
    expected = _rotation(axis, part * angle).as_matrix() @ ((1 - part) * np.eye(3) + part * stretch)
    np.testing.assert_allclose(between[:3, :3], expected, atol=1e-7)
    np.testing.assert_allclose(between[:3, 3], part * np.array([x, 1, 2]), atol=1e-9)


@given(AXES, ANGLES, PARTS)
def test_mirrored_placements_stay_mirrored(axis, angle, part):
    a = IDENTITY.mirror("x")
    motion = iso.Motion({0: a, 1: a.rotate(axis, angle)})
    linear = motion.at(part).matrix[:3, :3]
    assert np.linalg.det(linear) == pytest.approx(-1)
    np.testing.assert_allclose(linear, _rotation(axis, part * angle).as_matrix() @ np.diag([-1, 1, 1]), atol=1e-9)


def test_placements_are_met_exactly_and_held_before_and_after():
    a, b, c = IDENTITY, IDENTITY.rotate("y", 1).translate((1, 2, 3)), IDENTITY.scale(3)
    motion = iso.Motion({2: c, 0: a, 1: b})
    assert motion.times == (0.0, 1.0, 2.0)
    assert [motion.at(time) for time in (-1, 0, 2, 5)] == [a, a, c, c]
    np.testing.assert_allclose(motion.at(1).matrix, b.matrix, atol=1e-15)


@given(AXES, st.floats(-40, 40), PARTS)
def test_a_turn_goes_all_the_way_round(axis, angle, part):
    start = IDENTITY.rotate("x", 0.3).translate((1, 2, 3))
    motion = iso.Motion.turn(axis, angle, (1.0, 3.0), start)
    expected = start.matrix @ _placement(_rotation(axis, part * angle)).matrix
    np.testing.assert_allclose(motion.at(1 + 2 * part).matrix, expected, atol=1e-9)


def test_motions_print_compare_and_move_as_placements_do():
    motion = iso.Motion({0: IDENTITY, 1: IDENTITY.translate((1, 0, 0))})
    assert eval(repr(motion), {"Motion": iso.Motion, "Transform": iso.Transform}) == motion
    assert hash(motion) == hash(iso.Motion([(1, IDENTITY.translate((1, 0, 0))), (0, IDENTITY)]))
    moved = motion.rotate("y", 0.5).scale(2).translate((0, 1, 0))
    expected = motion.at(0.25).rotate("y", 0.5).scale(2).translate((0, 1, 0))
    np.testing.assert_allclose(moved.at(0.25).matrix, expected.matrix, atol=1e-12)


@pytest.mark.parametrize(
    ("placements", "said"),
    [
        ({0: IDENTITY}, "two different times"),
        ([(0, IDENTITY), (0.0, IDENTITY)], "two different times"),
        ({0: IDENTITY, 1: IDENTITY.rotate("y", math.pi)}, "half a turn"),
        ({0: IDENTITY, 1: IDENTITY.mirror("y")}, "mirror"),
        ({0: IDENTITY, math.nan: IDENTITY}, "finite"),
        ({0: IDENTITY, 1: np.eye(4)}, "Transform"),
        (5, "placements"),
        ({"a": IDENTITY, "b": IDENTITY}, "finite"),
    ],
)
def test_motions_without_a_way_are_refused(placements, said):
    with pytest.raises(iso.SceneError, match=said):
        iso.Motion(placements)


@pytest.mark.parametrize("times", [(0,), 3, (0, math.inf)])
def test_turns_need_two_times(times):
    with pytest.raises(iso.SceneError, match="times"):
        iso.Motion.turn("y", 1.0, times)


def test_items_stand_where_their_motion_has_them():
    ball = iso.Item(iso.sphere(1), transform=iso.Motion({0: IDENTITY, 1: IDENTITY.translate((4, 0, 0))}))
    np.testing.assert_allclose(ball.bounds, [[-1, -1, -1], [5, 1, 1]])
    np.testing.assert_allclose(ball.still(0.5).bounds, [[1, -1, -1], [3, 1, 1]])
    np.testing.assert_allclose(ball.at((0, 1, 0)).still(1).bounds, [[3, 0, -1], [5, 2, 1]])
    still = iso.Item(iso.sphere(1))
    assert still.still(3) is still


def test_cameras_go_where_their_motion_has_them():
    start, end = iso.Transform.look_at((0, 0, 5), (0, 0, 0)), iso.Transform.look_at((5, 0, 5), (5, 0, 0))
    camera = iso.Camera((0, 0, 5), (0, 0, 0), motion=iso.Motion({0: start, 1: end}), shutter=(0, 1), lens_radius=0.1)
    half = camera.still(0.5)
    np.testing.assert_allclose(half.eye, (2.5, 0, 5))
    np.testing.assert_allclose(half.target, (2.5, 0, 0))
    assert half.focus == camera.focus == 5
    assert half.motion is None
    parallel = iso.OrthographicCamera((0, 0, 5), (0, 0, 0), motion=camera.motion).still(1)
    np.testing.assert_allclose(parallel.eye, (5, 0, 5))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"shutter": (1, 0)}, "before it closes"),
        ({"shutter": 0.5}, "shutter"),
        ({"motion": IDENTITY}, "Motion"),
        ({"motion": iso.Motion({0: IDENTITY, 1: IDENTITY.scale(2)})}, "turn and move"),
    ],
)
def test_shutters_and_motions_without_sense_are_refused(changes, said):
    with pytest.raises(iso.SceneError, match=said):
        iso.Camera((0, 0, 5), (0, 0, 0)).with_(**changes)


def test_scenes_move_where_something_does_while_the_shutter_is_open():
    motion = iso.Motion({0: IDENTITY, 1: IDENTITY.translate((4, 0, 0))})
    camera = iso.Camera((0, 0, 5), (0, 0, 0))
    scene = iso.Scene([iso.Item(iso.sphere(1), transform=motion)], camera=camera)
    assert not scene.moves
    assert scene.with_(camera=camera.with_(shutter=(0, 0.5))).moves
    assert not scene.with_(camera=camera.with_(shutter=(1, 2))).moves
    stands = scene.with_(camera=camera.with_(shutter=(0, 1))).still()
    np.testing.assert_allclose(stands.bounds, [[1, -1, -1], [3, 1, 1]])
    assert stands.still() is stands
