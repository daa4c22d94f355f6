"""A sweep on a cluster of two processes, one of which is killed in the middle: nothing lost, same bytes."""

import os
import signal
import sys
import threading
from pathlib import Path

import pytest

distributed = pytest.importorskip("dask.distributed", reason="dask[distributed] is not here")

PLAN = """
command = "simulate"
scenario = "{scenario}"
runs = 24
seed = 1

[vary]
noise_scale = [1.0, 2.0]
"""


# A command that waits before it works: the worker can be killed while it surely has a shard in hand.
SLOW = """#!{python}
import os, subprocess, sys, time
if sys.argv[1] == "sweep":
    index = sys.argv[sys.argv.index("--shard") + 1].split("/")[0]
    begun = {folder!r} + "/begun_" + index
    if not os.path.exists(begun):
        open(begun, "w").write(str(os.getppid()))
        time.sleep({wait})
sys.exit(subprocess.run([{terra!r}, *sys.argv[1:]]).returncode)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_killed_worker_loses_nothing(command, examples, tmp_path):
    sys.path.insert(0, str(examples / "python"))
    from dask_sweep import sweep

    terra = os.environ.get("TERRA_COMMAND", examples.parent / "target/debug/terra")
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN.format(scenario=examples / "paper/lean_clay.toml"))
    alone = tmp_path / "alone.jsonl"
    command("sweep", plan, "--out", alone)

    slow = tmp_path / "terra-slow"
    slow.write_text(SLOW.format(python=sys.executable, folder=str(tmp_path), terra=str(terra), wait=2))
    slow.chmod(0o755)
    shards = tmp_path / "shards"
    shards.mkdir()
    killed = []

    def kill_one():
        """The process of the first worker that has begun a shard."""
        for _ in range(600):
            begun = sorted(Path(tmp_path).glob("begun_*"))
            if begun and begun[0].read_text():
                killed.append(int(begun[0].read_text()))
                os.kill(killed[0], signal.SIGKILL)
                return
            threading.Event().wait(0.1)

    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster, distributed.Client(cluster) as client:
        workers = {info["pid"] for info in client.run(lambda: {"pid": os.getpid()}).values()}
        assert len(workers) == 2
        killer = threading.Thread(target=kill_one)
        killer.start()
        out = tmp_path / "all.jsonl"
        sweep(client, str(plan), 6, str(out), str(shards), str(slow))
        killer.join()
    assert killed and killed[0] in workers
    assert len(list(shards.glob("*.jsonl"))) == 6
    assert out.read_bytes() == alone.read_bytes()
    assert len(out.read_text().splitlines()) == 48
