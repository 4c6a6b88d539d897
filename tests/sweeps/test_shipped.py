"""A model arrives in another process as it was sent, with effects of the user's own."""

import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from elastic_tendon.actuator.parameters import load_model
from elastic_tendon.sweeps.shipped import ship

RIPPLE = Path(__file__).parents[2] / "examples" / "own_effect" / "tooth_ripple.py"

SEND = """
import base64, pickle, sys
from elastic_tendon import effects, load_model
from elastic_tendon.sweeps.shipped import ship
effects.load(sys.argv[1])
model = load_model("biorob_x4_joint_3").with_effect("tooth_ripple", {"amplitude": 1e-3})
print(base64.b64encode(pickle.dumps(ship(model))).decode())
"""

RECEIVE = """
import base64, pickle, sys
from elastic_tendon.sweeps.task import UnfitError
sent = [pickle.loads(base64.b64decode(text)) for text in sys.stdin.read().split()]
print(sent[0].model.effects)
try:
    print(sent[1].model.effect_ids)
except UnfitError as error:
    print("refused:", error)
"""


def _python(program: str, *words: str, told: str = "") -> str:
    run = subprocess.run(
        [sys.executable, "-c", program, *words],
        input=told,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


def test_a_model_of_the_catalogue_takes_no_files_along():
    model = load_model("biorob_x4_joint_3").with_effect("coulomb_friction", {"torque": 0.3})
    sent = ship(model)
    assert sent.own_effects == ()
    assert pickle.loads(pickle.dumps(sent)).model == model


@pytest.mark.parametrize("changed", [False, True])
def test_an_effect_of_ones_own_arrives_where_its_file_is_not(changed, tmp_path):
    copy = tmp_path / RIPPLE.name
    copy.write_bytes(RIPPLE.read_bytes() + (b"\n# changed\n" if changed else b""))
    sent = [_python(SEND, str(path)) for path in (RIPPLE, copy)]
    copy.unlink()
    first, second = _python(RECEIVE, told="\n".join(sent)).splitlines()
    assert "'tooth_ripple': {'amplitude': 0.001" in first
    if changed:
        assert second.startswith("refused: ")
        assert "start the workers anew if tooth_ripple.py has changed" in second
    else:
        assert second == "('tooth_ripple',)"
