"""What a type of sensor brings to a simulation: types of your own in YAML, templates, mistakes, and reading back."""

from __future__ import annotations

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.model import Pose  # noqa: E402
from support.robots import compiled  # noqa: E402
from support.simulator import distance, emitted, load, probe, rays, room, said, sensor, written  # noqa: E402

SONAR_RING = """links: {base_link: {}}
sensor_types:
  sonar_ring:
    help: sonars all around
    params:
      count: {type: integer, default: 8, min: 2, max: 64, help: number of sonars}
      radius: {type: length, default: 0.1 m}
    mjcf:
      - sensor: rangefinder
        name: beam
        xyz: ["${radius}", 0, 0]
        rpy: [0, 90 deg, 0]
        replicate: {count: "${count}", rpy: [0, 0, "${360*deg / count}"]}
        attributes: {cutoff: 4}
  magnetometer:
    mjcf:
      - sensor: magnetometer
      - {sensor: clock, name: time, attributes: {site: }}
sensors:
  ring: {type: sonar_ring, parent: base_link, frame: ring, rpy: [0, 0, 30 deg], with: {count: 12, radius: 200 mm}}
  compass: {type: magnetometer, parent: base_link, frame: compass, rpy: [0, 0, 90 deg]}
"""


def test_a_type_of_your_own_is_yaml_alone(tmp_path):
    found = probe(tmp_path, SONAR_RING, room())
    readings = rays(found, "ring_beam")
    for index, reading in enumerate(readings):
        angle = np.radians(30 + 30 * index)
        direction = np.array([np.cos(angle), np.sin(angle), 0])
        assert reading == pytest.approx(distance(0.2 * direction, direction), abs=1e-9)
    field = found[0].opt.magnetic
    np.testing.assert_allclose(said(found, "compass"), [field[1], -field[0], field[2]], atol=1e-12)
    assert said(found, "compass_time")[0] == 0


TEMPLATED = """sensor_types:
  whiskers:
    params: {count: 3}
    mjcf:
      - {template: whiskers.xml.jinja, name: hair, frame: parent, attributes: {count: "${count}"}}
      - {template: reading.xml.jinja, section: sensor, name: hair, attributes: {count: "${count}"}}
sensors:
  snout: {type: whiskers, parent: base_link, frame: snout, with: {count: 2}}
"""
WHISKERS = """{% for i in range(element.attributes.count | int) %}
<site name="{{ element.name }}_{{ i }}" pos="{{ vector([0.1 * i, 0, 0]) }}" quat="0 1 0 0" size="{{ number(0.01) }}"/>
{% endfor %}
"""
READING = """{% for i in range(element.attributes.count | int) %}
<rangefinder name="{{ sensor.name }}_{{ i }}" site="{{ element.name }}_{{ i }}"/>
{% endfor %}
"""


def test_a_type_may_bring_text_of_its_own_by_a_template(tmp_path):
    path = written(tmp_path, TEMPLATED)
    (path.parent / "whiskers.xml.jinja").write_text(WHISKERS, "utf-8")
    (path.parent / "reading.xml.jinja").write_text(READING, "utf-8")
    made = compiled(path)
    assert {file.name for file in made.inputs} >= {"whiskers.xml.jinja", "reading.xml.jinja"}
    model, data = load(made.artifacts[0].text.replace("<worldbody>", f"<worldbody>{room()}"))
    np.testing.assert_allclose(rays((model, data), "snout"), [0.7, 0.7], atol=1e-12)
    assert model.body(model.site("snout_hair_1").bodyid[0]).name == "base_link"


@pytest.mark.parametrize("rpy", [(0.3, 0, 0), (0, -0.5, 0), (0, 0, 0.9), (0, 0, 0)])
def test_copies_turn_as_the_description_says(tmp_path, rpy):
    text = f"""sensor_types:
  fan:
    mjcf:
      - {{body: site, name: blade, xyz: [0.1, 0, 0], replicate: {{count: 3, xyz: [0, 0.2, 0], rpy: {list(rpy)}}}}}
sensors:
  fan: {{type: fan, parent: base_link, frame: fan}}
"""
    _, data = probe(tmp_path, text)
    step, at = Pose((0, 0.2, 0), rpy).transform(), Pose((0.1, 0, 0)).transform()
    for index in range(3):
        np.testing.assert_allclose(data.site(f"fan_blade_{index}").xpos, at.xyz, atol=1e-12)
        np.testing.assert_allclose(data.site(f"fan_blade_{index}").xmat.reshape(3, 3), at.rows, atol=1e-12)
        at = step.then(at)


def test_what_mujoco_does_not_know_is_left_to_mujoco(tmp_path):
    """The form of the names is checked here, what they mean there."""
    for element in ("{sensor: girot}", "{sensor: gyro, attributes: {colour: red}}"):
        text = emitted(tmp_path, own_type(element))
        with pytest.raises(ValueError, match=r"girot|colour"):
            mujoco.MjModel.from_xml_string(text)


def own_type(element: str) -> str:
    """Return a description with a type of one element, or of several with their own dashes, and a sensor of it."""
    used = "sensors:\n  it: {type: own, parent: base_link, frame: it}"
    return f"sensor_types:\n  own:\n    mjcf:\n      - {element}\n{used}"


def test_sensors_of_a_type_sit_in_its_link(tmp_path):
    model, _ = load(emitted(tmp_path, sensor("lidar_2d", more=", with: {rays: 72, max_range: 9 m}")))
    assert model.nsensor == 72
    assert list(model.sensor_cutoff) == [9.0] * 72
    sites = [model.sensor_objid[number] for number in range(72)]
    assert {model.body(model.site_bodyid[site]).name for site in sites} == {"probe_link"}
    model, _ = load(emitted(tmp_path, sensor("camera")))
    assert list(model.cam_resolution[model.cam("probe").id]) == [640, 480]
    model, _ = load(emitted(tmp_path, SONAR_RING))
    assert model.sensor("compass_time").type == mujoco.mjtSensor.mjSENS_CLOCK
    assert model.site("compass").id == model.sensor("compass").objid[0]


def test_the_order_of_keys_means_nothing(tmp_path):
    first = emitted(tmp_path, own_type("{sensor: gyro, attributes: {noise: 1, cutoff: 2}}"))
    assert emitted(tmp_path, own_type("{attributes: {cutoff: 2, noise: 1}, sensor: gyro}")) == first
    assert 'site="it" cutoff="2" noise="1"' in first
