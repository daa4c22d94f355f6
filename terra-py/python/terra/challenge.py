"""Sealed blind cases: logs whose cause is withheld, and their marking, as ``terra challenge``.

>>> import tempfile, pathlib, terra
>>> folder = pathlib.Path(tempfile.mkdtemp())
>>> made = terra.challenge.make("rig", 2, seed=7, out=folder / "logs", key=folder / "key.json")
>>> made["cases"], len(terra.challenge.reveal(folder / "key.json", folder / "logs"))
(2, 2)
"""

from __future__ import annotations

import os
from typing import Any, Mapping

from . import _terra

__all__ = ["make", "reveal", "run", "score"]


def make(
    design: str | os.PathLike[str],
    cases: int,
    *,
    seed: int,
    out: str | os.PathLike[str],
    key: str | os.PathLike[str],
    kinds: Mapping[str, float] | None = None,
) -> dict[str, Any]:
    """Draws cases, simulates their logs, and commits to what is withheld.

    Args:
        design: ``ramp``, ``steps``, ``flat``, ``rich``, ``rig``, or a scenario file.
        cases: how many.
        seed: of everything that is drawn: whoever knows it knows the answers.
        out: folder for the logs, the rover file and the commitments; a challenge that is there is replaced.
        key: key file to write, outside that folder.
        kinds: shares of ``none``, ``single``, ``pair``, ``off-library`` and ``form-variant``.

    Returns:
        How many ``cases``, how many of each of the ``kinds``, and the effects that the design cannot show
        (``not_carried``).

    Raises:
        ConfigurationError: an unknown design or kind, a key inside the folder.
        BadData: a design that no soil gets through.
        TerraError: a folder that holds something else.
    """
    shares = None if kinds is None else [(str(k), float(v)) for k, v in kinds.items()]
    return _terra.challenge_make(os.fspath(design), cases, seed, out, key, shares)


def run(folder: str | os.PathLike[str], out: str | os.PathLike[str]) -> dict[str, Any]:
    """Diagnoses every log of a challenge with its rover file, as ``terra.gap``.

    Verdicts that are there already are kept; Ctrl-C ends the work after the cases at hand.

    Args:
        folder: of the challenge.
        out: folder for the verdicts, ``case_001.json`` ...

    Returns:
        How many ``cases``, how many verdicts were ``kept``, how often each of the ``verdicts`` was given, how many cases
        ``failed``, and why the first of them did (``first_failure``).

    Raises:
        BadData: no logs, a verdict of another log, or no case that can be diagnosed.
    """
    return _terra.challenge_run(folder, out)


def score(
    verdicts: str | os.PathLike[str], key: str | os.PathLike[str], *, closing: bool = True
) -> dict[str, Any]:
    """Marks verdicts against the key, beside naive baselines: the content of ``--json``.

    Args:
        verdicts: folder with ``case_001.json`` ..., as ``terra gap --json`` writes them; one that is missing is wrong.
        key: key file.
        closing: simulate the cases again, to see how far the gap truly closed.

    Raises:
        BadData: no folder, a file that is no verdict, a key that is none.
    """
    return _terra.challenge_score(verdicts, key, closing)


def reveal(
    key: str | os.PathLike[str], folder: str | os.PathLike[str]
) -> list[dict[str, Any]]:
    """Checks every commitment and gives the answers.

    Args:
        key: key file.
        folder: of the challenge.

    Returns:
        Of each ``case`` what was withheld: its ``kind``, ``effects``, ``soil`` and ``seed``.

    Raises:
        BadData: a case whose key does not match what was committed to.
    """
    return _terra.challenge_reveal(key, folder)
