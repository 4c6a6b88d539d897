"""One recording as the rest of the program sees it: plain arrays in SI units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastic_tendon.actuator.interfaces import InterfaceKind
from elastic_tendon.actuator.motion_kind import MotionKind
from elastic_tendon.errors import MeasurementError
from elastic_tendon.measurement.between import interpolation_of
from elastic_tendon.measurement.noise import (
    NoiseFloor,
    noise_floors,
    quantisation_step,
    rests,
    rounding_noise,
)
from elastic_tendon.measurement.noise_text import (
    COMPARED,
    COMPARED_AS,
    check_size,
    floor_notes,
    given_note,
)
from elastic_tendon.measurement.preparation import (
    Preparation,
    check_preparation,
    preparation_json,
)
from elastic_tendon.native.interpolation import AskedInterpolation, Interpolation
from elastic_tendon.result import Result

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from elastic_tendon.actuator.parameters import Model

Array = NDArray[np.float64]

JOINT, DEFLECTION = "joint_position", "joint_deflection"
_COMPARED = (JOINT, "motor_position", *COMPARED[1:])
# fewer samples than this cannot distinguish an initial state from noise
MINIMUM_SAMPLES = 10
CLEARLY_LESS = 0.95  # of a mean square error, which straight inputs have to leave at most


def samples_text(count: int) -> str:
    """A number of samples in words."""
    return f"{count} sample{'' if count == 1 else 's'}"


def window_text(start: float | None, end: float | None) -> str:
    """Write ``[start:end]``, s, so that reading it cuts out the same samples; None: left open."""
    # 15 digits suffice for times since 1970, unless they round to the wrong side of a sample
    low = "" if start is None else f"{start:.15g}"
    high = "" if end is None else f"{end:.15g}"
    if start is not None and float(low) > start:
        low = repr(float(start))
    if end is not None and float(high) < end:
        high = repr(float(end))
    return f"[{low}:{high}]"


def _compared(signal: str) -> str:
    """The signal as which a measured one is compared."""
    return COMPARED_AS.get(signal, signal)


@dataclass(frozen=True, repr=False)
class Measurement(Result):
    """One recorded experiment.

    Parameters
    ----------
    time : (n,) array, s; strictly increasing, starts where the file says
    motor_position : (n,) array, rad at the motor pulley; None where there is no motor or it was
        not measured: the recording is one for interface load, or with a motor torque for those
        that it drives, and zeros stand here
    signals : name of a model output -> (n,) array in its SI unit; what is compared with the model:
        where measured, ``joint_position`` (rad), or in its place ``joint_deflection`` (rad), see
        `with_joint_position`; ``joint_torque`` and ``motor_torque`` (N·m),
        ``upper_spring_force`` and ``lower_spring_force`` (N)
    load_torque : (n,) array, N·m on the joint, or None: none acts
    interpolation : of motor position and load between the samples, as of `simulate`, or "auto":
        as their spectra show, see `input_interpolation`
    notes : what was ignored, converted, split or averaged on reading, one sentence each
    static : a static curve: the motor is held at 0 and the load passes through it slowly
    preparation : what made these samples of the file; reading it so gives them again
    source : path of the file as it was given; "" where the samples are from no file
    given_noise : name of a signal -> standard deviation in its SI unit, of the user's word; see
        `with_noise`
    name : what tables and figures call it
    kind : interface of the model for which `at` sorted inputs from signals
    driving : inputs of that interface beside motor position and load torque, by name, (n,) SI
    motor_share : of the motor position in a joint position that was not measured itself, see
        `with_joint_position`; None: it was
    motion : whether what was recorded turns or slides; None: no unit says so, and the model does
    cuts : times, s, across which nothing connects, as in gaps: where recordings are compared,
        fitted and diagnosed, the pieces between them have an initial state each, see `pieces`
    whole : name of the recording of which this is a piece; "" where it is none
    """

    time: Array
    motor_position: Array = None  # type: ignore[assignment]  # zeros are put there
    signals: Mapping[str, Array] = field(default_factory=dict)
    load_torque: Array | None = None
    interpolation: AskedInterpolation = "auto"
    notes: tuple[str, ...] = field(default=())
    static: bool = False
    preparation: Preparation = field(default_factory=Preparation)
    source: str = ""
    given_noise: Mapping[str, float] = field(default_factory=dict)
    name: str = "recording"
    kind: InterfaceKind = InterfaceKind.POSITION
    driving: Mapping[str, Array] = field(default_factory=dict)
    motor_share: float | None = None
    motion: MotionKind | None = None
    cuts: tuple[float, ...] = ()
    whole: str = ""

    def __post_init__(self) -> None:
        """Lists become arrays; all have one value for each sample."""
        if self.motor_position is None:
            object.__setattr__(self, "motor_position", np.zeros(len(self.time)))
            object.__setattr__(self, "kind", InterfaceKind.LOAD)
        for name in ("time", "motor_position", "load_torque"):
            if not isinstance(getattr(self, name), np.ndarray | None):
                object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        if not all(isinstance(values, np.ndarray) for values in self.signals.values()):
            arrays = {name: np.asarray(values, np.float64) for name, values in self.signals.items()}
            object.__setattr__(self, "signals", arrays)
        for name, values in (*self.inputs.items(), *self.signals.items()):
            if values.shape != self.time.shape:
                raise MeasurementError(
                    f"{self.name}: {name} has shape {values.shape}, but time has "
                    f"{self.time.shape}; give one value for each sample"
                )

    @cached_property
    def inputs(self) -> dict[str, Array]:
        """What drives the model, by name: at interface position the motor position and, where one
        acts, the load torque."""
        given = self.kind.has_springs and not self.kind.has_rotor
        inputs = {"motor_position": self.motor_position} if given else {}
        inputs |= self.driving
        if self.kind.has_link and self.load_torque is not None:
            inputs["load_torque"] = self.load_torque
        return inputs

    @property
    def joint_position(self) -> Array:
        """Position of the joint as it was measured, (n,) rad, as a signal or an input.

        Raises
        ------
        KeyError : it was not measured
        """
        return {**self.inputs, **self.signals}[JOINT]

    @property
    def recording(self) -> str:
        """Name of the recording: of which this is a piece, else its own."""
        return self.whole or self.name

    @property
    def pieces(self) -> "tuple[Measurement, ...]":
        """What lies between the cuts, at least ten samples each; itself where there are none."""
        if not self.cuts:
            return (self,)
        clocks = np.split(self.time, np.searchsorted(self.time, self.cuts))
        return tuple(
            replace(self.window(float(clock[0]), float(clock[-1])), whole=self.recording)
            for clock in clocks
            if len(clock) >= MINIMUM_SAMPLES
        )

    @property
    def first_signal(self) -> str:
        """Name of the signal that is looked at first: the joint position, unless it is given."""
        return JOINT if JOINT in self.signals else next(iter(self.signals))

    @property
    def unmeasured_positions(self) -> tuple[str, ...]:
        """Which of motor and joint position was not measured, neither as input nor as signal."""
        positions = ("motor_position", JOINT) if self.kind.has_springs else (JOINT,)
        return tuple(name for name in positions if name not in {**self.inputs, **self.signals})

    def for_model(self, model: "Model") -> "Measurement":
        """The recording as a model is compared with it: at its interface, with a joint position.

        Raises
        ------
        MeasurementError : see `with_joint_position` and `at`; or one turns and the other slides
        """
        return self.of_motion(model.motion).with_joint_position(model).at(model.kind)

    def to_compare(self, model: "Model") -> "Measurement":
        """The recording `for_model`, which has to show something that the model computes.

        Raises
        ------
        MeasurementError : see `for_model`; or nothing is left to compare
        """
        taken = self.for_model(model)
        if not taken.signals:
            computed = [name for name in _COMPARED if name not in taken.inputs]
            raise MeasurementError(
                f"{self.name}: interface {model.kind} computes {', '.join(computed)}, of which "
                "none was measured, so there is nothing to compare"
            )
        return taken

    def of_motion(self, motion: MotionKind) -> "Measurement":
        """The recording as of a machine that turns or slides.

        Raises
        ------
        MeasurementError : its units are those of the other
        """
        if self.motion is None and motion is not MotionKind.ROTARY:
            return replace(self, motion=motion)
        if self.motion not in (None, motion):
            raise MeasurementError(
                f"{self.name}: its units are those of a {self.motion} machine, and the model's "
                f'motion is {motion}; write motion = "{self.motion}" at the top of the model, or '
                "give other units with --map"
            )
        return self

    def with_joint_position(self, model: "Model") -> "Measurement":
        """The recording with the joint position where the deflection was measured instead: that,
        and what the model's pulleys make of the motor position.

        Raises
        ------
        MeasurementError : both were measured, of which one follows from the other
        """
        if DEFLECTION not in self.signals or not model.kind.has_springs:
            return self
        if JOINT in self.signals:
            raise MeasurementError(
                f"{self.name}: it holds {JOINT} and {DEFLECTION}, of which one follows from the "
                "other and the motor position; leave one out"
            )
        share = model.transmission.motor_share
        joint = self.signals[DEFLECTION] + share * self.motor_position
        noise = {_compared(name): sigma for name, sigma in self.given_noise.items()}
        signals = {_compared(name): values for name, values in self.signals.items()}
        return replace(self, signals=signals | {JOINT: joint}, given_noise=noise, motor_share=share)

    def at(self, kind: InterfaceKind | str) -> "Measurement":
        """The recording with inputs and signals as of an interface.

        Parameters
        ----------
        kind : what is given and what is computed, see `InterfaceKind`

        Raises
        ------
        MeasurementError : what drives this interface was not measured
        """
        kind = InterfaceKind(kind)
        if kind is self.kind:
            return self
        if self.static:
            raise MeasurementError(
                f"{self.name}: a static curve is compared at interface position, not {kind}"
            )
        if not kind.has_springs:
            return self._without_motor()
        measured = {**self.signals, **self.driving}
        if "motor_position" in self.inputs:
            measured["motor_position"] = self.motor_position
        driving: dict[str, Array] = {}
        for name in (
            *(("motor_torque",) if kind.has_rotor else ("motor_position",)),
            *(() if kind.has_link else ("joint_position",)),
        ):
            if name not in measured:
                raise MeasurementError(
                    f"{self.name}: interface {kind} is driven by {name}, which was not measured; "
                    f"name its column with --map {name}=COLUMN{self._or_without(name)}"
                )
            driving[name] = measured.pop(name)
        driving.pop("motor_position", None)  # has a field of its own
        return replace(self, signals=measured, kind=kind, driving=driving)

    def _or_without(self, name: str) -> str:
        """What else helps where a motor position was not measured."""
        if name != "motor_position":
            return ""
        if "motor_torque" in self.signals:
            return ", or take --interface torque, which motor_torque drives"
        return ", or leave [transmission] out of the model if it has no springs"

    def _without_motor(self) -> "Measurement":
        """The recording for a model without springs, of which only the joint moves."""
        if self.signals and JOINT not in self.signals:
            raise MeasurementError(
                f"{self.name}: a model without [transmission] moves the joint, and {JOINT} was not "
                f"measured; name its column with --map {JOINT}=COLUMN"
            )
        left_out = [name for name in self.signals if name != JOINT]
        notes = [f"{name} is not compared: the model has no springs" for name in left_out]
        return replace(
            self,
            kind=InterfaceKind.LOAD,
            motor_position=np.zeros(len(self.time)),
            signals={name: values for name, values in self.signals.items() if name == JOINT},
            given_noise={name: size for name, size in self.given_noise.items() if name == JOINT},
            driving={},
            notes=(*self.notes, *notes),
        )

    @cached_property
    def input_interpolation(self) -> Interpolation:
        """How inputs run between the samples: what was asked for, or what their spectra show.

        A cubic spline where all that move end below the highest frequency that the samples can
        show, straight lines where they step or are noisy.
        """
        if self.interpolation != "auto":
            return self.interpolation
        return "linear" if self.static else interpolation_of(self.inputs.values())

    @property
    def has_assumed_curves(self) -> bool:
        """Whether inputs run in curves because their spectra allow it, and nobody has said so."""
        return self.interpolation == "auto" and self.input_interpolation == "cubic"

    def with_straight_inputs(self) -> "Measurement":
        """The recording with straight lines where it has assumed curves.

        A spectrum shows what may be between the samples, only a motion what was: inputs of an FMU,
        and those of many simulators, run in straight lines however smooth they look.
        """
        return replace(self, interpolation="linear") if self.has_assumed_curves else self

    def settled(self) -> "Measurement":
        """The recording with the interpolation that was chosen as if it were asked for."""
        if self.static:  # its inputs have no motion between them
            return self
        return replace(self, interpolation=self.input_interpolation)

    @cached_property
    def noise(self) -> Mapping[str, NoiseFloor]:
        """Noise floor of each signal: what was given, else what the recording shows."""
        floors = noise_floors(self.time, self.inputs, self.signals)
        given = {
            name: floors[name].given(sigma, rounding_noise(self.signals[name]))
            for name, sigma in self.given_noise.items()
            if name in floors  # at some interfaces a signal is an input
        }
        return floors | given

    @cached_property
    def rounding(self) -> Mapping[str, Array]:
        """How far each sample of a signal may err, in its unit, where an encoder that counts steps
        rests: half a step, (n,); 0 elsewhere. Only signals that rest somewhere are named."""
        found: dict[str, Array] = {}
        for name, floor in self.noise.items():
            if floor.kind == "quantised" and (resting := rests(self.signals[name])).any():
                half = 0.5 * quantisation_step(self.signals[name])
                found[name] = np.where(resting, half, 0.0)
        return found

    @property
    def noise_notes(self) -> tuple[str, ...]:
        """Why the noise floor of a signal is known badly, a sentence each.

        Not among `notes`, as it takes a look at the spectrum of every signal.
        """
        return floor_notes(self.noise)

    def summary(self) -> str:
        """Name, length, rate and signals, a line each for what was noted on reading."""
        time = self.time
        rate = (len(time) - 1) / (time[-1] - time[0]) if len(time) > 1 else 0.0
        names = ", ".join((*self.inputs, *self.signals))
        kind = "static curve" if self.static else f"{time[-1] - time[0]:.4g} s at {rate:.4g} Hz"
        lines = [f"{self.name}: {samples_text(len(time))}, {kind}; {names}"]
        if not self.static:
            lines.append(f"inputs between the samples: {self.input_interpolation}")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def to_dataframe(self) -> "pd.DataFrame":
        """Inputs and signals, a column each, SI; the index is the time, s."""
        import pandas as pd

        columns = {**self.inputs, **self.signals}
        return pd.DataFrame(columns, index=pd.Index(self.time, name="time"))

    def to_dict(self) -> dict[str, Any]:
        """Time, inputs and signals, a list each, SI; and what made them of a file."""
        columns = {"time": self.time, **self.inputs, **self.signals}
        return {
            "name": self.name,
            "source": self.source,
            "static": self.static,
            "interpolation": self.input_interpolation,
            "preparation": preparation_json(self.preparation),
            "columns": {name: values.tolist() for name, values in columns.items()},
        }

    def plot(self) -> "Figure":
        """Draw inputs and signals over time; of a static curve, torque over deflection."""
        from elastic_tendon.reports.trajectory_figure import measurement_figure
        from elastic_tendon.reports.worded import worded_figure

        return worded_figure(measurement_figure(self), self.motion or MotionKind.ROTARY)

    def with_noise(self, sigmas: Mapping[str, float]) -> "Measurement":
        """The recording with noise that the user knows.

        Parameters
        ----------
        sigmas : name of a signal -> standard deviation of its noise, rad or N·m

        Returns
        -------
        Measurement; its noise floors have these sizes, and never less than the sensor's steps
        make. A note says where the recording itself shows noise of another size

        Raises
        ------
        MeasurementError : a signal was not measured, or a size is not positive
        """
        notes = []
        if self.motor_share is not None:
            sigmas = {_compared(name): sigma for name, sigma in sigmas.items()}
        for name, sigma in sigmas.items():
            if name not in self.signals:
                raise MeasurementError(f"{self.name}: {name} was not measured and has no noise")
            check_size(sigma, f"{self.name}: noise of {name}")
            rounding = rounding_noise(self.signals[name])
            notes.append(given_note(name, sigma, self.noise[name], rounding))
        given = replace(self, given_noise={**self.given_noise, **sigmas})
        return given.noted([note for note in notes if note])

    def shares_samples(self, recording: "Measurement") -> bool:
        """Whether the two are of one recording and overlap in time: equal at all common times."""
        _, mine, theirs = np.intersect1d(self.time, recording.time, return_indices=True)
        if len(mine) < MINIMUM_SAMPLES or np.ptp(self.motor_position[mine]) == 0.0:
            return False
        # a motion may be repeated exactly, but what it measures is never twice the same
        signals = self.signals.keys() & recording.signals.keys()
        pairs = [(self.signals[name][mine], recording.signals[name][theirs]) for name in signals]
        pairs.append((self.motor_position[mine], recording.motor_position[theirs]))
        return all(np.array_equal(own, others) for own, others in pairs)

    def noted(self, notes: Sequence[str]) -> "Measurement":
        """The recording with more notes; where there are none itself, which keeps what it found."""
        return replace(self, notes=(*self.notes, *notes)) if notes else self

    def samples(self, keep: slice | NDArray[np.bool_]) -> "Measurement":
        """Some of the samples, all else the same."""
        time = self.time[keep]
        return replace(
            self,
            interpolation=self.input_interpolation,
            time=time,
            cuts=tuple(cut for cut in self.cuts if time[0] < cut < time[-1]),
            motor_position=self.motor_position[keep],
            signals={name: values[keep] for name, values in self.signals.items()},
            driving={name: values[keep] for name, values in self.driving.items()},
            load_torque=None if self.load_torque is None else self.load_torque[keep],
        )

    def shifted(self, shifts: Mapping[str, float]) -> "Measurement":
        """Take back by how much sensors are late.

        The samples of the joint position are kept as they are, at earlier times; the others are
        brought to these times linearly, so that what is compared keeps its noise.

        Parameters
        ----------
        shifts : name of an input or signal -> s; what it shows at t it recorded at t + shift;
            adds to an earlier shift

        Returns
        -------
        Measurement over the time that all signals have in common; its preparation says so

        Raises
        ------
        MeasurementError : fewer than ten samples are left, or a signal is not there
        """
        if not shifts:
            return self
        held = self.inputs | dict(self.signals)
        for name in shifts:
            if name not in held:
                raise MeasurementError(f"{self.name}: {name} was not measured and has no shift")
        reference = shifts.get("joint_position", 0.0)
        late = {name: shifts.get(name, 0.0) - reference for name in held}
        lower = self.time[0] - min(0.0, *late.values())
        upper = self.time[-1] - max(0.0, *late.values())
        keep = (self.time >= lower) & (self.time <= upper)
        count = int(np.count_nonzero(keep))
        if count < MINIMUM_SAMPLES:
            raise MeasurementError(
                f"{self.name}: shifted by {max(map(abs, late.values())):g} s, signals have "
                f"{samples_text(count)} in common and need {MINIMUM_SAMPLES}"
            )
        at = self.time[keep]
        moved = {
            name: values[keep]
            if late[name] == 0.0
            else np.interp(at + late[name], self.time, values)
            for name, values in held.items()
        }
        total: dict[str, float | str] = dict(self.preparation.time_shift)
        for name, seconds in shifts.items():
            earlier = total.get(name, 0.0)
            total[name] = seconds if isinstance(earlier, str) else earlier + seconds
        tree = preparation_json(self.preparation) | {"time_shift": total}
        return replace(
            self,
            time=at - reference,
            cuts=tuple(cut - reference for cut in self.cuts),
            motor_position=moved.get("motor_position", self.motor_position[keep]),
            load_torque=moved.get("load_torque"),
            signals={name: moved[name] for name in self.signals},
            driving={name: moved[name] for name in self.driving},
            preparation=check_preparation(tree, self.name),
        )

    def window(self, start: float | None, end: float | None) -> "Measurement":
        """Cut the samples with ``start <= time <= end``.

        Parameters
        ----------
        start, end : float, s, in the time of the recording; None: its beginning, its end

        Returns
        -------
        Measurement; its name carries the window, and so does its preparation, which repeats the
        cut exactly where nothing was shifted or resampled

        Raises
        ------
        MeasurementError : fewer than ten samples lie in the window
        """
        lower = self.time[0] if start is None else start
        upper = self.time[-1] if end is None else end
        keep = (self.time >= lower) & (self.time <= upper)
        text, count = window_text(start, end), int(np.count_nonzero(keep))
        if count < MINIMUM_SAMPLES:
            raise MeasurementError(
                f"{self.name}{text}: the window holds {samples_text(count)} and needs "
                f"{MINIMUM_SAMPLES}; the recording runs from {self.time[0]:.15g} s "
                f"to {self.time[-1]:.15g} s"
            )
        preparation = self.preparation.model_copy(update={"window": (float(lower), float(upper))})
        return replace(self.samples(keep), name=self.name + text, preparation=preparation)


Recordings = Measurement | Sequence[Measurement]  # one, or several


def listed(recordings: Recordings) -> tuple[Measurement, ...]:
    """One recording or several, as a tuple of their pieces."""
    several = (recordings,) if isinstance(recordings, Measurement) else recordings
    return tuple(piece for recording in several for piece in recording.pieces)


def joined(pieces: Sequence[Measurement]) -> Measurement:
    """The recording of which these are the pieces, in order of time."""
    first = pieces[0]
    name = first.whole

    def together(arrays: Sequence[Any]) -> Any:
        return None if arrays[0] is None else np.concatenate(arrays)

    ends = [(piece.time[0], piece.time[-1]) for piece in pieces]
    window = (float(ends[0][0]), float(ends[-1][1]))
    return replace(
        first,
        name=name,
        whole="",
        time=together([piece.time for piece in pieces]),
        motor_position=together([piece.motor_position for piece in pieces]),
        load_torque=together([piece.load_torque for piece in pieces]),
        signals={key: together([piece.signals[key] for piece in pieces]) for key in first.signals},
        notes=tuple(dict.fromkeys(note for piece in pieces for note in piece.notes)),
        preparation=first.preparation.model_copy(update={"window": window}),
        cuts=tuple(float(0.5 * (before[1] + after[0])) for before, after in pairwise(ends)),
    )
