"""The soak where all processes run, beside the one in which cores run in one process."""
