"""Plug-ins of Gazebo that drive joints as the actuators of a description do.

An actuator with gains becomes a controller with the same law: ``kp * (command - position) - kv * speed`` or
``kv * (command - speed)``; a motor takes a force. The command of each is a topic of Gazebo. A joint that another
element of the robot drives is left to it: a hardware block of ros2_control, or a plug-in that names the joint.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from xml.sax.saxutils import escape

from rosorin_compile.model import Joint, Output, Robot
from rosorin_compile.model.simulation import CLASSIC, MOTOR, POSITION, VELOCITY, Actuator
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.numbers import NumberFormat
from rosorin_compile.source.wording import plural, quoted
from rosorin_compile.source.xml.elements import tree_of

from .gazebo_elements import distribution
from .unsupported import Unsupported

# gz-sim@gz-sim8:src/systems/{joint_position_controller,joint_controller,apply_joint_force}
_PLUGINS = {
    POSITION: ("joint-position-controller", "JointPositionController"),
    VELOCITY: ("joint-controller", "JointController"),
    MOTOR: ("apply-joint-force", "ApplyJointForce"),
}
_PREFIXES = {"fortress": ("ignition-gazebo", "ignition::gazebo")}
_OTHER_TARGETS = ("body", "crank_site", "joint_in_parent", "reference_site", "site", "slider_site", "tendon")
_GAINS = ("gear", "damping_ratio")
_BY_JOINT = ("name", "range", "unlimited", "mjcf")


def unsupported_drives(output: Output, quiet: bool = False) -> Mapping[str, Unsupported]:
    """Return which keys of actuators an output does not carry; ``quiet`` if it needs none without Gazebo."""
    places = ("actuators.*", "joints.*.actuator")
    gazebo = distribution(output.options.get("gazebo"))
    if gazebo in ("", CLASSIC):
        return dict.fromkeys(places, Unsupported("no drives; newer versions of Gazebo have plug-ins for them", quiet))
    bound = Unsupported("Gazebo bounds commands by the limits of the joint, and names topics after it", quiet=True)
    return {
        **{f"{place}.{key}": bound for place in places for key in _BY_JOINT},
        **{f"{place}.{key}": Unsupported("no such gain") for place in places for key in _GAINS},
        **{f"actuators.*.{key}": Unsupported("drives of joints alone") for key in _OTHER_TARGETS},
    }


def drive_blocks(
    robot: Robot, joints: Mapping[str, str], gazebo: str, number: NumberFormat, others: Iterable[str]
) -> tuple[list[str], list[str]]:
    """Return a ``<gazebo>`` for each drive of a joint, and the names of actuators that Gazebo has no plug-in for.

    ``joints`` are the joints of the artifact with their names in it, ``gazebo`` is the distribution, and ``others`` are
    elements of the robot, which may drive joints already.
    """
    blocks, without = list[str](), list[str]()
    if not gazebo or gazebo == CLASSIC:
        return blocks, without
    taken = set(_driven(others))
    program, namespace = _PREFIXES.get(gazebo, ("gz-sim", "gz::sim"))
    pairs = [(joint.actuator, joint) for joint in robot.joints if joint.actuator]
    pairs += [(one, robot.joint[name]) for one in robot.actuators if (name := one.targets.get("joint", ""))]
    without += [one.name for one in robot.actuators if "joint" not in one.targets]
    for actuator, joint in pairs:
        name = joints.get(joint.name, "")
        is_braked = actuator.damping and actuator.type != POSITION  # a controller brakes only what it positions
        if name in taken:
            continue
        if not name or not joint.moves or actuator.type not in _PLUGINS or is_braked:
            without.append(actuator.name or joint.name)
            continue
        file, word = _PLUGINS[actuator.type]
        values = {"joint_name": escape(name), **_settings(actuator, joint, number)}
        lines = [f"    <{tag}>{text}</{tag}>" for tag, text in values.items()]
        start = f'  <plugin filename="{program}-{file}-system" name="{namespace}::systems::{word}">'
        blocks.append("\n".join(["<gazebo>", start, *lines, "  </plugin>", "</gazebo>"]))
    return blocks, without


def no_plugin(rule: str, gazebo: str, actuators: Sequence[str]) -> list[Diagnostic]:
    """Return the warning about actuators that some Gazebo has no plug-in for."""
    if not actuators:
        return []
    message = f"Gazebo {gazebo} has no plug-in for {plural('actuator', len(actuators))} {quoted(actuators, 3)}"
    return [
        Diagnostic(rule, WARNING, message, help="drive the joint by position, velocity or motor, or by ros2_control")
    ]


def _settings(actuator: Actuator, joint: Joint, number: NumberFormat) -> dict[str, str]:
    """Return the elements of a plug-in; the damping of a servo, which MuJoCo has at the joint, acts like ``kv``."""
    if actuator.type == MOTOR:
        return {}
    effort = joint.limit.known("effort") if joint.limit else None
    force = actuator.force or ((-effort, effort) if effort else None)
    if actuator.type == VELOCITY:
        gains = {"p_gain": actuator.kv or 1.0}  # MuJoCo's default
    else:
        gains = {"p_gain": 1.0 if actuator.kp is None else actuator.kp, "d_gain": actuator.kv + actuator.damping}
    if force is not None:
        gains |= {"cmd_min": force[0], "cmd_max": force[1]}
    settings = {tag: number(value) for tag, value in gains.items()}
    return {"use_force_commands": "true", **settings} if actuator.type == VELOCITY else settings


def _driven(texts: Iterable[str]) -> Iterator[str]:
    """Yield the joints that hardware blocks of ros2_control and plug-ins among elements drive."""
    for text in texts:
        if "<ros2_control" in text or "<plugin" in text:
            root = tree_of(f"<all>{text}</all>")
            yield from (joint.get("name", "") for block in root.iter("ros2_control") for joint in block.iter("joint"))
            for plugin in root.iter("plugin"):
                if "state" not in plugin.get("name", "").lower():  # JointStatePublisher names joints, too
                    yield from ((inner.text or "").strip() for inner in plugin.iter() if "joint" in inner.tag.lower())
