"""The navigate module: map, route planning, position estimation and driving."""
