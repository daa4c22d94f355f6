"""An idea of one's own about what the simulator lacks: is it what the log shows?

A wheel whose treads clog: thrust falls with slip squared. The rig's world has slip-sinkage instead, so the diagnosis
should prefer that.

    python own_effect.py
"""

from pathlib import Path

import terra

RIG = Path(__file__).resolve().parent.parent / "rig"


class Clogging:
    name = "clogging"
    summary = "treads clog as the wheel slips: pull falls with slip squared"
    parameters = [terra.Parameter("magnitude", unit="N", min=0.0, max=500.0, prior_sd=20.0)]

    def after(self, e, contact, forces):
        return {"drawbar_pull": forces["drawbar_pull"] - e["magnitude"] * contact.slip**2}


log, _ = terra.simulate(RIG / "slip_sinkage.toml")
verdict = terra.gap(
    log,
    RIG / "rig.toml",
    effects=["clogging", "slip-sinkage"],
    combine=1,
    registry=terra.Registry(effects=[Clogging()]),
)
print(f"verdict: {verdict['verdict']} {verdict['set']}")
for cause in verdict["causes"][:3]:
    print(f"{cause['effect']}: {cause['probability']:.2f}")
