"""Signals of the joint that arrive late."""

from types import SimpleNamespace

from elastic_tendon.effects.base import Contribution, Effect, Parameter, Slot


def equations(
    _at: None, p: SimpleNamespace, _state: SimpleNamespace, _mode: SimpleNamespace
) -> Contribution:
    """A pure delay."""
    return Contribution(p.delay)


EFFECT = Effect(
    id="measurement_delay",
    title="Measurement delay",
    slot=Slot.SIGNAL_DELAY,
    catalogue_order=180,
    physics="The signals measured at the joint pass filters, a bus and a scheduler, and are "
    "recorded later than the motor's.",
    in_data="An error proportional to the joint's velocity, so of either sign: the measured joint "
    "lags behind the model in every motion and every slack state, and agrees at rest. Measured "
    "torque against deflection opens to a loop in fast motion. The phase lag grows in proportion "
    "to frequency, and the amplitude stays what it was.",
    law="joint signals recorded at t are those of t - delay",
    confused_with="Gear backlash: it too makes the joint late where a motion turns round, but by "
    "the same angle at any speed. Viscous damping: its lag comes with a lower resonance, a delay "
    "leaves the height of the resonance alone. Spring mass: it lags in fast motions only, and "
    "rings.",
    confirm="Swing the motor slowly enough that the joint follows, at several speeds, and plot the "
    "lag of the joint against its velocity: the slope is the delay and the damping's lag together. "
    "A jump of the motor shows the delay alone, as the time before the joint's reading moves at "
    "all. Surest is one electrical pulse recorded by both channels.",
    cure="Stamp the time at the sensor, sample both encoders by one clock, shorten filters. A "
    "recording may be shifted. In control a delay takes delay times crossover frequency (rad/s) "
    "from the phase margin.",
    magnitude="Half a sample to a few samples: 1 ms on a fast fieldbus, 5 to 20 ms over USB or a "
    "busy network. A low-pass filter adds its group delay: its time constant, for first order.",
    parameters=(
        Parameter(
            name="delay",
            unit="s",
            meaning="time by which the joint's signals are recorded late",
            null=0.0,
            lower=0.0,
            upper=1.0,
            typical=0.005,
        ),
    ),
    equations=equations,
    reference="S. Björklund, L. Ljung, A review of time-delay estimation techniques, 42nd IEEE "
    "Conference on Decision and Control, 2003",
)
