"""The motion in FOLDER/motion.json, integrated anew with the accelerations of the programs named, by the same method and step: the classic Runge-Kutta
method on the quaternion as four numbers, divided by its norm after each step. Prints the largest differences; fails if one is more than 1e-9."""

import json
import pathlib
import sys

import mujoco
import numpy as np
import pinocchio as pin

TOLERANCE = 1e-9


def turned(attitude, vector):
    axis, real = attitude[:3], attitude[3]
    twice = 2.0 * np.cross(axis, vector)
    return vector + real * twice + np.cross(axis, twice)


def quaternion_rate(attitude, angular):
    axis, real = attitude[:3], attitude[3]
    return 0.5 * np.append(real * angular + np.cross(axis, angular), -axis @ angular)


class Pinocchio:
    def __init__(self, folder):
        self.model = pin.buildModelFromUrdf(str(folder / "space.urdf"), pin.JointModelFreeFlyer())
        self.model.gravity.setZero()
        self.data = self.model.createData()

    def acceleration(self, attitude, place, position, velocity, torque):
        configuration = pin.neutral(self.model)
        configuration[:3], configuration[3:7] = place, attitude / np.linalg.norm(attitude)
        for joint, angle in zip(self.model.joints[2:], position, strict=True):
            values = [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
            configuration[joint.idx_q : joint.idx_q + joint.nq] = values
        velocity = np.concatenate([velocity[3:6], velocity[:3], velocity[6:]])
        found = pin.aba(self.model, self.data, configuration, velocity, np.concatenate([np.zeros(6), torque]))
        return np.concatenate([found[3:6], found[:3], found[6:]])


class Mujoco:
    def __init__(self, folder):
        self.model = mujoco.MjModel.from_xml_path(str(folder / "space.xml"))
        self.data = mujoco.MjData(self.model)

    def acceleration(self, attitude, place, position, velocity, torque):
        attitude = attitude / np.linalg.norm(attitude)
        angular, linear = velocity[:3], velocity[3:6]
        self.data.qpos[:3], self.data.qpos[3], self.data.qpos[4:7] = place, attitude[3], attitude[:3]
        self.data.qpos[7:] = position
        # MuJoCo has the linear velocity in axes that stand still.
        self.data.qvel[:3], self.data.qvel[3:6], self.data.qvel[6:] = turned(attitude, linear), angular, velocity[6:]
        self.data.ctrl[:] = torque
        mujoco.mj_forward(self.model, self.data)
        found = self.data.qacc
        back = np.append(-attitude[:3], attitude[3])
        return np.concatenate([found[3:6], turned(back, found[:3]) - np.cross(angular, linear), found[6:]])


PROGRAMS = {"pinocchio": Pinocchio, "mujoco": Mujoco}


def split(state, joints):
    return np.split(state, np.cumsum([4, 3, joints]))


def integrate(program, motion, joints):
    """Yields the state at each row but the first: attitude, place, position, velocity."""
    amplitude, frequency, phase = (np.array(motion[key]) for key in ("amplitude", "frequency", "phase"))

    def rate(time, state):
        attitude, place, position, velocity = split(state, joints)
        torque = amplitude * np.sin(frequency * time + phase)
        acceleration = program.acceleration(attitude, place, position, velocity, torque)
        moving = quaternion_rate(attitude, velocity[:3]), turned(attitude, velocity[3:6])
        return np.concatenate([*moving, velocity[6:], acceleration])

    first = motion["rows"][0]
    state = np.concatenate([first[key] for key in ("attitude", "place", "position", "velocity")])
    step = motion["step_s"]
    for row in range(len(motion["rows"]) - 1):
        for index in range(motion["steps_per_row"]):
            time = (row * motion["steps_per_row"] + index) * step
            a = rate(time, state)
            b = rate(time + step / 2, state + a * (step / 2))
            c = rate(time + step / 2, state + b * (step / 2))
            d = rate(time + step, state + c * step)
            state = state + (a + 2 * (b + c) + d) * (step / 6)
            state[:4] /= np.linalg.norm(state[:4])
        yield state


def main():
    folder, names = pathlib.Path(sys.argv[1]), sys.argv[2:]
    motion = json.loads((folder / "motion.json").read_text())
    joints = len(motion["amplitude"])
    first, last = (np.array(motion["rows"][index]["position"]) for index in (0, -1))
    assert len(motion["rows"]) > 30 and np.abs(last - first).max() > 0.3, "no motion"
    passed = bool(names)
    for name in names:
        worst = dict.fromkeys(("attitude", "place", "position", "velocity"), 0.0)
        rows = motion["rows"][1:]
        for row, state in zip(rows, integrate(PROGRAMS[name](folder), motion, joints), strict=True):
            for key, found in zip(worst, split(state, joints), strict=True):
                worst[key] = max(worst[key], np.abs(found - row[key]).max())
        good = all(difference <= TOLERANCE for difference in worst.values())  # false for NaN
        text = ", ".join(f"{key} {difference:.1e}" for key, difference in worst.items())
        print(f"  {name}: 3 s of motion: {text}{'' if good else ' TOO FAR'}")
        passed = passed and good
    sys.exit(0 if passed else 1)


main()
