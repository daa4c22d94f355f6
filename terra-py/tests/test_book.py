"""The Python of the book, word for word, in a folder that holds the files it names."""

import csv
import math
import re
import shutil

import numpy as np
import pytest

import terra


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def python(examples):
    return blocks(examples.parent / "book/src/python.md", "python")


@pytest.fixture
def folder(examples, tmp_path, monkeypatch):
    """The paper's drive under the names that the page uses."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(examples / "paper/lean_clay.toml", tmp_path / "scenario.toml")
    # A watch needs a soil to start from.
    rover = (examples / "paper/rover.toml").read_text()
    soils = 'hypotheses = "wong21"\n'
    assert soils in rover
    (tmp_path / "rover.toml").write_text(rover.replace(soils, soils + 'start = "lean_clay_22"\n'))
    return tmp_path


def plates(path):
    with open(path, "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["test", "plate_diameter_m", "sinkage_m", "pressure_Pa"])
        for diameter in (0.06, 0.1):
            for z in np.linspace(1e-3, 40e-3, 40):
                table.writerow([f"d{diameter}", diameter, z, (30e3 / (diameter / 2) + 1.2e6) * z**0.9])


def own_soil(path, page):
    path.write_text(blocks(page, "csv")[0])


def test_questions_and_answers(python, folder, examples):
    """Forces, a log, its forces, soil, gap, watch, exports, references, plates, design, reports."""
    plates(folder / "plates.csv")
    own_soil(folder / "own.csv", examples.parent / "book/src/wheel.md")
    # The outside simulator is the same one, on another draw.
    said = {"sim": terra.simulate("scenario.toml", seed=99)[0]}
    exec(python[0], said)
    assert said["forces"]["drawbar_pull_N"].shape == (19,) and said["forces"]["carried"].all()
    assert [g["map"] for g in said["soil"]["groups"]] == ["lean_clay_22"] * 2
    assert said["verdict"]["verdict"] and said["events"] and said["owed"] and said["design"]
    assert said["chrono"] and len(said["table"]["slip_compliance"]) == 2
    assert said["plates"]["soils"][0]["best"] == "bekker"
    for name in ("husky.toml", "gap.html", "figures"):
        assert (folder / name).exists()


def test_campaigns(python, folder, examples):
    """Fewer cases than a reader has time for; all else as it stands."""
    for name in ("slip_sinkage.toml", "rig.toml"):
        shutil.copy(examples / "rig" / name, folder / name)
    plan = (examples / "sweep/plan.toml").read_text()
    assert "runs = 20" in plan and "../rig/" in plan
    (folder / "plan.toml").write_text(plan.replace("runs = 20", "runs = 1").replace("../rig/", ""))
    text = python[1]
    for many, few in [("cases=50", "cases=1"), ('"rig", 20,', '"rig", 1,')]:
        assert many in text
        text = text.replace(many, few)
    sweep, rest = text.split("\n", 1)
    said = {"terra": terra}
    exec(sweep, said)
    # One shard is the whole.
    shutil.copy("all.jsonl", "1.jsonl")
    (folder / "2.jsonl").write_text("")
    exec(rest, said)
    assert len(said["runs"]) == 6
    assert said["marks"]["cases"] == 1 and said["answers"]


def test_an_effect_of_ones_own(python, folder):
    log, _ = terra.simulate("scenario.toml")
    said = {"terra": terra, "log": log}
    exec(python[2], said)
    assert "clogging" in str(said["verdict"])
    assert len(python) == 3
