"""The rules on any tree: none crashes, and they agree with a search that knows nothing of them."""

import math
from typing import Any

import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.lower import lower
from rosorin_compile.language.validate import validate
from rosorin_compile.model.drive import Twist, drive_kinematics
from rosorin_compile.rules.check import check
from rosorin_compile.source.diagnostics import NOTE, Source, has_errors
from rosorin_compile.source.load import parse_yaml
from support.robots import rules


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=7), st.integers(1, 6))
@settings(max_examples=400, deadline=None)
def test_what_is_no_tree_is_refused_and_a_tree_is_not(pairs, count):
    """Any set of joints between a few links: the rules agree with a search from every link."""
    links = {f"link{n}": {} for n in range(count)}
    joints = {f"j{i}": {"type": "fixed", "parent": f"link{a}", "child": f"link{b}"} for i, (a, b) in enumerate(pairs)}
    known = all(a < count and b < count for a, b in pairs)
    reached = {n: {n} for n in range(count)}
    for _ in range(count):
        for a, b in pairs if known else ():
            for seen in reached.values():
                seen |= {b} if a in seen else set()
    is_tree = known and len(pairs) == count - 1 and any(len(seen) == count for seen in reached.values())
    said = rules({"robot": "made", "links": links, "joints": joints})
    assert (said == []) == is_tree, said
    assert set(said) <= {"unknown-link", "two-parents", "joint-cycle", "several-roots", "unreached-link"}


NAMES = st.sampled_from(
    ["base_link", "arm", "hand", "laser", "map", "odom", "a_optical", "b_optical_frame", "bas_link", "j1", "j2"]
)
JOINTS = st.sampled_from(["j1", "j2", "j3", "wrist", "jj"])
NODES = st.sampled_from(["ekf", "slam", "tf_1", "tf-2", "robot_state_publisher"])
# Quantities of all kinds: most places refuse most of them before a rule sees them.
NUMBERS = st.sampled_from(
    [0, -1, 1, 0.5, 90, -90, 1e-12, 1e300, -1e300, math.pi, "30 deg", "5 mm", "2 kg", "3 N*m", "1 N", "1 rad/s"]
)
BARE = st.sampled_from([0, -1, 1, 0.5, 90, 1e-12, 1e300, -1e300, 5e-324])
ANGLES = st.lists(st.sampled_from([0, 90, -1.5707963, 1.5707963, "90 deg", 1e300]), min_size=3, max_size=3)
LENGTHS = st.lists(st.sampled_from([0, 46.6, "46.6 mm", 1e300]), min_size=3, max_size=3)
VECTOR = st.lists(BARE, min_size=3, max_size=3)
WHEN = st.sampled_from(
    ["", "slam", "not slam", "slam or gps", "slm", "1", "slam and not slam", "(", "slam.x", "m", " slam ", "9**9**9"]
)


def some(**entries: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    """Make mappings with any of the entries; those with a capital first letter are always there."""
    always = {key.lower(): value for key, value in entries.items() if key[0].isupper()}
    return st.fixed_dictionaries(
        always, optional={key: value for key, value in entries.items() if not key[0].isupper()}
    )


PUBLISHER = st.one_of(NODES, NODES.map(lambda name: {"static_transform_publisher": name}), st.just({"none": "why"}))
SOURCE = some(Status=st.sampled_from(["stand_in", "factory"]), note=st.sampled_from(["", "a", "b\x07"]))
MIMIC = some(Joint=JOINTS, multiplier=BARE, offset=st.sampled_from([0, 1, "5 deg", "5 mm"]))
LIMITS = some(
    lower=st.sampled_from([-1, 0, -90, "-30 deg", "-5 mm"]),
    upper=st.sampled_from([-1, 0, 1, 90, "30 deg", "5 mm"]),
    effort=st.sampled_from([-1, 0, 1, "3 N*m", "1 N"]),
    velocity=st.sampled_from([-1, 0, 1, "1 rad/s", "1 m/s"]),
    source=SOURCE,
)
INERTIA = some(Ixx=BARE, Iyy=BARE, Izz=BARE, ixy=BARE, ixz=BARE, iyz=BARE)
LINK = some(inertial=some(Mass=BARE, Inertia=INERTIA, rpy=ANGLES), source=SOURCE)
JOINT = some(
    Type=st.sampled_from(["fixed", "revolute", "continuous", "prismatic"]),
    Parent=NAMES,
    Child=NAMES,
    xyz=LENGTHS,
    rpy=ANGLES,
    axis=VECTOR,
    limit=LIMITS,
    mimic=MIMIC,
    dynamics=some(damping=BARE, armature=st.sampled_from([0, "1 kg", "1 kg*m^2"])),
    actuator=some(Kp=BARE),
    publisher=PUBLISHER,
    source=SOURCE,
)
OPTICAL = some(Frame=NAMES, joint=JOINTS, rpy=ANGLES, publisher=PUBLISHER)
SENSOR = some(
    Type=st.just("camera"), Parent=NAMES, Frame=NAMES, joint=JOINTS, rpy=ANGLES, publisher=PUBLISHER, optical=OPTICAL
)
EDGE = some(Parent=NAMES, Child=NAMES, publisher=NODES, when=WHEN, moving=st.booleans(), rpy=ANGLES)
SERVOS = some(
    Joints=st.lists(JOINTS, min_size=1, max_size=3),
    Rad_per_pulse=BARE,
    Zero_pulse=st.just(500),
    Pulse_range=st.just([0, 1000]),
)
POSE = some(
    positions=st.dictionaries(JOINTS, NUMBERS, max_size=3),
    pulses=st.dictionaries(JOINTS, st.integers(0, 1000), max_size=2),
)
WHEELS = st.lists(JOINTS, min_size=1, max_size=3)
STEERED = some(Steering=WHEELS, Driven=WHEELS, rolling=WHEELS)
DRIVE = some(
    mecanum=some(Front_left=JOINTS, Rear_left=JOINTS, Front_right=JOINTS, Rear_right=JOINTS),
    differential=some(Left=WHEELS, Right=WHEELS),
    omni=some(Wheels=WHEELS),
    tricycle=some(Steering=JOINTS, Driven=WHEELS, rolling=WHEELS),
    ackermann=STEERED,
    frame=NAMES,
    radius=BARE,
)
OUTPUT = some(
    File=st.sampled_from(["a.urdf", "A.urdf", "a.urdf/b", "../x", "/x", "x\\y", "C:x", "a//b", ".", " ", ".git/x"]),
    backend=st.sampled_from([*FORMATS, "urfd"]),
    joints=st.lists(JOINTS, max_size=2),
    rename=st.dictionaries(NAMES, NAMES, max_size=2),
    servos=st.sampled_from(["s1", "s3"]),
    base=st.just("free"),
)
DESCRIPTION = some(
    Robot=st.just("made"),
    Links=st.dictionaries(NAMES, LINK, max_size=5),
    Joints=st.dictionaries(JOINTS, JOINT, max_size=5),
    sensors=st.dictionaries(st.sampled_from(["s1", "s2"]), SENSOR, max_size=2),
    edges=st.lists(EDGE, max_size=4),
    Publishers=st.just({"ekf": None, "slam": {"node": "tf_1"}, "tf_1": None, "tf-2": None}),
    modes=st.sampled_from([{"slam": None}, {"slam": None, "gps": None}, {}]),
    servos=st.dictionaries(st.sampled_from(["s1", "s2"]), SERVOS, max_size=2),
    poses=st.dictionaries(st.sampled_from(["p1", "p2"]), POSE, max_size=2),
    disabled_contacts=st.lists(some(Links=st.lists(NAMES, min_size=2, max_size=2), Reason=st.just("r")), max_size=2),
    drive=DRIVE,
    outputs=st.dictionaries(st.sampled_from([*FORMATS, "own"]), OUTPUT, max_size=3),
    source=SOURCE,
)


@given(DESCRIPTION)
@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
def test_no_rule_crashes(description):
    tree = parse_yaml(Source("robot.yaml", yaml.safe_dump(description, sort_keys=False, allow_unicode=True)))
    if has_errors(validate(tree, FORMATS)):
        return
    lowered = lower(tree)
    if lowered.robot is None:
        return
    first = check(lowered.robot, tree, lowered.places, FORMATS)
    assert first == check(lowered.robot, tree, lowered.places, FORMATS)
    for diagnostic in first:
        assert diagnostic.span is not None, diagnostic
        line = diagnostic.span.source.line(diagnostic.span.line)
        assert 0 < diagnostic.span.column <= len(line) + 1, diagnostic
        assert all(related.span is not None for related in diagnostic.related), diagnostic
        assert diagnostic.with_help().help or diagnostic.severity == NOTE, diagnostic


TURNING = some(
    Type=st.sampled_from(["continuous", "revolute", "prismatic"]), Axis=VECTOR, xyz=LENGTHS, rpy=ANGLES, mimic=MIMIC
)
SHAPE = st.one_of(
    st.builds(lambda radius: {"sphere": {"radius": radius}}, BARE),
    st.builds(lambda radius, length: {"cylinder": {"radius": radius, "length": length}}, BARE, BARE),
    st.just({"box": {"size": [1, 1, 1]}}),
)
ONE_KIND = st.one_of(
    *(
        st.builds(lambda kind, wheels, more: {kind: wheels, **more}, st.just(kind), wheels, some(radius=BARE))
        for kind, wheels in (
            ("mecanum", some(Front_left=JOINTS, Rear_left=JOINTS, Front_right=JOINTS, Rear_right=JOINTS)),
            ("differential", some(Left=WHEELS, Right=WHEELS)),
            ("omni", some(Wheels=st.lists(JOINTS, min_size=3, max_size=4, unique=True))),
            ("tricycle", some(Steering=JOINTS, Driven=WHEELS, rolling=WHEELS)),
            ("ackermann", some(Steering=st.lists(JOINTS, min_size=2, max_size=2), Driven=WHEELS)),
        )
    )
)


@given(st.lists(TURNING, min_size=5, max_size=5), st.lists(SHAPE, min_size=5, max_size=5), ONE_KIND)
@settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
def test_no_rule_about_drives_crashes(turning, shapes, drive):
    """Wheels anywhere on one tree, of any size; what no rule refuses has kinematics."""
    names = ["j1", "j2", "j3", "wrist", "jj"]
    links: dict[str, Any] = {"base": {}}
    joints = {}
    for name, joint, shape in zip(names, turning, shapes, strict=True):
        links[f"{name}_link"] = {"collision": [shape]}
        joints[name] = {"parent": "base", "child": f"{name}_link", **joint}
    description = {"robot": "made", "links": links, "joints": joints, "drive": drive}
    tree = parse_yaml(Source("robot.yaml", yaml.safe_dump(description, sort_keys=False)))
    if has_errors(validate(tree, FORMATS)):
        return
    lowered = lower(tree)
    if lowered.robot is None:
        return
    if not has_errors(check(lowered.robot, tree, lowered.places, FORMATS)):
        driving = drive_kinematics(lowered.robot)
        assert all(math.isfinite(speed) for speed in driving.speeds(Twist(1.0, 0.0, 0.5)).values())
