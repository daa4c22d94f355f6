"""Reports and their figures: the same bytes as the command's."""

import json

import numpy as np
import pytest

import terra


class Twice:
    """Runs a command and a function with a report each, and compares what was written."""

    def __init__(self, command, folder):
        self.command, self.folder = command, folder

    def __call__(self, args, function, *given, **options):
        places = {who: (self.folder / f"{who}.html", self.folder / who) for who in ("theirs", "ours")}
        html, figures = places["theirs"]
        out = self.command(*args, "--html", html, "--figures", figures)
        html, figures = places["ours"]
        found = function(*given, **options, html=html, figures=figures)
        pages = [page.read_bytes() for page, _ in places.values()]
        assert pages[0] == pages[1] and b"<svg" in pages[0]
        theirs, ours = ({p.name: p.read_bytes() for p in f.iterdir()} for _, f in places.values())
        assert theirs == ours and any(name.endswith(".csv") for name in ours)
        return out, found


@pytest.fixture
def twice(command, tmp_path):
    return Twice(command, tmp_path)


def test_wheel(twice):
    args = ["wheel", "--terrain", "dry_sand", "--radius_m", "0.254", "--width_m", "0.15", "--load_N", "245.25",
            "--slip", "0.1:0.5:0.2", "--value", "c1=0.5"]  # fmt: skip
    twice(args, terra.wheel, "dry_sand", [0.1, 0.3, 0.5], 245.25, radius=0.254, width=0.15, values={"c1": 0.5})


def test_bevameter(twice, tmp_path):
    log = tmp_path / "plates.csv"
    rows = [f"{d},{d},{z},{(74.6e3 / (d / 2) + 2080e3) * z**1.1}" for d in (0.06, 0.1) for z in np.linspace(0.001, 0.06, 30)]
    log.write_text("\n".join(["test,plate_diameter_m,sinkage_m,pressure_Pa", *rows]) + "\n")
    twice(["bevameter", log, "--kind", "plate"], terra.bevameter, log, "plate")
    with pytest.raises(terra.ConfigurationError, match="would replace the input"):
        terra.bevameter(log, "plate", html=log)


def test_identifiability(twice):
    args = ["identifiability", "--terrain", "dry_sand", "--radius_m", "0.254", "--width_m", "0.15", "--load_N", "100",
            "--slip", "0.1:0.7:0.2", "--add", "1"]  # fmt: skip
    given = dict(radius=0.254, width=0.15, add=1)
    twice(args, terra.identifiability, "dry_sand", [0.1, 0.3, 0.5, 0.7], 100, **given)
    with pytest.raises(terra.ConfigurationError, match="from 0 to 50"):
        terra.identifiability("dry_sand", 0.1, 100, radius=0.254, width=0.15, add=51)


def test_estimate(twice, logs, examples):
    log, rover = logs / "drive.csv", examples / "paper/rover.toml"
    twice(["estimate", log, "--rover", rover], terra.estimate, log, rover)


def test_identify(twice, logs, examples, tmp_path):
    """With a report and without, the answer is the same: the posterior over time is kept for the figures alone."""
    log, rover, out = logs / "drive.csv", examples / "paper/rover.toml", tmp_path / "identify.json"
    args = ["identify", log, "--rover", rover, "--rows", "20-120", "--no-refine", "--json", out]
    asked = dict(rows=(20, 120), refine=False)
    _, found = twice(args, terra.identify, log, rover, **asked)
    assert found == json.loads(out.read_text()) == terra.identify(log, rover, **asked)
    assert found["samples"]["rows"] == 101
    with pytest.raises(terra.ConfigurationError, match="rows"):
        terra.identify(log, rover, rows=(5, 4))
    with pytest.raises(terra.ConfigurationError, match="rig log"):
        terra.identify(logs / "rig.csv", examples / "rig/rig.toml", rows=(1, 2))


def test_gap(twice, logs, examples):
    log, rover = logs / "rig.csv", examples / "rig/rig.toml"
    args = ["gap", log, "--rover", rover, "--effects", "slip-sinkage", "--combine", "1"]
    twice(args, terra.gap, log, rover, effects=["slip-sinkage"], combine=1)


def test_demo(command, tmp_path):
    """The whole folder, and what the two JSON files hold."""
    places = [tmp_path / who for who in ("theirs", "ours")]
    command("demo", "--out", places[0], "--figures", tmp_path / "their figures")
    found = terra.demo(places[1], figures=tmp_path / "our figures")
    for one, other in [places, (tmp_path / "their figures", tmp_path / "our figures")]:
        names = sorted(p.name for p in one.iterdir())
        assert names and names == sorted(p.name for p in other.iterdir())
        assert all((one / n).read_bytes() == (other / n).read_bytes() for n in names)
    for name in ("identify", "verdict"):
        assert found[name] == json.loads((places[1] / f"{name}.json").read_text())
