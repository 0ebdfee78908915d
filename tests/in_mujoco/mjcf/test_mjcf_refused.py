"""What MuJoCo does not load, and what MJCF cannot say, is told; MuJoCo is the judge."""

from dataclasses import replace

import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.formats.templating import Templates  # noqa: E402
from rosorin_compile.model import Joint, Limit, Link, Mesh, Output, Pose, Robot, Shape, Sphere  # noqa: E402
from rosorin_compile.mujoco.mjcf import write as mjcf  # noqa: E402
from support.machines import BODY, chain  # noqa: E402
from support.reading import leaves_of  # noqa: E402
from support.simulator import BASES, load  # noqa: E402


def emitted(robot: Robot, base: str = "fixed") -> tuple[str, list[str]]:
    text, said = mjcf.write(robot, Output("mjcf", "mjcf", "robot.xml", {"base": base}), Templates())
    return text, [f"{d.severity} {d.rule}" for d in said]


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize(
    "robot",
    [
        chain(child=BODY),
        chain(child=None, fixed_to_child=BODY),
        chain(child=None),
        chain(child=BODY, root=None),
        chain(child=None, root=None),
        chain(child=None, tip=None),
        chain(child=BODY, tip=None),
        chain(child=None, root=None, tip=None),
        replace(chain(child=BODY), links=(Link("root", BODY), Link("child", BODY), Link("tool"), Link("tip"))),
        Robot("alone", (Link("world", BODY),), ()),
        Robot("alone", (Link("base", BODY),), ()),
        Robot("frame", (Link("base"),), ()),
    ],
)
def test_what_mujoco_does_not_load_is_an_error_and_nothing_else_is(robot, base):
    text, said = emitted(robot, base)
    try:
        mujoco.MjModel.from_xml_string(text)
        loads = True
    except ValueError:
        loads = False
    assert loads == (not any(line.startswith("error") for line in said))


@pytest.mark.parametrize(
    ("limit", "warnings"), [(Limit(0.5, 0.5, 1.0), 1), (Limit(-1, 1, 0.0), 1), (Limit(-1, 1, 1.0), 0)]
)
def test_a_limit_that_mujoco_would_take_for_none_is_a_warning(limit, warnings):
    robot = Robot("stuck", (Link("a"), Link("b", BODY)), (Joint("j", "revolute", "a", "b", limit=limit),))
    text, said = emitted(robot)
    assert said.count("warning mjcf-cannot-say") == warnings
    model, _ = load(text)
    assert int(model.jnt_limited[0]) + int(model.jnt_actfrclimited[0]) == 2 - warnings


TETRAHEDRON = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def test_meshes_are_files_that_mujoco_can_open():
    shapes = tuple(Shape(Mesh(file, (0.1, 0.1, 0.2))) for file in ("part.obj", "part.step", "http://host/part.stl"))
    link = Link("a", BODY, visual=shapes, collision=(*shapes, Shape(Mesh("part.obj"))))
    robot = Robot("meshes", (link,), ())
    text, said = emitted(robot)
    assert said == ["warning mjcf-cannot-say"]
    model, _ = load(text, {"part.obj": TETRAHEDRON})
    assert (model.nmesh, model.ngeom) == (2, 3)
    assert model.body_mass.sum() == BODY.mass
    assert (model.mesh_scale[0] == (0.1, 0.1, 0.2)).all()


def test_a_link_called_world_has_a_body_of_another_name():
    links = (Link("world"), Link("world_link", BODY), Link("arm", BODY, collision=(Shape(Sphere(0.1)),)))
    joints = (
        Joint("turn", "continuous", "world", "world_link", Pose((0.0, 0.0, 1.0))),
        Joint("weld", "fixed", "world_link", "arm", Pose((0.0, 0.0, 2.0))),
    )
    robot = Robot("stand", links, joints, disabled_contacts=(("world", "arm"),))
    text, said = emitted(robot)
    assert said == ["note mjcf-cannot-say"]
    model, data = load(text)
    mujoco.mj_forward(model, data)
    assert model.body("world_link_").id == 1
    assert data.site("world").xpos.tolist() == [0, 0, 0]
    assert data.body("arm").xpos.tolist() == [0, 0, 3]
    found = leaves_of("mjcf", text)
    assert found["frame", "world_link", "parent"] == "world"
    assert found["excluded contacts", "excluded contacts", ""] == {"arm - world"}
    assert found["link", "world", "site"] == "world"
