"""Where the error lies and what it looks like, in one sentence.

Every pattern is one simple shape that the missing torque (or, for a measured torque, the error
itself) may have: constant, proportional to one variable, with the sign of the velocity, a curve
over one variable, or confined to a stretch of time. The pattern that explains most of the mean
square is told, the simpler one where two explain nearly as much, and a direction is claimed only
where the data show it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastic_tendon.identify.bins import Bin
from elastic_tendon.identify.compare import SignalError
from elastic_tendon.identify.missing_torque import MissingTorque
from elastic_tendon.identify.partition import Partition, blocks_of, memory_of
from elastic_tendon.identify.residuals import Array, rms

# of the mean square, below which a pattern is not told
TELLING = 0.5
# by which a pattern must explain more than a simpler one
SIMPLER = 0.04
# standard errors that a direction needs
SURE = 3.0
# times the noise's part of the missing torque; less is not interpreted
CLEAR = 2.0
# longest stretch that counts as a passing event, share of the recording
EVENT = 0.2
STRETCHES = 50
CURVE_PARTS = 24  # of the range of a variable
EVENT_SHARE = 0.8  # of the square over the recording that a passing event must hold
EVENT_ENERGY = 0.9  # of what the longest stretch holds lies between the times that are told
# share of the squared error that a concentration holds at least, and times its share of samples
CONCENTRATED, DENSER = 0.6, 1.5
ENOUGH = 100_000  # samples for every pattern
LOUD = 1.3  # times the noise, above which an error is more than noise even if nothing stands out


@dataclass(frozen=True)
class Evidence:
    """What is known of the error of one signal in one recording.

    `signal` and its `residual` (n,), simulated less measured, with its figures `error` and its
    `bins`; the rest as in `locate.FileLocation`; `static`: the recording is a slow sweep.
    """

    signal: str
    residual: Array
    error: SignalError
    bins: tuple[Bin, ...]
    missing: MissingTorque
    variables: Mapping[str, Array]
    parts: Mapping[str, Partition]
    static: bool


@dataclass(frozen=True)
class Finding:
    """How well one pattern fits.

    `explained` share of the mean square; `size` and `error`, the pattern's number and its standard
    error; `span` (s) of a passing event.
    """

    pattern: "Pattern"
    explained: float
    size: float
    error: float
    span: tuple[float, float] | None = None

    @property
    def sign(self) -> int:
        """Direction that the data show: -1, 1, or 0 where they do not."""
        return int(np.sign(self.size)) if abs(self.size) > SURE * self.error else 0


@dataclass(frozen=True)
class Pattern:
    """One shape: `by` its variable, `fit` from (target, evidence), and what it means.

    `meaning` by the sign of the finding, with ``{size}`` for its magnitude; 0 where the
    direction is not sure.
    """

    name: str
    by: str
    fit: Callable[["Pattern", Array, Evidence], Finding | None]
    meaning: Mapping[int, str]


def in_words(evidence: Evidence) -> str:
    """Say where most of the squared error lies and what it looks like.

    Parameters
    ----------
    evidence : Evidence

    Returns
    -------
    str, one sentence without a full stop
    """
    if not any(one.stands_out for one in evidence.bins):
        return _nothing(evidence)
    evidence = _thinned(evidence)
    torque = evidence.signal == "joint_position"
    finding = None
    if not torque:
        finding = _best(SIGNAL_PATTERNS, evidence.residual, evidence)
    elif rms(evidence.missing.torque) > CLEAR * rms(evidence.missing.sigma):
        finding = _best(TORQUE_PATTERNS, evidence.missing.torque, evidence)
    if finding is None:
        where = _densest(evidence.bins) or "the error stands out above the noise"
        return f"{where}; no single variable orders it"
    where = "" if finding.pattern.name in SELF_EVIDENT else _concentration(evidence, finding)
    meaning = finding.pattern.meaning[finding.sign].format(
        size=_digits(abs(finding.size)),
        milli=_digits(1e3 * abs(finding.size)),
        there=" there" if where else "",
        start=f"{finding.span[0]:.3g}" if finding.span else "",
        end=f"{finding.span[1]:.3g}" if finding.span else "",
    )
    explained = f"this pattern accounts for {100.0 * finding.explained:.0f} % of "
    explained += "the missing torque" if torque else "the error"
    if finding.pattern.name in OF_THE_ERROR:
        explained = f"this accounts for {100.0 * finding.explained:.0f} % of the squared error"
    elif finding.pattern.name == "event":
        explained = f"it holds {100.0 * finding.explained:.0f} % of the missing torque's square"
    # one colon in a sentence is enough
    joint = "" if not where else "; " if ":" in meaning else ": "
    return f"{where}{joint}{meaning} ({explained})"


def _digits(value: float) -> str:
    """Two digits, and no exponent for large numbers."""
    return f"{value:.2g}" if value < 100.0 else f"{value:.0f}"


def _thinned(evidence: Evidence) -> Evidence:
    """Of a long recording as many samples as patterns need."""
    stride = -(-len(evidence.residual) // ENOUGH)
    if stride == 1:
        return evidence
    missing = evidence.missing
    return replace(
        evidence,
        residual=evidence.residual[::stride],
        missing=replace(missing, torque=missing.torque[::stride], sigma=missing.sigma[::stride]),
        variables={name: values[::stride] for name, values in evidence.variables.items()},
        parts={name: part.thinned(stride) for name, part in evidence.parts.items()},
    )


def _nothing(evidence: Evidence) -> str:
    if all(one.significance is None for one in evidence.bins):
        return "the recording is too short to tell where the error lies"
    if evidence.error.noise_ratio > LOUD:
        return (
            f"the error is {evidence.error.noise_ratio:.2g} times the noise, but no part of it "
            "stands out"
        )
    return "nothing stands out: the error is the noise"


def _best(patterns: tuple[Pattern, ...], target: Array, evidence: Evidence) -> Finding | None:
    """The simplest of the patterns that explain nearly the most; they are listed by simplicity."""
    # a static curve's load follows from its deflection
    asked = [one for one in patterns if not (evidence.static and one.by == "load_torque")]
    fits = (pattern.fit(pattern, target, evidence) for pattern in asked)
    found = [one for one in fits if one is not None and one.sign in one.pattern.meaning]
    most = max((one.explained for one in found), default=0.0)
    if most < TELLING:
        return None
    return next(one for one in found if one.explained >= most - SIMPLER)


# ---- how a pattern is fitted ---------------------------------------------------------------


def _constant_error(pattern: Pattern, _target: Array, evidence: Evidence) -> Finding:
    """The error of the signal is the same throughout."""
    return _proportional_to(pattern, evidence.residual, np.ones(len(evidence.residual)))


def _late(pattern: Pattern, _target: Array, evidence: Evidence) -> Finding | None:
    """The error is the way that the joint goes in a constant time."""
    return _proportional(pattern, evidence.residual, evidence)


def _constant(pattern: Pattern, target: Array, _evidence: Evidence) -> Finding:
    return _proportional_to(pattern, target, np.ones(len(target)))


def _proportional(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    if pattern.by not in evidence.parts:
        return None
    return _proportional_to(pattern, target, evidence.variables[pattern.by])


def _direction(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    velocity = evidence.variables["joint_velocity"]
    # at rest friction takes any value
    member, words = evidence.parts["velocity_sign"].member, evidence.parts["velocity_sign"].words
    sign = np.array([{"negative": -1.0, "positive": 1.0}.get(word, 0.0) for word in words])[member]
    if not velocity.any():
        return None
    return _proportional_to(pattern, target, sign)


def _proportional_to(pattern: Pattern, target: Array, shape: Array) -> Finding:
    """Least squares of target on one shape; the standard error counts blocks, not samples."""
    square = float(shape @ shape)
    if square == 0.0:
        return Finding(pattern, 0.0, 0.0, 0.0)
    size = float(shape @ target) / square
    rest = target - size * shape
    score = shape * rest
    blocks = blocks_of(memory_of(score), len(score))
    error = float(np.linalg.norm(np.bincount(blocks, score))) / square
    return Finding(pattern, 1.0 - float(rest @ rest) / float(target @ target), size, error)


def _curve(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """A mean for each of many small parts of the range; the slope tells the direction."""
    if pattern.by not in evidence.parts:
        return None
    values = evidence.variables[pattern.by]
    lowest, width = float(np.min(values)), float(np.ptp(values)) / CURVE_PARTS
    member = np.minimum((values - lowest) / width, CURVE_PARTS - 1).astype(int)
    counts = np.bincount(member, minlength=CURVE_PARTS)
    means = np.bincount(member, target, CURVE_PARTS) / np.maximum(counts, 1)
    rest = target - means[member]
    # as many independent facts as the target has memories, less one for each part
    facts = len(target) / memory_of(target)
    penalty = facts / max(facts - float(np.count_nonzero(counts)), 1.0)
    slope = _proportional_to(pattern, target - np.mean(target), values - np.mean(values))
    explained = 1.0 - penalty * float(rest @ rest) / float(target @ target)
    return Finding(pattern, explained, slope.size, slope.error)


def _event(pattern: Pattern, target: Array, evidence: Evidence) -> Finding | None:
    """A stretch of time, shorter than `EVENT`, that holds nearly all of the target's square."""
    time = evidence.variables["time"]
    edges = np.linspace(time[0], time[-1], STRETCHES + 1)
    part = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, STRETCHES - 1)
    energy = np.bincount(part, target**2, STRETCHES)
    energy = np.maximum(energy - np.median(energy), 0.0)
    width = round(EVENT * STRETCHES)
    windows = np.convolve(energy, np.ones(width), "valid")
    first = int(np.argmax(windows))
    inside = np.cumsum(energy[first : first + width]) / max(float(windows[first]), 1e-300)
    start = first + int(np.searchsorted(inside, 0.5 * (1.0 - EVENT_ENERGY)))
    end = first + int(np.searchsorted(inside, 0.5 * (1.0 + EVENT_ENERGY)))
    span = (float(edges[start]), float(edges[end + 1]))
    within = (time >= span[0]) & (time <= span[1])
    explained = float(np.sum(target[within] ** 2) / np.sum(target**2))
    if explained < EVENT_SHARE:
        return None
    size = float(np.sign(np.mean(target[within])) * rms(target[within]))
    return Finding(pattern, explained, size, 0.0, span)


# ---- what is told --------------------------------------------------------------------------

SELF_EVIDENT = ("offset", "delay", "constant", "event")
OF_THE_ERROR = ("offset", "delay")  # patterns of the error itself
_TORQUE_OF_TIME = "a torque of about {size} N·m that the model does not know acted "
_EVENT_WORDS = {
    1: _TORQUE_OF_TIME + "on the joint in the positive direction from {start} to {end} s",
    -1: _TORQUE_OF_TIME + "on the joint in the negative direction from {start} to {end} s",
}
_OFFSET = "a constant error of {milli} mrad: an offset between the encoders would do this"
TORQUE_PATTERNS = (
    Pattern("offset", "", _constant_error, {1: _OFFSET, -1: _OFFSET}),
    Pattern(
        "delay",
        "joint_velocity",
        _late,
        {
            1: "the error is proportional to the velocity: the joint position was recorded later "
            "than the motor's, by about {milli} ms",
            -1: "the error is proportional to the velocity: the joint position was recorded "
            "earlier than the motor's, by about {milli} ms",
        },
    ),
    Pattern(
        "constant",
        "",
        _constant,
        {
            1: "a constant torque of about {size} N·m is missing",
            -1: "a constant torque of about -{size} N·m is missing",
        },
    ),
    Pattern(
        "direction",
        "velocity_sign",
        _direction,
        {
            -1: "the missing torque opposes the direction of motion: the joint resists motion "
            "more than the model, by about {size} N·m at any speed",
            1: "the missing torque has the direction of motion: the joint resists motion less "
            "than the model, by about {size} N·m at any speed",
        },
    ),
    Pattern(
        "velocity",
        "joint_velocity",
        _proportional,
        {
            -1: "the missing torque opposes the velocity in proportion: the joint is damped more "
            "than the model, by about {size} N·m·s/rad",
            1: "the missing torque grows with the velocity in proportion: the joint is damped "
            "less than the model, by about {size} N·m·s/rad",
        },
    ),
    Pattern(
        "acceleration",
        "joint_acceleration",
        _proportional,
        {
            -1: "the missing torque opposes the acceleration in proportion: the link is more "
            "inert than the model's, by about {size} kg·m²",
            1: "the missing torque grows with the acceleration in proportion: the link is less "
            "inert than the model's, by about {size} kg·m²",
        },
    ),
    Pattern(
        "load",
        "load_torque",
        _proportional,
        {
            1: "the missing torque is proportional to the load: the load acts more strongly "
            "than recorded, by about {size} of it",
            -1: "the missing torque is proportional to the load: the load acts less strongly "
            "than recorded, by about {size} of it",
        },
    ),
    Pattern(
        "deflection",
        "deflection",
        _curve,
        {
            -1: "the joint is stiffer{there} than the model, by about {size} N·m/rad on average",
            1: "the joint is softer{there} than the model, by about {size} N·m/rad on average",
            0: "the missing torque is a curve over the deflection",
        },
    ),
    Pattern(
        "motor position",
        "motor_position",
        _curve,
        dict.fromkeys(
            (-1, 0, 1),
            "the missing torque is a curve over the motor position, as gravity or an eccentric "
            "pulley would give",
        ),
    ),
    Pattern("event", "time", _event, _EVENT_WORDS),
)


def _follows(name: str, by: str, words: str) -> Pattern:
    fit = _curve if by != "velocity_sign" else _direction
    return Pattern(name, by, fit, dict.fromkeys((-1, 0, 1), f"the error follows the {words}"))


SIGNAL_PATTERNS = (
    Pattern(
        "offset",
        "",
        _constant_error,
        dict.fromkeys((-1, 1), "a constant error of {milli} mN·m, as an offset of the sensor"),
    ),
    _follows("direction", "velocity_sign", "direction of motion"),
    _follows("deflection", "deflection", "deflection"),
    _follows("velocity", "joint_velocity", "velocity"),
    _follows("acceleration", "joint_acceleration", "acceleration"),
    _follows("load", "load_torque", "load"),
    _follows("motor position", "motor_position", "motor position"),
)


# ---- where the squared error is ------------------------------------------------------------


def _concentration(evidence: Evidence, finding: Finding) -> str:
    """Where the error, else the missing torque, is dense in the finding's variable; or nothing."""
    by = finding.pattern.by
    bins = [one for one in evidence.bins if one.by == by]
    if text := _dense_part(bins, "squared error"):
        return text
    squares = evidence.missing.torque**2
    part = evidence.parts[by]
    mean = part.means(squares)
    shares = mean * part.counts / float(np.sum(squares))
    torque_bins = [
        replace(one, rmse=float(np.sqrt(mean[i])), share=float(shares[i]), stands_out=True)
        for i, one in enumerate(bins)
    ]
    if evidence.signal == "joint_position" and (
        text := _dense_part(torque_bins, "missing torque's square")
    ):
        return text
    return ""


def _densest(bins: tuple[Bin, ...]) -> str:
    """The variable in which the squared error is densest, and where."""
    texts = [
        (text, max(one.share / one.count for one in group))
        for by in dict.fromkeys(one.by for one in bins)
        if by != "slack_state"
        for group in [[one for one in bins if one.by == by]]
        if (text := _dense_part(group, "squared error"))
    ]
    return max(texts, key=lambda pair: pair[1])[0] if texts else ""


def _dense_part(bins: list[Bin], what: str) -> str:
    """The part of one variable's range that holds most of the squared error in few samples."""
    samples = sum(one.count for one in bins)
    order = sorted(range(len(bins)), key=lambda index: -bins[index].rmse)
    chosen: set[int] = set()
    for index in order:
        chosen.add(index)
        share = sum(bins[i].share for i in chosen)
        if share >= CONCENTRATED:
            break
    if share < DENSER * sum(bins[i].count for i in chosen) / samples:
        return ""
    if not all(bins[i].stands_out for i in chosen) or len(chosen) == len(bins):
        return ""
    text = f"{100.0 * share:.0f} % of the {what} lies "
    return text + _range_words(bins, sorted(chosen))


def _range_words(bins: list[Bin], chosen: list[int]) -> str:
    quantity = bins[0].by.replace("_", " ")
    unit = bins[0].bin.split()[-1]
    inner = [i for i in range(len(bins)) if i not in chosen]
    lower, upper = bins[0].lower, bins[-1].upper
    if lower is None or upper is None:
        return " and ".join(f"where the {quantity} is {bins[i].bin}" for i in chosen)
    whole = inner == list(range(inner[0], inner[-1] + 1))
    if whole and inner[0] > 0 and inner[-1] < len(bins) - 1:
        low, high = bins[inner[0]].lower, bins[inner[-1]].upper
        return f"at a {quantity} below {low:.3g} or above {high:.3g} {unit}, in both directions"
    if chosen == list(range(chosen[0], chosen[-1] + 1)):
        low, high = bins[chosen[0]].lower, bins[chosen[-1]].upper
        return f"between {low:.3g} and {high:.3g} {unit} of {quantity}"
    return "in " + ", ".join(f"{bins[i].bin}" for i in chosen) + f" of {quantity}"
