from dataclasses import astuple

import numpy as np

from navigate.maps import Floor, load_plan
from navigate.position._walls_met import MOST_TILES, WallsMet


def test_a_robot_that_has_been_everywhere_keeps_the_walls_around_few_places_and_sees_the_same():
    floor = Floor(load_plan())
    walls, places = WallsMet(floor), [(x, y) for x in range(-5, 45) for y in range(-2, 12)]
    assert len(places) > MOST_TILES
    first = [walls.nearest(sonars_at(*at)) for at in places[:3]]
    for at in places:
        walls.nearest(sonars_at(*at))
    assert walls.kept == MOST_TILES
    again = [walls.nearest(sonars_at(*at)) for at in places[:3]]
    for before, after in zip(first, again, strict=True):
        for one, other in zip(before, after, strict=True):
            assert all(map(np.array_equal, astuple(one), astuple(other)))


def sonars_at(x, y):
    return np.array([[x + 0.3, y + 0.6, angle] for angle in np.arange(0.0, 6.0, 0.5)])
