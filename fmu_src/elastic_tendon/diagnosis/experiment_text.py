"""What a proposed experiment is and what it decides, in plain words."""

from collections.abc import Sequence
from dataclasses import dataclass

from elastic_tendon import effects
from elastic_tendon.actuator.parameters import Model
from elastic_tendon.actuator.quantity import unit_text
from elastic_tendon.actuator.variables import SIGNALS
from elastic_tendon.comparison.residuals import Array
from elastic_tendon.diagnosis.driving import drive_of
from elastic_tendon.diagnosis.limits import Limits
from elastic_tendon.diagnosis.proposals import SINES, Form, Input, Proposal
from elastic_tendon.measurement import Measurement

ROUNDED = 9  # digits of an angle in rad after which nothing is left


@dataclass(frozen=True)
class Separated:
    """The two answers that the experiment tells apart least surely.

    `first` : the answer taken first. `easier` : number of other pairs that it tells apart;
    `left_open` : pairs that it does not.
    `signal` : the one that tells most; `largest` : what a refit leaves of its difference, where it
    is largest, and `noise` of one sample, both in its unit; `at` s. `together` : what is left in
    all samples, over what noise alone makes of them. `power` : 0 to 1.
    """

    ids: tuple[str, str]
    first: str
    easier: int
    left_open: tuple[tuple[str, str], ...]
    signal: str
    largest: float
    at: float
    noise: float
    together: float
    power: float


def experiment_text(
    limits: Limits,
    proposal: Proposal,
    repeats: int,
    recording: Measurement,
    separated: Separated,
) -> str:
    """Say what is done, for how long, and by how much it tells answers apart.

    Parameters
    ----------
    limits : Limits
    proposal : Proposal
    repeats : how often it is made in one run
    recording : that run, its inputs as the answer named first expects them
    separated : which answers, and by how much
    """
    time = limits.sample_times()
    courses = proposal.courses(time, limits)
    motion, beside = proposal.motion, proposal.joint_side
    loaded = limits.kind.has_link and limits.joint_side is not None
    sentences = [
        f"Run for {repeats * time[-1]:.3g} s at {1.0 / limits.step:.4g} samples per second, from "
        f"rest with the {_moved(limits)} at {round(limits.motion.start, ROUNDED) + 0.0:.3g} rad"
        + (" and without load." if loaded else "."),
        f"{_moved(limits).capitalize()}: "
        + _course(motion, motion.at(time, limits), courses[0], "rad"),
    ]
    if beside is not None:
        how = "Load: " if limits.kind.has_link else "Joint, away from where springs hold it: "
        unit = "N·m" if limits.kind.has_link else "rad"
        sentences.append(how + _course(beside, beside.at(time, limits), courses[1], unit))
    sentences += _following(limits, recording, separated)
    if repeats > 1:
        sentences.append(f"All this {repeats} times, {time[-1]:.3g} s each, in one recording.")
    return " ".join([*sentences, *_cautions(limits, courses), _separation(separated)])


def _moved(limits: Limits) -> str:
    return "motor" if limits.kind.has_springs else "joint"


def _following(limits: Limits, recording: Measurement, separated: Separated) -> list[str]:
    """How a machine that a torque drives makes the motion."""
    drive = drive_of(limits.kind)
    if drive is None:
        return []
    torque = recording.inputs[drive.torque]
    return [
        f"Let its controller follow this, and record the {drive.torque.replace('_', ' ')}: "
        f"{titled(separated.first)} expects {torque.min():.3g} to {torque.max():.3g} N·m."
    ]


def undisputed_text(*, complete: bool) -> str:
    """Why no experiment is proposed where no other answer was found; `complete` : the search."""
    if complete:
        return "no other answer explains these data equally well, so there is none to rule out"
    return "none was looked for: the search was stopped before its end"


def undecidable_text(ids: Sequence[str], models: Sequence[Model]) -> str:
    """Say that no experiment was found, and why where the catalogue knows it.

    Parameters
    ----------
    ids : of the answers
    models : fitted with them
    """
    *most, last = map(titled, ids)
    sentences = [
        f"No motion within the limits of the actuator tells {', '.join(most)} and {last} apart by "
        "clearly more than the noise: with other parameters each explains what another predicts."
    ]
    same = {
        tuple(sorted(map(titled, (effect_id, rival)))): alias.when
        for model in models
        for effect_id in model.effect_ids
        for alias in effects.BY_ID.aliases_of(effects.BY_ID[effect_id])
        for rival in alias.of
        if {effect_id, rival} <= set(ids)
    }
    sentences += [
        f"{first} and {second} are the same wherever {when}."
        for (first, second), when in sorted(same.items())
    ]
    return " ".join(sentences)


def titled(answer: str) -> str:
    """An answer by the titles of its effects; "+" between their ids."""
    known = effects.BY_ID
    return " with ".join(known[part].title if part in known else part for part in answer.split("+"))


def _course(course: Input, form: Form, values: Array, unit: str) -> str:
    low, high = float(values.min()), float(values.max())
    if low == high:
        return f"{low:.3g} {unit} throughout."
    slow, fast = f"{form.slow:.3g}", f"{form.fast:.3g}"
    words = {
        "hold": "to one value and back",
        "sines": f"{SINES} sines of {slow} to {fast} Hz",
        "rising": f"a sine whose frequency rises from {slow} to {fast} Hz",
        "steps": f"{form.times} steps, each within {form.edge:.2g} s, with rests between",
        "runs": f"{2 * form.times} runs forth and back, each at a constant speed of its own",
        "reversals": f"swings of {fast} Hz that grow and shrink to nothing, {form.times} times",
        "releases": f"{form.times} times slowly to one end, held, and let go within "
        f"{form.edge:.2g} s",
    }[course.form]
    return f"{words}, between {low:.3g} and {high:.3g} {unit}."


def _cautions(limits: Limits, courses: tuple[Array, Array]) -> list[str]:
    reaches = {
        _moved(limits): limits.motion,
        "load" if limits.kind.has_link else "joint": limits.joint_side,
    }
    beyond = [
        name
        for (name, reach), values in zip(reaches.items(), courses, strict=True)
        if reach is not None
        and (values.min() < min(reach.recorded) or values.max() > max(reach.recorded))
    ]
    if limits.motor_was_held:
        return ["The motor was held in the recordings: check that it may move so far and so fast."]
    if beyond:
        return [
            f"The {' and the '.join(beyond)} go{'es' * (len(beyond) == 1)} beyond what was "
            "recorded: check that nothing is in the way."
        ]
    return []


def _separation(found: Separated) -> str:
    unit = unit_text(SIGNALS[found.signal].unit)
    first, second = map(titled, found.ids)
    sentences = [
        f"{first} and {second}, either refitted to the other, then differ in "
        f"{found.signal.replace('_', ' ')} by up to {found.largest:.2g} {unit}, most at "
        f"{found.at:.3g} s; that is {found.largest / found.noise:.2g} times the noise of one "
        f"sample and, over all samples together, {found.together:.2g} times what noise does: a "
        f"chance of {100.0 * found.power:.0f} % that the experiment decides."
    ]
    if found.easier:
        sentences.append("Other pairs of answers are told apart more surely.")
    sentences += [f"It does not tell {titled(a)} from {titled(b)}." for a, b in found.left_open]
    return " ".join(sentences)
