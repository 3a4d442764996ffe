"""Workers that cannot do what they are for: they are left out and named, and end no job."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

import lumivox
from lumivox import cluster
from lumivox.cluster import job, roster
from lumivox.rendering import Options

OPTIONS: Options = {"preset": "ct-bone", "size": (48, 40), "samples": 16, "pass_samples": 4}


def join(local: cluster.Local, **environment: str) -> None:
    """One more worker, in another environment."""
    local._processes.append(local._start({**os.environ, "LP_NUM_THREADS": "1", **environment}))


def module(folder: Path, name: str, text: str) -> str:
    """A folder with a module that comes before the installed ones."""
    file = folder / name
    file.parent.mkdir(parents=True)
    file.write_text(text)
    return str(folder)


def test_workers_that_cannot_render_are_left_out_and_named(
    head: lumivox.Volume, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = lumivox.render(head, **OPTIONS).film.sums()
    with cluster.Local(1) as local:
        (good,) = cluster.workers(local)
        join(local, LUMIVOX_GPU="no such GPU")
        join(local, PYTHONPATH=module(tmp_path / "bare", "lumivox/__init__.py", "raise ModuleNotFoundError('No Lumivox here')"))
        # It says that it can, and cannot.
        lame = "import lumivox.cluster.worker as it\ndef fail(*_): raise MemoryError('no room')\nit._run = fail\n"
        join(local, PYTHONPATH=module(tmp_path / "lame", "sitecustomize.py", lame))
        local.client.wait_for_workers(4, timeout=60)
        assert len(cluster.workers(local)) == 2
        work = cluster.submit(head, cluster=local, tiles=8, ranges=1, **OPTIONS)
        image = work.result()
        np.testing.assert_array_equal(image.film.sums(), expected)
        assert work.figures.retried > 0, "what the lame one was given was given to the other"
        assert len(image.notes) == 2 and all(note.startswith("worker tls://127.0.0.1:") for note in image.notes)
        assert any("no such GPU" in note for note in image.notes)
        assert any("pip install 'lumivox[cluster]==" in note for note in image.notes)
        frames = dict(cluster.film(head, [lumivox.Camera.look_at((0, 0, 500), (0, 0, 0))] * 3, cluster=local, **OPTIONS))
        assert len(frames) == 3

        # The one that can is started again elsewhere, and none of the others may.
        monkeypatch.setattr(job, "LOOK_AFTER", 0.5)
        work = cluster.submit(head, cluster=local, tiles=40, **{**OPTIONS, "samples": 64})
        while work.progress.samples == 0 and not work.done:
            time.sleep(0.02)
        os.kill(cluster.workers(local)[good]["pid"], signal.SIGKILL)
        # A worker that is started anew loads Lumivox first, and machines are busy: the limit is for one that never comes.
        assert work.wait(240) and work.result().complete


def test_where_nobody_can_render_it_is_said_why(monkeypatch: pytest.MonkeyPatch) -> None:
    class Client:
        def __init__(self, **answers: object) -> None:
            self.answers = answers

        def run(self, *_: object, on_error: str) -> dict[str, object]:
            assert on_error == "return"
            return self.answers

    with pytest.raises(ConnectionError, match="no workers"):
        roster.look(Client())
    with pytest.raises(lumivox.GpuError, match=r"no worker can render: a: there is no GPU; b: it has Lumivox 0\.0\.9"):
        roster.look(Client(a=lumivox.GpuError("there is no GPU"), b={"version": "0.0.9", "software": False}))
    with pytest.raises(lumivox.LumivoxError, match="an older one"):
        roster.look(Client(a={"software": False}))
    fit = {"version": lumivox.__version__, "software": True}
    found = roster.look(Client(a=fit, b=fit, c=ModuleNotFoundError("No module named 'lumivox'")))
    assert found.software and list(found.left_out) == ["c"] and found.without(set()) == ["a", "b"]
    assert found.without({"a"}) == ["b"] and found.without({"a", "b"}) == ["a", "b"], "who alone is left may try again"
    assert roster.look(Client(a=fit)).without(set()) is None, "whoever joins may work, too"


def test_parts_whose_workers_are_gone_are_given_to_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who may work can have changed since a part was given out: not those of now, but its own have to be there."""
    monkeypatch.setattr(job, "LOOK_AFTER", 0.0)
    monkeypatch.setattr(job, "PATIENCE", 1e6)
    fit = {"version": lumivox.__version__, "software": True}

    class Client:
        def __init__(self) -> None:
            self.there = {"lame": fit}
            self.cancelled: list[object] = []

        def scheduler_info(self, n_workers: int) -> dict[str, object]:
            return {"workers": self.there}

        def run(self, *_: object, on_error: str) -> dict[str, object]:
            return {**self.there, "other": lumivox.GpuError("there is no GPU")}

        def cancel(self, futures: list[object], force: bool) -> None:
            self.cancelled = futures

    client = Client()
    tasks = job.Tasks(client, [], job.Figures(parts=2), roster.look(client))
    tasks._strikes = {"lame": job.STRIKES}
    tasks._futures = {"first": job.Given(0, print, (), 0, ["gone"]), "second": job.Given(1, print, (), 0, ["lame"])}
    tasks._look_after()
    assert client.cancelled == [], "who has failed all the time is not asked while another may come"
    client.there = {"lame": fit, "new": fit}
    tasks._look_after()
    assert client.cancelled == ["first"]
    client.there, client.cancelled = {"lame": fit}, []
    monkeypatch.setattr(job, "PATIENCE", -1.0)
    tasks._look_after()
    assert client.cancelled == ["first"], "nobody came"


def test_images_that_were_iterated_over_say_so() -> None:
    images = cluster.Images.__new__(cluster.Images)
    images._begun = True
    with pytest.raises(RuntimeError, match="iterated over already"):
        iter(images)
