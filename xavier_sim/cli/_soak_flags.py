"""What a soak is made of: its flags."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from tca_bus import ConfigError
from xavier_sim.cli._worlds import Count
from xavier_sim.floors import DEFAULT_FLOOR
from xavier_sim.messages import ProfileName
from xavier_sim.profile import PROFILES
from xavier_sim.sensors import Rays
from xavier_sim.soak import FaultKind, SoakOptions, possible_faults

ERRANDS = Group("Errands", sort_key=10)

Share = Annotated[float, Parameter(validator=Number(gte=0.0, lte=1.0))]
Hours = Annotated[float, Parameter(validator=Number(gt=0.0, lte=100_000.0))]


@Parameter(name="*", group=ERRANDS)
@dataclass(frozen=True, kw_only=True)
class ErrandFlags:
    """On what the course of a soak depends, beside its seed."""

    map: str = DEFAULT_FLOOR
    """Floor plan: the name of a floor that comes with it, or a YAML file."""
    profile: ProfileName = "xavier"
    """The robot: Xavier as a rule, on its bad days, or a robot of today with a lidar."""
    people: Annotated[Count, Parameter(name=("--people-walking", "--people"))] = 0
    """How many people walk the corridors and stand about in them."""
    carts: Count = 0
    """How many carts stand in the corridors, now here, now there."""
    fault: FaultKind | None = None
    """What is wrong with the robot, or goes wrong again and again."""
    navigator: str = "navigate"
    """Name of an installed navigator, or module:factory."""
    localizer: str | None = None
    """What tells the navigator where it is, if it has a choice: for navigate "pomdp", its default,
    "particles" or "odometry"."""
    policy: str | None = None
    """How the navigator picks a lost robot's way, if it has a choice: for navigate with its POMDP
    "voting", its default, "mls" or "qmdp"."""
    sigma: Annotated[float, Parameter(validator=Number(gte=0.0, lte=0.2))] = 0.03
    """Standard deviation of the errors in the navigator's map, metres."""
    shut: Share = 0.1
    """Share of the time that a door is shut, 0 to 1."""
    door_moves: Annotated[float, Parameter(validator=Number(gte=0.0, lte=3600.0))] = 1.0
    """How often an hour somebody opens or shuts each door."""
    doors: Annotated[int, Parameter(validator=Number(gte=0, lte=1000))] = 0
    """Go into every room and out again so many times, instead of anywhere at random."""
    rays: Annotated[Rays, Parameter(env_var="XAVIER_RAYS")] = "auto"
    """What casts the rays of the sensors: numba, the extra "fast", or numpy; auto takes numba where
    it is installed. The soak is the same."""

    def options(self, seed: int) -> SoakOptions:
        """The options of the soak of a seed.

        Raises:
            ConfigError: The robot has no sensor of the kind that is to fail.
        """
        possible = possible_faults(PROFILES[self.profile])
        if self.fault is not None and self.fault not in possible:
            expected = f"one that a robot of profile {self.profile} can have: {', '.join(possible)}"
            raise ConfigError("--fault", self.fault, expected)
        return SoakOptions(
            seed=seed,
            floor=self.map,
            profile=self.profile,
            people=self.people,
            carts=self.carts,
            fault=self.fault,
            navigator=self.navigator,
            navigator_options=self._navigator_options(),
            survey_sigma=self.sigma,
            shut_share=self.shut,
            door_moves_per_hour=self.door_moves,
            doors_in_and_out=self.doors,
            rays=self.rays,
        )

    def _navigator_options(self) -> dict[str, str]:
        """What is handed on to the navigator: what was given."""
        choices = {"localizer": self.localizer, "policy": self.policy}
        return {name: choice for name, choice in choices.items() if choice}


DEFAULT_ERRANDS = ErrandFlags()


def parse_seeds(text: str) -> list[int]:
    """The seeds that ``--seeds`` names.

    Raises:
        ConfigError: they are no whole numbers of 0 or more, each once.
    """
    words = [word.strip() for word in text.split(",")]
    seeds = [int(word) for word in words if word.isascii() and word.isdigit()]
    if len(seeds) < len(words) or len(set(seeds)) < len(seeds):
        raise ConfigError("--seeds", text, "whole numbers of 0 or more, each once, as in 1,2,3")
    return seeds
