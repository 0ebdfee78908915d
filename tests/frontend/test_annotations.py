"""What the schema says of names, and the walkers that read it."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.language.expand.placing import Use, placed
from rosorin_compile.language.schema import of_parts
from rosorin_compile.language.suppressions import names_at
from rosorin_compile.language.symbols import SymbolTable
from rosorin_compile.source.load import load_mapping
from rosorin_compile.source.tree import Instance, Map, at


def tree(folder: Path, text: str) -> Map:
    """Return the tree of a text."""
    path = folder / "some.yaml"
    path.write_text(text, "utf-8")
    return load_mapping(path, "some.yaml")


def names_of_tree(fragment: Map) -> SymbolTable:
    return SymbolTable(fragment)


def test_what_a_fragment_gives_and_what_follows_from_it(tmp_path: Path) -> None:
    names = names_of_tree(
        tree(
            tmp_path,
            """\
links: {plate: {sites: {dimple: {}}, mjcf_elements: ['<geom name="pad"/>']}}
joints: {float: {type: floating, parent: mount, child: plate, actuator: {name: motor}}}
sensors: {eye: {type: camera, parent: plate, frame: eye_frame, optical: {frame: eye_optical}}}
control: {board: {plugin: some/Plugin, sensors: {gauge: {}}, gpio: {lamp: {}}}}
""",
        )
    )
    assert names.of["link"] == {"plate", "eye_frame", "eye_optical"}
    moving = {"float", "float_TX", "float_TY", "float_TZ", "float_R"}
    assert names.of["joint"] == {*moving, "eye_frame_joint", "eye_optical_joint"}
    assert names.of["actuator"] == {"motor"}
    assert names.of["hardware sensor"] == {"gauge"}
    assert names.mounted
    assert names.inside
    assert names.gives("site", "plate")  # a frame is a site of the MJCF, too
    assert names.gives("shape", "plate_collision_1")
    assert names.gives("shape", "pad")
    assert not names.gives("link", "float")
    assert not names.gives("joint", "plate")


@pytest.mark.parametrize(
    ("text", "mounted"),
    [
        ("joints: {a: {type: fixed, parent: mount, child: b}}", True),
        ("joints: {mount: {type: fixed, parent: a, child: b}}", False),
        ("moveit: {spheres: {mount: []}}", True),
        ("moveit: {joint_properties: {mount: {}}}", False),
        ("disabled_contacts: [{links: [b, mount]}]", True),
        ("urdf_elements: ['<gazebo reference=\"mount\"/>']", True),
        ("urdf_elements: ['<a><bodyName>mount</bodyName></a>']", False),  # only seems to be a name
        ("urdf_elements: ['<gazebo reference=\"mount_2\"/>']", False),
        ('mjcf: [\'<contact><exclude body1="mount" body2="b"/></contact>\']', True),
        ("mjcf: ['<sensor><force site=\"mount\"/></sensor>']", True),
        ("mjcf: ['<actuator><motor joint=\"mount\"/></actuator>']", False),
        ("links: {b: {mjcf_elements: ['<camera target=\"mount\"/>']}}", True),
        ("links: {b: {mjcf_elements: ['<geom material=\"mount\"/>']}}", False),
        ("mjcf: ['<option body=\"mount\"/>']", False),  # of settings
        ("links: {b: {mjcf_elements: [5]}}", False),
        ("edges: [{parent: b, child: c, when: mount}]", False),
        ("controllers: {c: {params: {frame: mount}}}", False),
        ("poses: {home: {positions: {mount: 0}}}", False),
    ],
)
def test_what_sits_on_the_mount_or_names_it(text: str, mounted: bool, tmp_path: Path) -> None:
    assert SymbolTable(tree(tmp_path, text)).mounted is mounted


def test_a_part_that_is_placed_calls_its_own_things_anew_and_nothing_else(tmp_path: Path) -> None:
    fragment = tree(
        tmp_path,
        """\
links: {arm: {mjcf_elements: ['<site name="tip"/><geom material="steel"/>']}, hand: {}}
joints: {elbow: {type: revolute, parent: mount, child: arm}}
control: {board: {plugin: some/Plugin, gpio: {lamp: {}}}}
controllers: {runner: {type: a, params: {joints: [elbow, wheel], gains: {elbow: {p: 1}, wheel: {p: 2}},
  interfaces: [elbow/position, lamp/state], frame: mount, number: 5}}}
mjcf: ['<contact><exclude body1="arm" body2="mount"/></contact>',
  '<sensor><force site="tip"/><touch site="other"/></sensor>',
  '<contact><pair geom1="arm_collision_1" geom2="floor"/></contact>']
urdf_elements: ['<gazebo reference="arm"/><gazebo reference="wheel"/>']
""",
    )
    made = placed(fragment, Use("l_", "base", [1, 0, 0], None, None))
    assert list(made["links"]) == ["l_arm", "l_hand"]
    assert made["links"]["l_arm"]["mjcf_elements"] == ['<site name="l_tip"/><geom material="steel"/>']
    assert made["joints"]["l_elbow"]["parent"] == "base"
    assert made["controllers"]["l_runner"]["params"] == {
        "joints": ["l_elbow", "wheel"],
        "gains": {"l_elbow": {"p": 1}, "wheel": {"p": 2}},
        "interfaces": ["l_elbow/position", "l_lamp/state"],
        "frame": "base",
        "number": 5,
    }
    assert made["mjcf"] == [
        '<contact><exclude body1="l_arm" body2="base"/></contact>',
        '<sensor><force site="l_tip"/><touch site="other"/></sensor>',
        '<contact><pair geom1="l_arm_collision_1" geom2="floor"/></contact>',
    ]
    assert made["urdf_elements"] == ['<gazebo reference="l_arm"/><gazebo reference="wheel"/>']
    assert fragment["joints"]["elbow"]["parent"] == "mount"  # what was given stays as it was


def test_nothing_is_given_where_values_have_the_wrong_form(tmp_path: Path) -> None:
    names = SymbolTable(
        tree(tmp_path, "links: [plate]\njoints: {a: 5}\nsensors: {b: [c]}\nmoveit: none\nedges: {a: b}\n")
    )
    assert {kind: set(some) for kind, some in names.of.items() if some} == {"joint": {"a"}, "sensor": {"b"}}
    assert not names.mounted
    assert not names.inside


def test_what_has_the_wrong_form_is_placed_as_it_is(tmp_path: Path) -> None:
    said = """\
links: {arm: {}}
mjcf: {a: b}
urdf_elements: [5]
nothing: {of: it}
sensors: {}
moveit: {nothing: [arm], groups: {all: {links: [arm]}}}
"""
    made = placed(tree(tmp_path, said), Use("l_", "base", None, None, None))
    unchanged = ("mjcf", "urdf_elements", "nothing", "sensors")
    assert [made[key] for key in unchanged] == [{"a": "b"}, [5], {"of": "it"}, {}]
    assert made["moveit"]["nothing"] == ["arm"]
    assert placed(tree(tmp_path, "moveit: none"), Use("l_", "base", None, None, None)) == {"moveit": "none"}


@pytest.mark.parametrize(("mirror", "xyz"), [("x", [-1, 2, 3]), ("y", [1, -2, 3]), ("z", [1, 2, -3])])
def test_a_mirror_is_across_one_axis(mirror: str, xyz: list[int], tmp_path: Path) -> None:
    said = "joints: {elbow: {type: fixed, parent: arm, child: hand, xyz: [1, 2, 3]}}"
    assert placed(tree(tmp_path, said), Use("", None, None, None, mirror))["joints"]["elbow"]["xyz"] == xyz


def test_elements_know_the_part_that_made_them_first(tmp_path: Path) -> None:
    said = tree(tmp_path, "mjcf: ['<camera/>']")
    inner, outer = (Instance(word, said.span, made=True) for word in ("in", "out"))
    said.via = inner
    once = placed(said, Use("", None, None, None, None))
    once.via = outer
    (text,) = placed(once, Use("", None, None, None, None))["mjcf"]
    assert text.via == inner


def test_a_mention_has_the_words_of_the_schema(tmp_path: Path) -> None:
    said = tree(
        tmp_path,
        """\
joints: {hinge: {type: fixed, parent: plate, child: arm, mimic: {joint: other}}}
poses: {home: {positions: {hinge: 0}}}
drive: {mecanum: {front_left: a, front_right: b, rear_left: c, rear_right: d}}
actuators: {pull: {site: dimple, type: motor}}
""",
    )
    assert [
        (one.kind, one.name, one.path, one.key, one.what) for one in SymbolTable(said).references(("link", "joint"))
    ] == [
        ("link", "plate", ("joints", "hinge", "parent"), False, 'the parent of joint "hinge"'),
        ("link", "arm", ("joints", "hinge", "child"), False, 'the child of joint "hinge"'),
        ("joint", "hinge", ("poses", "home", "positions", "hinge"), True, 'in pose "home"'),
        *(
            ("joint", name, ("drive", "mecanum", role), False, f"named as {role.replace('_', ' ')} of the drive")
            for role, name in {"front_left": "a", "front_right": "b", "rear_left": "c", "rear_right": "d"}.items()
        ),
    ]
    (site,) = SymbolTable(said).references(("site",))
    assert (site.path, site.what, site.among) == (
        ("actuators", "pull", "site"),
        'driven by actuator "pull"',
        "simulation",
    )


def test_where_the_schema_has_no_words_the_place_is_said(tmp_path: Path) -> None:
    text = "sensors: {eye: {type: camera, publisher: tracker}}\nedges: [{parent: map, child: odom, publisher: slam}]\n"
    assert {one.name: one.what for one in SymbolTable(tree(tmp_path, text)).references(("publisher",))} == {
        "tracker": 'the publisher of sensor "eye"',
        "slam": "the publisher of edges[0]",
    }
    assert [
        one.name for one in SymbolTable(tree(tmp_path, text)).references(("link",))
    ] == []  # edges have a rule of their own


@pytest.mark.parametrize(
    ("path", "names"),
    [
        ("links.arm", ["arm"]),
        ("links.arm.visual.0.material", ["arm"]),
        ("links.gone.inertial", []),
        ("joints.hinge.limit.lower", ["hinge", "arm"]),
        ("joints.hinge.parent", ["hinge", "arm"]),
        ("joints.loose.type", ["loose"]),
        ("sensors.eye", ["eye_frame_joint", "eye_frame"]),
        ("sensors.eye.optical.rpy", ["stalk", "eye_optical"]),
        ("sensors.blind.type", []),
        ("actuators.motor.kp", ["motor"]),
        ("poses.home", []),
        ("poses.home.positions.hinge", ["hinge"]),
        ("drive.frame", ["arm"]),
        ("drive.mecanum.front_left", ["hinge"]),
        ("moveit.virtual_joint.name", ["world_joint"]),
        ("moveit.groups.all.chain.base", ["arm"]),
        ("servos.quad.joints.0", ["hinge"]),
        ("robot", []),
        ("nothing.of.it", []),
    ],
)
def test_what_is_wrong_is_accepted_of_the_names_that_the_schema_says(
    path: str, names: list[str], tmp_path: Path
) -> None:
    said = tree(
        tmp_path,
        """\
robot: some
links: {arm: {visual: [{material: steel}]}}
joints: {hinge: {type: fixed, parent: plate, child: arm}, loose: {type: fixed}}
sensors: {eye: {frame: eye_frame, optical: {frame: eye_optical, joint: stalk}}, blind: {type: camera}}
actuators: {motor: {type: motor, kp: 1}}
poses: {home: {positions: {hinge: 0}}}
drive: {frame: arm, mecanum: {front_left: hinge}}
moveit: {virtual_joint: {name: world_joint}, groups: {all: {chain: {base: arm}}}}
servos: {quad: {joints: [hinge]}}
""",
    )
    assert list(names_at(said, tuple(int(step) if step.isdigit() else step for step in path.split(".")))) == names


def test_what_may_stand_in_a_part_is_what_editors_are_told() -> None:
    from rosorin_compile.language.schema import schema

    part = set(schema("authoring")["definitions"]["part"]["properties"])
    assert part - {"help", "params", "let", "use"} == set(of_parts())


def test_a_tree_returns_the_value_at_a_path(tmp_path: Path) -> None:
    loaded = tree(tmp_path, "links: {plate: {sites: [{mass: 2}]}}\n")
    assert at(loaded, ("links", "plate", "sites", 0, "mass")) == 2
    assert at(loaded, ("links", "nothing")) is None
