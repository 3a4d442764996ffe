"""Processes: those that are forked render or say why not, and never wait for threads that did not come along; all end."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PARENT = """
import os, signal, sys, warnings
import numpy as np
import lumivox
from lumivox import cluster

# It forks where threads run, which Python warns of: that is what this is about.
warnings.simplefilter("ignore", DeprecationWarning)
SIZE = {"size": (16, 16), "samples": 2}


def child(work):
    process = os.fork()
    if process == 0:
        # What waits for ever is ended.
        signal.alarm(40)
        code = 1
        try:
            work()
            code = 0
        except BaseException:
            import traceback
            traceback.print_exc()
        finally:
            os._exit(code)
    _, status = os.waitpid(process, 0)
    assert os.waitstatus_to_exitcode(status) == 0, work.__name__


def computes():
    volume = lumivox.phantom("head", 32)
    assert volume.segment().labels is not None
    scene = lumivox.Scene.of(volume)
    lumivox.Camera.framing(scene)
    assert lumivox.load(sys.argv[1]) == lumivox.load(sys.argv[1])


def renders():
    assert lumivox.render(lumivox.phantom("cube", 16), preset="plain", **SIZE).alpha.any()


def is_told():
    for work in (lumivox.gpus, renders):
        try:
            work()
        except lumivox.GpuError as error:
            assert "forked" in str(error) and "spawn" in str(error), error
        else:
            raise AssertionError(work)
    image.denoised()
    computes()
    # A child of the child, too.
    child(computes)
    import gc
    lumivox.rendering._renderers.clear()
    gc.collect()


lumivox.phantom("cube", 16)
child(computes)
child(renders)
image = lumivox.render(lumivox.phantom("head", 32), layers=True, **SIZE)
child(is_told)
renders()
print("done")
"""


def test_a_forked_child_works_or_says_what_to_do(python: str, head_folder: Path, tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    flags = ["-P"] if sys.version_info >= (3, 11) else []
    done = subprocess.run(
        [python, *flags, str(script), str(head_folder)], capture_output=True, text=True, timeout=150, check=False
    )
    assert done.returncode == 0 and done.stdout == "done\n", done.stdout + done.stderr


LEAVES = """
import atexit, os, threading, time

# Registered before the package's own, and called after that.
atexit.register(lambda: os.write(1, b"%d\\n" % lumivox.phantom("head", 16).shape[0]))
import lumivox

begun = threading.Event()

def work():
    try:
        while True:
            begun.set()
            lumivox.phantom("head", 128)
    except SystemExit:
        # Nothing of Python's own may write any more.
        os.write(1, b"stopped\\n")
        raise

threading.Thread(target=work, daemon=True).start()
begun.wait()
time.sleep(0.2)
"""


def test_work_of_a_daemon_thread_is_stopped_before_python_ends(python: str) -> None:
    flags = ["-P"] if sys.version_info >= (3, 11) else []
    done = subprocess.run([python, *flags, "-c", LEAVES], capture_output=True, text=True, timeout=150, check=False)
    assert (done.returncode, sorted(done.stdout.split()), done.stderr) == (0, ["16", "stopped"], "")
