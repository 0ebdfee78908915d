"""Runs inside ROS 1, with Debian's Python: sets a parameter, or publishes joint states and asks tf2 for every frame."""

import json
import sys
import time

WAIT = 20.0


def set_parameter(name):
    import rosgraph

    rosgraph.Master("/tests").setParam(name, sys.stdin.read())


def run():
    import rospy
    import tf2_msgs.msg
    import tf2_ros
    from sensor_msgs.msg import JointState

    asked = json.loads(sys.stdin.read())
    out, sys.stdout = sys.stdout, sys.stderr
    rospy.init_node("tests", disable_signals=True)
    messages = []

    def heard(topic):
        def take(message):
            node = message._connection_header["callerid"].lstrip("/")
            for one in message.transforms:
                t, r = one.transform.translation, one.transform.rotation
                pose = [t.x, t.y, t.z, r.x, r.y, r.z, r.w]
                times = [one.header.stamp.to_nsec(), time.time_ns()]
                messages.append([topic, node, one.header.frame_id, one.child_frame_id, *times, pose])

        return take

    listeners = [rospy.Subscriber(topic, tf2_msgs.msg.TFMessage, heard(topic)) for topic in ("/tf", "/tf_static")]
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)
    publisher = rospy.Publisher("/joint_states", JointState, queue_size=10)
    await_nodes(asked["nodes"], publisher)
    answers, sent = [], []
    for state in asked["states"]:
        sent.append(publish(publisher, state, messages))
        answers.append(poses(buffer))
    del listeners, listener
    json.dump({"states": answers, "messages": messages, "joint_states": sent}, out)


def await_nodes(nodes, publisher):
    """Wait until each node is there and robot_state_publisher listens."""
    import rosgraph

    until = time.monotonic() + WAIT
    while True:
        publishers, _, _ = rosgraph.Master("/tests").getSystemState()
        there = {node.lstrip("/") for topic, names in publishers if topic in ("/tf", "/tf_static") for node in names}
        if there >= set(nodes) and publisher.get_num_connections() > 0:
            time.sleep(0.3)  # latched messages are on their way
            return
        if time.monotonic() > until:
            raise SystemExit("missing: " + ", ".join(sorted(set(nodes) - there)))
        time.sleep(0.02)


def publish(publisher, state, messages):
    """Publish a joint state until tf says it; return the stamps of the messages that were sent."""
    import rospy
    from sensor_msgs.msg import JointState

    stamps = []
    for _ in range(5):
        message = JointState()
        message.header.stamp = rospy.Time.now()
        message.name, message.position = list(state), list(state.values())
        publisher.publish(message)
        stamps.append(message.header.stamp.to_nsec())
        until = time.monotonic() + 1
        while not any(one[0] == "/tf" and one[4] == stamps[-1] for one in messages) and time.monotonic() < until:
            time.sleep(0.005)
        time.sleep(0.02)
    return [state, stamps]


def poses(buffer):
    """Return where every frame that tf2 knows sits in the root of its tree, as it answers for the latest time."""
    import rospy
    import yaml

    frames = yaml.safe_load(buffer.all_frames_as_yaml()) or {}
    answer = {}
    for child, entry in frames.items():
        root = entry["parent"]
        while root in frames:
            root = frames[root]["parent"]
        found = buffer.lookup_transform(root, child, rospy.Time(0)).transform
        t, r = found.translation, found.rotation
        answer[child] = [root, [t.x, t.y, t.z], [r.x, r.y, r.z, r.w]]
    return answer


if __name__ == "__main__":
    set_parameter(*sys.argv[2:]) if sys.argv[1] == "set" else run()
