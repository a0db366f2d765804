"""ROGUE: a roving office gopher that plans with PRODIGY4.0 while its robot drives."""
