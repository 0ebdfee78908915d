"""The types of sensors of the library, judged in MuJoCo: scenes whose right reading is known."""

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.model import Pose  # noqa: E402
from support.engines import rpy_matrix  # noqa: E402
from support.paths import data_text  # noqa: E402
from support.simulator import GRAVITY, distance, emitted, frame, load, no_warning, probe, rays, room, said, sensor  # noqa: E402

pytestmark = pytest.mark.slow

MOUNTS = [(0.0, 0.0, 0.0), (0.0, 0.0, np.pi), (np.pi, 0.0, 0.0), (0.4, -0.9, 2.0), (-np.pi / 2, 0.0, np.pi / 2)]


@pytest.mark.parametrize("rpy", MOUNTS)
@pytest.mark.parametrize(("fov", "count"), [(360, 36), (360, 7), (270, 28), (90, 1), (180, 2)])
def test_lidar_2d_sees_the_room_at_each_of_its_angles(tmp_path, rpy, fov, count):
    xyz = np.array([0.3, 0.2, -0.1])
    given = f", with: {{rays: {count}, fov: {fov} deg}}"
    found = rays(probe(tmp_path, sensor("lidar_2d", rpy, xyz, given), room()), "probe")
    first, step = (-180, 360 / count) if fov == 360 else (-fov / 2, fov / max(count - 1, 1))
    angles = np.radians([first + index * step for index in range(count)]) if count > 1 else np.zeros(1)
    turn = rpy_matrix(*rpy)
    expected = [distance(xyz, turn @ [np.cos(angle), np.sin(angle), 0]) for angle in angles]
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("rpy", MOUNTS)
def test_lidar_3d_sees_the_room_layer_by_layer_from_below(tmp_path, rpy):
    given = ", with: {rays: 10, layers: 4, fov: 200 deg, vertical_fov: 60 deg}"
    found = probe(tmp_path, sensor("lidar_3d", rpy, more=given), room())
    turn = rpy_matrix(*rpy)
    for layer, rise in enumerate(np.radians([-30, -10, 10, 30])):
        angles = np.radians(np.linspace(-100, 100, 10))
        level = np.column_stack((np.cos(angles) * np.cos(rise), np.sin(angles) * np.cos(rise)))
        expected = [distance(np.zeros(3), turn @ [x, y, np.sin(rise)]) for x, y in level]
        np.testing.assert_allclose(rays(found, f"probe_{layer}"), expected, atol=1e-9)


def test_a_ray_leaves_along_x_of_the_frame(tmp_path):
    found = probe(tmp_path, sensor("range_finder", (0, 0, np.pi / 2), (0, 0.5, 0)), room())
    assert said(found, "probe")[0] == pytest.approx(1.0, abs=1e-12)
    site = frame(found[1], "site", "probe_site")
    np.testing.assert_allclose(site[:, 2], frame(found[1], "body", "probe_link")[:, 0], atol=1e-12)


@pytest.mark.parametrize("kind", ["lidar_2d", "lidar_3d", "range_finder"])
def test_what_is_too_far_away_reads_as_the_range_and_what_is_not_there_as_minus_one(tmp_path, kind):
    wall = '<geom type="box" size="0.1 9 9" pos="5.1 0 0"/>'
    ahead = {"lidar_2d": "probe_18", "lidar_3d": "probe_1_06"}.get(kind, "probe")
    assert said(probe(tmp_path, sensor(kind), wall), ahead)[0] == pytest.approx(5.0)
    short = sensor(kind, more=", with: {max_range: 3 m}")
    assert said(probe(tmp_path, short, wall), ahead)[0] == 3.0
    assert said(probe(tmp_path, short), ahead)[0] == -1.0


def test_a_lidar_scans_at_its_rate(tmp_path):
    ball = '<body pos="1 0 0"><freejoint/><geom size="0.1"/></body>'
    text = sensor("lidar_2d", more=", with: {rays: 1, rate: 20 Hz}")
    model, data = probe(tmp_path, text, ball)
    data.qvel[0] = 1.0
    seen = []
    for _ in range(100):
        mujoco.mj_step(model, data)
        seen.append(data.sensor("probe_0").data[0])
    assert len(set(seen)) == 4
    every = probe(tmp_path, sensor("lidar_2d", more=", with: {rays: 1, rate: 0}"), ball)
    assert every[0].sensor_history[0, 0] == 0


@pytest.mark.parametrize("kind", ["camera", "depth_camera"])
@pytest.mark.parametrize("rpy", MOUNTS)
def test_a_camera_looks_out_of_its_image_frame(tmp_path, kind, rpy):
    model, data = probe(tmp_path, sensor(kind, rpy, (0.1, 0.2, 0.3), ", with: {hfov: 90 deg, width: 320, height: 200}"))
    image = frame(data, "body", "probe_link_optical")
    axes = data.cam("probe").xmat.reshape(3, 3)
    np.testing.assert_allclose(axes[:, 0], image[:, 0], atol=1e-12)  # right
    np.testing.assert_allclose(axes[:, 1], -image[:, 1], atol=1e-12)  # up
    np.testing.assert_allclose(axes[:, 2], -image[:, 2], atol=1e-12)  # backwards
    np.testing.assert_allclose(data.cam("probe").xpos, image[:, 3], atol=1e-12)
    forward = rpy_matrix(*rpy) @ [1, 0, 0]
    np.testing.assert_allclose(-axes[:, 2], forward, atol=1e-12)
    assert tuple(model.cam_resolution[0]) == (320, 200)
    assert model.cam_fovy[0] == pytest.approx(2 * np.degrees(np.arctan(200 / 320)), abs=1e-6)


def test_pixels_of_a_camera_lie_where_its_field_of_view_says(tmp_path):
    """MuJoCo measures through each pixel: the first is at the top left, the field of view the one that was given."""
    width, height, half = 8, 4, np.radians(40)
    text = sensor("camera", more=f", with: {{hfov: 80 deg, width: {width}, height: {height}}}")
    model, _ = probe(tmp_path, text)
    xml = emitted(tmp_path, text)
    scan = '<sensor><rangefinder name="scan" camera="probe" data="dist dir"/></sensor></mujoco>'
    seen = load(xml.replace("</mujoco>", scan).replace("<worldbody>", f"<worldbody>{room()}"))
    found = said(seen, "scan").reshape(height, width, 4)
    slope = np.tan(half)
    for row in range(height):
        for column in range(width):
            left = slope * (1 - (2 * column + 1) / width)
            up = slope * (height / width) * (1 - (2 * row + 1) / height)
            expected = np.array([1, left, up]) / np.linalg.norm([1, left, up])
            np.testing.assert_allclose(found[row, column, 1:], expected, atol=1e-6)
            assert found[row, column, 0] == pytest.approx(distance(np.zeros(3), expected), abs=1e-6)
    assert model.ncam == 1


@pytest.mark.parametrize("rpy", MOUNTS)
def test_an_imu_at_rest_reads_gravity_upwards_in_its_own_axes(tmp_path, rpy):
    found = probe(tmp_path, sensor("imu", rpy, (0.1, 0.2, 0.3), ", with: {orientation: true}"))
    expected = rpy_matrix(*rpy).T @ [0, 0, GRAVITY]
    np.testing.assert_allclose(said(found, "probe_accelerometer"), expected, atol=1e-12)
    np.testing.assert_allclose(said(found, "probe_gyro"), 0, atol=1e-12)
    turned = Pose(rpy=rpy).transform().quaternion()
    np.testing.assert_allclose(np.abs(said(found, "probe_orientation") @ turned), 1, atol=1e-12)


TURNTABLE = """links:
  base_link: {}
  table: {inertial: {mass: 1 kg, of: [cylinder: {radius: 100 mm, length: 20 mm}]}}
joints:
  turn: {type: continuous, parent: base_link, child: table, axis: [0, 0, 1]}
"""


def test_an_imu_on_a_turntable_reads_its_speed_and_the_pull_inwards(tmp_path):
    rpy, arm, speed = (0.3, -0.2, 0.9), 0.25, 3.0
    text = TURNTABLE + sensor("imu", rpy, (arm, 0, 0)).replace("parent: base_link", "parent: table")
    model, data = probe(tmp_path, text)
    data.qvel[0] = speed
    mujoco.mj_forward(model, data)
    turn = rpy_matrix(*rpy).T
    np.testing.assert_allclose(said((model, data), "probe_gyro"), turn @ [0, 0, speed], atol=1e-12)
    pull = turn @ [-(speed**2) * arm, 0, GRAVITY]
    np.testing.assert_allclose(said((model, data), "probe_accelerometer"), pull, atol=1e-9)


def test_gnss_reads_where_its_frame_is_in_the_world(tmp_path):
    text = TURNTABLE + sensor("gnss", xyz=(0.5, 0, 0.2)).replace("parent: base_link", "parent: table")
    model, data = probe(tmp_path, text)
    data.qpos[0] = np.pi / 2
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(said((model, data), "probe"), [0, 0.5, 0.2], atol=1e-12)


def test_a_magnetometer_reads_the_field_of_the_world_in_its_axes(tmp_path):
    rpy = (0.3, -0.4, 0.5)
    model, data = probe(tmp_path, TURNTABLE + sensor("magnetometer", rpy))
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(said((model, data), "probe"), rpy_matrix(*rpy).T @ model.opt.magnetic, atol=1e-12)


def test_an_altimeter_reads_the_height_of_its_frame(tmp_path):
    model, data = probe(tmp_path, TURNTABLE + sensor("altimeter", xyz=(0.5, 0, 0.2)))
    mujoco.mj_forward(model, data)
    assert said((model, data), "probe")[2] == pytest.approx(0.2)


FOOT = """links:
  base_link: {collision: [box: {min: [-0.2, -0.2, -0.1], max: [0.2, 0.2, 0]}]}
"""


@pytest.mark.parametrize("surface", ["parent", "sensor"])
def test_a_contact_sensor_feels_the_weight_that_lies_on_it_and_nothing_beside(tmp_path, surface):
    text = FOOT.replace("base_link", "shoe" if surface == "sensor" else "base_link")
    text = text.replace("links:", "links:\n  base_link: {}") if surface == "sensor" else text
    frame_name = "shoe" if surface == "sensor" else "sole"
    at = "xyz: [0.1, 0, 0]" if surface == "parent" else "xyz: [0, 0, 0]"
    text += f"sensors:\n  foot: {{type: contact, parent: base_link, frame: {frame_name}, {at},"
    text += f" with: {{size: [40 mm, 40 mm, 20 mm], surface: {surface}}}}}"
    heavy = '<body pos="{} 0 0.05"><freejoint/><geom size="0.05" mass="{}" condim="3"/></body>'
    on, beside = (0.1, -0.1) if surface == "parent" else (0.0, 0.12)
    model, data = probe(tmp_path, text, heavy.format(on, 2) + heavy.format(beside, 7))
    with no_warning():
        mujoco.mj_step(model, data, 2000)
    assert said((model, data), "foot")[0] == pytest.approx(2 * GRAVITY, rel=1e-3)
    assert data.ncon == 2
    data.qpos[:3] = (0, 0, 5)
    mujoco.mj_forward(model, data)
    assert said((model, data), "foot")[0] == 0


@pytest.mark.parametrize("rpy", MOUNTS)
def test_a_force_torque_sensor_reads_the_weight_and_the_lever_of_what_hangs_on_it(tmp_path, rpy):
    mass, lever = 1.5, np.array([0.2, -0.1, 0.3])
    text = f"""links:
  base_link: {{inertial: {{mass: 9 kg, of: [sphere: {{radius: 0.1}}]}}}}
  tool: {{inertial: {{mass: {mass} kg, of: [sphere: {{radius: 30 mm}}]}}}}
joints:
  grip: {{type: fixed, parent: probe_link, child: tool, xyz: {lever.tolist()}}}
{sensor("force_torque", rpy)}"""
    found = probe(tmp_path, text)
    weight = rpy_matrix(*rpy).T @ [0, 0, mass * GRAVITY]
    np.testing.assert_allclose(said(found, "probe_force"), weight, atol=1e-9)
    np.testing.assert_allclose(said(found, "probe_torque"), np.cross(lever, weight), atol=1e-9)


PART = data_text("robots/sensor_types_part.yaml")


def test_sensors_of_parts_have_the_names_and_the_places_of_their_part(tmp_path):
    model, data = probe(tmp_path, PART)
    assert [model.camera(i).name for i in range(model.ncam)] == ["left_eye", "right_eye"]
    left, right = (-data.cam(f"{side}_eye").xmat.reshape(3, 3)[:, 2] for side in ("left", "right"))
    np.testing.assert_allclose(left, [np.cos(np.radians(20)), np.sin(np.radians(20)), 0], atol=1e-12)
    np.testing.assert_allclose(right, left * [1, -1, 1], atol=1e-12)
    assert model.body("right_eye_optical").id
