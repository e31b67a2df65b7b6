"""The programs named against the states in FOLDER/states.json, on the models beside it and on the URDF that they come from. Prints the largest differences,
each relative to the largest entry; fails if one is more than two programs' rounding."""

import json
import pathlib
import sys

import mujoco
import numpy as np
import pinocchio as pin

# MuJoCo keeps attitudes as quaternions, and diagonalises inertias when it reads a model.
TOLERANCES = {"pinocchio": 1e-12, "mujoco": 1e-10}
MANY = 10


class Comparison:
    def __init__(self):
        self.worst = {}

    def add(self, program, what, ours, theirs):
        ours, theirs = np.asarray(ours), np.asarray(theirs)
        assert ours.shape == theirs.shape, (program, what, ours.shape, theirs.shape)
        difference = np.abs(ours - theirs).max() / np.abs(theirs).max()
        key = program, what
        self.worst[key] = max(self.worst.get(key, 0.0), difference)

    def passed(self):
        passed = True
        for (program, what), difference in self.worst.items():
            good = difference <= TOLERANCES[program]  # false for NaN
            print(f"  {program}: {what}: {difference:.1e}{'' if good else ' TOO FAR'}")
            passed = passed and good
        return passed


def linear_first(joints):
    """Pinocchio and MuJoCo have the base's linear velocity before the angular one."""
    return [3, 4, 5, 0, 1, 2, *range(6, 6 + joints)]


def pinocchio_position(model, joints, angles):
    position = pin.neutral(model)
    for joint, angle in zip(joints, angles, strict=True):
        continuous = joint.nq == 2
        position[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(angle), np.sin(angle)] if continuous else [angle]
    return position


def pinocchio_mass(model, data, position):
    upper = np.triu(pin.crba(model, data, position))
    return upper + np.triu(upper, 1).T


def pinocchio(folder, states, comparison):
    model = pin.buildModelFromUrdf(str(folder / "space.urdf"), pin.JointModelFreeFlyer())
    model.gravity.setZero()
    data = model.createData()
    order = linear_first(model.nv - 6)
    for state in states:
        position = pinocchio_position(model, model.joints[2:], state["position"])
        velocity = np.array(state["velocity"])[order]
        torque = np.concatenate([np.zeros(6), state["torque"]])
        mass = np.array(state["mass"])[np.ix_(order, order)]
        comparison.add("pinocchio", "mass matrix", mass, pinocchio_mass(model, data, position))
        coriolis = np.array(state["coriolis_torque"])[order]
        comparison.add("pinocchio", "Coriolis torque", coriolis, pin.nle(model, data, position, velocity))
        acceleration = np.array(state["acceleration"])[order]
        comparison.add("pinocchio", "acceleration", acceleration, pin.aba(model, data, position, velocity, torque))


def original(source, locked, states, comparison):
    """The arm's block of the mass matrix from the file that uarm read: joints that uarm locks are locked here too."""
    whole = pin.buildModelFromUrdf(str(source))
    locked = [whole.getJointId(name) for name in locked]
    model = pin.buildReducedModel(whole, locked, pin.neutral(whole))
    data = model.createData()
    for state in states:
        position = pinocchio_position(model, model.joints[1:], state["position"])
        mass = np.array(state["mass"])[6:, 6:]
        comparison.add("pinocchio", "mass matrix of the file read", mass, pinocchio_mass(model, data, position))


def accelerate(model, position, velocity, torque):
    data = mujoco.MjData(model)
    data.qpos[:] = position
    data.qvel[:] = velocity
    data.ctrl[:] = torque
    mujoco.mj_forward(model, data)
    return data.qacc.copy()


def mujoco_models(folder, states, comparison):
    space = mujoco.MjModel.from_xml_path(str(folder / "space.xml"))
    dem = mujoco.MjModel.from_xml_path(str(folder / "dem.xml"))
    order = linear_first(space.nv - 6)
    upright = [1.0, 0.0, 0.0, 0.0]
    for state in states:
        velocity = np.array(state["velocity"])[order]
        found = accelerate(space, [0, 0, 0, *upright, *state["position"]], velocity, state["torque"])
        # MuJoCo's is the rate in axes that stand still, ours that of the components in base axes.
        found[:3] -= np.cross(velocity[3:6], velocity[:3])
        comparison.add("mujoco", "acceleration", np.array(state["acceleration"])[order], found)
        found = accelerate(dem, [*upright, *state["position"]], velocity[3:], state["torque"])
        comparison.add("mujoco", "acceleration of the equivalent", state["dem_acceleration"], found)


def main():
    source, folder = map(pathlib.Path, sys.argv[1:3])
    programs = sys.argv[3:]
    states = json.loads((folder / "states.json").read_text())
    assert len(states) >= MANY, len(states)
    print(f"{folder.name}: {len(states)} states")
    comparison = Comparison()
    locked = json.loads((folder / "map.json").read_text())["locked_joints"]
    if "pinocchio" in programs:
        original(source, locked, states, comparison)
        pinocchio(folder, states, comparison)
    if "mujoco" in programs:
        mujoco_models(folder, states, comparison)
    assert len(comparison.worst) > 1, programs
    sys.exit(0 if comparison.passed() else 1)


main()
