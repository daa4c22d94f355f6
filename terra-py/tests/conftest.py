"""What the tests share: the examples, the command to compare with, logs simulated once."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def examples():
    return ROOT / "examples"


@pytest.fixture(scope="session")
def program():
    """The command: $TERRA_COMMAND, or what `cargo build` made."""
    program = os.environ.get("TERRA_COMMAND", ROOT / "target" / "debug" / "terra")
    if not Path(program).exists():
        pytest.skip(f"no command to compare with: {program} does not exist (cargo build)")
    return program


@pytest.fixture(scope="session")
def command(program):
    """Runs the command, which must go well."""

    def run(*args):
        done = subprocess.run([program, *map(str, args)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture(scope="session")
def logs(tmp_path_factory, command, examples):
    """A drive and a rig log as files, by the command."""
    folder = tmp_path_factory.mktemp("logs")
    command("simulate", examples / "paper" / "lean_clay.toml", "--out", folder / "drive.csv")
    command("simulate", examples / "rig" / "slip_sinkage.toml", "--out", folder / "rig.csv")
    return folder
