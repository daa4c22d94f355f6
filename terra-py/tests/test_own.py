"""A model and an effect written in Python."""

import math

import numpy as np
import pytest

import terra


class Saturating:
    """T = W R mu (1 - exp(-s/kappa)), D = T/R - rho W."""

    name = "saturating"
    parameters = [
        terra.Parameter("traction", min=0.05, max=1.5, scale="log"),
        terra.Parameter("slip_scale", min=0.01, max=1.0, scale="log"),
        terra.Parameter("rolling_resistance", min=0.001, max=0.5, scale="log"),
    ]

    def wheel_forces(self, p, at):
        grip = math.copysign(-math.expm1(-abs(at.slip) / p["slip_scale"]), at.slip)
        thrust = at.normal_load * p["traction"] * grip
        resistance = at.normal_load * p["rolling_resistance"]
        return {
            "drawbar_pull": thrust - resistance,
            "resistive_torque": thrust * at.radius,
            "compaction_resistance": resistance,
        }


class Clogging:
    """Thrust falls by the share e s^2."""

    name = "clogging"
    parameters = [terra.Parameter("magnitude", min=0.0, max=1.0, prior_sd=0.2)]

    def after(self, e, at, forces):
        return {"drawbar_pull": forces["drawbar_pull"] * (1 - e["magnitude"] * at.slip**2)}


class DigsIn:
    """The built-in slip-sinkage, n + e |s|, said again."""

    name = "digs-in"
    like = next(e for e in terra.effects() if e["name"] == "slip-sinkage")["parameters"][0]
    parameters = [
        terra.Parameter("magnitude", min=like["min"], max=like["max"], scale=like["scale"], prior_sd=like["prior_sd"])
    ]  # fmt: skip
    needs = ["sinkage exponent"]

    def before(self, e, at):
        return {"sinkage_exponent": at.sinkage_exponent + e["magnitude"] * abs(at.slip)}


SOIL = {"traction": 0.6, "slip_scale": 0.15, "rolling_resistance": 0.08}
WHEEL = dict(radius=0.254, width=0.15)


def test_own_model_with_own_effect_by_hand():
    registry = terra.Registry(models=[Saturating()], effects=[Clogging()])
    slip, load, e = np.array([0.1, 0.3, 0.8]), 200.0, 0.4
    found = terra.wheel_forces(
        SOIL, slip, load, **WHEEL, model=f"saturating+clogging={e}", registry=registry
    )
    grip = 1 - np.exp(-slip / 0.15)
    pull = load * (0.6 * grip - 0.08)
    np.testing.assert_allclose(found["drawbar_pull_N"], pull * (1 - e * slip**2), rtol=1e-14)
    np.testing.assert_allclose(found["torque_N_m"], load * 0.6 * grip * 0.254, rtol=1e-14)
    assert np.isnan(found["sinkage_m"]).all()
    assert {"saturating"} < {m["name"] for m in terra.models(registry)}
    assert {"clogging"} < {m["name"] for m in terra.effects(registry)}


def test_an_effect_on_the_contact_is_the_built_in_one():
    registry = terra.Registry(effects=[DigsIn()])
    slip = np.linspace(0.05, 0.8, 6)
    own, built_in = (
        terra.wheel_forces("dry_sand", slip, 245.25, **WHEEL, model=f"wong-reece+{name}=0.3", registry=registry)
        for name in ("digs-in", "slip-sinkage")
    )  # fmt: skip
    np.testing.assert_allclose(own["drawbar_pull_N"], built_in["drawbar_pull_N"], rtol=1e-12)
    np.testing.assert_allclose(own["sinkage_m"], built_in["sinkage_m"], rtol=1e-12)


def test_a_diagnosis_names_an_effect_of_ones_own(examples):
    """A rig whose world has the effect, diagnosed with it among the candidates: derivatives included."""
    log, _ = terra.simulate(examples / "rig/slip_sinkage.toml")
    registry = terra.Registry(effects=[DigsIn()])
    options = dict(combine=1, hold_out="slip", registry=registry)
    own = terra.gap(log, examples / "rig/rig.toml", effects=["digs-in", "torque-bias"], **options)
    built_in = terra.gap(log, examples / "rig/rig.toml", effects=["slip-sinkage", "torque-bias"], **options)
    assert own["causes"][0]["effect"] == "digs-in"
    gain = [v["causes"][0]["log_evidence_gain"] for v in (own, built_in)]
    assert gain[0] == pytest.approx(gain[1], abs=0.05)
    size = [v["causes"][0]["parameters"]["magnitude"]["mean"] for v in (own, built_in)]
    assert size[0] == pytest.approx(size[1], rel=1e-3)


def test_an_effect_that_is_flat_at_zero_is_seen_where_it_says_so(examples):
    """n + e² |s| has no slope at zero: a screen by slopes sets it aside."""

    class BySquare(DigsIn):
        name = "digs-by-square"
        flat = True
        parameters = [terra.Parameter("magnitude", min=0.0, max=2.0, prior_sd=0.6)]

        def before(self, e, at):
            return {"sinkage_exponent": at.sinkage_exponent + e["magnitude"] ** 2 * abs(at.slip)}

    class Unsaid(BySquare):
        flat = False

    log, _ = terra.simulate(examples / "rig/slip_sinkage.toml")
    options = dict(effects=["digs-by-square", "torque-bias"], combine=1, hold_out="slip")

    def diagnosed(effect):
        return terra.gap(log, examples / "rig/rig.toml", registry=terra.Registry(effects=[effect]), **options)

    told = diagnosed(BySquare())
    linear = terra.gap(log, examples / "rig/rig.toml", effects=["slip-sinkage", "torque-bias"], combine=1)
    assert told["causes"][0]["effect"] == "digs-by-square"
    size, right = (v["causes"][0]["parameters"]["magnitude"]["mean"] for v in (told, linear))
    assert size**2 == pytest.approx(right, rel=0.1)
    unsaid = {a["effect"]: a["reason"] for a in diagnosed(Unsaid())["not_asked"]}
    assert "no trace" in unsaid["digs-by-square"]


def test_own_model_competes_from_its_typical_soil(examples):
    class Starting(Saturating):
        typical = {"traction": 0.5, "slip_scale": 0.1, "rolling_resistance": 0.05}

    log, _ = terra.simulate(examples / "rig/slip_sinkage.toml")
    options = dict(effects=["torque-bias"], combine=1, hold_out="slip")

    def weighed(model):
        verdict = terra.gap(log, examples / "rig/rig.toml", registry=terra.Registry(models=[model]), **options)
        return "structure:saturating" in verdict["evidence"]["names"]

    assert weighed(Starting())
    assert not weighed(Saturating())
    Starting.typical = {"tractionn": 0.5}
    with pytest.raises(terra.ConfigurationError, match="'tractionn' is no parameter"):
        terra.Registry(models=[Starting()])


def test_what_python_raises_comes_back():
    class Broken(Saturating):
        def wheel_forces(self, p, at):
            raise ZeroDivisionError("of my own")

    class Bog(Saturating):
        def wheel_forces(self, p, at):
            if at.normal_load > 100.0:
                raise terra.NoEquilibrium(at.normal_load, 100.0)
            return super().wheel_forces(p, at)

    class Misnamed(Saturating):
        def wheel_forces(self, p, at):
            return {"drawbar_pull": 1.0, "resistive_torque": 1.0, "sinkagge": 0.0}

    def forces(model, load=50.0):
        registry = terra.Registry(models=[model])
        return terra.wheel_forces(SOIL, 0.2, load, **WHEEL, model="saturating", registry=registry)

    with pytest.raises(ZeroDivisionError, match="of my own"):
        forces(Broken())
    with pytest.raises(KeyError, match="sinkagge"):
        forces(Misnamed())
    assert forces(Bog(), [50.0, 150.0])["carried"].tolist() == [True, False]


@pytest.mark.parametrize(
    "wrong",
    [
        type("NoName", (), {"parameters": [terra.Parameter("a")]}),
        type("NoParameters", (), {"name": "x", "parameters": []}),
        type("BadScale", (), {"name": "x", "parameters": [terra.Parameter("a", scale="ln")]}),
        type("NoMethod", (), {"name": "x", "parameters": [terra.Parameter("a")]}),
        type("BadHook", (), {"name": "x", "parameters": [terra.Parameter("a")], "needs": ["softness"], "after": 1}),
    ],
)  # fmt: skip
def test_an_object_that_is_no_effect_is_refused(wrong):
    with pytest.raises((AttributeError, terra.ConfigurationError)):
        terra.Registry(effects=[wrong()])
