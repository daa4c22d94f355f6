"""One drive in every format: the same result as from its CSV, to rounding."""

from pathlib import Path

import numpy as np
import pytest

import terra

FILES = Path(__file__).resolve().parents[2] / "terra-data/tests/readers/files"


@pytest.mark.parametrize(
    "kind, name", [("mcap", "drive.mcap"), ("mcap", "drive_zstd.mcap"), ("parquet", "drive.parquet"), ("mat", "drive.mat")]
)  # fmt: skip
def test_same_result_as_the_csv(examples, kind, name):
    rover = examples / "paper/rover.toml"
    try:
        log, notes = terra.import_log(kind, FILES / name, map=FILES / "topics.toml" if kind == "mcap" else None)
    except terra.TerraError as e:
        if "--features" in str(e):
            pytest.skip(f"this build has no reader of {kind}")
        raise
    assert all(isinstance(n, str) for n in notes)
    found, expected = (terra.estimate(x, rover) for x in (log, FILES / "drive.csv"))
    assert found["flag"] == expected["flag"] and found["segment"] == expected["segment"]
    for column, values in expected.items():
        if not isinstance(values, list):
            np.testing.assert_allclose(found[column], values, rtol=1e-9, atol=1e-9)
    soil, known = (terra.identify(x, rover, refine=False)["groups"] for x in (log, FILES / "drive.csv"))
    for a, b in zip(soil, known):
        assert a["map"] == b["map"]
        assert a["posterior"][0]["probability"] == pytest.approx(b["posterior"][0]["probability"], rel=1e-6)


def test_a_kind_that_is_none():
    with pytest.raises(terra.ConfigurationError, match="norlab-drive"):
        terra.import_log("rosbag", FILES / "drive.mcap")
    with pytest.raises(terra.ConfigurationError, match="--map|--features"):
        terra.import_log("mcap", FILES / "drive.mcap")
