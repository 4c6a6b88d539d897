"""Design controllers of the joint's position on linear models, and run them against the FMU.

    python examples/controller_design/run.py [FOLDER]

Three designs for an actuator whose stiffness halves when a tendon goes slack: for both tendons
taut only, scheduled on the slack state, and one for all states. Prints their margins, a common
Lyapunov function and how well the joint of the FMU follows; draws loops.png,
motion.png and late_commands.png in FOLDER (default: here).
"""

import argparse
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import fmpy
import numpy as np
from delayed import fastest_growth, observed, predicted
from design import LOAD, SAMPLE, Design, lqg, origin, plants, softened, stiffness
from experiment import Actuator, LinearActuator, Scenario, Signals, run, tracking
from figures import draw_delayed, draw_loops, draw_motion
from robustness import (
    closed_loop,
    common_lyapunov,
    growth,
    growth_within_samples,
    guaranteed_decay,
    margins,
    slowest_rhythm,
)

from elastic_tendon import (
    LimitCycle,
    LinearModel,
    Model,
    OperatingPoint,
    SlackState,
    export_fmu,
    linearise,
    load_model,
)

HERE = Path(__file__).parent
I, II, III = SlackState.I, SlackState.II, SlackState.III  # noqa: E741, the paper's names
LOAD_DRIFT = 1.0  # N·m/√s, of all designs
LEAST_DISK = 0.6  # of the robust design in each state: at least 5.4 dB and 33 degrees
SHARES = np.arange(0.0, 1.7, 0.2)  # of the way from taut (0) to slack (1), and softer still
STEP = 0.05  # rad
HEAVY = 1.25  # a load that makes a tendon slack, of the load on the boundary
Plants = Mapping[SlackState, LinearModel]
Runs = dict[Scenario, dict[str, Signals]]


# ---- the designs ---------------------------------------------------------------------------


def one_for_all(plants: Plants, share: float) -> Design:
    """A controller for one stiffness, on the way from taut to slack, used in every state."""
    soft = softened(plants[III], plants[I], share)
    return dict.fromkeys(plants, lqg(soft, origin(plants[III]), LOAD_DRIFT))


def scheduled(plants: Plants) -> Design:
    """A controller for each state, at its operating point; they share what is observed."""
    return {state: lqg(plants[state], origin(plants[state]), LOAD_DRIFT) for state in plants}


def loops(plants: Plants, design: Design) -> list[np.ndarray]:
    return [closed_loop(plants[state], design[state]) for state in (III, I, II)]


def robust(plants: Plants) -> Design:
    """The stiffness to design for, by search: fastest decay that a common P guarantees."""
    print("\nWhich stiffness to design for, if one controller is to do for all states?")
    print("share  stiffness (N·m/rad)  least disk margin  guaranteed decay (1/s)")
    found: dict[float, Design] = {}
    for share in SHARES:
        design = one_for_all(plants, share)
        decay = guaranteed_decay(loops(plants, design))
        disk = min(margins(plants[state], design[state]).disk for state in plants)
        soft = stiffness(softened(plants[III], plants[I], share))
        print(f"{share:5.1f} {soft:19.1f}   {disk:18.2f} {_or_none(decay, '.1f'):>23}")
        if disk >= LEAST_DISK and decay is not None:
            found[decay] = design
    print(f"chosen: the fastest guaranteed decay of those with a disk margin of {LEAST_DISK:g}")
    return found[max(found)]


# ---- what linear models say ----------------------------------------------------------------


def report_margins(plants: Plants, designs: Mapping[str, Design]) -> None:
    print("\nMargins of the loop at the motor's velocity, and poles of the closed loop")
    print("design     state  gain (dB)  phase (°)  delay (ms)  disk  damping  decay (1/s)")
    for name, design in designs.items():
        for state in (III, I, II):
            m = margins(plants[state], design[state])
            print(
                f"{name:10} {state.name:5} {m.gain:10.1f} {m.phase:10.1f} {1e3 * m.delay:11.1f}"
                f" {m.disk:5.2f} {m.damping:8.3f} {m.decay:12.1f}"
            )
    for state in (III, I, II):
        (pole,) = (one for one in plants[state].poles() if one.imag > 0.0)
        print(f"free joint {state.name:5} {-pole.real / abs(pole):47.3f} {-pole.real:12.1f}")


def report_switching(plants: Plants, designs: Mapping[str, Design]) -> None:
    """What is guaranteed while the states take turns, by one P for all, and what is not."""
    print("\nDecay while the states take turns: guaranteed by a common P, and at the worst rhythm")
    print("design     guaranteed (1/s)  worst rhythm (1/s)  eigenvalues of A'PA - P, P scaled to 1")
    for name, design in designs.items():
        closed = loops(plants, design)
        decay = guaranteed_decay(closed)
        line = f"{name:10} {_or_none(decay, '.1f'):>16} {slowest_rhythm(*closed[:2]):19.1f}"
        if decay is not None and (P := common_lyapunov(closed, decay)) is not None:
            each = zip((III, I, II), closed, strict=True)
            line += "".join(f"  {state.name}: {growth(P, [one]):.4f}" for state, one in each)
            print(line)
            report_within_samples(plants, design, P)
        else:
            print(line)


def report_within_samples(plants: Plants, design: Design, P: np.ndarray) -> None:
    halfway = softened(plants[III], plants[I], 0.5)
    passed = [plants[III], halfway, plants[I], plants[II]]
    largest = growth_within_samples(P, passed, design[III])
    print(f"           with stiffness that changes in each quarter of a sample: {largest:.4f}")


# ---- what the FMU does ---------------------------------------------------------------------


def scenarios(edge: float) -> Iterator[Scenario]:
    """`edge` is the load (N·m) that brings a tendon to the boundary of slack."""
    begin = 0.1

    def step(time: float) -> np.ndarray:
        return np.array([STEP * (time >= begin), 0.0, 0.0, 0.0])

    def swing(time: float, size: float = 0.15, w: float = 4.0 * np.pi) -> np.ndarray:
        c, s = np.cos(w * time), np.sin(w * time)
        return size * np.array([1.0 - c, w * s, w**2 * c, -(w**3) * s])

    for state, load in ((III, 0.0), (I, -LOAD), (II, LOAD)):
        name = f"step of the reference in state {state.name}, load {load:g} N·m"
        yield Scenario(name, step, lambda _, load=load: load, begin, step=True)
    heavy = HEAVY * edge
    name = f"load step from 0 to {heavy:.3g} N·m: III to II"
    yield Scenario(name, lambda _: np.zeros(4), lambda time: heavy * (time >= begin), begin)
    yield Scenario(
        f"swing of 2 Hz, load {edge:.3g} N·m: III and II in turns", swing, lambda _: edge
    )


def simulate(
    model: Model, unzipped: Path, design: Design, scenario: Scenario, delay: int = 0
) -> Signals:
    """Run a design against the FMU, from rest with the joint at 0."""
    load = scenario.load(0.0)
    rest = linearise(model, "III", OperatingPoint(load_torque=load, joint_position=0.0))
    motor_position = rest.validity.operating_point.inputs["motor_position"]
    actuator = Actuator(unzipped, motor_position, load)
    signals = run(actuator, design, scenario, delay)
    actuator.close()
    return signals


def report_tracking(runs: Runs) -> None:
    print("\nThe joint of the FMU: error, time until it stays below 2 mrad, motor's largest speed")
    print("design      rms (mrad)  peak or overshoot (mrad)  settled (s)  motor (rad/s)  slack")
    for scenario, by_design in runs.items():
        print(scenario.name)
        for name, signals in by_design.items():
            t = tracking(signals, scenario)
            slack = np.mean(signals["slack_state"] != III.value)
            settled = "" if scenario.event is None else _or_none(t.settled, ".2f")
            print(
                f"  {name:10} {1e3 * t.rms:9.2f} {1e3 * t.peak:25.1f}"
                f" {settled:>12} {t.fastest:14.1f} {100 * slack:4.0f} %"
            )


def report_prediction(plants: Plants, designs: Mapping[str, Design], runs: Runs) -> None:
    """Steps within one state: the FMU does what the linear model of that state says."""
    apart = []
    for scenario, state in zip(runs, (III, I, II), strict=False):
        for name, design in designs.items():
            linear = run(LinearActuator(plants[state]), design, scenario)
            apart.append(np.abs(linear["joint"] - runs[scenario][name]["joint"]).max())
    told = "In the steps of the reference, each within one state, FMU and linear model are within"
    print(f"\n{told} {1e3 * max(apart):.2g} mrad")


def report_delayed(
    model: Model, plants: Plants, design: Design, unzipped: Path, heavy: float
) -> tuple[Signals, Sequence[LimitCycle]]:
    """The design for taut tendons with commands so late that its margin is used up in slack."""
    slack, taut = (margins(plants[state], design[state]).delay for state in (II, III))
    delay = round((slack + taut) / 2.0 / SAMPLE)
    print(f"\nTaut only, commands {1e3 * SAMPLE * delay:.0f} ms late")
    for state in (III, II):
        rate = fastest_growth(plants[state], design[state], delay)
        print(f"  {state.name:3} {'grows' if rate > 0.0 else 'decays'} with {abs(rate):.1f} 1/s")

    def load(time: float) -> float:
        return heavy * min(max((time - 0.5) / 0.2, 0.0), 1.0)

    scenario = Scenario("late commands", lambda _: np.zeros(4), load, duration=12.0)
    signals = simulate(model, unzipped, design, scenario, delay)
    cycles = predicted(model, plants, design[II], delay, heavy).cycles
    for cycle in cycles:
        print(
            f"  limit cycle under {heavy:.3g} N·m, predicted: amplitude of the deflection"
            f" {1e3 * cycle.amplitude:.1f} mrad, {cycle.frequency:.1f} rad/s"
        )
    amplitude, frequency = observed(signals)
    print(f"  the FMU: {1e3 * amplitude:.1f} mrad, {frequency:.1f} rad/s")
    return signals, cycles


def _or_none(value: float | None, form: str) -> str:
    return "none" if value is None else format(value, form)


# ---- all of it -----------------------------------------------------------------------------


def chosen_folder() -> Path:
    """FOLDER of the command line, created if missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    told = "where the pictures go (default: beside this script); created if missing"
    parser.add_argument("folder", nargs="?", type=Path, default=HERE, metavar="FOLDER", help=told)
    folder = parser.parse_args().folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        parser.error(f"{folder} cannot be made a folder: {error.strerror}")
    return folder


def main(folder: Path) -> None:
    model = load_model("biorob_x4_joint_3")
    linear = plants(model)
    designs = {"taut only": one_for_all(linear, 0.0), "scheduled": scheduled(linear)}
    designs["robust"] = robust(linear)
    report_margins(linear, designs)
    report_switching(linear, designs)
    edge = max(boundary.load_torque for boundary in linear[III].validity.boundaries)
    with tempfile.TemporaryDirectory() as work:
        fmu = export_fmu(model, Path(work) / "actuator.fmu")
        unzipped = Path(fmpy.extract(str(fmu), str(Path(work) / "actuator")))
        runs = {
            scenario: {
                name: simulate(model, unzipped, design, scenario)
                for name, design in designs.items()
            }
            for scenario in scenarios(edge)
        }
        report_tracking(runs)
        report_prediction(linear, designs, runs)
        delayed, cycles = report_delayed(
            model, linear, designs["taut only"], unzipped, HEAVY * edge
        )
    draw_loops(linear, designs, folder / "loops.png")
    drawn = list(runs)[:1] + list(runs)[2:]  # I looks like II: the springs are alike
    draw_motion({scenario: runs[scenario] for scenario in drawn}, folder / "motion.png")
    draw_delayed(delayed, cycles, folder / "late_commands.png")


if __name__ == "__main__":
    main(chosen_folder())
