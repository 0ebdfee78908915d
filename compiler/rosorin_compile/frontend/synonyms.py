"""Synonyms: what URDF, SDF, MJCF and xacro call a thing, and what it is called here.

``KEYS`` has a table for each kind of entry, by its name in ``$defs`` of the schema (``top`` for the description);
``VALUES`` one for each key whose values are words. A name alone is the word to write; a sentence is the way out. Words
are compared in small letters, without ``_`` and the like.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

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
_APART = "leave it out: half of it stands in xyz of the joint of each wheel, in metres, or as 20 cm"
_KINDS = "the key says the kind: differential: {left: [JOINT], right: [JOINT]}, or mecanum, omni, tricycle, ackermann"
_SIDES = "write differential: {left: [JOINT], right: [JOINT]}"
_MEASURED = "an element of sensors is called by sensor: {sensor: gyro}, one of the body by body: {body: camera}"
_MEASURING = "accelerometer gyro magnetometer force torque touch rangefinder framepos framequat"
_AT_SITE = "{body: site} makes one; what a sensor measures at is made of frame, xyz and rpy"


def _all(words: str, meaning: str) -> dict[str, str]:
    return dict.fromkeys(words.split(), meaning)


_DISTANCES = {
    **_all("separation wheelseparation wheeldistance wheelspacing distance spacing gauge wheelgauge base", _APART),
    **_all("track trackwidth wheeltrack axletrack width wheelbase axledistance length lx ly", _APART),
}
_WHEELS = {
    **_DISTANCES,
    **_all("radius wheelradius r", "it stands beside the kind of drive: drive: {radius: ...}"),
    **_all("diameter wheeldiameter", "a radius is half of it, beside the kind of drive: drive: {radius: ...}"),
    **_all("frame baseframe baselink", "it stands beside the kind of drive: drive: {frame: ...}"),
}
_SITE = {
    **_all(
        "site sites", "MuJoCo's site is made where mjcf: [{sensor: gyro}] measures; a mere one is mjcf: [{body: site}]"
    ),
}
_LEFT_RIGHT = {
    **_all("leftwheel leftwheels leftjoint leftjoints leftwheeljoint leftwheeljoints leftwheelnames l", "left"),
    **_all("rightwheel rightwheels rightjoint rightjoints rightwheeljoint rightwheeljoints rightwheelnames r", "right"),
}
_STEERED = {
    **_all("steer steered steeringjoint steeringjoints steeringwheel steeringwheels front frontwheels", "steering"),
    **_all("drive driving drivenjoint drivenjoints drivenwheels traction tractionwheels rear rearwheels", "driven"),
    **_all("passive free", "rolling"),
}

_POSE = {
    **_all("origin pose transform tf placement mount offsetxyz", _XYZ_RPY),
    **_all("position pos translation trans location offset", "xyz"),
    **_all("rotation rot orientation euler eulerangles angles rpydeg", "rpy"),
    **_all("x y z", "write xyz: [X, Y, Z]"),
    **_all("roll pitch yaw theta", "write rpy: [ROLL, PITCH, YAW]"),
    **_all("quat quaternion wxyz xyzw q", "write the rotation as rpy: [ROLL, PITCH, YAW]"),
}
_ACTUATOR = {
    **_all("p gain stiffness pgain", "kp"),
    **_all("d dgain", "kv"),
    **_all("dampratio", "damping_ratio"),
    **_all("ctrlrange", "range"),
    **_all("forcerange", "force"),
    **_all("gearratio ratio", "gear"),
}
_PARENT = _all("parentlink base from attachedto mounton relativeto refframe", "parent")
_WITH = _all("params parameters param args arguments arg config options settings values inputs", "with")

_SHAPE = {
    **_POSE,
    **_all("geometry geom geometries shape", 'the shape stands in the entry itself: "- box: {size: ...}"'),
    **_all("color colour rgb", "rgba"),
    **_all("type kind", "the key says the kind of shape: box: {size: ...}"),
    **_all("size radius length height filename file uri url scale diameter dimensions", _IN_A_SHAPE),
    **_all("cube cuboid", "box"),
    **_all("ball", "sphere"),
    **_all("tube", "cylinder"),
    **_all("stl dae obj", "mesh"),
    **_all("hfield heightfield", "height_map"),
    "id": "name",
}

KEYS: dict[str, dict[str, str]] = {
    "top": {
        **_all("link body bodies segments", "links"),
        **_all("frame frames", "a frame is an empty link, placed by a joint: links: {NAME: {}}"),
        **_all("joint connections", "joints"),
        **_all("sensor", "sensors"),
        **_all("property properties variable variables var vars constant constants const defines definitions", "let"),
        **_all("params parameters param argument arguments options", "args"),
        **_all("macro macros module modules component components", "parts"),
        **_all("instance instances instantiate", "use"),
        **_all("import imports using files", "include"),
        **_all("name robotname model modelname", "robot"),
        **_all("version schema schemaversion", "rosorin_compile"),
        **_all("color colors colour colours material", "materials"),
        **_all("transmission transmissions gazebo plugin plugins xml raw", _XML),
        **_all("ros2control ros2controls hardware hardwareinterface", "control"),
        **_all("controller ros2controllers controllermanager", "controllers"),
        **_all("actuator motor motors", "actuators"),
        **_all("tendon", "tendons"),
        **_all("equality equalities loops closedloops constraint", "constraints"),
        **_all("contactpair pair pairs", "contact_pairs"),
        **_all("mjcfelement mujocoelements", "mjcf_elements"),
        **_all("mujoco mjcf", f"{_IN_LINK}; other XML is kept under mjcf_elements"),
        **_all("site sites camera cameras light lights", _IN_LINK),
        **_all("statictransforms statictfs transforms transform tf tfs", _FIXED),
        **_all("keyframe keyframes groupstate groupstates states configurations", "poses"),
        **_all("contact contacts exclude excludes disablecollisions disabledcollisions acm", "disabled_contacts"),
        **_all("output target targets artifacts backends formats generate", "outputs"),
        **_all("geometry collision collisions visual visuals inertial", "it belongs into an entry of links"),
        **_all("node nodes", "publishers"),
        **_all("ignore suppress allow", "accept"),
        **_all("rosparameters", "parameters of nodes are no part of a description"),
    },
    "link": {
        **_all("geometry geom geoms geometries shape shapes box sphere cylinder capsule ellipsoid mesh", _IN_SHAPES),
        **_all("collider colliders collisions", "collision"),
        **_all("visuals visualization appearance", "visual"),
        **_all("mass com cog cg density inertia centerofmass diaginertia weight", _IN_INERTIAL),
        "inertials": "inertial",
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
        **_PARENT,
        **_all("childlink to link target", "child"),
        **_all("limits lim range bounds jointlimit jointlimits", "limit"),
        **_all("lower upper effort velocity min max maxeffort maxvelocity torque speed", _IN_LIMIT),
        **_all("damping friction armature frictionloss damper viscousfriction stiffness springref", _IN_DYNAMICS),
        **_all("kp kv p d gain motor servo", "it belongs into actuator: {kp: ..., kv: ...}"),
        **_all("transmission gazebo hardwareinterface", _XML),
        **_all("name id", _NAME),
        **_all("jointtype kind jtype", "type"),
        **_all("axisxyz direction rotationaxis", "axis"),
        **_all("safety safetylimits", "safety_controller"),
        **_all("follow follows mimics couple", "mimic"),
    },
    "visual": _SHAPE,
    "collision": {**_SHAPE, **_all("color colour rgb rgba material texture", "it belongs into a shape under visual")},
    "box": {
        **_all("x y z length width height depth dimensions dimension dims dim extents extent lengths sizes", _SIZE),
        **_all("halfsize halfextents halfextent half", "write size: [X, Y, Z], the full extents: twice the half"),
    },
    "sphere": {**_all("r rad", "radius"), **_all("diameter d dia size", _HALF)},
    "cylinder": {
        **_all("r rad", "radius"),
        **_all("diameter d dia", _HALF),
        **_all("h height depth l len", "length"),
        "size": "write radius: ... and length: ..., the full one",
    },
    "mesh": {
        **_all("filename path uri url src source name", "file"),
        "scaling": "scale",
        **_all("units unit", "write scale: [0.001, 0.001, 0.001] for a file in millimetres"),
    },
    "inertial": {
        **_POSE,
        **_all("com cog cg centerofmass centreofmass centerofgravity", "xyz"),
        **_all("ixx iyy izz ixy ixz iyz diaginertia fullinertia inertiatensor moments tensor i", _MOMENTS),
        **_all("weight m masskg", "mass"),
        **_all("auto from shape", "of"),
    },
    "limit": {
        **_all("min low lowerlimit minimum minposition", "lower"),
        **_all("max high upperlimit maximum maxposition", "upper"),
        **_all("force torque maxeffort maxforce maxtorque eff", "effort"),
        **_all("speed vel maxvelocity maxspeed maxvel rate", "velocity"),
        **_all("range", "write lower: ... and upper: ..."),
        **_all("acceleration maxacceleration jerk", "a description has no such limit: it belongs to the planner"),
    },
    "mimic": {
        **_all("ratio multiply gear gearing factor gain scale polycoef", "multiplier"),
        **_all("leader of master jointname joint1 follows", "joint"),
        **_all("bias", "offset"),
    },
    "dynamics": {
        **_all("damper d viscous", "damping"),
        **_all("frictionloss coulomb static", "friction"),
        **_all("rotorinertia", "armature"),
        **_all("spring springstiffness", "stiffness"),
        **_all("springref rest restposition", "spring_reference"),
    },
    "drive": {
        **_DISTANCES,
        **_all("kind type model mode", _KINDS),
        **_all("diff diffdrive differentialdrive skid skidsteer tank", "differential"),
        **_all("mecanumdrive mechanum", "mecanum"),
        **_all("omnidirectional holonomic omnidrive", "omni"),
        **_all("car carlike ackermannsteering", "ackermann"),
        **_all(" ".join(_LEFT_RIGHT), _SIDES),
        **_all("left right wheels joints wheel", _SIDES),
        **_all("wheelradius r", "radius"),
        **_all("diameter wheeldiameter d", _HALF),
        **_all("baseframe baselink basefootprint", "frame"),
        **_all(
            "maxspeed maxvelocity speed velocity acceleration", "a drive has no such limit: it belongs to controllers"
        ),
    },
    "differential_wheels": {**_WHEELS, **_LEFT_RIGHT},
    "omni_wheels": {**_WHEELS, **_all("joints wheeljoints", "wheels")},
    "mecanum_wheels": {
        **_WHEELS,
        **_all("fl frontleftwheel leftfront", "front_left"),
        **_all("fr frontrightwheel rightfront", "front_right"),
        **_all("rl bl backleft rearleftwheel leftrear leftback", "rear_left"),
        **_all("rr br backright rearrightwheel rightrear rightback", "rear_right"),
    },
    "tricycle_wheels": {**_WHEELS, **_STEERED},
    "ackermann_wheels": {**_WHEELS, **_STEERED},
    "actuator": _ACTUATOR,
    "other_actuator": {**_ACTUATOR, **_all("link target", "body"), **_all("refsite", "reference_site")},
    "tendon": {**_all("frictionloss", "friction"), **_all("limit limits", "range"), **_all("sites", "path")},
    "constraint": {
        **_all("bodies body1 body2 link1 link2", "links"),
        **_all("anchor point", "at"),
        **_all("polycoef coefficients", "polynomial"),
        **_all("relpose", "write xyz and rpy: where the second link sits in the first"),
    },
    "contact": {**_all("mu", "friction"), **_all("contype layer groups", "layers"), **_all("conaffinity", "touches")},
    "contact_pair": {**_all("bodies body1 body2 link1 link2", "links"), **_all("geoms geom1 geom2", "shapes")},
    "mjcf_sensor": {**_all("type", "kind"), **_all("body", "link"), **_all("geom", "shape")},
    "material": {**_all("color colour rgb diffuse", "rgba"), **_all("image filename file", "texture"), "name": _NAME},
    "sensor": {
        **_POSE,
        **_PARENT,
        **_WITH,
        **_all("link parentframe", "parent"),
        **_all("frameid framename sensorframe", "frame"),
        **_all("opticalframe opticalframeid", "optical"),
        **_all("driver node visualize alwayson", _DRIVER),
        **_all("topic topicname updaterate rate frequency", "for a simulation it belongs into with: {...}"),
        **_all("noise fov hfov horizontalfov range resolution width height samples", "it belongs into with: {...}"),
        **_all("plugin plugins xml", _XML),
        **_all("gz sdf ignition", "gazebo"),
        **_all("name id", _NAME),
        **_all("jointname", "joint"),
        **_all("model kind sensortype", "type"),
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
        **_all("type kind", "sensor"),
        **_all("topic updaterate rate alwayson camera lidar ray imu plugin", "it belongs into elements: {...}"),
        **_all("reference link", "frame"),
    },
    "edge": {
        **_POSE,
        **_all("from frameid parentframe headerframeid", "parent"),
        **_all("to childframe childframeid target frame", "child"),
        **_all("node by broadcaster publishedby", "publisher"),
        **_all("static dynamic isstatic", "moving"),
        **_all("condition if mode", "when"),
    },
    "source": {
        **_all("origin kind type from state", "status"),
        **_all("date when day", "measured"),
        **_all("comment text reason remark description why", "note"),
    },
    "pose": {**_all("joints values angles position", "positions"), **_all("pulse servos", "pulses")},
    "servo_group": {
        **_all("min max range limits pulses", "pulse_range"),
        **_all("center centre zero offset home neutral", "zero_pulse"),
        **_all("invert inverted reverse reversed direction sign flip", "flipped"),
        **_all("scale resolution step radperstep", "rad_per_pulse"),
        **_all("joint ids", "joints"),
    },
    "publisher_node": {**_all("name nodename", "node"), **_all("pkg rospackage", "package")},
    "output": {**_all("filename path name target", "file"), **_all("format type kind generator", "backend")},
    "acceptance": {**_all("rules id", "rule"), **_all("why note comment", "reason")},
    "use": {
        **_POSE,
        **_PARENT,
        **_WITH,
        **_all("macro module template component of type name", "part"),
        **_all("namespace ns suffix", "prefix"),
    },
    "arg": {
        **_all("choices enum options values allowed oneof", "one_of"),
        **_all("description doc about desc comment", "help"),
        **_all("value", "default"),
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
