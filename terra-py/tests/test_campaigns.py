"""Campaigns, challenges and sweeps: the same files and the same figures as the command, and an end when one is asked for."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

import terra


def files(folder):
    """What lies below a folder, by its path there."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def said(command, tmp_path, *args):
    """What a campaign's `--json` holds."""
    out = tmp_path / "said.json"
    command("campaign", *args, "--json", out)
    return json.loads(out.read_text())


def test_ramps(command, tmp_path):
    found = terra.campaign.ramps(runs=2, seed=3, terrains=["dry_sand"])
    assert found == said(command, tmp_path, "ramps", "--runs", "2", "--seed", "3", "--terrains", "dry_sand")
    with pytest.raises(terra.ConfigurationError, match="dry_sand"):
        terra.campaign.ramps(runs=1, terrains=["dry_snad"])
    with pytest.raises(terra.ConfigurationError, match="from 1 to"):
        terra.campaign.ramps(runs=0)


def test_faults(command, tmp_path):
    found = terra.campaign.faults(runs=1, filter="kf")
    assert found == said(command, tmp_path, "faults", "--runs", "1", "--filter", "kf")
    assert found["report"]["total"]["panics"] == 0


def test_reproduction(command, tmp_path):
    found = terra.campaign.reproduction(runs=1, tables=["switch"])
    assert found == said(command, tmp_path, "reproduction", "--runs", "1", "--tables", "switch")
    assert {f["table"] for f in found["figures"]} == {"switch"}
    with pytest.raises(terra.ConfigurationError, match="exact, switch, perturbed, mismatch"):
        terra.campaign.reproduction(runs=1, tables=["swich"])


def test_sealed_cases(command, tmp_path):
    """A campaign in a folder, and the calibration that its cases teach."""
    theirs, ours = tmp_path / "theirs", tmp_path / "ours"
    asked = ["--designs", "rig", "--cases", "2", "--seed", "5", "--out", theirs]
    expected = said(command, tmp_path, "gap", *asked, "--left-out")
    found = terra.campaign.gap(ours, designs=["rig"], cases=2, seed=5, left_out=True)
    assert found == expected
    assert files(ours) == files(theirs) and "rig/logs/case_002.csv" in files(ours)
    command("campaign", "gap-calibration", *asked, "--nulls", "1")
    text = terra.campaign.gap_calibration(ours, designs=["rig"], cases=2, seed=5, nulls=1)
    assert text == (ours / "calibration.toml").read_text() == (theirs / "calibration.toml").read_text()
    with pytest.raises(terra.ConfigurationError, match="ramp, steps, flat, rich, rig"):
        terra.campaign.gap(ours, designs=["rigg"])


def test_cross_structure(command, tmp_path):
    theirs, ours = tmp_path / "theirs", tmp_path / "ours"
    expected = said(command, tmp_path, "cross-structure", "--cases", "1", "--seed", "2", "--out", theirs)
    assert terra.campaign.cross_structure(ours, cases=1, seed=2) == expected
    assert files(ours) == files(theirs) and "calibration.toml" in files(ours)


def test_challenge(command, tmp_path):
    """Made, diagnosed, marked and opened: every file as the command writes it."""
    theirs, ours = tmp_path / "theirs", tmp_path / "ours"
    for folder in (theirs, ours):
        folder.mkdir()
    command("challenge", "make", "--design", "rig", "--cases", "2", "--seed", "9", "--kinds", "single=1",
            "--out", theirs / "logs", "--key", theirs / "key.json")  # fmt: skip
    made = terra.challenge.make("rig", 2, seed=9, kinds={"single": 1}, out=ours / "logs", key=ours / "key.json")
    assert made["cases"] == 2 and made["kinds"]["single"] == 2
    command("challenge", "run", theirs / "logs", "--out", theirs / "verdicts")
    ran = terra.challenge.run(ours / "logs", ours / "verdicts")
    assert (ran["cases"], ran["kept"], ran["failed"], ran["first_failure"]) == (2, 0, 0, None)
    assert sum(ran["verdicts"].values()) == 2
    assert files(ours) == files(theirs) and len(files(ours)) == 7
    assert terra.challenge.run(ours / "logs", ours / "verdicts")["kept"] == 2
    marks = tmp_path / "score.json"
    for options, closing in [([], True), (["--skip-closing"], False)]:
        command("challenge", "score", "--verdicts", theirs / "verdicts", "--key", theirs / "key.json", "--json",
                marks, *options)  # fmt: skip
        score = terra.challenge.score(ours / "verdicts", ours / "key.json", closing=closing)
        assert score == json.loads(marks.read_text())
    table = command("challenge", "reveal", "--key", theirs / "key.json", theirs / "logs")
    answers = terra.challenge.reveal(ours / "key.json", ours / "logs")
    assert [a["case"] for a in answers] == ["case_001", "case_002"]
    for answer, line in zip(answers, table.splitlines()[2:]):
        assert answer["effects"][0]["name"] in line and str(answer["seed"]) in line
    commitment = ours / "logs/COMMIT.txt"
    text = commitment.read_text()
    commitment.write_text(text[:-2] + ("1" if text[-2] == "0" else "0") + "\n")
    with pytest.raises(terra.BadData, match="COMMIT.txt"):
        terra.challenge.reveal(ours / "key.json", ours / "logs")
    with pytest.raises(terra.ConfigurationError, match="inside the challenge"):
        terra.challenge.make("rig", 1, seed=1, out=ours / "logs", key=ours / "logs/key.json")
    with pytest.raises(terra.ConfigurationError, match="form-variant"):
        terra.challenge.make("rig", 1, seed=1, out=ours / "logs", key=ours / "key.json", kinds={"one": 1})


PLAN = """
command = "{command}"
scenario = "{scenario}"
runs = {runs}
seed = 1

[vary]
noise_scale = [1.0, 2.0]
"""


def plan(tmp_path, examples, command, runs):
    path = tmp_path / "plan.toml"
    path.write_text(PLAN.format(command=command, scenario=(examples / "rig/slip_sinkage.toml").as_posix(), runs=runs))
    return path


def test_sweep_and_merge(command, examples, tmp_path):
    asked, whole = plan(tmp_path, examples, "simulate", 3), tmp_path / "whole.jsonl"
    command("sweep", asked, "--out", whole)
    shards = [tmp_path / f"{k}.jsonl" for k in (1, 2)]
    assert [terra.sweep(asked, s, shard=(k, 2)) for k, s in enumerate(shards, 1)] == [(3, 3), (3, 3)]
    assert terra.sweep(asked, shards[0], shard=(1, 2)) == (3, 0)
    joined = tmp_path / "joined.jsonl"
    assert terra.merge(shards[::-1], joined) is None
    assert joined.read_bytes() == whole.read_bytes()
    assert terra.merge(shards) == [json.loads(line) for line in whole.read_text().splitlines()]
    with pytest.raises(terra.BadData, match="run 1 is in none"):
        terra.merge(shards[:1])
    with pytest.raises(terra.ConfigurationError, match="3/2"):
        terra.sweep(asked, shards[0], shard=(3, 2))


INTERRUPTED = """
import signal, sys, terra
signal.signal(signal.SIGINT, signal.default_int_handler)
print("ready", flush=True)
try:
    terra.sweep(sys.argv[1], sys.argv[2])
except KeyboardInterrupt:
    print("heard", flush=True)
    # The work ends by itself, so that this process may go on with the file at once.
    print(*terra.sweep(sys.argv[1], sys.argv[2]), flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for one process")
def test_an_interrupted_sweep_is_gone_on_with(command, examples, tmp_path):
    """Ctrl-C in the middle, then the same plan once more in the same process: nothing is lost, and the bytes are the same."""
    asked, whole, out = plan(tmp_path, examples, "identify", 40), tmp_path / "whole.jsonl", tmp_path / "out.jsonl"
    # Lines come in batches of a few for each thread: on many they would all come at once.
    work = subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, asked, out],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "RAYON_NUM_THREADS": "2"},
    )
    assert work.stdout.readline() == "ready\n"
    growing = tmp_path / "out.jsonl.partial"
    while not (growing.exists() and growing.stat().st_size):
        assert work.poll() is None
        time.sleep(0.01)
    work.send_signal(signal.SIGINT)
    rest = work.stdout.read().split()
    assert work.wait(timeout=300) == 0
    assert rest[0] == "heard" and int(rest[1]) == 80 and 0 < int(rest[2]) < 80
    command("sweep", asked, "--out", whole)
    assert out.read_bytes() == whole.read_bytes()
