"""Linear models around each stiffness state, and what they say: see `linearise`."""
