"""What forces does the ground give each wheel, what soil is it, and which unmodelled effect makes the simulator differ
from reality?

All that the command ``terra`` does, with numpy in and out and the same numbers; the command itself comes with the
package. Campaigns are in ``terra.campaign``, blind challenges in ``terra.challenge``. SI units and radians throughout;
column and key names carry their unit. Long work releases the interpreter's lock and answers Ctrl-C.

>>> import numpy as np, terra
>>> forces = terra.wheel_forces("dry_sand", np.linspace(0.1, 0.9, 9), 245.25, radius=0.254, width=0.15)
>>> bool(forces["drawbar_pull_N"].max() > 0)
True
"""

from __future__ import annotations

import csv
import io
import json
import os
import sys
from dataclasses import dataclass
from typing import Any, Mapping, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _terra, campaign, challenge
from ._terra import (
    BadData,
    ConfigurationError,
    Contact,
    NoEquilibrium,
    Registry,
    TerraError,
    __version__,
)

__all__ = [
    "BadData",
    "ConfigurationError",
    "Contact",
    "NoEquilibrium",
    "Parameter",
    "Registry",
    "TerraError",
    "__version__",
    "bevameter",
    "campaign",
    "challenge",
    "cite",
    "demo",
    "effects",
    "estimate",
    "estimators",
    "filters",
    "gap",
    "hypotheses",
    "identifiability",
    "identify",
    "import_log",
    "import_scm_json",
    "init",
    "inspect",
    "merge",
    "models",
    "scenario_effects",
    "scm_json",
    "simulate",
    "slip_compliance",
    "sweep",
    "terrains",
    "watch",
    "wheel",
    "wheel_forces",
    "wheel_stresses",
]

#: A log: the path of a CSV file, or its columns (a dict of arrays, a pandas or polars frame).
Log = Union[str, "os.PathLike[str]", Mapping[str, Any]]
#: A rover or rig file: its path, or its tables as nested dicts.
Rover = Union[str, "os.PathLike[str]", Mapping[str, Any]]
#: A soil: an id of the catalogue, or values by the model's parameter names (SI, rad).
Terrain = Union[str, Mapping[str, float]]
#: A path.
Path = Union[str, "os.PathLike[str]"]
#: A soil to export: an id, the path of what ``terra identify --json`` wrote, or what ``identify`` returned.
Exported = Union[str, "os.PathLike[str]", Mapping[str, Any]]


@dataclass(frozen=True)
class Parameter:
    """One number of a model or an effect of one's own.

    ``scale`` is ``"log"`` for a positive number that is fitted by its logarithm, ``prior_sd`` the standard deviation
    of ln(value) on that scale and of the value on the linear one.
    """

    name: str
    unit: str = "1"
    min: float = 0.0
    max: float = float("inf")
    scale: str = "linear"
    prior_sd: float = 0.3
    symbol: str = ""
    doc: str = ""


def wheel_forces(
    terrain: Terrain,
    slip: ArrayLike,
    normal_load: ArrayLike,
    *,
    radius: ArrayLike,
    width: ArrayLike,
    model: str = "wong-reece",
    registry: Registry | None = None,
    catalogue: Path | None = None,
    values: Mapping[str, float] | None = None,
) -> dict[str, NDArray[Any]]:
    """Forces of the ground on one wheel, for any number of contacts at once.

    Args:
        terrain: id of a soil (``terrains()``), or parameter values by name.
        slip: library slip in [-1, 1]: 1 - v/(R w) driving, R w/v - 1 braking.
        normal_load: N.
        radius: wheel radius in m.
        width: wheel width in m.
        model: ``"wong-reece"``, or with effects ``"wong-reece+slip-sinkage=0.3"``.
        registry: where models and effects are looked up.
        catalogue: a file with soils of one's own (CSV); an id that is in both is that of the file.
        values: parameters (SI, rad) in place of the soil's own, or that it does not give.

    Slip, load, radius and width are broadcast against each other.

    Returns:
        Arrays of that shape: ``drawbar_pull_N``, ``torque_N_m``, ``thrust_N`` (of it ``rim_thrust_N`` and
        ``lug_thrust_N``), ``motion_resistance_N`` (of it ``compaction_resistance_N`` and
        ``bulldozing_resistance_N``), ``other_force_N`` that an effect adds under no other name, ``lateral_force_N``,
        ``sinkage_m``, ``entry_angle_rad``, ``max_stress_angle_rad``, and ``carried``: False (and NaN elsewhere) where the
        soil cannot carry the load.

    Raises:
        ConfigurationError: an unknown name, a number out of range.
    """
    arrays = np.broadcast_arrays(
        *(np.asarray(a, dtype=np.float64) for a in (slip, normal_load, radius, width))
    )
    shape = arrays[0].shape
    s, w, r, b = (np.ascontiguousarray(a).reshape(-1) for a in arrays)
    out = _terra.wheel_forces(
        _terrain(terrain), s, w, r, b, model, registry, catalogue, _pairs(values or {})
    )
    return {name: np.asarray(values).reshape(shape) for name, values in out.items()}


def wheel_stresses(
    terrain: Terrain,
    slip: float,
    normal_load: float,
    *,
    radius: float,
    width: float,
    model: str = "wong-reece",
    points: int = 101,
    catalogue: Path | None = None,
    values: Mapping[str, float] | None = None,
) -> dict[str, NDArray[np.float64]]:
    """Stresses along the contact from exit to entry: ``angle_rad``, ``normal_stress_Pa``, ``shear_stress_Pa``, of
    ``points`` values each. Arguments as those of ``wheel_forces``.

    Raises:
        ConfigurationError: an unknown name, a number out of range, a model that knows forces alone.
    """
    return _terra.wheel_stresses(
        _terrain(terrain), slip, normal_load, radius, width, model, points, catalogue, _pairs(values or {})
    )


def wheel(
    terrain: str,
    slip: ArrayLike,
    normal_load: float,
    *,
    radius: float,
    width: float,
    model: str = "wong-reece",
    values: Mapping[str, float] | None = None,
    catalogue: Path | None = None,
    contributions: bool = False,
    stress: bool = False,
    lugs: bool = False,
    html: Path | None = None,
    figures: Path | None = None,
) -> dict[str, dict[str, Any]]:
    """The force-slip curve of one wheel under one load: the tables and the report of ``terra wheel``.

    ``wheel_forces`` gives any number of loads and wheels at once.

    Args:
        terrain: id of a soil, of ``terrains()`` or of ``catalogue``.
        slip: library slips in [-1, 1], n of them.
        normal_load: N.
        radius: m.
        width: m.
        model: as for ``wheel_forces``.
        values: parameters (SI, rad) in place of the soil's own, or that it does not give.
        catalogue: a file with soils of one's own (CSV); an id that is in both is that of the file.
        contributions: also the parts of the drawbar pull.
        stress: also the stresses along the contact.
        lugs: also what the lugs push during the passage of one.
        html: a report to write (HTML, one file).
        figures: a folder for each figure of that report (SVG) and its numbers (CSV).

    Returns:
        Tables by name, columns as the command writes them: ``forces`` (n rows; NaN where ``status`` says that the soil
        cannot carry the load), and where asked for ``stress`` (a row a slip and an angle) and ``lugs`` (a row a slip and a
        moment of the passage).

    Raises:
        ConfigurationError: an unknown name, a number out of range, stresses or lugs of a model without.
    """
    slips = np.atleast_1d(np.asarray(slip, dtype=np.float64)).tolist()
    return _terra.wheel(
        terrain,
        slips,
        float(normal_load),
        float(radius),
        float(width),
        model,
        _pairs(values or {}),
        catalogue,
        contributions,
        stress,
        lugs,
        html,
        figures,
    )


def models(registry: Registry | None = None) -> list[dict[str, Any]]:
    """The terrain models, as ``terra models --json``."""
    return _terra.models(registry)


def effects(registry: Registry | None = None) -> list[dict[str, Any]]:
    """The effects a diagnosis can name, as ``terra effects --json``."""
    return _terra.effects(registry)


def terrains() -> list[dict[str, Any]]:
    """The soils of the literature with their sources, as ``terra terrains --json``."""
    return _terra.terrains()


def filters() -> list[dict[str, Any]]:
    """The filters that estimate wheel forces, as ``terra filters --json``."""
    return _terra.filters()


def estimators() -> list[dict[str, Any]]:
    """The estimators that weigh soils, as ``terra estimators --json``."""
    return _terra.estimators()


def scenario_effects() -> list[dict[str, Any]]:
    """The effects and forms that only the simulator has, as ``terra simulate --list``: ``name``, ``form``, ``min`` and
    ``max`` of the magnitudes worth drawing with their ``unit``, ``summary`` and ``reference``."""
    return _terra.scenario_effects()


def init(robot: str, out: Path | None = None, *, force: bool = False) -> str:
    """A commented rover file to start from, as ``terra init`` writes it: published figures, guesses marked.

    Args:
        robot: ``"husky"``, ``"jackal"``, ``"single-wheel-rig"`` or ``"paper-robot"``.
        out: a file to write it to (TOML); the command's own is ``rover.toml``, here none is written when absent.
        force: overwrite that file.

    Returns:
        The text of the file.

    Raises:
        ConfigurationError: an unknown robot.
        TerraError: the file exists, or cannot be written.
    """
    return _terra.init(robot, out, force)


def demo(out: Path = "terra-demo", *, figures: Path | None = None) -> dict[str, dict[str, Any]]:
    """The main job end to end on input of its own: ``report.html``, ``identify.json`` and ``verdict.json`` in a folder.

    Args:
        out: the folder.
        figures: a folder for each figure of the report (SVG) and its numbers (CSV).

    Returns:
        ``identify`` and ``verdict``: what the two JSON files hold.
    """
    identified, verdict = _terra.demo(out, figures)
    return {"identify": identified, "verdict": verdict}


def sweep(plan: Path, out: Path, *, shard: tuple[int, int] | None = None) -> tuple[int, int]:
    """A grid of runs, as ``terra sweep``: JSON lines in a file, the same bytes on any number of threads.

    What is in the file already is kept, so that the call that was stopped is simply made again. Ctrl-C ends the sweep
    after the runs at hand.

    Args:
        plan: what is run, over which grid (TOML).
        out: the file.
        shard: ``(i, n)`` for runs i, i + n, ... alone, i from 1; see ``merge``.

    Returns:
        Runs of the plan or the shard, and how many of them were left to do.

    Raises:
        ConfigurationError: a plan, scenario or rover file with a mistake.
        BadData: a file of another plan.
    """
    return _terra.sweep(plan, out, None if shard is None else f"{shard[0]}/{shard[1]}")


def merge(files: Sequence[Path], out: Path | None = None) -> list[dict[str, Any]] | None:
    """Joins the shards of a sweep, as ``terra merge``.

    Args:
        files: the shards, in any order.
        out: a file for the bytes of an unsharded run.

    Returns:
        The runs in order (``run``, ``seed``, ``vary``, ``result``); none when they go to a file.

    Raises:
        BadData: a shard that is not finished, a run that is there twice or not at all.
    """
    if out is not None:
        _terra.merge_into(list(files), out)
        return None
    return _terra.merge(list(files))


def simulate(
    scenario: str | os.PathLike[str],
    *,
    seed: int | None = None,
    registry: Registry | None = None,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Runs a scenario file; the log a user would have, and the truth behind it.

    Both are columns: float64 arrays with NaN for a missing sample, lists for text. ``pandas.DataFrame(log)`` and
    ``polars.DataFrame(log)`` take them, and so do ``estimate``, ``identify`` and ``gap``. Same seed, same numbers.
    """
    return _terra.simulate(scenario, seed, registry)


def inspect(log: Log, rover: Rover | None = None) -> dict[str, Any]:
    """What is in a log, and what in it looks wrong: the content of ``terra inspect --json``."""
    return _terra.inspect(_log(log), None if rover is None else _rover(rover))


def bevameter(
    log: Log,
    kind: str,
    *,
    columns: Path | None = None,
    html: Path | None = None,
    figures: Path | None = None,
) -> dict[str, Any]:
    """Soil from plates pressed into the ground or from shear tests: the content of ``terra bevameter --json``.

    Args:
        log: a path or columns: ``test``, ``plate_diameter_m``, ``sinkage_m``, ``pressure_Pa``, or ``test``,
            ``normal_stress_Pa``, ``shear_displacement_m``, ``shear_stress_Pa``; ``soil`` keeps soils apart.
        kind: ``"plate"`` or ``"shear"``.
        columns: a file with other names and units (TOML).
        html: a report to write (HTML, one file).
        figures: a folder for each figure of that report (SVG) and its numbers (CSV).
    """
    return _terra.bevameter(_log(log), kind, columns, html, figures)


def identifiability(
    terrain: str,
    slip: ArrayLike,
    normal_load: ArrayLike,
    *,
    radius: float,
    width: ArrayLike,
    model: str = "wong-reece",
    noise: Mapping[str, float] | None = None,
    values: Mapping[str, float] | None = None,
    set: str = "wong21",
    catalogue: str | os.PathLike[str] | None = None,
    add: int = 3,
    html: Path | None = None,
    figures: Path | None = None,
) -> dict[str, Any]:
    """What could rows at these slips and loads tell about a soil? The content of ``terra identifiability --json``.

    Args:
        terrain: id of the soil around which to ask.
        slip: library slips; every one is measured under every load with every wheel.
        normal_load: N.
        radius: m.
        width: m, one or several.
        model: ``"wong-reece"``, or with effects whose sizes are asked for too.
        noise: measured channels with their sd; ``{"drawbar_pull_N": 0.5, "torque_N_m": 0.1}`` when absent.
        values: parameters in place of the soils' own, or that no soil gives.
        set: soils that should be told apart: a set of the catalogue, or a file of soils.
        catalogue: a file with soils of one's own (CSV).
        add: further rows to propose, 0 to 50.
        html: a report to write (HTML, one file).
        figures: a folder for each figure of that report (SVG) and its numbers (CSV).
    """
    if noise is None:
        noise = {"drawbar_pull_N": 0.5, "torque_N_m": 0.1}
    return _terra.identifiability(
        terrain,
        *(np.atleast_1d(np.asarray(a, dtype=np.float64)).tolist() for a in (slip, normal_load, width)),
        float(radius),
        model,
        _pairs(noise),
        _pairs(values or {}),
        set,
        catalogue,
        add,
        html,
        figures,
    )


def _pairs(values: Mapping[str, float]) -> list[tuple[str, float]]:
    return [(str(name), float(value)) for name, value in values.items()]


def import_log(
    kind: str, source: str | os.PathLike[str], *, map: str | os.PathLike[str] | None = None
) -> tuple[dict[str, Any], list[str]]:
    """A known data set or format as the columns of a log, with notes on what its user should know.

    Args:
        kind: as in ``terra import``: ``mcap``, ``parquet``, ``mat``, ``norlab-drive`` ...
        source: the file.
        map: topic map of a bag (TOML).
    """
    return _terra.import_log(kind, source, map)


def import_scm_json(source: Path, *, out: Path | None = None) -> dict[str, Any]:
    """The soil of a JSON file of Chrono's soil contact model, as ``terra import scm-json``.

    Args:
        source: the file; its name becomes the soil's id.
        out: a catalogue to write (CSV), which ``catalogue=`` and ``hypotheses=`` take.

    Returns:
        The soil, with the keys of ``terrains()``.

    Raises:
        ConfigurationError: no JSON, a key missing, a value that is none of a soil.
    """
    return _terra.import_scm_json(source, out)


def estimate(
    log: Log,
    rover: Rover,
    *,
    filter: str = "block",
    smooth: bool = False,
    html: Path | None = None,
    figures: Path | None = None,
) -> dict[str, Any]:
    """Wheel force, torque and slip with 1-sigma for each row of a drive log, without any soil model.

    Columns as ``terra estimate`` writes them; ``filter`` as in ``filters()``; ``smooth`` uses the whole log for
    every instant; ``html`` and ``figures``: a report to write, and a folder for its figures (SVG, CSV).
    """
    return _terra.estimate(_log(log), _rover(rover), filter, smooth, html, figures)


def identify(
    log: Log,
    rover: Rover,
    *,
    hypotheses: str | os.PathLike[str] | None = None,
    estimator: str | None = None,
    choice: str = "none",
    join: bool = False,
    history: bool = False,
    refine: bool = True,
    filter: str = "block",
    rows: tuple[int, int] | None = None,
    registry: Registry | None = None,
    html: Path | None = None,
    figures: Path | None = None,
) -> dict[str, Any]:
    """What soil is it? The content of ``terra identify --json`` (schema ``terra-identify/1``).

    Args:
        hypotheses: a catalogue set, a CSV of soils or a TOML plan of sets, in place of the rover file's.
        estimator: as in ``estimators()``; the default of the log's kind when absent.
        choice: what happens to old evidence: ``none``, ``floor:F``, ``forgetting:L``, ``transition:FILE``.
        join: one soil under both sides.
        history: keep the posterior after every sample.
        refine: refine the winner's parameters.
        filter: of the forces, as in ``filters()``.
        rows: first and last row of a drive log to weigh, the first being 1; a log of more than 300 000 needs it.
        registry: with models of one's own.
        html: a report to write (HTML, one file).
        figures: a folder for each figure of that report (SVG) and its numbers (CSV).
    """
    named = None if hypotheses is None else os.fspath(hypotheses)
    return _terra.identify(
        _log(log),
        _rover(rover),
        named,
        estimator,
        choice,
        join,
        history,
        refine,
        filter,
        rows,
        registry,
        html,
        figures,
    )


def hypotheses(
    rover: Rover,
    named: str | os.PathLike[str] | None = None,
    *,
    registry: Registry | None = None,
) -> list[dict[str, Any]]:
    """What ``identify`` weighs: ``id``, ``model`` and ``parameters`` of every hypothesis.

    Args:
        rover: whose ``hypotheses`` of ``[terrain]`` are meant.
        named: in their place: a catalogue set, a CSV of soils or a TOML plan of sets.
    """
    return _terra.hypotheses(_rover(rover), None if named is None else os.fspath(named), registry)


def gap(
    log: Log | Sequence[Log],
    rover: Rover,
    *,
    effects: Sequence[str] | None = None,
    hold_out: str | None = None,
    combine: int = 2,
    windows: int = 512,
    calibrate: int = 0,
    seed: int = 1,
    soil: str = "shared",
    sim: Log | None = None,
    same_bed: bool = False,
    motion_only: bool = False,
    registry: Registry | None = None,
    html: Path | None = None,
    figures: Path | None = None,
) -> dict[str, Any]:
    """Where does the simulator differ from reality, and what causes it? The content of ``terra gap --json``
    (schema ``terra-gap/1``).

    Args:
        log: one log, or a list of logs of one rover that are diagnosed together.
        effects: candidates by name; all when absent.
        hold_out: ``segment``, ``trial``, ``condition`` or ``slip``.
        combine: most effects combined (1 or 2).
        windows: most windows of a drive that are used, at least 16. Where there are more, every kind of motion stays
            and frequent ones are thinned.
        calibrate: mock cases of this log's own design to calibrate with.
        seed: of the mock cases.
        soil: ``shared`` by all logs, or each log's ``own``; sizes of effects are shared either way.
        sim: an outside simulator's log of the same manoeuvres or trials: causes are then of the difference to it,
            by motion alone where one of two drives holds no torques.
        same_bed: that log and the others are of the same ground.
        motion_only: a drive without torques is diagnosed by its motion alone, even where its accelerations tell of
            forces: on ground that no terrain model describes.
        registry: with effects and models of one's own among the candidates.
        html: a report to write (HTML, one file).
        figures: a folder for each figure of that report (SVG) and its numbers (CSV).
    """
    names = None if effects is None else list(effects)
    several = list(log) if isinstance(log, (list, tuple)) else [log]
    logs = [_log(one) for one in several]
    if len(logs) > 1:
        # Names tell the groups of several logs apart.
        logs = [
            (f"log {k}", one[1]) if isinstance(one, tuple) else one for k, one in enumerate(logs, 1)
        ]
    return _terra.gap(
        logs,
        _rover(rover),
        names,
        hold_out,
        combine,
        windows,
        calibrate,
        seed,
        soil,
        None if sim is None else _log(sim),
        same_bed,
        motion_only,
        registry,
        html,
        figures,
    )


def watch(
    log: Log,
    rover: Rover,
    *,
    baseline: float | str = 20.0,
    false_alarms: float = 0.05,
    effects: Sequence[str] | None = None,
    registry: Registry | None = None,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """When and where does a gap open in a long drive? ``terra gap --watch``: the content of its ``--json``, and the
    columns of its ``--track``, what every window shows.

    Args:
        log: a drive with wheel torques.
        rover: with a soil to start from (``start`` in ``[terrain]``).
        baseline: what the soil is learned from: so many seconds from the log's beginning, or a manoeuvre by its name.
        false_alarms: share of logs without a gap, of whatever length, in which an event may be raised.
        effects: hints by name; all when absent.
    """
    names = None if effects is None else list(effects)
    return _terra.watch(_log(log), _rover(rover), str(baseline), false_alarms, names, registry)


def scm_json(
    soil: Exported,
    *,
    catalogue: str | os.PathLike[str] | None = None,
    group: str | None = None,
) -> dict[str, Any]:
    """A soil for Chrono's soil contact model, as ``terra export scm-json`` writes it.

    >>> terra.scm_json("dry_sand")["Bekker n exponent"]
    1.1

    Args:
        soil: an id of ``terrains()`` or of ``catalogue``, or an identification, whose refined soil is meant.
        catalogue: a file with soils of one's own (CSV); an id that is in both is that of the file.
        group: of the identification (``left``, ``right``, ``all`` ...), where it has several.
    """
    return _terra.scm_json(_exported(soil), catalogue, group)


def slip_compliance(
    soil: Exported,
    normal_load: ArrayLike,
    *,
    radius: float,
    width: float,
    model: str = "wong-reece",
    values: Mapping[str, float] | None = None,
    tolerance: float = 0.1,
    catalogue: str | os.PathLike[str] | None = None,
    group: str | None = None,
) -> dict[str, Any]:
    """The slip compliance that rigid-body simulators (Gazebo, ODE) take, by load, with the slips up to which it holds.

    Args:
        soil: as for ``scm_json``.
        normal_load: N, one or several.
        radius: wheel radius in m.
        width: wheel width in m.
        model: terrain model.
        values: parameters in place of the soil's own, or that it does not give.
        tolerance: how far the line may be from the law, as a share of the largest traction on its range.
        catalogue: a file with soils of one's own (CSV).
        group: of an identification.

    Returns:
        The columns of ``terra export slip-compliance``, a row a load; NaN where ``status`` says that there is none.
    """
    loads = np.atleast_1d(np.asarray(normal_load, dtype=np.float64)).tolist()
    return _terra.slip_compliance(
        _exported(soil), loads, radius, width, model, _pairs(values or {}), tolerance, catalogue, group
    )


def cite(file: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """The references owed for what a scenario or a rover file uses: ``kind``, ``name`` and ``reference`` of each."""
    return _terra.cite(file)["references"]


def _exported(soil: Exported) -> str | tuple[str, str]:
    if isinstance(soil, (str, os.PathLike)):
        return os.fspath(soil)
    return ("the identification", json.dumps(soil))


def _terrain(terrain: Terrain) -> str | dict[str, float]:
    if isinstance(terrain, str):
        return terrain
    return {str(name): float(value) for name, value in terrain.items()}


def _log(log: Log) -> Any:
    """A path as it is; columns as the bytes of the CSV file they would be."""
    if isinstance(log, (str, os.PathLike)):
        return log
    columns = {str(name): log[name] for name in _names(log)}
    if not columns:
        raise ConfigurationError("the log has no columns")
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ConfigurationError(f"columns of different lengths: {lengths}")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(_cells(values) for values in columns.values())))
    return ("log in memory", text.getvalue().encode())


def _names(log: Any) -> list[Any]:
    return list(log.keys() if hasattr(log, "keys") else log.columns)


def _cells(values: Any) -> list[str]:
    """Shortest digits that read back to the same bits; empty for a missing value."""
    array = np.asarray(values)
    if array.dtype.kind in "fiub":
        numbers = array.astype(np.float64)
        return ["" if not np.isfinite(x) else repr(float(x)) for x in numbers]
    return ["" if v is None or v != v else str(v) for v in array.tolist()]


def _rover(rover: Rover) -> Any:
    if isinstance(rover, (str, os.PathLike)):
        return rover
    return ("rover in memory", _toml(rover).encode())


def _toml(tables: Mapping[str, Any]) -> str:
    return "".join(f"{_key(name)} = {_value(value)}\n" for name, value in tables.items())


def _key(name: str) -> str:
    return _value(str(name))


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        escaped = escaped.replace("\n", "\\n").replace("\r", "\\r").replace("\t", "\\t")
        return f'"{escaped}"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_value, value)) + "]"
    raise ConfigurationError(f"{value!r} has no place in a rover file")


def _main() -> int:
    """The command ``terra``, which comes with the package."""
    return _terra.command(["terra", *sys.argv[1:]])
