"""Where the error lies and what it looks like, in one sentence.

Every pattern is one simple shape, of `patterns`, that the missing torque (or, for a measured
torque, the error itself) may have, and what it means. The pattern that explains most of the mean
square is told, the simpler one where two explain nearly as much, and a direction is claimed only
where the data show it. Where none explains enough, it is said where the error lies.
"""

from dataclasses import replace

import numpy as np

from elastic_tendon.identify import patterns
from elastic_tendon.identify.bins import Bin
from elastic_tendon.identify.patterns import SIMPLER, Evidence, Finding, Pattern
from elastic_tendon.identify.residuals import Array, rms

# of the mean square, below which a pattern is not told
TELLING = 0.5
# times the noise's part of the missing torque; less is not interpreted
CLEAR = 2.0
# share of the squared error that a concentration holds at least, and times its share of samples
CONCENTRATED, DENSER = 0.6, 1.5
ENOUGH = 100_000  # samples for every pattern
LOUD = 1.3  # times the noise, above which an error is more than noise even if nothing stands out


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
        target = evidence.missing.torque
        finding = _best(TORQUE_PATTERNS, target, evidence) or _best(LAST_PATTERNS, target, evidence)
    if finding is None:
        where = _densest(evidence.bins) or "the error stands out above the noise"
        return f"{where}; no simple pattern explains it"
    where = _where(evidence, finding)
    meaning = finding.pattern.meaning[finding.sign].format(
        size=_digits(abs(finding.size)),
        milli=_digits(1e3 * abs(finding.size)),
        there=" there" if where else "",
        start=f"{finding.bounds[0]:.3g}" if finding.bounds else "",
        end=f"{finding.bounds[-1]:.3g}" if finding.bounds else "",
        alike=_alike(evidence, finding),
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


def _alike(evidence: Evidence, finding: Finding) -> str:
    """Where no load acts, only the ratio of stiffness and inertia moves the joint."""
    if evidence.static or "load_torque" in evidence.parts:
        return ""
    stiffness = {-1: "its link less inert", 1: "its link more inert"}
    acceleration = {-1: "the joint softer", 1: "the joint stiffer"}
    words = {"stiffness": stiffness, "deflection": stiffness, "acceleration": acceleration}
    other = words.get(finding.pattern.name, {}).get(finding.sign)
    return f", or {other} by a like share, as without a known load both look alike" if other else ""


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


def _best(table: tuple[Pattern, ...], target: Array, evidence: Evidence) -> Finding | None:
    """The simplest of the patterns that explain nearly the most; they are listed by simplicity."""
    # a static curve's load follows from its deflection
    asked = [
        one
        for one in table
        if (not one.by or one.by in evidence.parts)
        and not (evidence.static and one.by == "load_torque")
    ]
    fits = (pattern.fit(pattern, target, evidence) for pattern in asked)
    found = [one for one in fits if one is not None and one.sign in one.pattern.meaning]
    most = max((one.explained for one in found), default=0.0)
    if most < TELLING:
        return None
    return next(one for one in found if one.explained >= most - SIMPLER)


# ---- what is told --------------------------------------------------------------------------

SELF_EVIDENT = (
    *("offset", "delay", "constant", "event"),
    *("direction", "direction and load", "held", "unknown torque"),
)
OF_THE_ERROR = ("offset", "delay")  # patterns of the error itself
_TORQUE_OF_TIME = "a torque of about {size} N·m that the model does not know acted "
_EVENT_WORDS = {
    1: _TORQUE_OF_TIME + "on the joint in the positive direction from {start} to {end} s",
    -1: _TORQUE_OF_TIME + "on the joint in the negative direction from {start} to {end} s",
}
_OFFSET = "a constant error of {milli} mrad: an offset between the encoders would do this"
TORQUE_PATTERNS = (
    Pattern("offset", "", patterns.constant_error, {1: _OFFSET, -1: _OFFSET}),
    Pattern(
        "delay",
        "joint_velocity",
        patterns.late,
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
        patterns.constant,
        {
            1: "a constant torque of about {size} N·m is missing",
            -1: "a constant torque of about -{size} N·m is missing",
        },
    ),
    Pattern(
        "direction",
        "velocity_sign",
        patterns.direction,
        {
            -1: "the missing torque opposes the direction of motion: the joint resists motion "
            "more than the model, by about {size} N·m at any speed",
            1: "the missing torque has the direction of motion: the joint resists motion less "
            "than the model, by about {size} N·m at any speed",
        },
    ),
    Pattern(
        "direction and load",
        "velocity_sign",
        patterns.direction_and_load,
        {
            -1: "the missing torque opposes the direction of motion and grows with the load: the "
            "joint resists motion more than the model, by about {size} of the load",
            1: "the missing torque has the direction of motion and grows with the load: the joint "
            "resists motion less than the model, by about {size} of the load",
        },
    ),
    Pattern(
        "velocity",
        "joint_velocity",
        patterns.proportional,
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
        patterns.proportional,
        {
            -1: "the missing torque opposes the acceleration in proportion: the link is more "
            "inert than the model's, by about {size} kg·m²{alike}",
            1: "the missing torque grows with the acceleration in proportion: the link is less "
            "inert than the model's, by about {size} kg·m²{alike}",
        },
    ),
    Pattern(
        "load",
        "load_torque",
        patterns.proportional,
        {
            1: "the missing torque is proportional to the load: the load acts more strongly "
            "than recorded, by about {size} of it",
            -1: "the missing torque is proportional to the load: the load acts less strongly "
            "than recorded, by about {size} of it",
        },
    ),
    Pattern(
        "stiffness",
        "deflection",
        patterns.stiffness,
        {
            -1: "the joint is stiffer than the model, by about {size} N·m/rad{alike}",
            1: "the joint is softer than the model, by about {size} N·m/rad{alike}",
        },
    ),
    Pattern(
        "beyond",
        "deflection",
        patterns.beyond,
        {
            -1: "the joint is stiffer{there} than the model, by about {size} N·m/rad",
            1: "the joint is softer{there} than the model, by about {size} N·m/rad",
        },
    ),
    Pattern(
        "deflection",
        "deflection",
        patterns.stiffness_curve,
        {
            -1: "the joint is stiffer than the model, by about {size} N·m/rad on average over "
            "all deflections{alike}",
            1: "the joint is softer than the model, by about {size} N·m/rad on average over "
            "all deflections{alike}",
            0: "the missing torque is a curve over the deflection",
        },
    ),
    Pattern(
        "held",
        "motor_position",
        patterns.held,
        {
            1: "the motor moves and the joint stays: a torque of about {size} N·m RMS that the "
            "model does not know holds it",
        },
    ),
    Pattern(
        "motor position",
        "motor_position",
        patterns.curve,
        dict.fromkeys(
            (-1, 0, 1),
            "the missing torque is a curve over the motor position, as gravity or an eccentric "
            "pulley would give",
        ),
    ),
    Pattern("event", "time", patterns.event, _EVENT_WORDS),
)
# true of whatever the model does not know, hence told only where no other pattern is
LAST_PATTERNS = (
    Pattern(
        "unknown torque",
        "deflection",
        patterns.unknown_torque,
        {
            1: "load and inertia hardly account for the deflection, so that stiffness cannot be "
            "its cause: a torque of about {size} N·m RMS that the model does not know deflects "
            "the joint, as friction, a hand or an unmeasured load would",
        },
    ),
)


def _follows(name: str, by: str, words: str) -> Pattern:
    fit = patterns.curve if by != "velocity_sign" else patterns.direction
    return Pattern(name, by, fit, dict.fromkeys((-1, 0, 1), f"the error follows the {words}"))


SIGNAL_PATTERNS = (
    Pattern(
        "offset",
        "",
        patterns.constant_error,
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


def _where(evidence: Evidence, finding: Finding) -> str:
    """Where the finding holds; nothing where its own words say so, or it holds everywhere."""
    if finding.pattern.name in SELF_EVIDENT:
        return ""
    if finding.pattern.name == "beyond":
        return _outside(evidence, finding.bounds)
    return _concentration(evidence, finding)


def _outside(evidence: Evidence, bounds: tuple[float, ...]) -> str:
    """How much lies beyond bounds of the deflection, each on its side of 0."""
    deflection = evidence.variables["deflection"]
    outside = np.any([np.sign(one) * deflection > abs(one) for one in bounds], axis=0)
    squares = {"squared error": evidence.residual**2}
    squares["missing torque's square"] = evidence.missing.torque**2
    shares = {what: float(np.sum(one[outside]) / np.sum(one)) for what, one in squares.items()}
    enough = max(CONCENTRATED, DENSER * float(np.mean(outside)))
    what = next((one for one, share in shares.items() if share >= enough), list(shares)[-1])
    places = " and ".join(f"{bound:.3g}" for bound in bounds)
    both = ", in both directions" if len(bounds) > 1 else ""
    share = f"{100.0 * shares[what]:.0f} % of the {what}"
    return f"{share} lies beyond {places} rad of deflection{both}"


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
    """The variable in which the squared error is densest, and where; no frequency if another is."""
    texts = [
        (text, (by != "frequency", max(one.share / one.count for one in group)))
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
    firsts = [i for i in chosen if i - 1 not in chosen]
    lasts = [i for i in chosen if i + 1 not in chosen]
    runs = zip(firsts, lasts, strict=True)
    between = [f"between {bins[i].lower:.3g} and {bins[j].upper:.3g} {unit}" for i, j in runs]
    return " or ".join(between) + f" of {quantity}"
