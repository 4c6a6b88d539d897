"""Where the squared error is: which variable tells most, and which part of its range, in words."""

from collections.abc import Sequence

import numpy as np

from elastic_tendon.actuator.transmission import SlackState
from elastic_tendon.comparison.bins import Bin
from elastic_tendon.comparison.partition import Partition, range_text
from elastic_tendon.comparison.patterns import Evidence, Finding
from elastic_tendon.comparison.residuals import Array

# share of the squared error that a concentration holds at least, and times its share of samples
CONCENTRATED, DENSER = 0.6, 1.5
# when it was tells less of a cause than what the joint did: time must concentrate more by this
MERE_TIME = 0.1
ERROR, TORQUE = "squared error", "missing torque's square"
PLURALS = {
    "deflection": "deflections",
    "joint_velocity": "joint velocities",
    "joint_acceleration": "joint accelerations",
    "joint_position": "joint positions",
    "motor_position": "motor positions",
    "load_torque": "load torques",
    "time": "times",
    "frequency": "frequencies",
}


def by_concentration(bins: Sequence[Bin]) -> list[str]:
    """Variables, the one first whose bins hold most of the error beyond their share of samples.

    A band of frequencies has no share of the samples, so the frequency comes last.

    Parameters
    ----------
    bins : of one signal; of each variable all, as the shares of samples follow from their counts
    """
    totals: dict[str, int] = {}
    for bin_ in bins:
        totals[bin_.by] = totals.get(bin_.by, 0) + bin_.count
    excess = dict.fromkeys(totals, 0.0)
    for bin_ in bins:
        if bin_.stands_out:
            excess[bin_.by] += max(bin_.share - bin_.count / totals[bin_.by], 0.0)
    excess["time"] = excess.get("time", 0.0) - MERE_TIME
    return sorted(totals, key=lambda by: (by == "frequency", -excess[by]))


def densest(bins: Sequence[Bin]) -> str:
    """Where the squared error is densest, in the first variable that tells; else that none does."""
    for by in by_concentration(bins):
        if text := _dense_part([bin_ for bin_ in bins if bin_.by == by], ERROR):
            return text
    return "the error stands out above the noise, everywhere alike"


def outside(evidence: Evidence, bounds: tuple[float, ...]) -> str:
    """How much lies beyond bounds of the deflection, each on its side of 0."""
    deflection = evidence.variables["deflection"]
    beyond = np.any([np.sign(bound) * deflection > abs(bound) for bound in bounds], axis=0)
    squares = {ERROR: evidence.residual**2, TORQUE: evidence.missing.torque**2}
    shares = {
        what: float(np.sum(squared[beyond]) / np.sum(squared)) for what, squared in squares.items()
    }
    enough = max(CONCENTRATED, DENSER * float(np.mean(beyond)))
    what = next((name for name, share in shares.items() if share >= enough), TORQUE)
    places = " and ".join(f"{bound:.3g}" for bound in bounds)
    both = ", in both directions" if len(bounds) > 1 else ""
    share = f"{100.0 * shares[what]:.0f} % of the {what}"
    return f"{share} lies beyond {places} rad of deflection{both}"


def concentration(evidence: Evidence, finding: Finding) -> str:
    """Where the error, else the missing torque, is dense in the finding's variable; or nothing."""
    by = finding.pattern.by
    bins = [bin_ for bin_ in evidence.bins if bin_.by == by]
    text = _dense_part(bins, ERROR)
    if text or evidence.signal != "joint_position":
        return text
    shares, sizes = _of_torque(evidence.parts[by], evidence.missing.torque)
    return _dense(bins, shares, sizes, TORQUE)


def _of_torque(part: Partition, torque: Array) -> tuple[list[float], list[float]]:
    """Share of the torque's square in each bin, and its RMS there."""
    means = part.means(torque**2)
    sums = means * part.counts
    return (sums / np.sum(sums)).tolist(), np.sqrt(means).tolist()


def _dense_part(bins: list[Bin], what: str) -> str:
    """Bins of one variable that hold most of the squared error, if each of them stands out."""
    chosen_from = [bin_.share for bin_ in bins], [bin_.rmse for bin_ in bins]
    if not all(bins[i].stands_out for i in _fullest(*chosen_from)):
        return ""
    return _dense(bins, *chosen_from, what)


def _fullest(shares: list[float], sizes: list[float]) -> list[int]:
    """The largest bins, until they hold enough of the whole."""
    chosen: list[int] = []
    for index in sorted(range(len(sizes)), key=lambda position: -sizes[position]):
        chosen.append(index)
        if sum(shares[i] for i in chosen) >= CONCENTRATED:
            break
    return chosen


def _dense(bins: list[Bin], shares: list[float], sizes: list[float], what: str) -> str:
    """The part of one variable's range that holds most of it in few samples; or nothing."""
    chosen = _fullest(shares, sizes)
    share = sum(shares[i] for i in chosen)
    samples = sum(bins[i].count for i in chosen) / sum(bin_.count for bin_ in bins)
    if share < DENSER * samples or len(chosen) == len(bins):
        return ""
    return f"{100.0 * share:.0f} % of the {what} lies {_range_words(bins, sorted(chosen))}"


STATES = {
    SlackState.I.label: "while the lower tendon is slack",
    SlackState.II.label: "while the upper tendon is slack",
    SlackState.III.label: "while both tendons are taut",
    SlackState.BOTH.label: "while both tendons are slack",
    "negative": "while the joint moves in the negative direction",
    "positive": "while the joint moves in the positive direction",
    "at rest": "while the joint is at rest",
}


def _range_words(bins: list[Bin], chosen: list[int]) -> str:
    edges = [(bin_.lower, bin_.upper) for bin_ in bins]
    ranges = [(low, high) for low, high in edges if low is not None and high is not None]
    if len(ranges) < len(bins):
        return " and ".join(STATES[bins[i].bin] for i in chosen)
    unit = bins[0].bin.split()[-1]
    quantity = PLURALS[bins[0].by]
    inner = [i for i in range(len(bins)) if i not in chosen]
    if inner[0] > 0 and inner[-1] < len(bins) - 1 and len(inner) == 1 + inner[-1] - inner[0]:
        low, high = ranges[inner[0]][0], ranges[inner[-1]][1]
        both = ", in both directions" if low < 0.0 < high else ""
        return f"at {quantity} below {range_text(low, high, ' or above ')} {unit}{both}"
    firsts = [i for i in chosen if i - 1 not in chosen]
    lasts = [i for i in chosen if i + 1 not in chosen]
    between = (
        f"between {range_text(ranges[i][0], ranges[j][1], ' and ')} {unit}"
        for i, j in zip(firsts, lasts, strict=True)
    )
    where = " or ".join(between)
    return where if bins[0].by == "time" else f"at {quantity} {where}"
