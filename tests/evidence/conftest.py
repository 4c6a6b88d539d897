"""FMUs with evidence, exported once; keys of their own."""

from pathlib import Path

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import (
    Encoding,
    NoEncryption,
    PrivateFormat,
    PublicFormat,
)
from evidence_cases import friction_diagnosis, friction_model

import elastic_tendon as et
from made_soon import not_optimised


def _key(folder: Path, name: str) -> Path:
    """A new private key; its public one lies beside it."""
    key = Ed25519PrivateKey.generate()
    path = folder / f"{name}.pem"
    path.write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
    public = key.public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo)
    path.with_suffix(".pub").write_bytes(public)
    return path


@pytest.fixture(scope="session")
def keys(tmp_path_factory):
    """Paths of the keys "ours" and "theirs"."""
    folder = tmp_path_factory.mktemp("keys")
    return {name: _key(folder, name) for name in ("ours", "theirs")}


@pytest.fixture(scope="session")
def evidence():
    """Evidence of the demo's model with friction, and its two recordings."""
    demo = et.load_demo()
    recordings = [demo.recording, demo.validation]
    return et.gather_evidence(friction_model(), recordings, diagnosis=friction_diagnosis())


@pytest.fixture(scope="session")
def sealed(tmp_path_factory, evidence, keys):
    """Path of a signed FMU by version of FMI; its binary is not optimised."""
    made = {}

    def get(version):
        if version not in made:
            path = tmp_path_factory.mktemp("sealed") / "x.fmu"
            with not_optimised():
                options = {"fmi_version": version, "evidence": evidence, "sign": keys["ours"]}
                made[version] = et.export_fmu(friction_model(), path, **options)
        return made[version]

    return get
