"""What examples/cluster tells a cluster to do, done on this computer."""

import os
import shutil
import socket
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest

import elastic_tendon as et

pytest.importorskip("distributed")
yaml = pytest.importorskip("yaml")

EXAMPLES = Path(__file__).parents[1] / "examples" / "cluster"
MODEL = et.load_model("biorob_x4_joint_3")
RUNS = 40
# what stands in for SLURM: its options are dropped, the command is run once
SRUN = '#!/bin/bash\nwhile [[ "$1" == --* ]]; do shift; done\nexec "$@"\n'
OUTPUT = "runs.parquet"


def environment(folder, **settings):
    """That of a job: programs of this environment, and srun."""
    stub = folder / "bin" / "srun"
    stub.parent.mkdir()
    stub.write_text(SRUN)
    stub.chmod(0o755)
    path = os.pathsep.join([str(stub.parent), str(Path(sys.executable).parent), os.environ["PATH"]])
    return os.environ | {"PATH": path, "RUNS": f"{RUNS}"} | settings


def sbatch(script, folder, settings):
    """Run a job script; SLURM gives it what is in `settings`."""
    done = subprocess.run(
        ["bash", str(EXAMPLES / script)],
        cwd=folder,
        env=settings,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """The table of the same sweep without a cluster."""
    folder = tmp_path_factory.mktemp("here")
    springs = [f"transmission.{side}_spring.stiffness" for side in ("upper", "lower")]
    et.sweep(MODEL, folder / OUTPUT, vary=dict.fromkeys(springs, "5%"), runs=RUNS, workers=1)
    return (folder / OUTPUT).read_bytes()


def test_shares_of_a_job_array_are_joined(tmp_path, expected):
    settings = environment(tmp_path)
    for task in (2, 1):
        own = {
            "SLURM_ARRAY_TASK_ID": f"{task}",
            "SLURM_ARRAY_TASK_COUNT": "2",
            "SLURM_CPUS_PER_TASK": "1",
        }
        assert f"Share {task}/2 is done" in sbatch("job_array.sh", tmp_path, settings | own)
    sbatch("job_array.sh", tmp_path, settings)
    assert (tmp_path / OUTPUT).read_bytes() == expected
    assert len(pd.read_parquet(tmp_path / OUTPUT)) == RUNS


@pytest.mark.slow  # a cluster as the manifest's, begun otherwise
def test_the_tasks_of_one_job_are_a_cluster(tmp_path, expected):
    sbatch("one_job.sh", tmp_path, environment(tmp_path, SLURM_NTASKS="2"))
    assert (tmp_path / OUTPUT).read_bytes() == expected


@contextmanager
def running(command, folder):
    process = subprocess.Popen(command, cwd=folder, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(timeout=20)


def commands(port, folder):
    """Command of each container, with this computer's names of service and volume."""
    found = {}
    for part in yaml.safe_load_all((EXAMPLES / "kubernetes.yaml").read_text()):
        for container in part["spec"].get("template", {}).get("spec", {}).get("containers", ()):
            words = [
                word.replace("scheduler:8786", f"127.0.0.1:{port}")
                .replace("/results/", f"{folder}/")
                .replace("8786", f"{port}")
                .replace("1000000", f"{RUNS}")
                for word in container["command"]
            ]
            program = shutil.which(words[0], path=str(Path(sys.executable).parent))
            found[container["name"]] = [program, *words[1:]]
    return found


def test_what_the_manifest_runs_gives_the_same(tmp_path, expected):
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    told = commands(port, tmp_path)
    assert list(told) == ["scheduler", "worker", "springs"]
    with running(told["scheduler"], tmp_path), running(told["worker"], tmp_path):
        subprocess.run(told["springs"], cwd=tmp_path, check=True, capture_output=True, timeout=120)
    assert (tmp_path / OUTPUT).read_bytes() == expected
    assert not any((tmp_path / "parts").glob("*"))
