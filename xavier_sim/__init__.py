"""Xavier, simulated: a floor with walls and doors, a robot in it, and people to talk to."""
