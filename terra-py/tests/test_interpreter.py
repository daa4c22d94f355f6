"""Long work leaves the interpreter to others, and Ctrl-C is heard."""

import signal
import subprocess
import sys
import threading

import pytest

import terra

# A diagnosis calibrated on its own design takes minutes.
LONG = """
import signal, sys, terra
# What a shell starts in the background is born deaf to the signal.
signal.signal(signal.SIGINT, signal.default_int_handler)
print("ready", flush=True)
try:
    terra.gap(sys.argv[1], sys.argv[2], calibrate=1000)
except KeyboardInterrupt:
    print("heard", flush=True)
    sys.exit(7)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for one process")
def test_ctrl_c(logs, examples):
    work = subprocess.Popen(
        [sys.executable, "-c", LONG, str(logs / "rig.csv"), str(examples / "rig/rig.toml")],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert work.stdout.readline() == "ready\n"
    threading.Event().wait(0.5)
    assert work.poll() is None
    work.send_signal(signal.SIGINT)
    assert work.wait(timeout=60) == 7
    assert work.stdout.read() == "heard\n"


def test_other_threads_go_on(logs, examples):
    """Two of Python's threads meet at a barrier while one of them is inside a diagnosis."""
    done = threading.Event()

    def diagnose():
        terra.gap(logs / "rig.csv", examples / "rig/rig.toml", effects=["slip-sinkage"], combine=1)
        done.set()

    worker = threading.Thread(target=diagnose)
    worker.start()
    steps = 0
    while not done.wait(timeout=0.001):
        steps += 1
    worker.join()
    assert steps > 3
