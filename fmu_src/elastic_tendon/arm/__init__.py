"""Arms: actuators that drive the joints of a robot which MuJoCo moves, and the way back."""
