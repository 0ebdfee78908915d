"""The rules about recordings."""

from rosorin_compile.source.rule_registry import RECORDINGS, Rule

RULES = (
    Rule(
        "recording-unreadable",
        "The source is not a recording, or it is damaged, or its end is missing because the recorder was killed.",
        "The message gives the cause; `ros2 bag reindex` or `mcap recover` may help. End a recording with Ctrl-C.",
        RECORDINGS,
    ),
    Rule("recording-empty", "There are no messages.", "Record `/tf`, `/tf_static`, `/joint_states`.", RECORDINGS),
    Rule("recording-foreign", "There are no transforms.", "Record `/tf`; `--namespace` if it has one.", RECORDINGS),
    Rule("recording-type", "A topic has the name of a standard topic, but another type.", "Rename it.", RECORDINGS),
    Rule(
        "recording-other-clock",
        "A warning, or a note with `/clock`: all stamps are of another clock than that of the recorder, as in a "
        "simulation or in a bag that was played. Ages are measured with the clock of the stamps.",
        "`ros2 bag record --use-sim-time`; or set the clocks of the computers.",
        RECORDINGS,
    ),
    Rule(
        "recording-silent",
        "A warning: no messages were recorded for longer than `--stale`. No edge is called stale for that.",
        "Find out whether the recorder was paused, or a clock was set.",
        RECORDINGS,
    ),
    Rule(
        "recording-no-static",
        "There are no messages of `/tf_static`, so that static edges cannot be compared.",
        "Record `/tf_static`, with durability transient_local.",
        RECORDINGS,
    ),
    Rule(
        "text-not-understood",
        "A text, or a part of it, has no known form.",
        "Paste all of it, with the command line above it.",
        RECORDINGS,
    ),
    Rule(
        "text-frames",
        "tf2_echo printed a transform, but the text does not name its frames.",
        "`--frames SOURCE TARGET`",
        RECORDINGS,
    ),
    Rule(
        "not-compared",
        "A note: something could not be compared, because a pose or the joint states are not known. An error if "
        "nothing could be compared.",
        "`--pose NAME`; record `/joint_states`.",
        RECORDINGS,
    ),
    Rule(
        "edge-not-described",
        "A warning: an edge was published that is not described, or that nobody should publish.",
        "Correct the name, or declare the edge.",
        RECORDINGS,
    ),
    Rule(
        "edge-wrong-parent",
        "A frame has another parent than described.",
        "Correct the node, or the description.",
        RECORDINGS,
    ),
    Rule(
        "edge-dropped",
        "tf2 drops a transform: its frame is its own parent, or has no name.",
        "Correct the frames that the node publishes.",
        RECORDINGS,
    ),
    Rule("edge-two-parents", "A frame was published under two parents.", "Stop one of the nodes.", RECORDINGS),
    Rule(
        "edge-two-values",
        "Two nodes publish one edge with two values: a stamp has both, the edge leaps back and forth, or a static edge "
        "has several.",
        "Stop one of the nodes.",
        RECORDINGS,
    ),
    Rule(
        "edge-published-twice",
        "A warning: two nodes seem to publish one edge, with the same values.",
        "Stop one of the nodes.",
        RECORDINGS,
    ),
    Rule("edge-static-and-moving", "An edge is on `/tf` and `/tf_static`.", "Stop one of the nodes.", RECORDINGS),
    Rule("edge-not-static", "An edge that never moves is on `/tf`.", "Publish it on `/tf_static`.", RECORDINGS),
    Rule("edge-not-moving", "An edge that moves is on `/tf_static`.", "Publish it on `/tf`.", RECORDINGS),
    Rule(
        "edge-wrong-value",
        "The value of an edge is not as described; the message contains the difference.",
        "Deploy what is compiled, or correct the description.",
        RECORDINGS,
    ),
    Rule(
        "mounted-backwards",
        "An edge is turned by a half turn about z: the yaw of a sensor that is mounted backwards is missing, or applied "
        "twice.",
        "Deploy what is compiled, or correct the description.",
        RECORDINGS,
    ),
    Rule(
        "not-a-rotation",
        "A transform contains NaN, or a quaternion whose length is not one: tf2 drops it.",
        "Correct the node.",
        RECORDINGS,
    ),
    Rule(
        "edge-missing",
        "Nobody published an edge that is described, in any combination of modes; or tf2_echo got no answer.",
        "The message names who should publish it; `--without NODE` if the node was not supposed to run.",
        RECORDINGS,
    ),
    Rule(
        "edge-of-other-mode",
        "Some edges are those of one mode, and others those of another: no described mode has both.",
        "Find out which nodes run; set the mode with `--mode`.",
        RECORDINGS,
    ),
    Rule(
        "frames-prefixed",
        "All frames of the transforms begin with a prefix that the description does not have; or none begins with "
        "`--prefix`. Nothing could be compared.",
        "`--prefix TEXT`, as in the message.",
        RECORDINGS,
    ),
    Rule(
        "edge-late",
        "A note: a moving edge was first published some time after the start of the recording.",
        "Start its publisher earlier, or let listeners wait.",
        RECORDINGS,
    ),
    Rule(
        "edge-stale",
        "The newest transform of an edge was older than `--stale` (1 s).",
        "Find out why its publisher stopped.",
        RECORDINGS,
    ),
    Rule(
        "stamp-zero",
        "Messages are stamped with time zero.",
        "A node with `use_sim_time` receives no `/clock`.",
        RECORDINGS,
    ),
    Rule("stamp-jumps-back", "Stamps jump back by more than 0.1 s.", "Use one clock for all nodes.", RECORDINGS),
    Rule(
        "stamp-other-clock",
        "Messages are stamped by another clock than the others: simulation time among wall clocks, a clock that begins "
        "in 1970, or one that is a minute or more away.",
        "`use_sim_time` for all nodes or for none; set the clocks of the computers.",
        RECORDINGS,
    ),
    Rule(
        "stamp-ahead",
        "A warning: messages are dated further ahead of the time when they were recorded than AMCL does it (1 s).",
        "Set the clock of the computer, or the parameter that dates ahead.",
        RECORDINGS,
    ),
    Rule(
        "stamp-clock-set",
        "A warning: the offset between stamps and the time when they were recorded changed during the recording.",
        "Set the clocks of all computers before the nodes start.",
        RECORDINGS,
    ),
    Rule(
        "joint-state-unknown",
        "`/joint_states` names a joint that is not described.",
        "Correct the driver, or the description.",
        RECORDINGS,
    ),
    Rule(
        "joint-state-missing",
        "`/joint_states` leaves out a joint that robot_state_publisher moves.",
        "Correct the driver.",
        RECORDINGS,
    ),
    Rule("joint-state-short", "A joint state has fewer positions than names.", "Correct the driver.", RECORDINGS),
    Rule(
        "joint-states-two-values",
        "Two nodes publish joint states of the same joints.",
        "Stop one of them.",
        RECORDINGS,
    ),
    Rule("joint-not-a-number", "A position is NaN or infinite.", "Correct the driver.", RECORDINGS),
    Rule(
        "joint-beyond-limit",
        "A warning: a joint was beyond its limits.",
        "Correct the limits, the zero of the servo, or the node that moves it there.",
        RECORDINGS,
    ),
    Rule(
        "joint-off-its-leader",
        "A warning: the reported position of a follower is not the one that its leader gives.",
        "Correct `mimic`, or let the driver leave followers out: robot_state_publisher uses reported positions.",
        RECORDINGS,
    ),
    Rule(
        "other-robot-description",
        "`/robot_description` is another robot than the compiled URDF.",
        "Deploy what is compiled.",
        RECORDINGS,
    ),
    Rule(
        "robot-description-text",
        "A note: `/robot_description` has the same meaning as the compiled URDF, but another text.",
        "Deploy what is compiled.",
        RECORDINGS,
    ),
    Rule(
        "robot-description-changed",
        "A warning: there was more than one `/robot_description`.",
        "Start one robot_state_publisher, with one URDF.",
        RECORDINGS,
    ),
    Rule(
        "frame-unknown",
        "A message names a frame that is neither described nor published.",
        "Correct `frame_id` in the driver, or describe the frame.",
        RECORDINGS,
    ),
    Rule(
        "frame-with-slash",
        'Messages are stamped with a frame that begins with "/". tf2 strips it from transforms only and refuses to look '
        "it up.",
        "Set `frame_id` without it.",
        RECORDINGS,
    ),
    Rule(
        "frame-not-as-declared",
        "No message has the frame that a sensor declares, and all messages of its type have another one.",
        "Correct `frame_id` in the driver, or declare the frame under `stamps`.",
        RECORDINGS,
    ),
    Rule(
        "frame-late",
        "The first messages of a sensor came before its frame was available.",
        "Wait for the frame, or start its publisher first.",
        RECORDINGS,
    ),
    Rule(
        "lookup-fails",
        "tf2 could not have answered at the exact stamps of messages on arrival, because an edge comes too seldom.",
        "Request the latest transform, wait with a timeout, or publish more often.",
        RECORDINGS,
    ),
)
