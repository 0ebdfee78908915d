"""The table of the built-in commands and checks, as the help lists them."""

from __future__ import annotations

from typing import NamedTuple

from rosorin_compile.source.plugins import installed_plugins

CHECK = "check"  # the command that has checks
# Groups in the order of the help, each with its commands; those of plug-ins follow.
COMMANDS = {
    "describe and compile": {
        "init": "create a new robot description",
        "all": "compile robots and write all artifacts; alias: compile",
        "print": "compile a robot and print one artifact to standard output",
        "check": "compile robots and compare them with the committed artifacts",
        "watch": "compile on every change of a file and print the changes of the robot",
        "sweep": "compile many variants of one robot, each to a separate folder",
        "collisions": "compute the pairs of links that MoveIt does not need to check",
        "schema": "print the JSON Schema of descriptions or of an output",
        "rule": "explain a rule: the cause of the message and the fix",
    },
    "import and compare": {
        "import": "convert a URDF, xacro, SDF or MJCF to a description",
        "extract": "compute boxes and height maps from meshes",
        "diff": "compare two robots by meaning, in any supported formats",
    },
    "inspect": {
        "explain": "print the pose of a frame and the lines of YAML that define it",
        "tf": "print the transform between two frames, in the format of tf2_echo",
        "frames": "show the tree of frames with their publishers",
        "graph": "show the ROS 2 nodes of the robot and the topics between them",
        "view": "show the robot in the browser and update it when files change",
        "picture": "draw the robot to a PNG file, without a browser",
        "simulate": "test the robot in MuJoCo: at rest, in its poses and driving",
        "pulses": "convert servo pulses to joint positions and back",
        "args": "list the arguments of a robot",
    },
    "build systems": {
        "cmake-dir": "print the folder of the CMake package",
        "bazel-dir": "print the folder of the Bazel rule",
    },
    "deploy and verify": {
        "package": "write a ROS 2 package with the artifacts of a robot",
        "deploy": "copy the artifacts to an existing ROS 2 package",
        "verify": "compare a recording of the robot with its description",
    },
    "set up": {"completion": "print the completion script for bash, zsh or fish", "help": "show the help of a command"},
}
CHECKS = {
    "parameters": "check parameter files of ROS nodes: frames and publishers",
    "deployed": "compare with copies in a package, an install space or another folder",
    "physics": "find links that collide with each other at rest or while joints move, with MuJoCo",
}
ALIASES = {"compile": "all"}
_HIDDEN = ("pulses", "cmake-dir", "bazel-dir")
# Modules of commands that are not named after the command.
MODULES = {
    **dict.fromkeys(("bazel-dir", "cmake-dir", "completion", "help", "rule", "schema"), "tool"),
    **dict.fromkeys(("deploy", "deployed", "parameters"), "package"),
    **dict.fromkeys(("collisions", "physics"), "simulate"),
    **dict.fromkeys(("args", "explain", "graph", "pulses", "tf"), "frames"),
    **dict.fromkeys(("import", "init"), "import_robot"),
    "diff": "check",
    "picture": "view",
    "sweep": "watch",
}


class Entry(NamedTuple):
    """A command or check as the help lists it."""

    name: str
    group: str
    help: str
    hidden: bool = False


BUILT_IN = {
    "commands": {
        name: Entry(name, group, help, name in _HIDDEN)
        for group, helps in COMMANDS.items()
        for name, help in helps.items()
    },
    "checks": {name: Entry(name, CHECK, help) for name, help in CHECKS.items()},
}


def names(group: str) -> dict[str, str]:
    """Return the names of all "commands" or "checks" with their help; plug-ins are named, but not imported."""
    plugins = {p.name: f"of {p.distribution} {p.version}" for p in installed_plugins() if p.group == group}
    return plugins | {entry.name: entry.help for entry in BUILT_IN[group].values() if not entry.hidden}
