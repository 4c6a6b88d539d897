"""Where the error lies and what it looks like, in one sentence.

Every pattern is one simple shape, of `patterns` or `springs`, that the missing torque (or, for a
measured torque, the error itself) may have, and `meanings` says what it means. The pattern that
explains most of the mean square is told, the simpler one where two explain nearly as much, and a
direction is claimed only where the data show it. Where none explains enough, it is said where the
error lies.
"""

import numpy as np

from elastic_tendon.comparison.meanings import (
    EQUALLY_SIMPLE,
    LAST_PATTERNS,
    OF_MOTION,
    OF_SPRINGS,
    OF_THE_ERROR,
    OF_THE_UNKNOWN,
    SELF_EVIDENT,
    SIGNAL_PATTERNS,
    TORQUE_PATTERNS,
)
from elastic_tendon.comparison.partition import range_text
from elastic_tendon.comparison.patterns import SIMPLER, Evidence, Finding, Pattern
from elastic_tendon.comparison.places import concentration, densest, outside
from elastic_tendon.comparison.residuals import Array, rms

# of the mean square, below which a pattern is not reported
TELLING = 0.5
# times the noise's part of the missing torque; less is not interpreted
CLEAR = 2.0
LOUD = 1.3  # times the noise, above which an error is more than noise even if nothing stands out
SURELY = 0.75  # of the mean square, below which another cause may be behind what is reported
# single samples: that hold most of what the few hold, times their neighbours, share of all
MOST, FAR, FEW = 0.95, 5.0, 0.005
MANY = 100  # samples, of which a few are few
ALIKE = 0.1  # of the mean square, by which another cause may explain less and still be named
# of the springs' torque: a missing torque as large may well be a load that nobody recorded
LARGE = 0.3
SPEEDS = {
    -1: ", more at low speed",
    0: " at any speed",
    1: " on average, more at high speed",
}


def in_words(evidence: Evidence) -> str:
    """Say where most of the squared error lies and what it looks like.

    Parameters
    ----------
    evidence : Evidence

    Returns
    -------
    str, one sentence without a full stop
    """
    if not any(bin_.stands_out for bin_ in evidence.bins):
        return _nothing(evidence)
    if jumps := _single_samples(evidence):
        return jumps
    findings = _found(evidence)
    if not findings:
        load = "; no load was recorded" if _may_be_a_load(evidence) else ""
        return f"{densest(evidence.bins)}; no simple pattern explains it{load}"
    finding = findings[0]
    where = _where(evidence, finding)
    start, end = _bounds(finding)
    meaning = finding.pattern.meaning[finding.sign].format(
        **_numbers(finding.size),
        **_pretensions(evidence, finding),
        speed=SPEEDS[finding.trend],
        there=" there" if where else "",
        start=start,
        end=end,
        alike=_alike(evidence, findings),
    )
    # one colon in a sentence is enough
    joint = "" if not where else "; " if ":" in meaning else ": "
    explained = _explained(evidence, finding)
    return f"{where}{joint}{meaning}{_unrecorded(evidence, finding)} ({explained})"


def _single_samples(evidence: Evidence) -> str:
    """Where a few samples far from their neighbours hold most of the error; else nothing.

    A static curve has no time at which to look, and its rows may lie far apart.
    """
    error = np.abs(evidence.residual)
    if len(error) < MANY or evidence.static:
        return ""
    inner = np.arange(2, len(error) - 2)
    around = np.stack([error[inner + shift] for shift in (-2, -1, 1, 2)])
    alone = inner[error[inner] > FAR * np.median(around, axis=0)]
    largest = alone[np.argsort(error[alone])[::-1]][: max(int(FEW * len(error)), 1)]
    shares = np.cumsum(error[largest] ** 2) / np.sum(error**2)
    if not len(shares) or shares[-1] < TELLING:
        return ""
    share = float(shares[-1])
    count = 1 + int(np.argmax(shares >= MOST * share))
    samples = "a single sample holds" if count == 1 else f"{count} single samples hold"
    return (
        f"{samples} {100.0 * share:.0f} % of the squared error, the largest at "
        f"{evidence.variables['time'][largest[0]]:.6g} s: look whether the sensor jumped there"
    )


def _found(evidence: Evidence) -> list[Finding]:
    """The finding to be reported, and then all others; nothing where none is clear."""
    if evidence.signal != "joint_position":
        return _best(SIGNAL_PATTERNS, evidence.residual, evidence)
    target = evidence.missing.torque
    if not evidence.missing.found or rms(target) <= CLEAR * rms(evidence.missing.sigma):
        return []
    return _best(TORQUE_PATTERNS, target, evidence) or _best(LAST_PATTERNS, target, evidence)


def _best(table: tuple[Pattern, ...], target: Array, evidence: Evidence) -> list[Finding]:
    """First the simplest of the patterns that explain nearly the most, as they are listed."""
    # a static curve's load follows from its deflection
    asked = [
        pattern
        for pattern in table
        if (not pattern.by or pattern.by in evidence.parts)
        and not (evidence.static and pattern.by == "load_torque")
    ]
    fits = (pattern.fit(pattern, target, evidence) for pattern in asked)
    possible = [fit for fit in fits if fit is not None and fit.sign in fit.pattern.meaning]
    most = max((finding.explained for finding in possible), default=0.0)
    if most < TELLING:
        return []
    best = next(finding for finding in possible if finding.explained >= most - SIMPLER)
    for group in EQUALLY_SIMPLE:
        if best.pattern.name in group:
            equals = (finding for finding in possible if finding.pattern.name in group)
            best = max(equals, key=lambda finding: finding.explained)
    return [best, *(finding for finding in possible if finding is not best)]


def _bounds(finding: Finding) -> tuple[str, str]:
    """Start and end of a passing event; of other findings nothing."""
    if finding.pattern.name != "event":
        return "", ""
    start, end = range_text(finding.bounds[0], finding.bounds[-1]).split(" to ")
    return start, end


def _numbers(size: float) -> dict[str, str]:
    """Magnitude of a finding as its unit, thousandths and percent."""
    factors = {"size": 1.0, "milli": 1e3, "percent": 1e2}
    return {name: _digits(factor * abs(size)) for name, factor in factors.items()}


def _pretensions(evidence: Evidence, finding: Finding) -> dict[str, str]:
    """The model's pretension, and the one that a change of it by the finding's share gives."""
    force = evidence.model.transmission.pretension_force
    forces = {"model_pretension": force, "pretension": (1.0 + finding.size) * force}
    return {name: _digits(value) for name, value in forces.items()}


def _digits(value: float) -> str:
    """Two digits, and no exponent for large numbers."""
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}"


def _where(evidence: Evidence, finding: Finding) -> str:
    """Where the finding holds; nothing where its own words say so, or it holds everywhere."""
    if finding.pattern.name in SELF_EVIDENT:
        return ""
    if finding.pattern.name == "beyond":
        return outside(evidence, finding.bounds)
    return concentration(evidence, finding)


def _explained(evidence: Evidence, finding: Finding) -> str:
    share = f"{100.0 * finding.explained:.0f} %"
    if finding.pattern.name in OF_THE_ERROR:
        return f"this accounts for {share} of the squared error"
    if finding.pattern.name == "event":
        return f"it holds {share} of the missing torque's square"
    of = "the missing torque" if evidence.signal == "joint_position" else "the error"
    left = "" if finding.explained >= SURELY else "; much is left, so the cause may be another"
    return f"this pattern accounts for {share} of {of}{left}"


def _alike(evidence: Evidence, findings: list[Finding]) -> str:
    """Another cause that the recording can hardly tell from the finding."""
    finding, *others = findings
    name = finding.pattern.name
    explained = {
        rival.pattern.name: rival
        for rival in others
        if rival.explained >= finding.explained - ALIKE
    }
    if name == "joint position" and "motor position" in explained:
        return " or the motor position"
    if name in OF_SPRINGS and "load" in explained:
        load = explained["load"]
        way = "more" if load.sign > 0 else "less"
        return (
            f", or the load acts {way} strongly than recorded by about "
            f"{_numbers(load.size)['percent']} %, as in slow motion both look alike"
        )
    if evidence.static or "load_torque" in evidence.parts:
        return ""
    return _without_load(finding)


def _without_load(finding: Finding) -> str:
    """Where no load acts, only the ratio of stiffness and inertia moves the joint."""
    sign = finding.sign
    if finding.pattern.name == "acceleration":
        cause = {-1: "the joint softer", 1: "the joint stiffer"}.get(sign)
    elif finding.pattern.name in ("stiffness", "deflection"):
        cause = {-1: "its link less inert", 1: "its link more inert"}.get(sign)
    elif finding.pattern.name in OF_SPRINGS:
        cause = {1: "its link less inert", -1: "its link more inert"}.get(sign)
    else:
        cause = None
    return f", or {cause} by a like share, as without a known load both look alike" if cause else ""


def _unrecorded(evidence: Evidence, finding: Finding) -> str:
    """That a load which nobody recorded would do this, where it may be one."""
    if finding.pattern.name in (*OF_THE_ERROR, *OF_MOTION) or not _may_be_a_load(evidence):
        return ""
    if finding.pattern.name in OF_THE_UNKNOWN:
        return "; no load was recorded"
    return "; no load was recorded, and one that acted would do this too"


def _may_be_a_load(evidence: Evidence) -> bool:
    """Whether what is missing is so large that a load which nobody recorded may be behind it."""
    if evidence.load_recorded or evidence.static or evidence.signal != "joint_position":
        return False
    return rms(evidence.missing.torque) >= LARGE * rms(evidence.variables["joint_torque"])


def _nothing(evidence: Evidence) -> str:
    if all(bin_.significance is None for bin_ in evidence.bins):
        return "the recording is too short to tell where the error lies"
    if evidence.error.noise_ratio > LOUD:
        return (
            f"the error is {evidence.error.noise_ratio:.2g} times the noise, but no part of it "
            "stands out"
        )
    return "nothing stands out: the error is the noise"
