"""The arm as a system of FMUs, an SSP: four actuators at interface joint, and links with motors.

    python examples/arm/system.py [FOLDER]

Runs arm.ssp in fmpy, which is not ours, and prints how far its joints are from those of the arm in
one process, as the step halves. Leaves arm.ssp in FOLDER (default: here).
"""

import tempfile
import zipfile
from pathlib import Path

import numpy as np
from fmpy.ssp.simulation import simulate_ssp
from pythonfmu.builder import FmuBuilder
from run import ACTUATORS, HERE, PERIOD, POSE, SWING, arm_at, chosen_folder, move

import elastic_tendon as et

DURATION = 0.5  # s
STEPS = (1e-3, 5e-4, 2.5e-4)  # s
GIVEN = ("motor_position", "motor_velocity", "joint_position", "joint_velocity")
UNITS = {"position": "rad", "velocity": "rad/s", "torque": "N.m"}
SSD = """<?xml version="1.0" encoding="UTF-8"?>
<!-- Four actuators, and the links and motors that they stand between. -->
<ssd:SystemStructureDescription version="1.0" name="arm"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
  <ssd:System name="arm" description="Arm with four elastic joints">
    <ssd:Elements>
{elements}
    </ssd:Elements>
    <ssd:Connections>
{connections}
    </ssd:Connections>
  </ssd:System>
  <ssd:Units>
    <ssc:Unit name="rad"><ssc:BaseUnit rad="1"/></ssc:Unit>
    <ssc:Unit name="rad/s"><ssc:BaseUnit rad="1" s="-1"/></ssc:Unit>
    <ssc:Unit name="N.m"><ssc:BaseUnit kg="1" m="2" s="-2"/></ssc:Unit>
  </ssd:Units>
  <ssd:DefaultExperiment startTime="0.0" stopTime="{duration}"/>
</ssd:SystemStructureDescription>
"""


# ---- the system ----------------------------------------------------------------------------


def component(name: str, inputs: list[str], outputs: list[str]) -> str:
    connectors = "".join(
        f'          <ssd:Connector name="{connector}" kind="{kind}">'
        f'<ssc:Real unit="{UNITS[connector.rpartition("_")[2]]}"/></ssd:Connector>\n'
        for kind, names in (("input", inputs), ("output", outputs))
        for connector in names
    )
    return (
        f'      <ssd:Component name="{name}" type="application/x-fmu-sharedlibrary"\n'
        f'          source="resources/{name}.fmu">\n'
        f"        <ssd:Connectors>\n{connectors}        </ssd:Connectors>\n"
        f"      </ssd:Component>"
    )


def connection(begin: str, output: str, end: str, given: str) -> str:
    return (
        f'      <ssd:Connection startElement="{begin}" startConnector="{output}"\n'
        f'          endElement="{end}" endConnector="{given}"/>'
    )


def structure() -> str:
    """What stands in SystemStructure.ssd."""
    shown = [f"{joint}_{name}" for joint in ACTUATORS for name in GIVEN]
    torques = [f"{joint}_joint_torque" for joint in ACTUATORS]
    elements = [component("links", torques, shown)]
    elements += [component(joint, list(GIVEN), ["joint_torque"]) for joint in ACTUATORS]
    connections = [
        connection("links", f"{joint}_{name}", joint, name) for joint in ACTUATORS for name in GIVEN
    ] + [connection(joint, "joint_torque", "links", f"{joint}_joint_torque") for joint in ACTUATORS]
    return SSD.format(
        elements="\n".join(elements), connections="\n".join(connections), duration=DURATION
    )


def pack(archive: Path, folder: Path) -> Path:
    """Export the four actuators, build the FMU of the links, and zip all of it."""
    fmus = {
        joint: et.export_fmu(model.at("joint"), folder / f"{joint}.fmu")
        for joint, model in ACTUATORS.items()
    }
    motion = folder / "motion.txt"
    np.savetxt(motion, [arm_at(1e-3).motor_position, SWING, PERIOD, POSE])
    fmus["links"] = FmuBuilder.build_FMU(
        HERE / "links.py", dest=folder / "links.fmu", project_files=[HERE / "arm.xml", motion]
    )
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as zipped:
        zipped.writestr("SystemStructure.ssd", structure())
        for name, path in fmus.items():
            zipped.write(path, f"resources/{name}.fmu")
    return archive


# ---- both runs -----------------------------------------------------------------------------


def in_fmpy(ssp: Path, step: float) -> np.ndarray:
    """Joint positions after each step, (n, 4), rad."""
    rows = simulate_ssp(str(ssp), stop_time=DURATION, step_size=step)
    return np.array([rows[f"links.{joint}_joint_position"] for joint in ACTUATORS]).T


def main(folder: Path) -> None:
    with tempfile.TemporaryDirectory() as work:
        ssp = pack(folder / "arm.ssp", Path(work))
        print(f"the system is {ssp}")
        for step in STEPS:
            there, here = in_fmpy(ssp, step), move(arm_at(step), DURATION)["joint"]
            count = min(len(there), len(here))
            apart = np.abs(there[:count] - here[:count]).max()
            print(f"step {1e3 * step:g} ms: joints {1e3 * apart:.2f} mrad apart")


if __name__ == "__main__":
    main(chosen_folder())
