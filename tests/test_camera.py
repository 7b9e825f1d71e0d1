"""Cameras: rays against projection, OpenCV's matrices, lenses, and framing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from isophote import Camera, OrthographicCamera, RenderError, SceneError
from isophote.scene.studio import frame

SIZE = (640, 480)
PLACES = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-50, 50))


def rays(camera, size, x, y, a=0.0, b=0.0):
    m = camera.linear_map(size)
    x, y, a, b = (np.asarray(value, float)[..., None] for value in (x, y, a, b))
    origins = m.o + x * m.ox + y * m.oy + a * m.oa + b * m.ob
    directions = m.d + x * m.dx + y * m.dy + a * m.da + b * m.db
    return origins, directions


CAMERAS = {
    "plain": Camera((3, 2, 4), (0, 0.5, 0)),
    "tilted": Camera((3, 2, 4), (0, 0.5, 0), up=(1, 1, 0), fov_degrees=100),
    "offset": Camera((3, 2, 4), (0, 0.5, 0), principal_point=(0.3, 0.9), pixel_aspect=1.7),
    "lens": Camera((3, 2, 4), (0, 0.5, 0), lens_radius=0.2, focus_distance=3),
    "orthographic": OrthographicCamera((3, 2, 4), (0, 0.5, 0), height=5),
}


@pytest.mark.parametrize("name", CAMERAS)
def test_points_along_a_ray_project_back_to_its_pixel(name):
    camera = CAMERAS[name]
    rng = np.random.default_rng(1)
    x, y, depth = rng.uniform(0, 640, 100), rng.uniform(0, 480, 100), rng.uniform(0.1, 50, 100)
    origins, directions = rays(camera, SIZE, x, y)
    pixels, found = camera.project(origins + depth[:, None] * directions, SIZE)
    assert np.allclose(pixels, np.stack([x, y], -1), atol=1e-9)
    assert np.allclose(found, depth)


def test_conventions():
    camera = Camera((0, 0, 5), (0, 0, 0), fov_degrees=90)
    origin, direction = rays(camera, SIZE, 320, 240)
    assert origin.tolist() == [0, 0, 5]
    assert np.allclose(direction, (0, 0, -1))
    # The top of the picture is up, at the tangent of half the vertical angle; the right is +X.
    assert np.allclose(rays(camera, SIZE, 320, 0)[1], (0, 1, -1))
    assert np.allclose(rays(camera, SIZE, 640, 240)[1], (640 / 480, 0, -1))
    pixels, depth = camera.project([(1, 0, 3), (0, 0, 6), (0, 0, 5)], SIZE)
    assert np.allclose(pixels[0], (320 + 120, 240))
    assert depth.tolist() == [2, -1, 0]
    assert np.isnan(pixels[1:]).all()


def test_a_lens_is_sharp_where_it_is_focused():
    camera = CAMERAS["lens"]
    rng = np.random.default_rng(2)
    angle, radius = rng.uniform(0, 2 * np.pi, 200), np.sqrt(rng.random(200))
    a, b = radius * np.cos(angle), radius * np.sin(angle)
    origins, directions = rays(camera, SIZE, 100.5, 33.5, a, b)
    at_focus = origins + 3 * directions
    assert np.allclose(at_focus, at_focus[0])
    assert np.allclose(camera.project(at_focus, SIZE)[0], (100.5, 33.5))
    # The lens is a disk of its radius around the eye, across the viewing axis.
    away = origins - camera.eye
    assert np.allclose(np.linalg.norm(away, axis=1), 0.2 * radius)
    assert np.allclose(away @ camera.axes[2], 0)
    assert np.allclose(directions @ -camera.axes[2], 1)


def test_without_a_focus_distance_the_target_is_sharp():
    camera = Camera((0, 0, 5), (0, 3, 1), lens_radius=0.5)
    assert camera.focus == 5
    origins, directions = rays(camera, SIZE, 320, 240, [0, 1, 0], [0, 0, -1])
    assert np.allclose(origins + 5 * directions, (0, 3, 1))


@given(
    st.floats(1, 1e5), st.floats(1, 1e5), st.floats(-3000, 3000), st.floats(-3000, 3000),
    st.floats(-4, 4), st.floats(-1.5, 1.5), st.floats(-4, 4),
    st.tuples(*[st.floats(-1e6, 1e6)] * 3), st.integers(1, 4000), st.integers(1, 4000),
)  # fmt: skip
def test_opencv_matrices_make_a_round_trip(fx, fy, cx, cy, yaw, pitch, roll, offset, width, height):
    R = turn(2, roll) @ turn(0, pitch) @ turn(1, yaw)
    K, t = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), np.array(offset)
    camera = Camera.from_opencv(K, R, t, (width, height))
    again_K, again_R, again_t = camera.to_opencv((width, height))
    assert np.allclose(again_K, K, rtol=1e-10, atol=1e-9)
    assert np.allclose(again_R, R, atol=1e-12)
    assert np.allclose(again_t, t, rtol=1e-12, atol=1e-9)


def turn(axis, angle):
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[[i, i, j, j], [i, j, i, j]] = [math.cos(angle), -math.sin(angle), math.sin(angle), math.cos(angle)]
    return matrix


def test_opencv_projection_agrees_but_for_half_a_pixel():
    rng = np.random.default_rng(3)
    K = np.array([[500, 0, 310], [0, 620, 250.5], [0, 0, 1]])
    R, t = turn(0, 0.3) @ turn(1, -0.8), np.array([0.3, -0.2, 4])
    points = rng.uniform(-1, 1, (50, 3))
    in_camera = points @ R.T + t
    homogeneous = in_camera @ K.T
    pixels, depth = Camera.from_opencv(K, R, t, SIZE).project(points, SIZE)
    assert np.allclose(pixels - 0.5, homogeneous[:, :2] / homogeneous[:, 2:])
    assert np.allclose(depth, in_camera[:, 2])


def test_the_middle_of_an_opencv_picture_is_the_middle_of_a_camera():
    camera = Camera((1, 2, 3), (0, 0, 0))
    K, _, _ = camera.to_opencv(SIZE)
    assert K[:2, 2].tolist() == [319.5, 239.5]
    assert K[0, 0] == pytest.approx(240 / math.tan(math.radians(20)))


@pytest.mark.parametrize("aspect", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("scale", [1e-4, 1, 1e5])
@given(PLACES, PLACES, st.sampled_from([(0, 1, 0), (1, 0, 0), (0, -1, 0), (1, 2, 3)]), st.floats(5, 150))
def test_framing_has_everything_in_the_picture(aspect, scale, a, b, direction, fov):
    box = scale * np.stack([np.minimum(a, b), np.maximum(a, b)])
    assume(np.linalg.norm(box[1] - box[0]) > 1e-5 * np.abs(box).max())
    camera = frame(box, direction, fov, aspect)
    height = 1000
    width = round(aspect * height)
    corners = np.array([[box[i, 0], box[j, 1], box[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    pixels, depth = camera.project(corners, (width, height))
    assert (depth > 0).all()
    assert (pixels > 0).all()
    assert (pixels < (width, height)).all()
    assert np.allclose(camera.project(box.mean(axis=0), (width, height))[0], (width / 2, height / 2), atol=0.01)


def test_framing_is_tight():
    camera = frame([(-1, -1, -1), (1, 1, 1)], (0, 0, 1), 40)
    # The silhouette of the sphere around the box fills most of the height.
    half = math.asin(math.sqrt(3) / np.linalg.norm(camera.eye))
    assert 0.85 < math.tan(half) / math.tan(math.radians(20)) < 1


def test_a_point_can_be_framed_and_the_endless_cannot():
    assert frame([(1, 2, 3), (1, 2, 3)]).target == (1, 2, 3)
    assert frame([(1e6, 0, 0), (1e6, 0, 0)]).eye != frame([(1e6, 0, 0), (1e6, 0, 0)]).target
    with pytest.raises(SceneError, match="camera"):
        frame([(-np.inf, 0, 0), (np.inf, 1, 1)])
    with pytest.raises(SceneError):
        frame([(0, 0, 0), (1, 1, 1)], direction=(0, 0, 0))
    with pytest.raises(SceneError):
        frame([(0, 0, 0), (1, 1, 1)], aspect=0)


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_cameras_are_values(camera):
    again = eval(repr(camera))
    assert again == camera
    assert hash(again) == hash(camera)
    assert np.allclose(camera.transform.apply((0, 0, 0)), camera.eye)
    assert np.allclose(camera.transform.matrix[:3, :3].T, camera.axes)


@pytest.mark.parametrize(
    ("message", "make"),
    [
        ("apart", lambda: Camera((1, 2, 3), (1, 2, 3))),
        ("parallel", lambda: Camera((0, 2, 0), (0, 0, 0))),
        ("parallel", lambda: OrthographicCamera((0, 2, 0), (0, 0, 0))),
        ("fov_degrees", lambda: Camera((0, 0, 1), (0, 0, 0), fov_degrees=0)),
        ("fov_degrees", lambda: Camera((0, 0, 1), (0, 0, 0), fov_degrees=180)),
        ("fov_degrees", lambda: Camera((0, 0, 1), (0, 0, 0), fov_degrees=float("nan"))),
        ("Camera: eye", lambda: Camera((0, 0, float("nan")), (0, 0, 0))),
        ("Camera: eye", lambda: Camera((0, 0), (0, 0, 0))),
        ("Camera: target", lambda: Camera((0, 0, 1), "origin")),
        ("up", lambda: Camera((0, 0, 1), (0, 0, 0), up=(0, 0, 0))),
        ("lens_radius", lambda: Camera((0, 0, 1), (0, 0, 0), lens_radius=-1)),
        ("focus_distance", lambda: Camera((0, 0, 1), (0, 0, 0), focus_distance=0)),
        ("pixel_aspect", lambda: Camera((0, 0, 1), (0, 0, 0), pixel_aspect=0)),
        ("height", lambda: OrthographicCamera((0, 0, 1), (0, 0, 0), height=0)),
        ("skew", lambda: Camera.from_opencv([[1, 1, 0], [0, 1, 0], [0, 0, 1]], np.eye(3), np.zeros(3), SIZE)),
        ("focal", lambda: Camera.from_opencv(np.diag([-1, 1, 1]), np.eye(3), np.zeros(3), SIZE)),
        ("rotation", lambda: Camera.from_opencv(np.eye(3), 2 * np.eye(3), np.zeros(3), SIZE)),
        ("rotation", lambda: Camera.from_opencv(np.eye(3), np.diag([1, 1, -1]), np.zeros(3), SIZE)),
        ("K must be", lambda: Camera.from_opencv(np.eye(2), np.eye(3), np.zeros(3), SIZE)),
    ],
)
def test_what_is_no_camera_is_refused(message, make):
    with pytest.raises(SceneError, match=message):
        make()


@pytest.mark.parametrize("size", [(0, 10), (10, -1), (10,), 10, (1.5, 2), "ab", None])
@pytest.mark.parametrize("camera", [CAMERAS["plain"], CAMERAS["orthographic"]], ids=["perspective", "orthographic"])
def test_what_is_no_size_is_refused(camera, size):
    with pytest.raises(RenderError, match="width, height"):
        camera.linear_map(size)
