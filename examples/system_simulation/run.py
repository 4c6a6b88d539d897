"""Simulate a joint under control: two FMUs, connected in an SSP, run by two system simulators.

    python examples/system_simulation/run.py [FOLDER]

Packs the actuator's FMU and the controller (controller.c) into controlled_joint.ssp, as
SystemStructure.ssd connects them, and runs it in fmpy and, where it is installed, in Ecos, which
takes an actuator of FMI 3.0 too. Leaves controlled_joint.ssp and draws controlled_joint.png in
FOLDER (default: here).
"""

import argparse
import ctypes
import subprocess
import sys
import tempfile
import zipfile
from importlib import metadata, util
from pathlib import Path
from typing import Literal

import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv

import elastic_tendon as et

HERE = Path(__file__).parent
# s; also the delay in the loop, so keep it well below the joint's natural period of 0.17 s
STEP = 1e-3
STOP = 1.2  # s
REFERENCE, MOTOR = "controller.reference_position", "controller.motor_position"
JOINT, SLACK_STATE = "actuator.joint_position", "actuator.slack_state"
BOTH_TAUT = 3
SLACK_STATES = {1: ("lower slack", "#D55E00"), 2: ("upper slack", "#0072B2")}
Signals = dict[str, np.ndarray]


# ---- the system ----------------------------------------------------------------------------


def pack(archive: Path, files: dict[str, Path]) -> Path:
    """Zip files under the names that they have in the archive."""
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name, path in files.items():
            zipped.write(path, name)
    return archive


def controller_fmu(folder: Path) -> Path:
    """Compile controller.c; an FMU is a zip of a description and a library for each platform."""
    library = folder / f"controller{fmpy.sharedLibraryExtension}"
    headers = Path(fmpy.__file__).parent / "c-code"
    compiler = [sys.executable, "-m", "ziglang", "cc"]  # which elastic-tendon uses too
    options = ["-shared", "-fPIC", "-O2", f"-I{headers}", "-o", str(library)]
    subprocess.run([*compiler, *options, str(HERE / "controller.c")], check=True)
    binary = f"binaries/{fmpy.platform}/{library.name}"
    files = {"modelDescription.xml": HERE / "controller.xml", binary: library}
    return pack(folder / "controller.fmu", files)


def system(archive: Path, folder: Path, fmi_version: Literal[2, 3] = 2) -> Path:
    """The SSP: a zip of the system's structure, its parameters and the FMUs, made in a folder."""
    folder.mkdir()
    model = et.load_model("biorob_x4_joint_3").with_effect("gravity_load", {"torque": 1.5})
    actuator = et.export_fmu(model, folder / "actuator.fmu", fmi_version=fmi_version)
    files = {
        "SystemStructure.ssd": HERE / "SystemStructure.ssd",
        "resources/tuning.ssv": HERE / "tuning.ssv",
        "resources/controller.fmu": controller_fmu(folder),
        "resources/actuator.fmu": actuator,
    }
    return pack(archive, files)


# ---- its simulators ------------------------------------------------------------------------


def in_fmpy(ssp: Path) -> Signals:
    """Signals after each step, by fmpy."""
    tuning = read_ssv(str(ssp), resource="resources/tuning.ssv")
    for parameter in tuning.parameters:  # fmpy sets parameters only where it is told to
        parameter.name = f"controller.{parameter.name}"
    rows = simulate_ssp(str(ssp), stop_time=STOP, step_size=STEP, parameter_set=tuning)
    # a row holds the time where a step began and the values where it ended
    signals = {name: rows[name] for name in (REFERENCE, MOTOR, JOINT, SLACK_STATE)}
    return {"time": rows["time"] + STEP} | signals


def in_ecos(ssp: Path) -> Signals:
    """Signals after each step, by Ecos, a simulator in C++; it does not read enumerations."""
    for file in metadata.files("tbb") or ():  # which Ecos needs and does not find by itself
        if file.name == "libtbb.so.12":
            ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)
    from ecospy import EcosSimulation

    names = (REFERENCE, MOTOR, JOINT)
    rows = []
    with EcosSimulation(STEP, ssp_path=str(ssp)) as simulation:
        simulation.init(parameter_set="tuning")
        while simulation.get_time() < STOP:
            simulation.step()
            values = [simulation.get_real(name.replace(".", "::")) for name in names]
            rows.append((simulation.get_time(), *values))
        simulation.terminate()
    return dict(zip(("time", *names), np.array(rows).T, strict=True))


# ---- what came of it -----------------------------------------------------------------------


def draw(run: Signals, picture: Path) -> None:
    figure, (way, error) = plt.subplots(2, 1, figsize=(7, 6), sharex=True, layout="constrained")
    time, reference = run["time"], run[REFERENCE]
    joint, slack_state = run[JOINT], run[SLACK_STATE]
    way.plot(time, run[MOTOR], color="0.6", label="motor")
    way.plot(time, reference, "--", color="black", label="reference")
    way.plot(time, joint, color="#009E73", label="joint")
    way.set(ylabel="position (rad)")
    error.plot(time, 1e3 * (joint - reference), color="#009E73")
    error.set(ylabel="joint minus reference (mrad)", xlabel="time (s)")
    for axes in (way, error):
        for state, (label, colour) in SLACK_STATES.items():
            there = slack_state == state
            shade = {"color": colour, "alpha": 0.3, "linewidth": 0, "label": label}
            axes.fill_between(time, 0, 1, there, transform=axes.get_xaxis_transform(), **shade)
    way.legend(loc="center left")
    figure.savefig(picture, dpi=110)


def chosen_folder() -> Path:
    """FOLDER of the command line, created if missing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    told = "where the picture and the SSP go (default: beside this script); created if missing"
    parser.add_argument("folder", nargs="?", type=Path, default=HERE, metavar="FOLDER", help=told)
    folder = parser.parse_args().folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        parser.error(f"{folder} cannot be made a folder: {error.strerror}")
    return folder


def main(folder: Path) -> None:
    with tempfile.TemporaryDirectory() as work:
        ssp = system(folder / "controlled_joint.ssp", Path(work) / "fmpy")
        print(f"the system is {ssp}")
        run = in_fmpy(ssp)
        error = run[JOINT] - run[REFERENCE]
        taut = run[SLACK_STATE] == BOTH_TAUT
        print(f"a tendon is slack for {1e3 * STEP * np.sum(~taut):.0f} ms")
        print(f"largest error of the joint: {1e3 * np.abs(error).max():.1f} mrad")
        for fmi_version in (2, 3) if util.find_spec("ecospy") else ():
            parts = Path(work) / f"ecos_{fmi_version}"
            ssp = system(parts.with_suffix(".ssp"), parts, fmi_version)
            apart = np.abs(in_ecos(ssp)[JOINT] - run[JOINT]).max()
            print(f"Ecos, actuator of FMI {fmi_version}.0: joint {apart:.1g} rad from fmpy's")
    draw(run, folder / "controlled_joint.png")


if __name__ == "__main__":
    main(chosen_folder())
