"""Routes over the graph: A* by time, round doors and places believed to be blocked."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from navigate.body import ROBOT_RADIUS
from navigate.maps import Floor, Passage, Point, frame
from navigate.messages import Route
from navigate.routes._graph import (
    CORRIDOR_STANDOFF,
    CRUISE,
    Graph,
    Link,
    Node,
    build_graph,
    missing,
    nodes_of,
    show_point,
    straight,
)
from navigate.routes._hindrances import Hindrances


class NoRouteError(LookupError):
    """The map has no way there, or none that is not believed to be blocked."""

    def __init__(self, goal: Point, why: str) -> None:
        self.goal, self.why = goal, why
        super().__init__(f"no route to {show_point(goal)}: {why}")


@dataclass(frozen=True, slots=True)
class Step:
    """Go straight to ``to``, which lies in ``space``; through ``door`` if there is one."""

    to: Point
    space: str
    metres: float
    seconds: float
    door: Passage | None = None


@dataclass
class _Search:
    """A* from one end to the other; nodes -1 and -2 are the start and the goal."""

    graph: Graph
    goal: Point
    entries: dict[int, float]
    exits: dict[int, float]
    cost: Callable[[Link, int], float]
    best: dict[int, float] = field(default_factory=dict)
    before: dict[int, tuple[int, Link | None]] = field(default_factory=dict)

    def run(self) -> list[tuple[int, Link | None]]:
        """The nodes of the best way with the links that lead to them; empty when there is none."""
        queue: list[tuple[float, int]] = []
        for node, seconds in self.entries.items():
            self._reach(queue, node, seconds, (-1, None))
        done: set[int] = set()
        while queue:
            _, node = heapq.heappop(queue)
            if node == -2:
                return self._trace()
            if node in done:
                continue
            done.add(node)
            self._expand(queue, node)
        return []

    def _expand(self, queue: list[tuple[float, int]], node: int) -> None:
        for other, link in self.graph.around[node]:
            self._reach(queue, other, self.best[node] + self.cost(link, other), (node, link))
        if node in self.exits:
            self._reach(queue, -2, self.best[node] + self.exits[node], (node, None))

    def _reach(
        self,
        queue: list[tuple[float, int]],
        node: int,
        seconds: float,
        how: tuple[int, Link | None],
    ) -> None:
        if seconds < self.best.get(node, math.inf):
            self.best[node], self.before[node] = seconds, how
            ahead = 0.0 if node == -2 else math.dist(self.graph.nodes[node].at, self.goal) / CRUISE
            heapq.heappush(queue, (seconds + ahead, node))

    def _trace(self) -> list[tuple[int, Link | None]]:
        way: list[tuple[int, Link | None]] = []
        node, _ = self.before[-2]
        while node != -1:
            previous, link = self.before[node]
            way.append((node, link))
            node = previous
        return way[::-1]


class Planner:
    """Plans routes on a floor."""

    def __init__(self, floor: Floor) -> None:
        self.floor = floor
        self.graph = build_graph(floor)

    def plan(self, start: Point, goal: Point, hindrances: Hindrances | None = None) -> list[Step]:
        """The fastest way from ``start`` to ``goal``, both in metres.

        Raises:
            NoRouteError: ``goal`` lies in no free space, or every way there is blocked.
        """
        self.check_goal(goal)
        blocked = hindrances or Hindrances()
        if self.is_direct(start, goal, blocked):
            return [_step(start, goal, self.floor.space_nearest(*goal).name)]
        steps = self._search(start, goal, blocked)
        if not steps:
            raise NoRouteError(goal, _why(blocked))
        return steps

    def check_goal(self, goal: Point) -> None:
        """Make sure that the robot could stand at a point at all, wherever it is now.

        Raises:
            NoRouteError: it lies in no free space.
        """
        if self.floor.space_at(*goal) is None:
            raise NoRouteError(goal, "that lies in no space of the floor")
        if not self.floor.free(*goal, clearance=0.2):
            raise NoRouteError(goal, "there is no room for the robot")

    def is_reachable(self, goal: Point) -> bool:
        """Whether the robot could stand at a point at all."""
        try:
            self.check_goal(goal)
        except NoRouteError:
            return False
        return True

    def is_direct(self, start: Point, goal: Point, blocked: Hindrances) -> bool:
        """Whether the way is straight, within one space, and nothing is in it."""
        begins, ends = self.space_of(start), self.floor.space_nearest(*goal).name
        return begins == ends and not blocked.lie_ahead(start, goal)

    def seconds_now(self, at: Point, steps: Sequence[Step], blocked: Hindrances) -> float:
        """Seconds that a route takes from ``at``, as the hindrances are; infinite if blocked."""
        here = at
        for number, step in enumerate(steps):
            door = step.door.name if step.door else None
            if door in blocked.doors or (number and blocked.lie_between(at, step.to)):
                return math.inf
            at = step.to
        return seconds_left(here, steps)

    def space_of(self, start: Point) -> str | None:
        """The space that a robot is in, None when it stands in the frame of a door."""
        in_frame = self.floor.doorway_at(*start) is not None
        return None if in_frame else self.floor.space_nearest(*start).name

    def cost(self, link: Link, to: int, blocked: Hindrances) -> float:
        """Seconds that a link of the graph costs on the average; infinite where it is blocked."""
        if not blocked:
            return link.seconds_to(to)
        one, other = self.graph.nodes[link.one].at, self.graph.nodes[link.other].at
        if blocked.stops(link, one, other):
            return math.inf
        return link.seconds_to(to) + blocked.delay(link.door, one, other)

    def ways_in(self, start: Point, blocked: Hindrances) -> dict[int, float]:
        """Seconds from a point to the nodes that are seen from there, by their indices."""
        costs = self._costs(start, self._entries(start), blocked)
        nodes = self.graph.nodes
        return {i: seconds + missing(start, nodes[i]) for i, seconds in costs.items()}

    def ways_out(self, goal: Point, blocked: Hindrances) -> dict[int, float]:
        """Seconds to a point from the nodes that are seen from there, by their indices."""
        ends = self.floor.space_nearest(*goal).name
        return self._costs(goal, self.graph.at.get(ends, []), blocked)

    def _search(self, start: Point, goal: Point, blocked: Hindrances) -> list[Step]:
        search = _Search(
            self.graph,
            goal,
            entries=self.ways_in(start, blocked),
            exits=self.ways_out(goal, blocked),
            cost=lambda link, to: self.cost(link, to, blocked),
        )
        steps, at, door, begun = [], start, self.floor.doorway_at(*start), 0.0
        for node, link in search.run():
            seconds = search.best[node] - begun
            steps.append(self._taken(at, self.graph.nodes[node], link, door, seconds))
            at, door, begun = self.graph.nodes[node].at, None, search.best[node]
        ends = self.floor.space_nearest(*goal).name
        return [*steps, _step(at, goal, ends)] if steps else []

    def _entries(self, start: Point) -> Iterable[int]:
        door = self.floor.doorway_at(*start)
        if door is not None:
            return (i for i, node in enumerate(self.graph.nodes) if node.passage == door.name)
        space = self.floor.space_nearest(*start).name
        return {*self.graph.at.get(space, []), *self._beside(start, space)}

    def _beside(self, start: Point, space: str) -> Iterable[int]:
        """The nodes on both sides of the open passages in which a point of ``space`` lies."""
        for number, passage in enumerate(self.floor.passages):
            if passage.door or space not in passage.spaces or passage.normal == (0.0, 0.0):
                continue
            ahead, aside = frame(passage, *start)
            if abs(ahead) < CORRIDOR_STANDOFF and abs(aside) < passage.width / 2 - ROBOT_RADIUS:
                yield from nodes_of(number)

    def _costs(self, point: Point, nodes: Iterable[int], blocked: Hindrances) -> dict[int, float]:
        spots = ((i, self.graph.nodes[i].at) for i in nodes)
        return {
            i: straight(math.dist(point, at)) + blocked.delay(None, point, at)
            for i, at in spots
            if not blocked.lie_ahead(point, at)
        }

    def _taken(
        self, at: Point, node: Node, link: Link | None, door: Passage | None, seconds: float
    ) -> Step:
        """The step to a node; out of a door's frame it counts as passing that door."""
        through = self.floor.doors[link.door] if link and link.door else door
        return Step(node.at, node.space, math.dist(at, node.at), seconds, through)


def describe(start: Point, steps: list[Step]) -> Route:
    """A route as the message that `PlanRoute` answers with."""
    via: list[str] = []
    for step in steps:
        via += [step.door.name] if step.door else []
        via += [step.space] if not via or via[-1] != step.space else []
    points = [start] + [step.to for step in steps if step.metres > 0.01]
    return Route(
        points=[(round(x, 3), round(y, 3)) for x, y in points],
        via=list(dict.fromkeys(via)),
        metres=round(sum(step.metres for step in steps), 2),
        seconds=round(sum(step.seconds for step in steps), 1),
    )


def remaining(at: Point, steps: list[Step]) -> float:
    """Metres left to go from ``at`` over ``steps``."""
    if not steps:
        return 0.0
    return math.dist(at, steps[0].to) + sum(step.metres for step in steps[1:])


def seconds_left(at: Point, steps: Sequence[Step]) -> float:
    """Seconds left to go from ``at`` over ``steps``, as the planner reckons them."""
    if not steps:
        return 0.0
    step = steps[0]
    begun = min(1.0, math.dist(at, step.to) / step.metres) if step.metres > 0.0 else 0.0
    return step.seconds * begun + sum(step.seconds for step in steps[1:])


def side_of(door: Passage, at: Point) -> float:
    """-1.0 on the side of the door's first space, 1.0 on the other."""
    return 1.0 if frame(door, *at)[0] > 0.0 else -1.0


def _why(blocked: Hindrances) -> str:
    met = [f"door {name}" for name in sorted(blocked.doors)]
    met += [f"({x:.1f}, {y:.1f})" for x, y in blocked.points]
    if not met:
        return "the floor is closed off there"
    return f"every way there is blocked, as was seen lately at {', '.join(met)}"


def _step(start: Point, goal: Point, space: str) -> Step:
    metres = math.dist(start, goal)
    return Step(goal, space, metres, straight(metres))
