"""The native half of the package; use the functions of ``terra``."""

import os
from typing import Any, Sequence

import numpy as np
from numpy.typing import NDArray

__version__: str

_Source = str | os.PathLike[str] | tuple[str, bytes]
_Soil = str | dict[str, float]
_Exported = str | tuple[str, str]
_Path = str | os.PathLike[str]
_Pairs = list[tuple[str, float]]

class TerraError(ValueError):
    """Whatever terra refuses; the message says what was found, what was expected, and what to do."""

class ConfigurationError(TerraError):
    """A wrong argument, rover file or scenario (the command would exit with status 2)."""

class BadData(TerraError):
    """A log that cannot be used (the command would exit with status 3)."""

class NoEquilibrium(TerraError):
    """Raised by a model of one's own, as ``NoEquilibrium(load, max_load)``: the soil cannot carry the wheel."""

class Contact:
    """One wheel's contact as a model or an effect of one's own sees it; SI and radians."""

    slip: float
    normal_load: float
    radius: float
    width: float
    speed: float
    wheel_speed: float
    slip_angle: float
    yaw_rate: float
    path: float
    earlier_passes: float
    side: float
    ahead: float
    wheelbase: float
    time: float
    stiffness: float
    cohesion: float
    friction: float
    shear_modulus: float
    sinkage_exponent: float
    contact_radius: float
    exit_ratio: float
    shear_hump: float
    lug_height: float
    layer_depth: float
    layer_stiffness: float

class Registry:
    """Models and effects by name: the built-in ones and one's own.

    A model is an object with ``name``, ``parameters`` (a list of ``terra.Parameter``) and
    ``wheel_forces(p, contact)``, which returns a dict with ``drawbar_pull`` and ``resistive_torque`` and may add
    ``sinkage``, ``lateral_force``, ``thrust``, ``compaction_resistance``. An effect has ``name``, ``parameters`` and
    ``before(e, contact)`` or ``after(e, contact, forces)``, which return a dict of what they change. ``p`` and ``e``
    are dicts by parameter name. Both may have ``summary``, ``reference``; a model ``hooks``, an effect ``needs``,
    ``scope``, ``regime``, ``isolated_by``, ``flat`` (True where a small magnitude does next to nothing, as where
    only its square acts).
    """

    def __init__(self, models: Sequence[Any] = ..., effects: Sequence[Any] = ...) -> None: ...

def wheel_forces(
    terrain: _Soil,
    slip: NDArray[np.float64],
    normal_load: NDArray[np.float64],
    radius: NDArray[np.float64],
    width: NDArray[np.float64],
    model: str = ...,
    registry: Registry | None = ...,
    catalogue: _Path | None = ...,
    values: _Pairs = ...,
) -> dict[str, Any]: ...
def wheel_stresses(
    terrain: _Soil,
    slip: float,
    normal_load: float,
    radius: float,
    width: float,
    model: str = ...,
    points: int = ...,
    catalogue: _Path | None = ...,
    values: _Pairs = ...,
) -> dict[str, NDArray[np.float64]]: ...
def wheel(
    terrain: str,
    slips: list[float],
    load: float,
    radius: float,
    width: float,
    model: str,
    values: _Pairs,
    catalogue: _Path | None,
    contributions: bool,
    stress: bool,
    lugs: bool,
    html: _Path | None = ...,
    figures: _Path | None = ...,
) -> dict[str, dict[str, Any]]: ...
def models(registry: Registry | None = ...) -> list[dict[str, Any]]: ...
def effects(registry: Registry | None = ...) -> list[dict[str, Any]]: ...
def terrains() -> list[dict[str, Any]]: ...
def filters() -> list[dict[str, Any]]: ...
def estimators() -> list[dict[str, Any]]: ...
def scenario_effects() -> list[dict[str, Any]]: ...
def init(robot: str, out: _Path | None = ..., force: bool = ...) -> str: ...
def demo(out: _Path, figures: _Path | None = ...) -> tuple[dict[str, Any], dict[str, Any]]: ...
def sweep(plan: _Path, out: _Path, shard: str | None = ...) -> tuple[int, int]: ...
def merge(files: list[_Path]) -> list[dict[str, Any]]: ...
def merge_into(files: list[_Path], out: _Path) -> None: ...
def campaign_ramps(runs: int, seed: int, terrains: list[str]) -> dict[str, Any]: ...
def campaign_faults(runs: int, seed: int, filter: str) -> dict[str, Any]: ...
def campaign_reproduction(runs: int, seed: int, tables: list[str]) -> dict[str, Any]: ...
def campaign_gap(
    out: _Path, designs: list[str], cases: int, seed: int, left_out: bool
) -> dict[str, Any]: ...
def campaign_gap_calibration(out: _Path, designs: list[str], cases: int, seed: int, nulls: int) -> str: ...
def campaign_cross_structure(out: _Path, design: str, cases: int, seed: int) -> dict[str, Any]: ...
def challenge_make(
    design: str, cases: int, seed: int, out: _Path, key: _Path, kinds: _Pairs | None = ...
) -> dict[str, Any]: ...
def challenge_run(folder: _Path, out: _Path) -> dict[str, Any]: ...
def challenge_score(verdicts: _Path, key: _Path, closing: bool) -> dict[str, Any]: ...
def challenge_reveal(key: _Path, folder: _Path) -> list[dict[str, Any]]: ...
def command(args: Sequence[str]) -> int: ...
def inspect(log: _Source, rover: _Source | None = ...) -> dict[str, Any]: ...
def bevameter(
    log: _Source,
    kind: str,
    columns: _Path | None = ...,
    html: _Path | None = ...,
    figures: _Path | None = ...,
) -> dict[str, Any]: ...
def identifiability(
    terrain: str,
    slips: list[float],
    loads: list[float],
    widths: list[float],
    radius: float,
    model: str,
    noise: list[tuple[str, float]],
    values: list[tuple[str, float]],
    set: str,
    catalogue: str | os.PathLike[str] | None,
    add: int,
    html: _Path | None = ...,
    figures: _Path | None = ...,
) -> dict[str, Any]: ...
def import_log(
    kind: str, source: str | os.PathLike[str], map: str | os.PathLike[str] | None = ...
) -> tuple[dict[str, Any], list[str]]: ...
def import_scm_json(source: _Path, out: _Path | None = ...) -> dict[str, Any]: ...
def simulate(
    scenario: str | os.PathLike[str], seed: int | None = ..., registry: Registry | None = ...
) -> tuple[dict[str, Any], dict[str, Any]]: ...
def estimate(
    log: _Source,
    rover: _Source,
    filter: str = ...,
    smooth: bool = ...,
    html: _Path | None = ...,
    figures: _Path | None = ...,
) -> dict[str, Any]: ...
def identify(
    log: _Source,
    rover: _Source,
    hypotheses: str | None = ...,
    estimator: str | None = ...,
    choice: str = ...,
    join: bool = ...,
    history: bool = ...,
    refine: bool = ...,
    filter: str = ...,
    rows: tuple[int, int] | None = ...,
    registry: Registry | None = ...,
    html: _Path | None = ...,
    figures: _Path | None = ...,
) -> dict[str, Any]: ...
def gap(
    logs: list[_Source],
    rover: _Source,
    effects: list[str] | None = ...,
    hold_out: str | None = ...,
    combine: int = ...,
    windows: int = ...,
    calibrate: int = ...,
    seed: int = ...,
    soil: str = ...,
    sim: _Source | None = ...,
    same_bed: bool = ...,
    motion_only: bool = ...,
    registry: Registry | None = ...,
    html: _Path | None = ...,
    figures: _Path | None = ...,
) -> dict[str, Any]: ...
def watch(
    log: _Source,
    rover: _Source,
    baseline: str,
    false_alarms: float,
    effects: list[str] | None,
    registry: Registry | None = ...,
) -> tuple[dict[str, Any], dict[str, Any]]: ...
def scm_json(
    soil: _Exported,
    catalogue: str | os.PathLike[str] | None = ...,
    group: str | None = ...,
) -> dict[str, Any]: ...
def slip_compliance(
    soil: _Exported,
    loads: list[float],
    radius: float,
    width: float,
    model: str,
    values: list[tuple[str, float]],
    tolerance: float,
    catalogue: str | os.PathLike[str] | None,
    group: str | None,
) -> dict[str, Any]: ...
def hypotheses(
    rover: _Source, named: str | None = ..., registry: Registry | None = ...
) -> list[dict[str, Any]]: ...
def cite(file: str | os.PathLike[str]) -> dict[str, Any]: ...
