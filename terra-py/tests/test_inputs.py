"""What may be handed in, and what is said of what may not."""

import tomllib

import numpy as np
import pytest

import terra


def test_arrays_are_broadcast():
    slip, load = np.array([[0.1], [0.4]]), np.array([150.0, 245.25, 300.0])
    found = terra.wheel_forces("dry_sand", slip, load, radius=0.254, width=0.15)
    assert found["drawbar_pull_N"].shape == (2, 3)
    one = terra.wheel_forces("dry_sand", 0.4, 300.0, radius=0.254, width=0.15)
    assert one["drawbar_pull_N"] == found["drawbar_pull_N"][1, 2]


def test_a_load_the_soil_cannot_carry_is_an_answer():
    found = terra.wheel_forces("dry_sand", 0.2, [245.25, 1e9], radius=0.254, width=0.15)
    assert found["carried"].tolist() == [True, False]
    assert np.isnan(found["torque_N_m"]).tolist() == [False, True]


def test_values_by_name_are_the_soil_of_that_id():
    soil = next(t for t in terra.terrains() if t["id"] == "dry_sand")
    model = next(m for m in terra.models() if m["name"] == "wong-reece")
    values = {p["name"]: soil[p["name"]] for p in model["parameters"]}
    wheel = dict(slip=[0.1, 0.5], normal_load=200.0, radius=0.254, width=0.15)
    by_id, by_value = (terra.wheel_forces(t, **wheel) for t in ("dry_sand", values))
    np.testing.assert_array_equal(by_id["drawbar_pull_N"], by_value["drawbar_pull_N"])
    del values["cohesion"]
    with pytest.raises(terra.ConfigurationError, match="cohesion"):
        terra.wheel_forces(values, **wheel)


def test_a_log_in_memory_is_the_file(logs, examples):
    rover = examples / "paper/rover.toml"
    log, _ = terra.simulate(examples / "paper/lean_clay.toml")
    tables = tomllib.loads(rover.read_text())
    found = terra.identify(log, tables)
    expected = terra.identify(logs / "drive.csv", rover)
    for answer in (found, expected):
        del answer["provenance"]
    assert found == expected


def test_missing_samples_are_counted_not_invented(examples):
    log, _ = terra.simulate(examples / "paper/lean_clay.toml")
    log["ground_speed_m_s"][50:53] = np.nan
    found = terra.identify(log, examples / "paper/rover.toml")
    assert found["samples"]["missing"] == 3


@pytest.mark.parametrize(
    "call, error, words",
    [
        (lambda e, l: terra.wheel_forces("dry_snad", 0.1, 1.0, radius=1, width=1), terra.ConfigurationError, "dry_sand"),
        (lambda e, l: terra.wheel_forces("dry_sand", 2.0, 1.0, radius=1, width=1), terra.ConfigurationError, "slip"),
        (lambda e, l: terra.identify(l / "none.csv", e / "paper/rover.toml"), terra.BadData, "no such file"),
        (lambda e, l: terra.identify({"time_s": [0.0]}, e / "paper/rover.toml"), terra.BadData, "neither log"),
        (lambda e, l: terra.identify({"a": [0.0], "b": [1.0, 2.0]}, e / "paper/rover.toml"), terra.ConfigurationError, "different lengths"),
        (lambda e, l: terra.estimate(l / "drive.csv", e / "paper/rover.toml", filter="ekff"), terra.ConfigurationError, "ekf"),
        (lambda e, l: terra.gap(l / "rig.csv", e / "rig/rig.toml", hold_out="trail"), terra.ConfigurationError, "trial"),
        (lambda e, l: terra.gap(l / "rig.csv", e / "rig/rig.toml", combine=3), terra.ConfigurationError, "1 or 2"),
    ],
)  # fmt: skip
def test_errors_say_what_to_do(examples, logs, call, error, words):
    with pytest.raises(error, match=words):
        call(examples, logs)
