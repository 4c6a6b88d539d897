"""Draw the figures of the paper: characteristic curves, and model against measurement.

    python examples/paper_figures/run.py [FOLDER]

Draws figure_5, 7, 8, 9, 10 and 11.png in FOLDER (default: here) and prints the paper's numbers.
Figs. 10 and 11 need measurements, which the paper does not give: static_curve.csv and
excitation.csv beside this script are synthetic, of a machine whose springs have the overstretch
protection that the paper's had and its model lacks.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from elastic_tendon import (
    Comparison,
    Location,
    Model,
    SlackState,
    characteristic_curves,
    compare,
    design,
    load_model,
    locate,
    read,
)

HERE = Path(__file__).parent
MEASURED, SIMULATED = "#000000", "#D55E00"
STATE_COLOURS = {SlackState.I: "#D55E00", SlackState.III: "#000000", SlackState.II: "#0072B2"}
DEFLECTION, TORQUE = r"joint deflection $q - {}^j\theta$ (rad)", r"torque ${}^j\tau_e$ (N·m)"

# pretensions, N: the paper shows several and does not print which; all stay below its limit (30)
FAMILIES = {
    7: ("figure_7", (10.0, 20.0, 30.0, 40.0)),
    8: ("figure_8", (20.0, 50.0, 80.0)),
    9: ("biorob_x4_joint_3", (40.0, 80.0, 120.0, 160.0)),
}


# ---- Figs. 5, 7, 8 and 9: characteristic curves ---------------------------------------------


def asymmetric(model: Model) -> Model:
    """Fig. 5: k_1 = 1.33 k_2 and l_max,1 = 0.67 l_max,2; the paper gives no other numbers."""
    lower = model.transmission.lower_spring
    return model.with_values(
        {
            "transmission.pretension_force": 30.0,
            "transmission.upper_spring.stiffness": 1.33 * lower.stiffness,
            "transmission.upper_spring.max_deflection": 0.67 * lower.max_deflection,
        }
    )


def draw_three_slopes(model: Model, picture: Path) -> None:
    """Fig. 5: one curve, its three slopes, and where its borders go when F_p rises."""
    (curve,) = characteristic_curves(model, [model.transmission.pretension_force])
    lower, upper = curve.slack_boundaries
    # a segment has the points on its borders, so the segments touch
    segments = {
        SlackState.I: (curve.deflection <= lower, "R² k₁"),
        SlackState.III: ((curve.deflection >= lower) & (curve.deflection <= upper), "R² (k₁ + k₂)"),
        SlackState.II: (curve.deflection >= upper, "R² k₂"),
    }
    figure, axes = plt.subplots(figsize=(7, 4.8), layout="constrained")
    for state, (there, slope) in segments.items():
        label = f"{state.label}, slope −{slope}"
        axes.plot(
            curve.deflection[there],
            curve.torque[there],
            color=STATE_COLOURS[state],
            label=label,
            linewidth=2.2,
        )
    outward, inward = (lower, upper), (curve.deflection[0], curve.deflection[-1])
    draw_borders(axes, outward, inward)
    axes.set(
        xlabel=DEFLECTION,
        ylabel=TORQUE,
        title=r"Fig. 5: $k_1 = 1.33\,k_2$, $l_{max,1} = 0.67\,l_{max,2}$",
    )
    axes.legend(frameon=False, loc="upper right")
    finish(figure, picture)


def draw_borders(axes: Axes, slack: tuple[float, float], limits: tuple[float, float]) -> None:
    """Borders of the slack states (dashed) and of the curve (dotted); arrows: F_p rises."""
    low, high = axes.get_ylim()
    axes.set_ylim(low - 0.15 * (high - low), high)
    length = 0.06 * (limits[1] - limits[0])
    for borders, style, towards in ((slack, "--", 1.0), (limits, ":", -1.0)):
        for border in borders:
            axes.axvline(border, color="0.5", linestyle=style, linewidth=1)
            tip = border + towards * np.sign(border) * length
            axes.annotate("", (tip, low), (border, low), arrowprops={"arrowstyle": "->"})
    axes.text(0.0, low, "$F_p$ rises", ha="center", va="center")


def draw_family(number: int, picture: Path) -> None:
    """Figs. 7 to 9: several pretensions; the largest torque stays, the deflection shrinks."""
    name, pretensions = FAMILIES[number]
    model = load_model(name)
    curves = characteristic_curves(model, pretensions)
    figure, axes = plt.subplots(figsize=(7, 4.8), layout="constrained")
    for curve in curves:
        (line,) = axes.plot(curve.deflection, curve.torque, label=f"{curve.pretension:g} N")
        axes.plot(curve.slack_boundaries, curve.boundary_torques, "o", color=line.get_color())
    axes.set(
        xlabel=DEFLECTION,
        ylabel=TORQUE,
        title=f"Fig. {number}: {name}.toml over the pretension; dots: slack boundaries",
    )
    axes.legend(frameon=False, title="pretension")
    finish(figure, picture)
    torques = [curve.torque[0] for curve in curves]
    spans = [np.ptp(curve.deflection) for curve in curves]
    print(
        f"Fig. {number}: largest torque {min(torques):.4g} to {max(torques):.4g} N·m at every "
        f"pretension, range of deflection {max(spans):.3g} down to {min(spans):.3g} rad"
    )


def print_numbers(model: Model) -> None:
    """The numbers (36) to (39) of the paper beside those of the model."""
    table = design(model)
    for what, ours, paper in (
        ("slack boundary (36), rad", table.positive_slack_boundary, "0.115"),
        ("largest deflection (37), rad", table.positive_max_deflection, "0.385"),
        ("stiffness, both taut (38), N·m/rad", table.stiffness_state_3, "41.69"),
        ("stiffness, one slack (39), N·m/rad", table.stiffness_state_1, "20.8"),
    ):
        print(f"{what}: {ours:.4g}, paper {paper}")


# ---- Figs. 10 and 11: model against measurement ---------------------------------------------


def compared(model: Model, data: Path) -> tuple[Comparison, Location]:
    """Comparison of one file and where it fails, told in words too."""
    comparison = compare(model, read(data))
    location = locate(comparison)
    error = comparison.files[0].signals["joint_position"]
    print(f"{data.name}: {1e3 * error.rmse:.3g} mrad RMS, fit {error.fit_percent:.1f} %")
    print(f"{data.name}: {location.files[0].in_words['joint_position']}")
    return comparison, location


def draw_static(comparison: Comparison, location: Location, picture: Path) -> None:
    """Fig. 10: torque over deflection, and below it the torque that the model lacks."""
    model, (file,), (place,) = comparison.model, comparison.files, location.files
    (curve,) = characteristic_curves(model, [model.transmission.pretension_force])
    figure, (top, bottom) = plt.subplots(
        2, 1, figsize=(7, 6), sharex=True, layout="constrained", height_ratios=[2, 1]
    )
    measured = file.measurement.signals["joint_position"]
    inside = (curve.deflection > measured.min()) & (curve.deflection < measured.max())
    top.plot(curve.deflection[inside], curve.torque[inside], color=SIMULATED, label="model")
    top.plot(measured, -file.measurement.load_torque, ".", color=MEASURED, label="measured")
    missing = place.missing_torque.torque
    bottom.plot(place.variables["deflection"], missing, ".", color=MEASURED)
    bottom.axhline(0.0, color=SIMULATED)
    for axes in (top, bottom):
        for boundary in curve.slack_boundaries:
            axes.axvline(boundary, color="0.5", linestyle="--", linewidth=1)
    top.legend(frameon=False)
    top.set(ylabel=TORQUE, title="Fig. 10: the corners deviate; dashed: slack boundaries")
    bottom.set(xlabel=DEFLECTION, ylabel="missing torque (N·m)")
    finish(figure, picture)


def draw_excitation(comparison: Comparison, picture: Path) -> None:
    """Fig. 11: motor and joint over time, measured and simulated, and the error below."""
    (file,) = comparison.files
    figure, (top, bottom) = plt.subplots(
        2, 1, figsize=(8, 5.5), sharex=True, layout="constrained", height_ratios=[2, 1]
    )
    time, measured = file.measurement.time, file.measurement.signals["joint_position"]
    simulated = file.trajectory["joint_position"]
    # the pulleys are equal: the motor position counts at the joint
    top.plot(time, file.measurement.motor_position, color="0.6", label=r"${}^j\theta_d$")
    top.plot(time, measured, color=MEASURED, label="q, measured")
    top.plot(time, simulated, "--", color=SIMULATED, label="q, simulated")
    top.set(ylabel="position (rad)", title="Fig. 11: an excitation of the motor, the joint free")
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    bottom.plot(time, 1e3 * (simulated - measured), color="#0072B2", linewidth=1)
    bottom.axhline(0.0, color="0.5", linewidth=0.8)
    bottom.set(xlabel="time (s)", ylabel="simulated less\nmeasured (mrad)")
    finish(figure, picture)


def finish(figure: plt.Figure, picture: Path) -> None:
    figure.savefig(picture, dpi=100)
    plt.close(figure)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    draw_three_slopes(asymmetric(load_model("figure_8")), folder / "figure_5.png")
    for number in FAMILIES:
        draw_family(number, folder / f"figure_{number}.png")
    model = load_model("biorob_x4_joint_3")
    print_numbers(model)
    draw_static(*compared(model, HERE / "static_curve.csv"), folder / "figure_10.png")
    draw_excitation(compared(model, HERE / "excitation.csv")[0], folder / "figure_11.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "folder", nargs="?", type=Path, default=HERE, metavar="FOLDER",
        help="where the pictures go (default: beside this script); created if missing",
    )  # fmt: skip
    main(parser.parse_args().folder)
