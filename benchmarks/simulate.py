"""Steps of simulation per CPU second: the reference robot on its wheels on a floor, against a box on four wheels.

Both stand in MuJoCo with the settings of our MJCF (steps of 2 ms), the reference robot as its scene is compiled with
``base:=free``, driving forward; the box has four plain cylinders. CPU seconds of this process, in pairs.
The goal is 20,000 steps a second for the reference robot on a quiet machine.

Run with the environment's Python: ``python benchmarks/simulate.py [PAIRS]``.
"""

from __future__ import annotations

import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import mujoco

from pairs import compare, row
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.model.drive import Twist, drive_kinematics

STEPS, SETTLE = 4000, 500
GOAL = 6.6  # times the box, which does some 132,000 steps a second where the robot is to do 20,000
ROBOT = Path(__file__).resolve().parent.parent / "descriptions" / "rosorin" / "robot.yaml"
WHEEL = '<body pos="{x} {y} 0.04"><joint axis="0 1 0" damping="0.01"/>'
WHEEL += '<geom type="cylinder" size="0.04 0.015" euler="90 0 0" mass="0.07"/></body>'
BOX = f"""<mujoco><option integrator="implicitfast"/><worldbody><geom type="plane" size="0 0 1"/>
<body><freejoint/><geom type="box" size="0.14 0.07 0.03" pos="0 0 0.06" mass="1"/>
{"".join(WHEEL.format(x=x, y=y) for x in (-0.09, 0.09) for y in (-0.09, 0.09))}
</body></worldbody></mujoco>"""


def main(pairs: int) -> None:
    """Print the table."""
    ours, box = reference(), settled(mujoco.MjModel.from_xml_string(BOX))
    print(f"{f'{STEPS} steps':<42} {'ours':>11} {'box':>11}   ratio, median of {pairs} pairs")
    ratio = compare(partial(stepped, *ours), partial(stepped, *box), pairs)
    print(f"{row('on a floor / a box on four wheels', ratio, GOAL)}   {STEPS / ratio.first:,.0f} steps a CPU second")


def reference() -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return the reference robot in its scene, driving forward at 0.3 m/s."""
    made = compile_robot(ROBOT, {"base": "free"})
    if made.robot is None:
        raise SystemExit("the reference robot does not compile")
    with tempfile.TemporaryDirectory() as folder:
        for artifact in made.artifacts:
            Path(folder, artifact.file).write_text(artifact.text, "utf-8")
        model = mujoco.MjModel.from_xml_path(str(Path(folder, "scene.xml")))
    speeds = drive_kinematics(made.robot).speeds(Twist(vx=0.3))
    model, data = settled(model)
    for joint, speed in speeds.items():
        data.actuator(joint).ctrl = speed
    return model, data


def settled(model: mujoco.MjModel) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return a model at rest on its floor."""
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, SETTLE)
    return model, data


def stepped(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """Return the CPU seconds of some steps."""
    start = time.process_time()
    mujoco.mj_step(model, data, STEPS)
    return time.process_time() - start


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 7)
