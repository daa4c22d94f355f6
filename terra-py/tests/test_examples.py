"""The examples as they ship, and what they should find."""

import subprocess
import sys


def run(path):
    done = subprocess.run([sys.executable, path], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_larger_wheels_pull_more(examples):
    """Less sinkage and a longer contact: Bekker's first lesson."""
    lines = run(examples / "python/forces.py").splitlines()
    pulls = [float(line.split("pull")[1].split("N")[0]) for line in lines]
    assert len(pulls) == 4 and pulls == sorted(pulls)


def test_the_true_effect_beats_an_idea(examples):
    out = run(examples / "python/own_effect.py")
    assert out.splitlines()[1].startswith("slip-sinkage: "), out
    assert "clogging: " in out
