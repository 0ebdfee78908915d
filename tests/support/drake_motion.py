"""Simulate an SDF in Drake; a program of its own for a Python that has Drake.

Standard input is JSON: ``file``, ``seconds``, ``steps``, ``floor`` (friction of the ground, or null), ``positions`` and
``velocities`` by joint, and ``push`` (m/s along x by free link). It prints the positions (m) of all links at the end of
each of the steps.
"""

import json
import sys

import numpy as np
from pydrake.geometry import HalfSpace
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, DiscreteContactApproximation
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder


def main() -> None:
    """Simulate once."""
    asked = json.load(sys.stdin)
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 1e-3)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    (model,) = Parser(plant).AddModels(asked["file"])
    if asked["floor"] is not None:
        friction = CoulombFriction(asked["floor"], asked["floor"])
        plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "floor", friction)
    elif not asked["push"]:
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base_link", model))
    plant.Finalize()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for name, position in asked["positions"].items():
        joint = plant.GetJointByName(name)
        getattr(joint, "set_angle", getattr(joint, "set_translation", None))(context, position)
    for name, speed in asked["push"].items():
        body = plant.GetBodyByName(name)
        plant.SetFreeBodySpatialVelocity(body, SpatialVelocity(np.zeros(3), np.array([speed, 0, 0])), context)
    bodies = [plant.get_body(index) for index in plant.GetBodyIndices(model)]
    found = []
    for step in range(1, asked["steps"] + 1):
        simulator.AdvanceTo(asked["seconds"] * step / asked["steps"])
        found.append({body.name(): plant.EvalBodyPoseInWorld(context, body).translation().tolist() for body in bodies})
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()
