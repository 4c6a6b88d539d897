"""Whether what hides in one joint of an arm is found in that joint, and in no other.

    python build_scripts/study_arm.py [--seeds dev|report] [--jobs 2] [--only NAME]

MuJoCo plays arms of four joints with its own tendons, friction and stops; see
tests/engine/arms.py. Each recording is cut into joints by `cut_into_joints`, and each joint
diagnosed alone. An arm is right when the joint with something hidden is said to have it, and each
other joint to have no effect. Results are kept: interrupt and go on at will.
"""

import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path

# the machines belong to the tests and are not installed
sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))

from benchmarking import Row, at_least, print_table
from elastic_tendon.arm.joints import cut_into_joints
from engine.arms import ACCEPTED, NOTHING, PlayedArm, believed, play, robot
from kept_answers import Content, asked, collected, kept, parser_of, print_columns, print_faults

HIDING = "elbow"  # the third joint
KINDS = ("dry", "stopped", "dry_stopped", "rotor", "nothing")
ROUNDS = 4
FIRST_REPORTED_SEED = 1008  # those before were looked at by now
DURATION = 8.0  # s
TARGET = 18  # of 20 arms


def orders(reported: bool) -> list[PlayedArm]:
    """All arms; those of the report have seeds from which nothing was tuned."""
    first = FIRST_REPORTED_SEED if reported else 0
    seeds = range(first, first + ROUNDS)
    return [PlayedArm(kind, HIDING, seed) for seed in seeds for kind in KINDS]


def judged(arm: PlayedArm, folder: Path) -> Content:
    """The row of one arm, from disk where it is kept there."""
    return kept(folder / f"{arm.name}.json", lambda: row_of(arm))


def row_of(arm: PlayedArm) -> Content:
    """What the tool says of each joint of an arm, and whether all of that is right."""
    cut = cut_into_joints(robot(arm.seed), believed(arm), play(arm, DURATION))
    said = {name: asked(joint.model, [joint.recording]) for name, joint in cut.items()}
    noise = {name: joint.recording.noise["joint_position"].sigma for name, joint in cut.items()}
    right = {
        name: frozenset(one.named) in (ACCEPTED[arm.hidden] if name == arm.joint else {NOTHING})
        and one.verdict not in ("unexplained", "unknown_effect")
        for name, one in said.items()
    }
    return {
        "name": arm.name,
        "hidden": arm.hidden,
        "joints": {
            name: asdict(one) | {"floor": noise[name], "right": right[name]}
            for name, one in said.items()
        },
        "right": all(right.values()),
    }


def lines_of(row: Content) -> list[list[str]]:
    """A row as text, a line a joint."""
    return [
        [
            row["name"],
            name,
            one["verdict"],
            "+".join(one["named"]) or "none",
            f"{one['error'] / one['floor']:.2f}",
            f"{one['seconds']:.0f}",
            "right" if one["right"] else "WRONG",
        ]
        for name, one in row["joints"].items()
    ]


def figures(rows: list[Content]) -> list[Row]:
    """How many are right."""
    joints = [(row, name, one) for row in rows for name, one in row["joints"].items()]
    hiding = [one for row, name, one in joints if name == HIDING]
    others = [one for row, name, one in joints if name != HIDING]
    return [
        at_least(f"arms right, of {len(rows)}", sum(row["right"] for row in rows), TARGET),
        Row(f"{HIDING}s right, of {len(hiding)}", str(sum(one["right"] for one in hiding))),
        Row(f"other joints right, of {len(others)}", str(sum(one["right"] for one in others))),
    ]


def main() -> int:
    """Run what is not yet done and print the table; exit status 1 where the target is missed."""
    chosen = parser_of(__doc__, "elastic-tendon-study-arm").parse_args()
    wanted = [one for one in orders(chosen.seeds == "report") if chosen.only in one.name]
    rows, faults = collected(wanted, partial(judged, folder=chosen.folder), chosen.jobs)
    rows.sort(key=lambda row: str(row["name"]))
    heads = ["arm", "joint", "verdict", "named", "error/noise", "s", ""]
    print_columns([heads, *(line for row in rows for line in lines_of(row))])
    print_faults(faults)
    return print_table(f"Arms of MuJoCo, {len(rows)} of them", figures(rows)) if rows else 1


if __name__ == "__main__":
    sys.exit(main())
