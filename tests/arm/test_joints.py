"""`cut_into_joints`, on arms that MuJoCo plays with its own tendons."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from arms import ACTUATORS

from elastic_tendon.actuator.parameters import load_model, parse_model
from elastic_tendon.arm.joints import cut_into_joints
from elastic_tendon.comparison.compare import compare
from elastic_tendon.errors import ArmError
from elastic_tendon.measurement import Measurement
from engine.arms import BASES, JOINTS, PlayedArm, links, play, robot
from study_arm import row_of

NOTHING = PlayedArm("nothing", "elbow", 3)  # of development
DURATION = 3.0  # s
TRUE = {name: load_model(BASES[name].tree()) for name in JOINTS}


@pytest.fixture(scope="module")
def recordings():
    return play(NOTHING, DURATION)


@pytest.fixture(scope="module")
def cut(recordings):
    return cut_into_joints(robot(NOTHING.seed), TRUE, recordings)


def errors(joints):
    """Of the models, in units of the noise that the recordings are said to have."""
    return {
        name: compare(joint.model, [joint.recording]).rmse()["joint_position"]
        / joint.recording.noise["joint_position"].sigma
        for name, joint in joints.items()
    }


def test_true_models_err_by_the_noise_that_was_carried_along(cut):
    """By no less either, so the weights are right."""
    assert set(errors(cut)) == set(JOINTS)
    for name, error in errors(cut).items():
        assert 0.7 < error < 1.4, name


def test_noise_of_loads_counts_where_it_moves_the_joint(cut):
    added = {name: one.recording.noise["joint_position"].sigma for name, one in cut.items()}
    assert added["wrist"] > 2 * added["base"]  # light links, far out
    assert all(one.load_noise < 0.2 * np.std(one.recording.load_torque) for one in cut.values())


def test_links_are_those_of_the_mass_matrix(cut):
    """Here the hand's, which no other joint changes, by the parallel axis theorem."""
    known = robot(NOTHING.seed)
    hand = known.body("hand").id
    offset = known.body_ipos[hand][0]
    inertia = known.body_inertia[hand].max() + known.body_mass[hand] * offset**2
    assert cut["wrist"].model.link.inertia == pytest.approx(inertia, rel=1e-6)
    assert cut["wrist"].model.link.damping == BASES["wrist"].damping


def test_models_need_no_link_of_their_own(cut, recordings):
    bare = {}
    for name, model in TRUE.items():
        tree = model.at("joint").model_dump()
        bare[name] = parse_model({key: tree[key] for key in tree if key != "link"}, name)
    assert all(model.link.absent for model in bare.values())
    again = cut_into_joints(robot(NOTHING.seed), bare, recordings)
    assert {name: one.model for name, one in again.items()} == {
        name: one.model for name, one in cut.items()
    }


def test_what_hides_in_one_joint_shows_in_that_joint_alone():
    arm = PlayedArm("dry", "elbow", NOTHING.seed)
    found = errors(cut_into_joints(robot(arm.seed), TRUE, play(arm, DURATION)))
    assert found.pop("elbow") > 5.0
    assert max(found.values()) < 1.4


@pytest.mark.slow
def test_it_is_diagnosed_in_that_joint_alone():
    row = row_of(PlayedArm("dry", "elbow", NOTHING.seed))
    assert row["right"], row


def test_recordings_of_another_number_of_joints_are_refused(recordings):
    without = {name: one for name, one in recordings.items() if name != "wrist"}
    words = r"the arm has 4 joints \(base, shoulder, elbow, wrist\), but there are 3 recordings "
    with pytest.raises(ArmError, match=words + r"\(base, shoulder, elbow\); give one of each"):
        cut_into_joints(robot(0), TRUE, without)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda one: one.samples(slice(1, None)), "base and wrist have different times"),
        (lambda one: replace(one, signals={"joint_torque": one.time}), "wrist has no joint_pos"),
    ],
)
def test_recordings_that_do_not_belong_together_are_refused(recordings, change, words):
    changed = {**recordings, "wrist": change(recordings["wrist"])}
    with pytest.raises(ArmError, match=words):
        cut_into_joints(robot(0), TRUE, changed)


def test_few_or_uneven_samples_are_refused(recordings):
    uneven = np.r_[0:400, 401:900]
    for keep, words in ((slice(100), "these are 100 at 0.002 to 0.002 s"), (uneven, "0.004 s")):
        some = {name: one.samples(keep) for name, one in recordings.items()}
        with pytest.raises(ArmError, match=words):
            cut_into_joints(robot(0), TRUE, some)


def test_joints_and_models_have_the_same_names(recordings):
    with pytest.raises(ArmError, match="no joint 'knee'"):
        cut_into_joints(robot(0), {"knee": ACTUATORS["elbow"]}, recordings)


def test_springs_need_to_know_where_their_motor_is(recordings):
    elbow = recordings["elbow"]
    given = recordings | {"elbow": Measurement(time=elbow.time, signals=elbow.signals)}
    with pytest.raises(ArmError, match="of elbow has no motor_position, which its springs need; "):
        cut_into_joints(robot(0), TRUE, given)


def test_loads_are_those_of_a_robot_that_moves_as_a_formula_says():
    """A free swinging hand on a held arm: the wrist's load is gravity's, m g l cos.

    Joints without springs need no motor position.
    """
    text = f"<mujoco><worldbody>{links(0)}</worldbody></mujoco>"
    known = mujoco.MjModel.from_xml_string(text)
    known.dof_damping[:] = 0.0
    time = np.arange(0.0, 2.0, 0.002)
    wrist = 0.5 * np.sin(3.0 * time)
    position = dict.fromkeys(JOINTS, 0 * time) | {"wrist": wrist}
    held = {
        name: Measurement(
            time=time,
            motor_position=at if name == "wrist" else None,
            signals={"joint_position": at},
        ).with_noise({"joint_position": 1e-6})
        for name, at in position.items()
    }
    load = cut_into_joints(known, {"wrist": TRUE["wrist"]}, held)["wrist"].recording
    hand = known.body("hand").id
    weight = known.body_mass[hand] * 9.81 * known.body_ipos[hand][0]
    expected = weight * np.cos(np.interp(load.time, time, wrist))
    assert load.load_torque == pytest.approx(expected, abs=1e-3 * weight)
