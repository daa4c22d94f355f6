"""A sweep on a Dask cluster: one shard a task, merged into the bytes of an unsharded run.

    python dask_sweep.py plan.toml --shards 8 --out all.jsonl                    a local cluster
    python dask_sweep.py plan.toml --shards 8 --out all.jsonl --scheduler tcp://head:8786

A worker that dies loses nothing: Dask gives its shards to another. Finished shards are kept, so that a sweep that was
stopped is gone on with by the same command. The shards' folder must be seen by all workers.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import tempfile
import uuid
from pathlib import Path

from dask.distributed import Client, LocalCluster


def shard(terra: str, plan: str, folder: str, index: int, count: int) -> str:
    """Runs one shard and gives its file, which is there whole or not at all."""
    out = Path(folder) / f"shard_{index:04d}_of_{count:04d}.jsonl"
    if not out.exists():
        # Under a name of its own: what a killed worker started may still be running.
        growing = out.with_name(f"{out.stem}.{uuid.uuid4().hex}.growing")
        line = [terra, "sweep", plan, "--shard", f"{index}/{count}", "--threads", "1", "--out", str(growing)]
        done = subprocess.run(line, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
        os.replace(growing, out)
    return str(out)


def sweep(client: Client, plan: str, count: int, out: str, folder: str, terra: str = "terra") -> None:
    """The whole sweep: every shard on some worker, then one file in order of runs."""
    tasks = [
        # Retried when it fails for a reason of the machine's; a shard may always be begun again.
        client.submit(shard, terra, plan, folder, k, count, pure=False, retries=2, key=f"shard-{k}")
        for k in range(1, count + 1)
    ]
    files = client.gather(tasks)
    subprocess.run([terra, "merge", *files, "--out", out], check=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="A sweep on a Dask cluster.")
    parser.add_argument("plan")
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--out", required=True)
    parser.add_argument("--folder", help="of the shards; kept, so that a sweep can be gone on with")
    parser.add_argument("--scheduler", help="address of a running cluster; a local one when absent")
    parser.add_argument("--terra", default="terra", help="the command")
    args = parser.parse_args()
    cluster = args.scheduler or LocalCluster(threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        folder = args.folder or tempfile.mkdtemp(prefix="terra-sweep-")
        sweep(client, str(Path(args.plan).resolve()), args.shards, args.out, folder, args.terra)


if __name__ == "__main__":
    main()
