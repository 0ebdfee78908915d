"""Synonyms: what URDF, SDF, MJCF and xacro call a thing, and what it is called here, or how it is said otherwise.

The words for a key stand beside it in the schema (``x-also``), the ways out for what is no key beside its keys where
they are of one section alone (``x-instead``). ``KEYS`` has the others, a table for each kind of entry by its name in
``$defs`` of the schema (``top``: the description), and the words of what is not in the schema: parts and their uses.
``VALUES`` has one for each key whose values are words. A name alone is the word to write; a sentence is the way out.
Words are compared in small letters, without ``_`` and the like.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any

from .schema import of_parts, resolve, schema

_XYZ_RPY = "xyz and rpy stand in the entry itself, without anything around them"
_NAME = "the key of an entry is its name"
_DRIVER = "a setting of the driver, which the description does not have"
_XML = "keep the XML under urdf_elements"
_IN_LIMIT = "it belongs into limit: {lower: ..., upper: ..., effort: ..., velocity: ...}"
_IN_DYNAMICS = "it belongs into dynamics: {damping: ..., friction: ...}"
_IN_INERTIAL = "it belongs into inertial: {mass: ..., inertia: {ixx: ..., iyy: ..., izz: ...}}"
_IN_SHAPES = 'shapes stand under visual and under collision, each with "- " before it'
_IN_A_SHAPE = "it belongs into the shape: box: {size: ...}, cylinder: {radius: ..., length: ...}, mesh: {file: ...}"
_SIZE = "write size: [X, Y, Z], the full extents"
_HALF = "a radius is half of it: radius: ..."
_FIXED = "each is a joint: {type: fixed, publisher: {static_transform_publisher: NODE_NAME}, ...}"
_MOMENTS = "write inertia: {ixx: ..., iyy: ..., izz: ..., ixy: ..., ixz: ..., iyz: ...}"
_IN_LINK = "sites, cameras and lights stand in their link: links: {NAME: {sites: {NAME: {xyz: ...}}}}"
_MEASURED = "an element of sensors is called by sensor: {sensor: gyro}, one of the body by body: {body: camera}"
_MEASURING = "accelerometer gyro magnetometer force torque touch rangefinder framepos framequat"
_AT_SITE = "{body: site} makes one; what a sensor measures at is made of frame, xyz and rpy"


def _all(words: str, meaning: str) -> dict[str, str]:
    return dict.fromkeys(words.split(), meaning)


_SITE = {
    **_all(
        "site sites", "MuJoCo's site is made where mjcf: [{sensor: gyro}] measures; a mere one is mjcf: [{body: site}]"
    ),
}

_POSE = {
    **_all("origin pose transform tf placement mount offsetxyz", _XYZ_RPY),
    **_all("x y z", "write xyz: [X, Y, Z]"),
    **_all("roll pitch yaw theta", "write rpy: [ROLL, PITCH, YAW]"),
    **_all("quat quaternion wxyz xyzw q", "write the rotation as rpy: [ROLL, PITCH, YAW]"),
}

_SHAPE = {
    **_POSE,
    **_all("geometry geom geometries shape", 'the shape stands in the entry itself: "- box: {size: ...}"'),
    **_all("type kind", "the key says the kind of shape: box: {size: ...}"),
    **_all("size radius length height filename file uri url scale diameter dimensions", _IN_A_SHAPE),
}

KEYS: dict[str, dict[str, str]] = {
    "top": {
        **_all("frame frames", "a frame is an empty link, placed by a joint: links: {NAME: {}}"),
        **_all("macro macros module modules component components", "parts"),
        **_all("instance instances instantiate", "use"),
        **_all("transmission transmissions gazebo plugin plugins xml raw", _XML),
        **_all("mujoco mjcf", f"{_IN_LINK}; other XML is kept under mjcf_elements"),
        **_all("site sites camera cameras light lights", _IN_LINK),
        **_all("statictransforms statictfs transforms transform tf tfs", _FIXED),
        **_all("geometry collision collisions visual visuals inertial", "it belongs into an entry of links"),
        **_all("rosparameters", "parameters of nodes are no part of a description"),
    },
    "link": {
        **_all("geometry geom geoms geometries shape shapes box sphere cylinder capsule ellipsoid mesh", _IN_SHAPES),
        **_all("mass com cog cg density inertia centerofmass diaginertia weight", _IN_INERTIAL),
        **_all(
            "origin pose xyz rpy pos position orientation rotation quat euler parent joint joints child",
            "a link is placed by a joint: joints: {NAME: {type: fixed, parent: ..., child: ..., xyz: ...}}",
        ),
        **_all("name id", _NAME),
        **_all("material color colour rgba texture", "it belongs into a shape under visual"),
        **_all("gazebo plugin surface friction selfcollide gravity", _XML),
        **_all("sensor sensors", "sensors have a section of their own: sensors: {NAME: {type: ..., parent: ...}}"),
    },
    "joint": {
        **_POSE,
        **_all("lower upper effort velocity min max maxeffort maxvelocity torque speed", _IN_LIMIT),
        **_all("damping friction armature frictionloss damper viscousfriction stiffness springref", _IN_DYNAMICS),
        **_all("kp kv p d gain motor servo", "it belongs into actuator: {kp: ..., kv: ...}"),
        **_all("transmission gazebo hardwareinterface", _XML),
        **_all("name id", _NAME),
    },
    "visual": _SHAPE,
    "collision": {**_SHAPE, **_all("color colour rgb rgba material texture", "it belongs into a shape under visual")},
    "box": {
        **_all("x y z length width height depth dimensions dimension dims dim extents extent lengths sizes", _SIZE),
        **_all("halfsize halfextents halfextent half", "write size: [X, Y, Z], the full extents: twice the half"),
    },
    "sphere": {**_all("diameter d dia size", _HALF)},
    "cylinder": {
        **_all("diameter d dia", _HALF),
        "size": "write radius: ... and length: ..., the full one",
    },
    "mesh": {
        **_all("units unit", "write scale: [0.001, 0.001, 0.001] for a file in millimetres"),
    },
    "inertial": {
        **_POSE,
        **_all("ixx iyy izz ixy ixz iyz diaginertia fullinertia inertiatensor moments tensor i", _MOMENTS),
    },
    "limit": {
        **_all("range", "write lower: ... and upper: ..."),
        **_all("acceleration maxacceleration jerk", "a description has no such limit: it belongs to the planner"),
    },
    "constraint": {
        **_all("relpose", "write xyz and rpy: where the second link sits in the first"),
    },
    "material": {"name": _NAME},
    "sensor": {
        **_POSE,
        **_all("driver node visualize alwayson", _DRIVER),
        **_all("topic topicname updaterate rate frequency", "for a simulation it belongs into with: {...}"),
        **_all("noise fov hfov horizontalfov range resolution width height samples", "it belongs into with: {...}"),
        **_all("plugin plugins xml", _XML),
        **_all("name id", _NAME),
        **_SITE,
    },
    "sensor_type": {
        **_SITE,
        **_all("parameters args arguments param arg inputs with", "params"),
        **_all("variables properties", "let"),
        **_all("description doc", "help"),
        **_all("gz sdf ignition", "gazebo"),
        **_all("plugin plugins xml", _XML),
        **_all("mujoco", "mjcf"),
        **_all(
            "type kind camera lidar ray imu", "the key of an entry is its name; gazebo and mjcf say what it is there"
        ),
    },
    "mjcf_element": {
        **_POSE,
        **_all("site", _AT_SITE),
        **_all("sites", "write {body: site}"),
        **_all("type kind element tag", _MEASURED),
        **_all(_MEASURING, _MEASURED),
        **_all("camera light geom", _MEASURED),
    },
    "mjcf_body": {
        **_all(
            "site sites camera cameras light lights", "it is a key of the link itself, as sites: {NAME: {xyz: ...}}"
        ),
        **_all("geom geoms", _IN_SHAPES),
    },
    "gazebo_sensor": {
        **_POSE,
        **_all("topic updaterate rate alwayson camera lidar ray imu plugin", "it belongs into elements: {...}"),
    },
    "edge": _POSE,
    "use": {
        **_POSE,
        **_all("position pos translation trans location offset", "xyz"),
        **_all("rotation rot orientation euler eulerangles angles rpydeg", "rpy"),
        **_all("parentlink base from attachedto mounton relativeto refframe", "parent"),
        **_all("params parameters param args arguments arg config options settings values inputs", "with"),
        **_all("macro module template component of type name", "part"),
        **_all("namespace ns suffix", "prefix"),
    },
    "arg": {
        **_all("minimum maximum min max range", "write one_of: [...], or refuse a value with ${error('...')}"),
    },
    "part": {
        **_all("parameters args arguments param arg inputs", "params"),
        **_all("variables properties", "let"),
        **_all("description doc", "help"),
    },
}

# What any other key of such an entry is told, where no word of its table is near.
OTHERS = {
    "mjcf_element": "attributes of MJCF belong into attributes: {...}",
    "controller": "parameters of a controller belong into params: {...}",
}

_LINE = "prismatic"
VALUES: dict[str, dict[str, str]] = {
    "joint type": {
        **_all("hinge rotational rotary rotation rotate angular turn servo pivot rev revolution", "revolute"),
        **_all("slide slider sliding linear translational translation prism piston rail", _LINE),
        **_all("wheel spin spinning endless rolling roller unlimited", "continuous"),
        **_all("weld welded rigid static none glue locked mounted", "fixed"),
        **_all("free 6dof freejoint float base", "floating"),
        **_all("spherical socket", "ball"),
        **_all("ball spherical universal screw gearbox cylindrical cardan", "build it of several joints and links"),
    },
    "which gazebo": {
        **_all("jazzy gz gzsim sim new", "harmonic"),
        **_all("humble ign ignition", "fortress"),
        **_all("gazebo11 gazebo_ros 11", "classic"),
    },
    "status": {
        **_all("guessed guess estimated estimate assumed unknown tbd todo placeholder approximate", "stand_in"),
        **_all("datasheet vendor manufacturer cad drawing manual spec", "factory"),
        **_all("computed derived", "calculated"),
        **_all("tested calibrated real", "measured"),
        **_all("design decided arbitrary", "chosen"),
    },
    "arg type": {
        **_all("float double real scalar num", "number"),
        **_all("int uint long", "integer"),
        **_all("str string char", "text"),
        **_all("bool flag", "boolean"),
        **_all("dict map mapping object", "table"),
        **_all("array vector tuple sequence", "list"),
        **_all("distance meter metre", "length"),
        **_all("velocity", "speed"),
    },
    "sensor type": {
        **_all("laser laserscan laserscanner scanner ray gpuray gpulidar rplidar hokuyo sick ydlidar", "lidar_2d"),
        **_all("velodyne ouster livox lidar3d pointcloud", "lidar_3d"),
        **_all("rgbd rgbdcamera depth realsense d435 kinect zed stereo stereocamera tofcamera", "depth_camera"),
        **_all("rgb webcam mono monocamera image usbcamera", "camera"),
        **_all("gps navsat gnssreceiver", "gnss"),
        **_all("compass magnetic mag", "magnetometer"),
        **_all("barometer altitude height", "altimeter"),
        **_all("ft forcetorquesensor wrench loadcell", "force_torque"),
        **_all("sonar ultrasonic ultrasound ir infrared tof range rangefinder", "range_finder"),
        **_all("bumper touch", "contact"),
        **_all("accelerometer gyro gyroscope inertial", "imu"),
    },
    "backend": {
        **_all("mujoco mjcfxml mujocoxml", "mjcf"),
        **_all("xacro robotdescription urdfxml", "urdf"),
        **_all("gazebo sdformat ignition", "Gazebo reads the sdf, or the urdf"),
        **_all("statictransforms statictransformpublisher statictf launch", "static_tf"),
        **_all("picture dot graph tree", "frames_picture"),
        **_all("markdown doc docs", "frames"),
        **_all("web webpage viewer browser threejs", "page"),
        **_all("moveit moveit2 semantic", "srdf"),
        **_all("navigation navigation2 costmap footprint amcl", "nav2"),
        **_all("ekf ukf localization", "robot_localization"),
        **_all("ros2control controllermanager ros2controllers", "controllers"),
    },
}


@cache
def words_for(kind: str) -> Mapping[str, str]:
    """Return what each word is called in an entry of a kind, or the way out for it."""
    sections = schema()["properties"]
    if kind in ("top", "part"):
        known = sections if kind == "top" else {section: sections[section] for section in of_parts()}
    elif kind in schema()["$defs"]:
        known = schema()["$defs"][kind].get("properties", {})
    else:  # a section whose entries are defined where they stand
        known = dict(_keys_within(sections.get(kind, {})))
    also = {word: key for key, fragment in known.items() for word in _also(fragment)}
    return {**KEYS.get(kind, {}), **_instead(kind), **also}


def _instead(kind: str) -> dict[str, str]:
    """Return the way out for each word that is no key of an entry, as the schema says it beside the keys."""
    said = schema()["$defs"].get(kind, {}).get("x-instead", {})
    if isinstance(said, str):  # as another kind says it
        return _instead(said)
    return {word: way for words, way in said.items() for word in words.split()}


def _keys_within(fragment: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    if isinstance(fragment, Mapping):
        yield from fragment.get("properties", {}).items()
    for inner in fragment.values() if isinstance(fragment, Mapping) else fragment if isinstance(fragment, list) else ():
        yield from _keys_within(inner)


def _also(fragment: Mapping[str, Any]) -> list[str]:
    return f"{fragment.get('x-also', '')} {resolve(dict(fragment)).get('x-also', '')}".split()


def plain(word: str) -> str:
    """Return a word as it is compared: small letters and digits alone."""
    return re.sub(r"[^a-z0-9]", "", word.casefold())


def synonym(word: str, table: Mapping[str, str], known: Iterable[str]) -> str | None:
    """Return what a word is called here, one of ``known``; None if no table has it or it only names a way out."""
    meaning = table.get(plain(word))
    return meaning if meaning in set(known) else None


def way_out(word: str, table: Mapping[str, str]) -> str:
    """Return the sentence that a table has for a word; "" if it has none, or another word alone."""
    meaning = table.get(plain(word), "")
    return meaning if " " in meaning else ""
