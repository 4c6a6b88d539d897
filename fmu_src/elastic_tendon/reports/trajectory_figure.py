"""A simulated trajectory over time."""

from matplotlib.figure import Figure

from elastic_tendon.reports.comparison_figures import BLUE, tidy
from elastic_tendon.reports.thinning import envelope
from elastic_tendon.reports.units import with_unit
from elastic_tendon.simulation.simulate import Trajectory

DRAWN = ("joint_position", "joint_torque", "slack_state")


def trajectory_figure(trajectory: Trajectory) -> Figure:
    """Draw joint position, joint torque and slack state over time.

    Parameters
    ----------
    trajectory : Trajectory

    Returns
    -------
    matplotlib.figure.Figure; one pair of axes for each
    """
    figure = Figure(figsize=(8.0, 6.0), layout="constrained")
    every = figure.subplots(len(DRAWN), 1, sharex=True)
    for axes, name in zip(every, DRAWN, strict=True):
        if name == "slack_state":
            axes.step(trajectory.time, trajectory[name], where="post", color=BLUE)
            axes.set_ylabel("slack state")
            axes.set_yticks([1, 2, 3, 4], ["I", "II", "III", "both slack"])
        else:
            axes.plot(*envelope(trajectory.time, trajectory[name]), color=BLUE)
            axes.set_ylabel(with_unit(name))
        tidy(axes)
    every[-1].set_xlabel("time (s)")
    return figure
