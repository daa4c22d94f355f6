"""Both ways in give the same numbers, to the last bit."""

import csv
import io
import json
import subprocess
import sys

import numpy as np
import pytest

import terra


def columns(text):
    rows = list(csv.reader(io.StringIO(text)))
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}


def same(array, cells):
    expected = [float(c) if c else np.nan for c in cells]
    np.testing.assert_array_equal(array, expected)


@pytest.mark.parametrize("name", ["models", "effects", "terrains", "filters", "estimators"])
def test_lists(command, name):
    assert getattr(terra, name)() == json.loads(command(name, "--json"))


@pytest.mark.parametrize("model", ["wong-reece", "wong-reece+slip-sinkage=0.3"])
def test_wheel(command, model):
    said = columns(
        command("wheel", "--terrain", "dry_sand", "--radius_m", "0.254", "--width_m", "0.15",
                "--load_N", "245.25", "--slip", "-0.5:0.9:0.1", "--model", model)
    )  # fmt: skip
    slip = [float(s) for s in said["slip"]]
    found = terra.wheel_forces("dry_sand", slip, 245.25, radius=0.254, width=0.15, model=model)
    for name in ["drawbar_pull_N", "torque_N_m", "thrust_N", "motion_resistance_N", "sinkage_m",
                 "entry_angle_rad", "max_stress_angle_rad"]:  # fmt: skip
        same(found[name], said[name])
    assert [s == "ok" for s in said["status"]] == found["carried"].tolist()


def test_stresses(command, tmp_path):
    out = tmp_path / "w.csv"
    command("wheel", "--terrain", "dry_sand", "--radius_m", "0.254", "--width_m", "0.15", "--load_N",
            "245.25", "--slip", "0.3", "--stress", "--csv", out)  # fmt: skip
    said = columns((tmp_path / "w.stress.csv").read_text())
    found = terra.wheel_stresses("dry_sand", 0.3, 245.25, radius=0.254, width=0.15)
    for name, values in found.items():
        same(values, said[name])


def test_contributions(command):
    said = columns(
        command("wheel", "--terrain", "upland_sandy_loam", "--radius_m", "0.254", "--width_m", "0.15", "--load_N",
                "245.25", "--slip", "0.1:0.5:0.1", "--contributions", "--model",
                "wong-reece+grousers/passive-lug=0.01+bulldozing=1")
    )  # fmt: skip
    slip = [float(s) for s in said["slip"]]
    found = terra.wheel_forces("upland_sandy_loam", slip, 245.25, radius=0.254, width=0.15,
                               model="wong-reece+grousers/passive-lug=0.01+bulldozing=1")  # fmt: skip
    for name in ["rim_thrust_N", "lug_thrust_N", "compaction_resistance_N", "bulldozing_resistance_N", "other_force_N"]:
        same(found[name], said[name])


def test_wheel_tables(command, tmp_path):
    """All three tables of a wheel with lugs, and a load that is not carried."""
    out, model = tmp_path / "w.csv", "grouser-passive"
    values = {"unit_weight": 15000.0, "lug_height": 0.01, "lug_count": 24.0}
    given = [word for name, value in values.items() for word in ("--value", f"{name}={value}")]
    command("wheel", "--terrain", "upland_sandy_loam", "--radius_m", "0.254", "--width_m", "0.15", "--load_N", "245.25",
            "--slip", "0.1:0.5:0.2", "--model", model, *given, "--contributions", "--stress", "--lugs", "--csv", out)  # fmt: skip
    found = terra.wheel("upland_sandy_loam", [0.1, 0.3, 0.5], 245.25, radius=0.254, width=0.15, model=model,
                        values=values, contributions=True, stress=True, lugs=True)  # fmt: skip
    for name, file in [("forces", "w.csv"), ("stress", "w.stress.csv"), ("lugs", "w.lugs.csv")]:
        said = columns((tmp_path / file).read_text())
        assert list(found[name]) == list(said)
        for column, cells in said.items():
            if column == "status":
                assert found[name][column] == cells
            else:
                same(found[name][column], cells)
    heavy = terra.wheel("dry_sand", 0.2, 1e9, radius=0.254, width=0.15)
    assert list(heavy) == ["forces"] and heavy["forces"]["status"] == ["no-equilibrium"]
    assert np.isnan(heavy["forces"]["torque_N_m"]).all()
    with pytest.raises(terra.ConfigurationError, match="no lugs that push"):
        terra.wheel("dry_sand", 0.2, 245.25, radius=0.254, width=0.15, lugs=True)


@pytest.mark.parametrize("in_memory", [False, True])
def test_bevameter(command, tmp_path, in_memory):
    sinkage = np.linspace(0.001, 0.06, 60)
    log = {name: np.concatenate(parts) for name, parts in {
        "test": [np.repeat(["a"], 60), np.repeat(["b"], 60)],
        "plate_diameter_m": [np.full(60, 0.06), np.full(60, 0.1)],
        "sinkage_m": [sinkage, sinkage],
        "pressure_Pa": [(74.6e3 / b + 2080e3) * sinkage**1.1 for b in (0.03, 0.05)],
    }.items()}  # fmt: skip
    path = tmp_path / "plates.csv"
    rows = zip(*(values.tolist() for values in log.values()))
    path.write_text("\n".join([",".join(log), *(",".join(map(str, r)) for r in rows)]) + "\n")
    out = tmp_path / "out.json"
    command("bevameter", path, "--kind", "plate", "--json", out)
    said = json.loads(out.read_text())
    found = terra.bevameter(log if in_memory else path, "plate")
    assert found["soils"] == said["soils"]
    bekker = next(law for law in found["soils"][0]["laws"] if law["law"] == "bekker")
    assert abs(bekker["parameters"]["sinkage_exponent"]["value"] - 1.1) < 2e-3
    with pytest.raises(terra.ConfigurationError, match="plate or shear"):
        terra.bevameter(log, "cone")


def test_identifiability(command, tmp_path):
    out = tmp_path / "out.json"
    command("identifiability", "--terrain", "dry_sand", "--radius_m", "0.254", "--width_m", "0.15,0.1", "--load_N",
            "100,300", "--slip", "0.1:0.7:0.2", "--model", "compliant-tyre", "--value", "tyre_pressure=60000",
            "--add", "2", "--json", out)  # fmt: skip
    found = terra.identifiability("dry_sand", np.array([0.1, 0.3, 0.5, 0.7]), [100, 300], radius=0.254,
                                  width=[0.15, 0.1], model="compliant-tyre",
                                  values={"tyre_pressure": 60000}, add=2)  # fmt: skip
    assert found == json.loads(out.read_text())
    with pytest.raises(terra.ConfigurationError, match="drawbar_pull_N"):
        terra.identifiability("dry_sand", 0.1, 100, radius=0.254, width=0.15, noise={"drawbar_pul_N": 1})
    with pytest.raises(terra.ConfigurationError, match="no slips"):
        terra.identifiability("dry_sand", [], 100, radius=0.254, width=0.15)


def test_simulate(logs, examples):
    for scenario, file in [("paper/lean_clay.toml", "drive.csv"), ("rig/slip_sinkage.toml", "rig.csv")]:
        log, truth = terra.simulate(examples / scenario)
        said = columns((logs / file).read_text())
        assert list(log) == list(said)
        for name, values in log.items():
            if isinstance(values, list):
                assert values == said[name]
            else:
                same(values, said[name])
        assert len(truth["normal_load_N" if file == "rig.csv" else "time_s"]) == len(said["slip" if file == "rig.csv" else "time_s"])  # fmt: skip


def test_another_seed_is_another_draw(examples):
    scenario = examples / "rig/slip_sinkage.toml"
    one, two, again = (terra.simulate(scenario, seed=s)[0] for s in (1, 2, 1))
    assert not np.array_equal(one["drawbar_pull_N"], two["drawbar_pull_N"])
    np.testing.assert_array_equal(one["drawbar_pull_N"], again["drawbar_pull_N"])


@pytest.mark.parametrize("smooth", [False, True])
def test_estimate(command, logs, examples, smooth):
    rover = examples / "paper/rover.toml"
    said = columns(
        command("estimate", logs / "drive.csv", "--rover", rover, *(["--smooth"] if smooth else []))
    )
    found = terra.estimate(logs / "drive.csv", rover, smooth=smooth)
    assert list(found) == list(said)
    for name, values in found.items():
        if name in ("segment", "flag"):
            assert values == said[name]
        else:
            same(values, said[name])


@pytest.mark.parametrize(
    "log, rover", [("drive.csv", "paper/rover.toml"), ("rig.csv", "rig/rig.toml")]
)
def test_identify(command, logs, examples, tmp_path, log, rover):
    out = tmp_path / "identify.json"
    command("identify", logs / log, "--rover", examples / rover, "--json", out)
    assert terra.identify(logs / log, examples / rover) == json.loads(out.read_text())


def test_gap(command, logs, examples, tmp_path):
    out = tmp_path / "verdict.json"
    rover = examples / "rig/rig.toml"
    options = ["--effects", "slip-sinkage,grousers", "--combine", "1", "--hold-out", "slip"]
    command("gap", logs / "rig.csv", "--rover", rover, "--json", out, *options)
    found = terra.gap(
        logs / "rig.csv", rover, effects=["slip-sinkage", "grousers"], combine=1, hold_out="slip"
    )
    assert found == json.loads(out.read_text())
    assert found["schema"] == "terra-gap/1"


def test_gap_of_few_windows(command, tmp_path):
    """The ramps of a sealed case are long enough to be thinned."""
    made, out = tmp_path / "made", tmp_path / "verdict.json"
    terra.challenge.make("ramp", 1, seed=1, kinds={"none": 1}, out=made, key=tmp_path / "key.json")
    log, rover = made / "case_001.csv", made / "rover.toml"
    command("gap", log, "--rover", rover, "--effects", "torque-bias", "--combine", "1", "--windows", "16", "--json", out)
    asked = dict(effects=["torque-bias"], combine=1)
    found = terra.gap(log, rover, windows=16, **asked)
    assert found == json.loads(out.read_text()) != terra.gap(log, rover, **asked)
    for wrong, words in [({"windows": 15}, "from 16 to"), ({"same_bed": True}, "without sim")]:
        with pytest.raises(terra.ConfigurationError, match=words):
            terra.gap(log, rover, **asked, **wrong)


def test_gap_against_a_simulator(command, logs, examples, tmp_path):
    out, rover, sim = tmp_path / "verdict.json", examples / "rig/rig.toml", tmp_path / "sim.csv"
    scenario = (examples / "rig/slip_sinkage.toml").read_text()
    without = scenario[: scenario.index("[[effect]]")]
    (tmp_path / "sim.toml").write_text(without)
    (tmp_path / "rig.toml").write_bytes(rover.read_bytes())
    command("simulate", tmp_path / "sim.toml", "--out", sim)
    options = ["--effects", "slip-sinkage", "--combine", "1", "--same-bed"]
    command("gap", "--sim", sim, logs / "rig.csv", "--rover", rover, "--json", out, *options)
    found = terra.gap(logs / "rig.csv", rover, effects=["slip-sinkage"], combine=1, sim=sim, same_bed=True)
    assert found == json.loads(out.read_text())
    assert found["calibration"]["design"] == "contrast"


def test_gap_of_several_logs(command, logs, examples, tmp_path):
    """Two logs by name, in memory under names of their own, each with its own soil."""
    out, rover, second = tmp_path / "verdict.json", examples / "rig/rig.toml", tmp_path / "second.csv"
    second.write_bytes((logs / "rig.csv").read_bytes())
    options = ["--effects", "slip-sinkage", "--combine", "1", "--soil", "own"]
    command("gap", logs / "rig.csv", second, "--rover", rover, "--json", out, *options)
    asked = {"effects": ["slip-sinkage"], "combine": 1, "soil": "own"}
    found = terra.gap([logs / "rig.csv", second], rover, **asked)
    assert found == json.loads(out.read_text())
    assert found["logs"] == {"names": ["rig.csv", "second.csv"], "soil": "own"}


def test_scm_json(command, logs, examples, tmp_path):
    assert terra.scm_json("dry_sand") == json.loads(command("export", "scm-json", "dry_sand"))
    out = tmp_path / "identify.json"
    command("identify", logs / "rig.csv", "--rover", examples / "rig/rig.toml", "--json", out)
    said = json.loads(command("export", "scm-json", out))
    assert terra.scm_json(out) == said
    # What Python was told is as good as the file of the same.
    assert terra.scm_json(json.loads(out.read_text())) == said
    with pytest.raises(terra.ConfigurationError, match="all"):
        terra.scm_json(out, group="left")
    with pytest.raises(terra.ConfigurationError, match="dry_sand"):
        terra.scm_json("dry_snad")
    with pytest.raises(terra.BadData, match="terra-identify/1"):
        terra.scm_json({"schema": "terra-gap/1"})


def test_a_catalogue_of_ones_own(command, tmp_path):
    own = tmp_path / "own.csv"
    own.write_text(
        "id,set,name,n,kc_kN_m_n1,kphi_kN_m_n2,c_kPa,phi_deg,K_m,c1,c2\ndry_sand,mine,Ours,0.9,2,310,0.6,24,0.03,NA,NA\n"
    )
    found = terra.scm_json("dry_sand", catalogue=own)
    assert found == json.loads(command("export", "scm-json", "dry_sand", "--catalogue", own))
    assert found["Bekker n exponent"] == 0.9
    wheel = dict(radius=0.254, width=0.15, catalogue=own, values={"c1": 0.4, "c2": 0.2})
    said = columns(
        command("wheel", "--terrain", "dry_sand", "--catalogue", own, "--radius_m", "0.254", "--width_m", "0.15",
                "--load_N", "100", "--slip", "0.3", "--value", "c1=0.4", "--value", "c2=0.2")
    )  # fmt: skip
    forces = terra.wheel_forces("dry_sand", [0.3], 100, **wheel)
    same(forces["drawbar_pull_N"], said["drawbar_pull_N"])
    assert forces["drawbar_pull_N"] != terra.wheel_forces("dry_sand", [0.3], 100, radius=0.254, width=0.15)["drawbar_pull_N"]
    stresses = terra.wheel_stresses("dry_sand", 0.3, 100, **wheel)
    assert float(said["max_normal_stress_Pa"][0]) == pytest.approx(stresses["normal_stress_Pa"].max(), rel=1e-3)
    same(terra.wheel("dry_sand", 0.3, 100, **wheel)["forces"]["drawbar_pull_N"], said["drawbar_pull_N"])
    with pytest.raises(terra.ConfigurationError, match="c_1"):
        terra.wheel_forces("dry_sand", 0.3, 100, radius=0.254, width=0.15, values={"c_1": 0.4})
    with pytest.raises(terra.ConfigurationError, match="by its id"):
        terra.wheel_forces({"cohesion": 1.0}, 0.3, 100, radius=0.254, width=0.15, catalogue=own)


def test_import_scm_json(command, tmp_path):
    chrono, theirs, ours = (tmp_path / name for name in ("sand.json", "theirs.csv", "ours.csv"))
    chrono.write_text(command("export", "scm-json", "dry_sand"))
    command("import", "scm-json", chrono, "--out", theirs)
    soil = terra.import_scm_json(chrono, out=ours)
    assert ours.read_bytes() == theirs.read_bytes()
    known = next(t for t in terra.terrains() if t["id"] == "dry_sand")
    assert list(soil) == list(known) and soil["id"] == "sand"
    assert soil["k_phi"] == pytest.approx(known["k_phi"], rel=1e-12)
    assert terra.import_scm_json(chrono) == soil
    with pytest.raises(terra.ConfigurationError, match="would replace the input"):
        terra.import_scm_json(chrono, out=chrono)


@pytest.mark.parametrize("robot", ["husky", "jackal", "single-wheel-rig", "paper-robot"])
def test_init(command, tmp_path, robot):
    theirs, ours = tmp_path / "theirs.toml", tmp_path / "ours.toml"
    command("init", robot, "--out", theirs)
    assert terra.init(robot) == terra.init(robot, ours) == theirs.read_text()
    assert ours.read_bytes() == theirs.read_bytes()
    with pytest.raises(terra.TerraError, match="exists"):
        terra.init(robot, ours)
    assert terra.init(robot, ours, force=True) == theirs.read_text()
    with pytest.raises(terra.ConfigurationError, match="single-wheel-rig"):
        terra.init("huskey")


def test_what_only_the_simulator_has(command):
    lines = command("simulate", "--list").splitlines()[2:]
    listed = terra.scenario_effects()
    assert len(lines) == len(listed) > 5
    for line, effect in zip(lines, listed):
        assert line.startswith(effect["name"]) and effect["form"] in line and effect["summary"] in line
        assert 0 <= effect["min"] < effect["max"]


def test_slip_compliance(command):
    said = columns(
        command("export", "slip-compliance", "dry_sand", "--radius_m", "0.254", "--width_m", "0.15", "--load_N",
                "150,245.25,1e9", "--tolerance", "0.05", "--model", "compliant-tyre", "--value", "tyre_pressure=60000")
    )  # fmt: skip
    found = terra.slip_compliance("dry_sand", [150, 245.25, 1e9], radius=0.254, width=0.15, tolerance=0.05,
                                  model="compliant-tyre", values={"tyre_pressure": 60000})  # fmt: skip
    assert list(found) == list(said)
    for name, values in found.items():
        if name == "status":
            assert values == said[name] and "no-compliance" in values
        else:
            same(values, said[name])
    for bad in [{"tolerance": 1.5}, {"model": "wong-rece"}]:
        with pytest.raises(terra.ConfigurationError):
            terra.slip_compliance("dry_sand", 150, radius=0.254, width=0.15, **bad)
    with pytest.raises(terra.ConfigurationError, match="no loads"):
        terra.slip_compliance("dry_sand", [], radius=0.254, width=0.15)


def test_cite(command, examples):
    for file in ["rig/slip_sinkage.toml", "paper/rover.toml"]:
        said = json.loads(command("cite", examples / file, "--json"))
        assert terra.cite(examples / file) == said["references"]


def test_a_plan_of_hypotheses(command, logs, examples, tmp_path):
    plan, out, rover = tmp_path / "plan.toml", tmp_path / "identify.json", examples / "rig/rig.toml"
    plan.write_text('[[set]]\nhypotheses = "wong21"\n[[set]]\nname = "again"\nstart = "dry_sand"\n')
    command("identify", logs / "rig.csv", "--rover", rover, "--hypotheses", plan, "--json", out)
    found = terra.identify(logs / "rig.csv", rover, hypotheses=plan)
    assert found == json.loads(out.read_text())
    assert len(terra.hypotheses(rover)) == 21
    weighed = {h["id"]: h for h in terra.hypotheses(rover, plan)}
    assert len(weighed) == 22 and set(weighed) == {p["id"] for p in found["groups"][0]["posterior"]}
    again, soil = weighed["again"], next(t for t in terra.terrains() if t["id"] == "dry_sand")
    assert again["model"] == "wong-reece"
    assert again["parameters"]["cohesion"] == pytest.approx(soil["cohesion"], rel=1e-12)


def test_watch(command, logs, examples, tmp_path):
    out, track = tmp_path / "watch.json", tmp_path / "track.csv"
    rover = tmp_path / "rover.toml"
    text = (examples / "paper/rover.toml").read_text()
    assert "[terrain]\n" in text and "start =" not in text
    rover.write_text(text.replace("[terrain]\n", '[terrain]\nstart = "lean_clay_22"\n'))
    log = logs / "drive.csv"
    command("gap", log, "--rover", rover, "--watch", "--baseline", "0.8", "--json", out, "--track", track)
    found, windows = terra.watch(log, rover, baseline=0.8)
    assert found == json.loads(out.read_text())
    said = columns(track.read_text())
    assert list(windows) == list(said)
    for name, values in windows.items():
        if name == "segment":
            assert values == said[name]
        else:
            same(values, said[name])
    with pytest.raises(terra.ConfigurationError, match="rig log"):
        terra.watch(logs / "rig.csv", examples / "rig/rig.toml")


def test_inspect(command, logs, examples, tmp_path):
    out = tmp_path / "inspect.json"
    for log, rover in [("drive.csv", None), ("rig.csv", examples / "rig/rig.toml")]:
        command("inspect", logs / log, "--json", out, *(["--rover", rover] if rover else []))
        assert terra.inspect(logs / log, rover) == json.loads(out.read_text())


def test_the_command_comes_with_the_package():
    def run(*args):
        line = [sys.executable, "-c", "import sys, terra; sys.exit(terra._main())", *args]
        done = subprocess.run(line, capture_output=True, text=True)
        return done.returncode, done.stdout, done.stderr

    code, out, _ = run("models", "--json")
    assert code == 0 and json.loads(out) == terra.models()
    code, _, said = run("gap", "none.csv", "--rover", "none.toml")
    assert code == 2 and "no such file" in said
