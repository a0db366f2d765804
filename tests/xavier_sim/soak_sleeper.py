"""A navigator for tests of soaks that take no time."""

from __future__ import annotations


class Sleeper:
    """A navigator that gives every goal up."""

    pose, done, confidence, recoveries = (0.0, 0.0, 0.0), True, 0.5, 0
    speed = turn = 0.0
    reason = "asleep"

    def __init__(self, plan, *, seed):
        self.told = []

    @property
    def failure(self):
        return self

    position = failure

    def step(self, sensors):
        return self

    def start(self, goal, sensors):
        return self

    def cancel(self):
        pass

    def report(self, drive):
        return self

    def set_pose(self, pose):
        self.told.append(pose)

    def freeze(self):
        return {}

    def thaw(self, state):
        pass
