"""The table of built-in commands and checks: what the help lists, and the module of each."""

from __future__ import annotations

from typing import NamedTuple

from rosorin_compile.source.plugins import installed

CHECK = "check"  # the command that has checks
_COMPILE, _IMPORT, _INSPECT = "describe and compile", "import and compare", "inspect"
_BUILD, _DEPLOY, _SET_UP = "build systems", "deploy and verify", "set up"
GROUPS = (_COMPILE, _IMPORT, _INSPECT, _BUILD, _DEPLOY, _SET_UP)  # in the order of the help; plug-ins follow


class Entry(NamedTuple):
    """A command or check as the help lists it, and the module whose ``run`` it is; empty for a plug-in."""

    name: str
    module: str
    group: str
    help: str
    order: int = 100
    also: tuple[str, ...] = ()
    hidden: bool = False


COMMANDS = (
    Entry("init", "init", _COMPILE, "create a new robot description", 10),
    Entry("all", "all", _COMPILE, "compile robots and write all artifacts", 20, ("compile",)),
    Entry("print", "print", _COMPILE, "compile a robot and print one artifact to standard output", 30),
    Entry("check", "check", _COMPILE, "compile robots and compare them with the committed artifacts", 40),
    Entry("watch", "watch", _COMPILE, "compile on every change of a file and print the changes of the robot", 50),
    Entry("sweep", "sweep", _COMPILE, "compile many variants of one robot, each to a separate folder", 60),
    Entry("collisions", "collisions", _COMPILE, "compute the pairs of links that MoveIt does not need to check", 70),
    Entry("schema", "schema", _COMPILE, "print the JSON Schema of descriptions or of an output", 80),
    Entry("rule", "rule", _COMPILE, "explain a rule: the cause of the message and the fix", 90),
    Entry("import", "import_robot", _IMPORT, "convert a URDF, xacro, SDF or MJCF to a description", 10),
    Entry("extract", "extract", _IMPORT, "compute boxes and height maps from meshes", 20),
    Entry("diff", "diff", _IMPORT, "compare two robots by meaning, in any supported formats", 30),
    Entry("explain", "explain", _INSPECT, "print the pose of a frame and the lines of YAML that define it", 10),
    Entry("tf", "tf", _INSPECT, "print the transform between two frames, in the format of tf2_echo", 20),
    Entry("frames", "frames", _INSPECT, "show the tree of frames with their publishers", 30),
    Entry("graph", "graph", _INSPECT, "show the ROS 2 nodes of the robot and the topics between them", 35),
    Entry("view", "view", _INSPECT, "show the robot in the browser and update it when files change", 40),
    Entry("picture", "picture", _INSPECT, "draw the robot to a PNG file, without a browser", 50),
    Entry("simulate", "simulate", _INSPECT, "test the robot in MuJoCo: at rest, in its poses and driving", 60),
    Entry("pulses", "pulses", _INSPECT, "convert servo pulses to joint positions and back", 70, hidden=True),
    Entry("args", "args", _INSPECT, "list the arguments of a robot", 80),
    Entry("cmake-dir", "cmake_dir", _BUILD, "print the folder of the CMake package", 10, hidden=True),
    Entry("bazel-dir", "bazel_dir", _BUILD, "print the folder of the Bazel rule", 20, hidden=True),
    Entry("package", "package", _DEPLOY, "write a ROS 2 package with the artifacts of a robot", 10),
    Entry("deploy", "deploy", _DEPLOY, "copy the artifacts to an existing ROS 2 package", 20),
    Entry("verify", "verify", _DEPLOY, "compare a recording of the robot with its description", 30),
    Entry("completion", "completion", _SET_UP, "print the completion script for bash, zsh or fish", 10),
    Entry("help", "help", _SET_UP, "show the help of a command", 20),
)
CHECKS = (
    Entry("parameters", "check_parameters", CHECK, "check parameter files of ROS nodes: frames and publishers"),
    Entry("deployed", "check_deployed", CHECK, "compare with copies in a package, an install space or another folder"),
    Entry(
        "physics",
        "check_physics",
        CHECK,
        "find links that collide with each other at rest or while joints move, with MuJoCo",
    ),
)
BUILT_IN = {"commands": COMMANDS, "checks": CHECKS}


def entry(name: str, group: str = "commands") -> Entry | None:
    """Return the built-in entry of a name or an alternative name, or None."""
    return next((one for one in BUILT_IN[group] if name in (one.name, *one.also)), None)


def names(group: str) -> dict[str, str]:
    """Return the names of all "commands" or "checks" with their help; plug-ins are named, but not imported."""
    own = {one.name: one.help for one in BUILT_IN[group] if not one.hidden}
    return {**{one.name: f"of {one.distribution} {one.version}" for one in installed() if one.group == group}, **own}
