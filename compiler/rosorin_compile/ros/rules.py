"""The rules about ROS 2: what a description, a package or a parameter file may not be, by heading."""

from __future__ import annotations

from collections.abc import Iterable

from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, Span, diagnostic
from rosorin_compile.source.rule_registry import DECLARED, Heading, declare

_PARAMETERS = declare(
    Heading.PARAMETERS,
    {
        "parameters-odometry": "A warning: a node listens to an odometry below the name of a controller that "
        "publishes another one. A note: it listens to `odom`, or below a `..._controller` that no file has, and the "
        "drive publishes elsewhere. Fix: Name the topic that is published; or say by `--remap` or `--launch` which "
        "remap there is.",
        "parameters-topic": "A warning: two nodes of one topic have other messages, Twist and TwistStamped, or the "
        "reader needs reliable messages and the publisher sends them as best effort. A note: a filter listens to "
        "another IMU than the broadcaster in the files publishes. Fix: As the message says; or say by `--remap` or "
        "`--launch` which remap there is.",
        "parameters-source": "A warning: a source of obstacles of a costmap or of collision_monitor has no parameters, "
        "never clears what it marks, marks farther than it clears, or expects another type of message than the sensor "
        "with its topic publishes. A note: no sensor of the robot has the topic that a node reads scans or points "
        "from. Fix: Set topic, data_type, clearing and the ranges of the source.",
        "parameters-frame": "A node names a frame that does not exist, that no node publishes, or by a name that tf2 "
        "refuses. Fix: Name a frame of the robot.",
        "parameters-base": "The base frame of a node is one that the odometry does not move: no transform leads to it "
        "from the odometry's frame. AMCL and slam_toolbox take base_footprint by default. Fix: Name the frame that "
        "the odometry moves, or one that hangs on it.",
        "parameters-reach-nobody": "No controller is called as parameters say that are for one. A warning: a node in "
        "a namespace does not get parameters that name it without. Fix: `/NAMESPACE/NODE:`, or `/**/NODE:`; or "
        "correct the name.",
        "parameters-two-owners": "A node publishes an edge that belongs to another one, so the frame jumps between "
        "the two. Fix: Switch one of them off, as the message says; or say in the description who owns the edge, and "
        "in which mode.",
        "parameters-no-owner": "The node that owns an edge by the description does not publish it. Fix: Switch it on, "
        "remap its topic to /tf, or name the real owner in the description.",
        "parameters-other-edge": "A node publishes an edge that the description does not have: it has another parent, "
        "or another child. A warning where no node of the description publishes that frame. Fix: Correct the frames "
        "of the node, or add the edge to `edges`.",
        "parameters-launch": "A launch file cannot be read; a warning where it says remaps that are known only when it "
        "runs. Fix: Say them by `--remap NODE:FROM:=TO`.",
        "parameters-gap": "An input of the EKF is never read, for it reads odom0, odom1, ... up to the first number "
        "that is missing. Fix: Number the inputs from 0, without gaps.",
        "parameters-unknown-key": "A node does not know a key, or that of another distribution: it starts, and does "
        "not do what is written. A warning where only some keys of the node are known, and this is nearly one of "
        "them. Fix: Correct it.",
        "parameters-wrong-type": "A value has another type than its node takes: it throws when it starts. 1 is no "
        "double, 1.0 is one. Fix: Write it as that type.",
        "parameters-wrong-value": "A list has another length than its node takes, a number or a text is none of those "
        "that it takes, frames are the same that have to differ. A warning where an input of the EKF uses nothing, "
        "and where it makes no difference what stands there. Fix: As the message says.",
        "parameters-syntax": "A parameter file is none, or one that ROS 2 refuses: no node starts with it. A warning "
        "where ROS 2 reads it otherwise than it looks. Fix: As the message says.",
        "parameters-twice": "A warning: a parameter is repeated for one node; the last one counts. Fix: Remove one.",
    },
)

_CONTROL = declare(
    Heading.CONTROL,
    {
        "controller-missing": "A controller lacks a parameter that it needs. Fix: Give it; or say in the description "
        "what it follows from: `drive`, `sensors`, `control`.",
        "controller-name": "A controller names a joint, a frame or a sensor that the robot does not have. Fix: "
        "Correct the name.",
        "controller-differs": "A controller is told something else than the robot says: the radius of a wheel, the "
        "distance between two, which is on the left. A warning in a description. Fix: Correct one of the two; what is "
        "left out of a description is filled in.",
        "controller-interface": "Two controllers that are started claim one command of a joint: the second one does "
        "not start. A warning: a controller commands what no hardware block has. Fix: Start one of the two with "
        "`inactive: true`; give the joint this command in `control`, or name another joint.",
        "controllers-none": "A file that has to name controllers (`check parameters --controllers`) names none. A "
        "warning: an output is for the controllers of a description that has none. Fix: `controllers: {NAME: {type: "
        "TYPE}}`.",
        "controllers-odometry": "A note: a controller can publish the pose of the base, and no edge names it as the "
        "publisher. Its parameters switch that off: the description defines who publishes each edge. Fix: Add the "
        "edge with the controller as its publisher; or nothing, if no node is to publish it.",
        "controllers-joint-states": "A warning: hardware blocks have states of joints, and no controller publishes "
        "them: a `joint_state_broadcaster` does, and without `joint_states` robot_state_publisher moves no frame. "
        "Fix: `controllers: {joint_state_broadcaster: {type: joint_state_broadcaster}}`.",
        "controllers-distribution": "A warning: the controllers are for one distribution, and the hardware blocks of "
        "every URDF for another one. Fix: Write the same `control` and `distribution`; or a URDF for each.",
        "controllers-later": "A note: the parameters of controllers are known up to Jazzy, and a later distribution "
        "is asked for. Fix: Nothing, as long as the controllers start.",
        "controllers-remap": "A note: a controller owns odom -> base, and publishes it beside /tf. Fix: Start it with "
        "the remap that the message names.",
        "controller-type": "A distribution has no controller of this type. A note where it is of another package, "
        "whose types are not known: its parameters are not checked. A warning where that is nearly the name of a "
        "known one. Fix: Name a type of this distribution, or ask for the distribution that has it.",
        "control-joint": "A joint of a hardware block is not in the URDF that the block goes into, or does not move "
        "along or about one axis. A warning on Humble, which does not compare the two. Fix: Let robot_state_publisher "
        "publish the joint, leave it out of the block, or ask for the block in a URDF with `frames: all`.",
        "control-type": "A hardware block is not what its type says: an actuator has one joint, a sensor takes no "
        "commands. Fix: `type: system`, or what the message says.",
        "control-interface": "A sensor of a hardware block says nothing, or two blocks have the same interface. A "
        "warning: an interface that no controller knows, such as `velocty`, or a joint without any. Fix: Correct the "
        "word; give each interface to one block.",
        "control-mimic": "A follower has commands, which Jazzy refuses, its leader is not in its block, or it has "
        "none. A warning: an offset that the mock hardware of Humble does not know. Fix: Leave the command out, add "
        "the leader, or say `mimic: false`.",
        "control-param": "A parameter of a hardware block is empty, or says what the joint says already. Fix: Give it "
        "a value, or leave it out.",
        "control-limit": "The smallest value of a command is above the largest. A warning: they go beyond the limit "
        "of the joint. Fix: Correct them, or leave them to the joint.",
        "control-ignored": "A warning: Humble does not read a key of a hardware block, or a description has no block "
        "where an output asks for them. Fix: Leave the key out, or ask for a later distribution.",
    },
)

_PACKAGES = declare(
    Heading.PACKAGES,
    {
        "package-open": "A node that the package starts reads a topic that nothing publishes, or in another type of "
        "message, or what it publishes has no reader. The message describes the symptom on the robot. Fix: See the "
        "message: name the topic that is published, or add the sensor or the controller.",
        "package-external": "A note: a node reads a topic that a driver outside of the package has to publish. Fix: "
        "Start the driver with this topic, or name the one that it has.",
        "package-start": "A package starts what no output is for, or what its nodes cannot load. Fix: Add the output "
        "that the message names, or follow its advice.",
        "package-gazebo": "A note: Nav2 is started, and an SDF gives sensors no frames: what Gazebo publishes is in "
        "no frame of tf. Fix: `gazebo: harmonic` in the output; nothing, where the SDF is for other readers.",
        "package-acceleration": "A note: MoveIt of Jazzy and later plans nothing for a joint without a limit of "
        "acceleration, which a description does not have: `joint_limits.yaml` has a stand-in, 1 rad/s^2 or 1 m/s^2, "
        "as MoveIt of Humble. Fix: Nothing, if that is what you want; else give MoveIt the limits of the maker.",
        "package-not-carried": "`--compile-at-launch`: something that the description reads, or that its URDF names, "
        "is not there at launch. Fix: Move it into the project, or into a ROS package.",
        "deployed-differs": "A copy is not the compiled one (in the forms for programs). Fix: `rosorin-compile deploy`",
        "deployed-mixed": "A run of `deploy` or `package` was ended while it wrote: some files are of that run, and "
        "others older. Fix: Run it again.",
        "deployed-missing": "The URDF, or a file that `--map` put somewhere, is not there. A note for others. Fix: "
        "`rosorin-compile deploy`",
        "deployed-launch-unread": "Arguments are known only when the launch file runs (a note), or it cannot be "
        "parsed (a warning). Fix: Compare with `frames.md`.",
        "deployed-static-missing": "A warning: no launch file publishes a static frame. Fix: Include "
        "`static_tf.launch.py`.",
        "deployed-static-twice": "A note: a launch file by hand and `static_tf.launch.py` publish the same frame. "
        "Fix: Launch one of them.",
        "deploy-unreadable": "The folder is unreadable, or has over 50,000 files. Fix: Name the package.",
        "deploy-changes": "A note: what was changed (in the forms for programs).",
        "deploy-other-robot": "Where an artifact would go is that of another robot. Fix: `--map OUTPUT=PLACE`",
        "deploy-ambiguous": "An artifact has several copies, or two outputs one place. Fix: `--map OUTPUT=PLACE`",
        "deploy-not-ours": "Where an artifact would go is a file that the tool did not write, or one of the package "
        "itself. Fix: Move it away, or `--map OUTPUT=PLACE` (`none`: nowhere).",
        "deploy-kept": "A warning: a file was changed after the tool wrote it, or nothing records who wrote it. It is "
        "replaced, and its old text is stored next to it. Fix: Bring the change into the description, and remove the "
        "old text.",
        "deploy-nowhere": "A note: the folder has no copy of these outputs yet. Fix: `--map OUTPUT=PLACE|none`",
        "deploy-no-package": "A note: the folder is in no ROS package.",
        "deploy-not-installed": "A warning: `setup.py` or `CMakeLists.txt` does not install a file. Fix: Add the line "
        "that the message names.",
        "deploy-not-depended": "A warning: `package.xml` does not name a package whose nodes the launch files start. "
        "Fix: Add `<exec_depend>NAME</exec_depend>`.",
        "deploy-not-built": "A warning: the install space has older copies, or none. Fix: `colcon build`",
        "deploy-no-install": "The folder of `--install` lacks the package. Fix: Name the install folder.",
        "deploy-install-space": "A warning: the folder is an install space, which the next build overwrites. Fix: "
        "Deploy into the sources.",
        "deployed-launch-differs": "A launch file gives a static transform other values, or another parent. Fix: "
        "Write the described values into it.",
        "deployed-launch-owner": "A launch file publishes a frame that belongs to another node. Fix: Publish it once.",
        "deployed-launch-refused": "static_transform_publisher would refuse its arguments. Fix: Correct them.",
        "deployed-launch-unknown": "A warning: a launch file publishes a frame that is not described. Fix: Describe "
        "it.",
        "package-mesh": "A warning: a mesh or texture is found on some machines only, or not at all. Fix: The message "
        "says where to put the file.",
        "deploy-mapping": "The file with the places of `--map` is damaged. Fix: Remove it, and repeat `--map`.",
        "package-no-urdf": "No output is a URDF. Fix: Add an output with the backend `urdf`.",
        "package-same-place": "Two outputs have one file name in two folders, and a package has one folder for both. "
        "Fix: Let the file names differ.",
        "package-exists": "The folder has files of a package that the tool did not make. Fix: A new folder, or "
        "`rosorin-compile deploy`.",
        "package-defaults": "A note: the package has no maintainer or no licence yet. Fix: `--maintainer`, `--license`",
        "package-license": "A note: the tool does not carry the text of the licence, so there is no LICENSE. Fix: Put "
        "the text into the file LICENSE of the package.",
    },
)

_NAVIGATION = declare(
    Heading.NAVIGATION,
    {
        "nav2-footprint": "A warning: the footprint is left out, for the robot has no collision shapes, or meshes of "
        "unknown size, so it would be too small; or the base frame is not within it, which Nav2 takes for granted. "
        "Fix: Give the links shapes; or name another `base_frame`.",
        "nav2-base": "The base frame for Nav2 is no frame of the robot, or it moves against the one that the odometry "
        "moves. Fix: Name a frame that is fixed to it.",
        "nav2-pose": "The robot has no pose of this name. Fix: Name one of `poses`.",
        "nav2-pose-left-out": "A warning: the pose of the footprint does not name a joint, and what that moves "
        "decides on the footprint, for it is where it reaches farthest. Fix: Name the joint in the pose.",
        "nav2-source": "An observation source is no sensor that sees obstacles, has no topic, or is lower than any "
        "obstacle. Fix: As the message says.",
        "nav2-command": "A warning: a controller of the drive takes velocities in another message than Nav2 sends: "
        "nothing drives. Fix: Give the controller `use_stamped_vel: false`, or both outputs the same `distribution`.",
        "navigation-frames": "The description does not say what nodes of navigation have to know: which frame the "
        "odometry moves, or which of several. Fix: Add the edge to `edges`, with who publishes it; or name the frames "
        "in the output.",
        "navigation-no-map": "A warning: no edge leads from a map to the odometry, so what needs a map is left out. "
        "Fix: Add it to `edges`: `{parent: map, child: odom, publisher: amcl}`.",
        "navigation-owner": "A node is to publish an edge that nodes of its kind do not publish, or two. Fix: Correct "
        "the edge, or its publisher.",
        "filter-unclear": "An output does not say which filter it is for, or names a node that is none. Fix: `node: "
        "NAME`, one of `publishers` of the package robot_localization.",
        "filter-owns-nothing": "A note: no edge is of the filter, so it is written with `publish_tf: false`. Fix: "
        "Name it as the publisher of an edge, if it is to publish one.",
        "filter-input": "An input of a filter has no topic or a number with a gap before it, or lacks the values that "
        "are used of it, or it is to give what such messages do not have. A warning where the filter has no inputs, "
        "or listens to an odometry that no node publishes. Fix: As the message says.",
    },
)

_OUTPUTS = declare(
    Heading.OUTPUTS,
    {
        "moveit-urdf": "`urdf` of `moveit` is no output that is a URDF, or there is none. Fix: Name the output; an "
        "SRDF belongs to one URDF.",
        "moveit-not-in-urdf": "A link or a joint for MoveIt is not in the URDF that the SRDF belongs to: MoveIt does "
        "not know it. Fix: Name another one; or `urdf` of `moveit` names a URDF that has it, such as one with "
        "`frames: all`.",
        "moveit-group": "A planning group has no joint, or has itself in it. Fix: Give it a chain, joints, links or "
        "other groups.",
        "moveit-chain-swapped": "A warning: the chain of a planning group ends at a link that its base hangs on: base "
        "and tip are swapped. MoveIt takes the joints, and its solvers move the wrong end. Fix: `chain: {base: LINK, "
        "tip: LINK}`: the tip is what moves.",
        "moveit-state": "A pose that is to be a state of a group names none of its joints. A note: a pose names some "
        "joints of a group and not all, and so is a state of none. Fix: Name the joints in the pose; `states` of the "
        "group takes it as it is.",
        "moveit-end-effector": "The parent group of an end effector does not have the link that carries it, or is its "
        "own group. A warning: its own group has that link; MoveIt's setup assistant refuses that. Fix: Correct the "
        "groups or the parent.",
        "moveit-virtual-joint": "The virtual joint has the name of a joint of the URDF. A warning: its parent frame "
        "is a link of the URDF. Fix: Rename it; name a frame of the world, such as odom.",
        "moveit-passive-joint": "A warning: a passive joint is fixed, or follows another one, which is passive "
        "anyway. Fix: Remove it.",
        "collisions-stale": "A warning: shapes, joints, limits or numbers changed since the collision matrix was "
        "computed. Its pairs stay in the SRDF; those that depend on what changed are listed, because they may collide "
        "now. Fix: `rosorin-compile collisions` computes them again.",
        "collisions-missing": "A note: no collision matrix was computed, so that MoveIt checks every pair of links, "
        "those that touch at a joint too. Fix: `rosorin-compile collisions` computes one.",
    },
)

_FORMATS = declare(
    Heading.FORMATS,
    {
        "srdf-without-urdf": "An SRDF belongs to a URDF, and the robot has none among its outputs, or none of that "
        "name. Fix: Add `urdf` to `outputs`; `urdf` of `moveit` names one of several.",
        "srdf-cannot-say": "A note: a pair of links that are not to collide is not in the URDF, so that the SRDF "
        "leaves it out. Fix: Nothing, if that is meant. `frames: all` of a URDF has every link.",
    },
)

RULES = (*_PARAMETERS, *_CONTROL, *_PACKAGES, *_NAVIGATION, *_OUTPUTS, *_FORMATS)


def report(
    rule: str,
    message: str,
    span: Span | None = None,
    help: Help = "",
    related: Iterable[Related] = (),
    severity: str = "",
) -> Diagnostic:
    """Return a diagnostic of one of the rules; severity and help are those of the rule unless others are passed."""
    declared = DECLARED[rule]
    return diagnostic(rule, severity or declared.severity, message, span, help or declared.hint, related)
