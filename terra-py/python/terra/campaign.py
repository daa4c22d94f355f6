"""How often the answer is right, on many runs with known truth: the kinds of ``terra campaign``.

The same figures as the command's for the same seed, on any number of threads. Those that work in a folder keep what is
there already: the call that was stopped is simply made again, and Ctrl-C ends it after the cases at hand.
"""

from __future__ import annotations

import os
from typing import Any, Sequence

from . import _terra

__all__ = ["cross_structure", "faults", "gap", "gap_calibration", "ramps", "reproduction"]


def ramps(
    *,
    runs: int = 200,
    seed: int = 1,
    terrains: Sequence[str] = ("dry_sand", "upland_sandy_loam", "lean_clay_22"),
) -> dict[str, Any]:
    """Torque ramps of the light robot of Ray 2008, identified among the 21 classic soils.

    Args:
        runs: noise draws of each soil.
        seed: of the noise.
        terrains: ids of soils.

    Returns:
        The content of ``--json``: in ``rows``, a soil each, the share of right answers with its 95 % interval.

    Raises:
        ConfigurationError: an unknown soil, no runs.
    """
    return _terra.campaign_ramps(runs, seed, list(terrains))


def faults(*, runs: int = 5000, seed: int = 1, filter: str = "block") -> dict[str, Any]:
    """Faults of sensors, torques and clocks: does the filter flag them, stay finite and come back?

    Args:
        runs: rounded up to whole draws of every kind, channel and soil.
        seed: of the noise.
        filter: as in ``terra.filters()``.

    Returns:
        The content of ``--json``: in ``report`` a row a kind of fault, and their ``total``.

    Raises:
        ConfigurationError: an unknown filter, no runs.
    """
    return _terra.campaign_faults(runs, seed, filter)


def reproduction(
    *,
    runs: int = 20,
    seed: int = 1,
    tables: Sequence[str] = ("exact", "switch", "perturbed", "mismatch"),
) -> dict[str, Any]:
    """The published figures of the light robot on all soils that carry it, beside what this build finds.

    Args:
        runs: noise draws of each case.
        seed: of the noise.
        tables: which to make.

    Returns:
        The content of ``--json``: in ``figures`` a figure each, found, published and asked for.

    Raises:
        ConfigurationError: an unknown table, no runs.
    """
    return _terra.campaign_reproduction(runs, seed, list(tables))


def gap(
    out: str | os.PathLike[str],
    *,
    designs: Sequence[str] = ("ramp", "rich"),
    cases: int = 100,
    seed: int = 1,
    left_out: bool = False,
) -> dict[str, Any]:
    """Sealed cases made, diagnosed and marked, beside what must be reached and what naive answers reach.

    Args:
        out: folder for logs, keys and verdicts; what is there already is kept.
        designs: of ``ramp``, ``steps``, ``flat``, ``rich``, ``rig``.
        cases: of each design.
        seed: of everything that is drawn.
        left_out: diagnose the single cases once more with the true effect taken out of the library.

    Returns:
        The content of ``--json``: in ``designs`` the marks of each with its ``targets``.

    Raises:
        ConfigurationError: an unknown design, no cases.
        BadData: a folder that holds verdicts of other logs.
    """
    return _terra.campaign_gap(out, list(designs), cases, seed, left_out)


def gap_calibration(
    out: str | os.PathLike[str],
    *,
    designs: Sequence[str] = ("ramp", "rich"),
    cases: int = 100,
    seed: int = 1,
    nulls: int = 0,
) -> str:
    """Cases with known truth, and the calibration that they teach.

    Args: as those of ``gap``, and
        nulls: cases of each design without any effect beside these, from which is learned what a cause must gain to be heard;
            they are drawn from the seed after ``seed``.

    Returns:
        The text of ``calibration.toml``, which is written into the folder.

    Raises: as ``gap``.
    """
    return _terra.campaign_gap_calibration(out, list(designs), cases, seed, nulls)


def cross_structure(
    out: str | os.PathLike[str], *, design: str = "rig", cases: int = 96, seed: int = 1
) -> dict[str, Any]:
    """Ground that follows another wheel law than the simulator that is diagnosed, with and without a baseline log.

    Args:
        out: folder for the answers and the calibration that they teach; what is there already is kept.
        design: rig, rich, flat, steps or ramp.
        cases: how many.
        seed: of everything that is drawn.

    Returns:
        The content of ``--json``: in ``figures`` a figure each, with its 95 % interval.

    Raises:
        ConfigurationError: no cases, an unknown design.
    """
    return _terra.campaign_cross_structure(out, design, cases, seed)
