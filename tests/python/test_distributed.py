# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints over several processes have the bytes of one process, even if workers die."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
from conftest import BALL, TOOL

import openfab

distributed = pytest.importorskip("distributed")

from openfab import distributed as over  # noqa: E402
from openfab.distributed import costs, printing  # noqa: E402

Tool = Callable[..., dict[str, Any]]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit="2GB"
    ) as cluster:
        yield cluster


@pytest.fixture
def client(cluster: Any) -> Iterator[Any]:
    with distributed.Client(cluster) as client:
        client.wait_for_workers(2)
        yield client


@pytest.fixture
def many_shares(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cuts small prints as if they were large."""
    monkeypatch.setattr(costs, "LEAST_SECONDS", 0.0)


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("magic_postcard/postcard.fab.json", {"draft": 6}),  # pictures
        ("gyroid_block/gyroid.fab.json", {"draft": 5, "slices": (3, 90), "seed": 7}),
        ("rhino/holes.fab.json", {"draft": 10, "support": True}),  # a surface stage
    ],
)
def test_a_file_has_the_bytes_of_one_process(
    client: Any, gallery: Path, tmp_path: Path, name: str, options: dict[str, Any], many_shares: None
) -> None:
    world = openfab.load(gallery / name)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", openfab.PrintWarning)
        alone = openfab.print_world(world, tmp_path / "alone.ofr", **options)
        done = over.print_world(world, client, tmp_path / "shared.ofr", **options)
    assert (tmp_path / "shared.ofr").read_bytes() == (tmp_path / "alone.ofr").read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["alone.ofr", "shared.ofr"]
    for key in ("complete", "hash", "size_voxels", "voxels_total", "voxels_solid", "voxels_by_material", "slices"):
        assert done.statistics[key] == alone.statistics[key], key
    assert done.statistics["blocks"] == alone.statistics["blocks"]
    assert done.info.materials == alone.info.materials and done.info.slices == alone.info.slices
    # Each slab is in one share.
    ends = [one.end for one in done.costs]
    assert [one.first for one in done.costs[1:]] == ends[:-1] and done.costs[0].first == done.info.slices[0] // 8
    slabs = -(-done.info.slices[1] // 8) - done.info.slices[0] // 8
    assert len(done.costs) >= min(slabs, 5) and ends[-1] == -(-done.info.slices[1] // 8)


def test_a_dither_rule_reaches_workers(client: Any, tmp_path: Path) -> None:
    (tmp_path / "tones.fl").write_text("const float SPACING = 0.6;")
    (tmp_path / "screens.fl").write_text(
        "import dither;\nimport tones;\nint dots(DitherAttributes voxel) { return dither_dots(voxel, SPACING, 0.3); }"
    )
    world = openfab.World(printer="generic", dither={"source": tmp_path / "screens.fl", "rule": "dots"})
    white, black = openfab.Material("white", "#ffffff"), openfab.Material("black", "#000000")
    world.add(openfab.sphere(6), openfab.Fablet(text=BALL), {"core": white, "shell": black})
    alone = openfab.print_world(world, tmp_path / "alone.ofr", voxel=0.2)
    done = over.print_world(world, client, tmp_path / "shared.ofr", voxel=0.2)
    assert done.statistics["hash"] == alone.statistics["hash"]


def test_programs_run_on_workers_where_they_may(client: Any, tmp_path: Path) -> None:
    (tmp_path / "made.py").write_text(
        "from openfab.procedural import beam, generator\n"
        "@generator(attributes={'kind': 'int'})\n"
        "def made(bound):\n"
        "    yield beam((0, 0, 0), (0, 0, 5), (1, 0.5), kind=1)\n"
        "if __name__ == '__main__':\n"
        "    made.serve()\n"
    )
    (tmp_path / "ball.fl").write_text(BALL)
    (tmp_path / "w.fab.json").write_text(json.dumps({
        "openfab": 1, "printer": "generic",
        "fablets": {"ball": {"source": "ball.fl", "fablet": "Ball"}},
        "materials": {"white": {"key": "#ffffff"}, "red": {"key": "#ff0000"}},
        "meshes": {"made": {
            "program": [sys.executable, "made.py"], "box_mm": [[-2, -2, -2], [2, 2, 7]], "attributes": {"kind": "int"},
        }},
        "objects": {"a": {"mesh": "made", "fablet": "ball", "uniforms": {"core": "red", "shell": "white"}}},
        "build": [{"object": "a"}],
    }))
    with pytest.raises(openfab.InputError, match="`allow_programs`"):
        over.print_world(openfab.load(tmp_path / "w.fab.json"), client, tmp_path / "shared.ofr", voxel=0.2)
    world = openfab.load(tmp_path / "w.fab.json", allow_programs=True)
    openfab.print_world(world, tmp_path / "alone.ofr", voxel=0.2)
    over.print_world(world, client, tmp_path / "shared.ofr", voxel=0.2)
    assert (tmp_path / "shared.ofr").read_bytes() == (tmp_path / "alone.ofr").read_bytes()


def test_objects_of_python_reach_workers(client: Any, ball: openfab.World, tmp_path: Path) -> None:
    picture = np.random.default_rng(3).integers(0, 256, (8, 8, 3), np.uint8)
    fablet = openfab.Fablet(
        text="""fablet Painted {
            @uniform { ImageTexture2D picture; Material white, black; }
            @Volume(@varying { VolumeAttributes attr }) {
                MaterialComposition mc;
                float t = picture.Sample1(attr.voxelCenter.x / 5, attr.voxelCenter.y / 5, 0);
                mc.Set(white, t);
                mc.Set(black, 1 - t);
                return mc;
            }
        }"""
    )
    vertices = [(0, 0, 0), (5, 0, 0), (0, 5, 0), (0, 0, 5)]
    mesh = openfab.Mesh(vertices, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    core = ball.objects["ball"]["core"]
    ball.add(mesh, fablet, {"picture": picture, "white": core, "black": ball.objects["ball"]["shell"]},
             translate=(6, 0, 0))
    for skin in (0.8, 0.3):  # the second time only the world is new
        ball.objects["ball"]["skin"] = skin
        openfab.print_world(ball, tmp_path / "alone.ofr", voxel=0.1)
        over.print_world(ball, client, tmp_path / "shared.ofr", voxel=0.1)
        assert (tmp_path / "shared.ofr").read_bytes() == (tmp_path / "alone.ofr").read_bytes()


def test_files_travel_once(client: Any, ball: openfab.World, tmp_path: Path) -> None:
    over.print_world(ball, client, tmp_path / "a.ofr", voxel=0.2)
    sent = printing._files[client]
    done = over.print_world(ball, client, tmp_path / "b.ofr", voxel=0.2, uniforms={"ball.skin": 0.2})
    # Which workers hold them may change: Dask drops copies that none is asking for.
    assert printing._files[client] is sent and client.who_has([sent])[sent.key]
    assert done.statistics["inputs_bytes"] < 3000
    over.release(client)
    assert client not in printing._files


def test_a_folder_has_the_files_of_one_process(client: Any, ball: openfab.World, tmp_path: Path) -> None:
    openfab.print_world(ball, tmp_path / "alone", voxel=0.2, format="png")
    over.print_world(ball, client, tmp_path / "shared", voxel=np.float64(0.2), format="png", in_flight=np.int64(3))
    assert files_of(tmp_path / "shared") == files_of(tmp_path / "alone")


def test_object_storage_is_reached_by_fsspec(client: Any, ball: openfab.World, tmp_path: Path) -> None:
    fsspec = pytest.importorskip("fsspec")
    memory = fsspec.filesystem("memory")
    openfab.print_world(ball, tmp_path / "alone.ofr", voxel=0.2)
    over.print_world(ball, client, "memory://prints/ball.ofr", voxel=0.2)
    assert memory.cat_file("/prints/ball.ofr") == (tmp_path / "alone.ofr").read_bytes()
    over.print_world(ball, client, f"file://{tmp_path}/shared.ofr", voxel=0.2)
    assert (tmp_path / "shared.ofr").read_bytes() == (tmp_path / "alone.ofr").read_bytes()
    openfab.print_world(ball, tmp_path / "alone", voxel=0.2, format="png")
    over.print_world(ball, client, "memory://prints/slices", voxel=0.2, format="png")
    stored = {Path(path).name: memory.cat_file(path) for path in memory.ls("/prints/slices", detail=False)}
    assert stored == files_of(tmp_path / "alone")


def test_storage_that_fails_is_an_error(
    client: Any, ball: openfab.World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fsspec = pytest.importorskip("fsspec")
    from fsspec.implementations.memory import MemoryFile

    memory = fsspec.filesystem("memory")
    memory.pipe_file("/prints/kept.ofr", b"before")

    def full(self: Any, data: bytes) -> int:
        raise OSError(28, "no space")

    monkeypatch.setattr(MemoryFile, "write", full)
    with pytest.raises(openfab.OutsideError, match="no space"):
        over.print_world(ball, client, "memory://prints/kept.ofr", voxel=0.05)
    assert memory.cat_file("/prints/kept.ofr") == b"before"
    with pytest.raises(openfab.InputError, match="nosuch"):
        over.print_world(ball, client, "nosuch://prints/ball.ofr", voxel=0.5)
    with pytest.raises(openfab.OutsideError, match="none/slices"):
        over.print_world(ball, client, f"file://{tmp_path}/none/slices", voxel=0.5, format="png")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("listen", ["unix:{folder}/printer", "tcp://127.0.0.1:0"])
def test_a_receiver_gets_the_bytes_of_one_process(
    client: Any, ball: openfab.World, tmp_path: Path, listen: str
) -> None:
    openfab.print_world(ball, tmp_path / "alone.ofr", voxel=0.2)
    command = [TOOL, "receive", "--listen", listen.format(folder=tmp_path), "-o", tmp_path / "received.ofr"]
    with subprocess.Popen(list(map(str, command)), stderr=subprocess.PIPE, text=True) as receiver:
        assert receiver.stderr is not None
        words, _, address = receiver.stderr.readline().strip().rpartition(" ")
        assert words == "listening at"
        over.print_world(ball, client, address, voxel=0.2)
        receiver.communicate(timeout=300)
    assert receiver.returncode == 0
    assert (tmp_path / "received.ofr").read_bytes() == (tmp_path / "alone.ofr").read_bytes()


def test_a_receiver_that_goes_away_is_an_error(client: Any, ball: openfab.World, many_shares: None) -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        address = "tcp://{}:{}".format(*listener.getsockname())

        def hang_up() -> None:
            connection, _ = listener.accept()
            connection.recv(1)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            connection.close()

        thread = threading.Thread(target=hang_up)
        thread.start()
        with pytest.raises(openfab.OutsideError, match=re.escape(address)):
            over.print_world(ball, client, address, voxel=0.05)
        thread.join()
    with pytest.raises(openfab.OutsideError, match=re.escape(address)):
        over.print_world(ball, client, address, voxel=0.5)


class Mortals:
    """Two workers without a nanny; a killed one is replaced here."""

    def __init__(self, address: str, folder: Path, seed: int) -> None:
        self._words = [
            sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "1",
            "--no-dashboard", "--local-directory", str(folder),
        ]
        self._chance = random.Random(seed)
        self._workers = [self._start(), self._start()]
        self.killed = 0

    def _start(self) -> subprocess.Popen[bytes]:
        return subprocess.Popen(self._words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def kill(self) -> None:
        """Kills a random worker at a random moment of the next half second."""
        time.sleep(self._chance.uniform(0, 0.5))
        victim = self._chance.randrange(2)
        self._workers[victim].kill()
        self._workers[victim].wait()
        self._workers[victim] = self._start()
        self.killed += 1

    def end(self) -> None:
        for worker in self._workers:
            worker.kill()
            worker.wait()


@pytest.mark.parametrize("kills", [2] + ([20] if os.environ.get("OPENFAB_LONG") else []))
def test_workers_that_die_lose_nothing(
    gallery: Path, tmp_path: Path, kills: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(costs, "MOST_SECONDS", 0.0)  # a share is a slab
    world = openfab.load(gallery / "gyroid_block" / "gyroid.fab.json")
    draft = 4 if kills < 20 else 2
    alone = openfab.print_world(world, tmp_path / "alone.ofr", draft=draft)
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        mortals = Mortals(cluster.scheduler_address, tmp_path, seed=kills)

        def pace(done: int, total: int) -> None:
            # The kills are spread over the print, with something done between them.
            if mortals.killed < kills * done // total:
                mortals.kill()

        try:
            done = over.print_world(world, client, tmp_path / "shared.ofr", draft=draft, progress=pace)
        finally:
            mortals.end()
    assert mortals.killed == kills
    assert (tmp_path / "shared.ofr").read_bytes() == (tmp_path / "alone.ofr").read_bytes()
    assert done.statistics["hash"] == alone.statistics["hash"]
    if kills > 2:
        assert done.statistics["set_ups"] > 2  # also by processes that took the place of others


def test_a_slow_output_holds_the_workers_back(
    client: Any, gallery: Path, tmp_path: Path, many_shares: None
) -> None:
    world = openfab.load(gallery / "gyroid_block" / "gyroid.fab.json")
    held: list[int] = []

    def slow(done: int, total: int) -> None:
        time.sleep(0.2)
        held.append(client.run_on_scheduler(_shares_known))

    done = over.print_world(world, client, tmp_path / "shared.ofr", draft=4, in_flight=2, progress=slow)
    samples = len(costs.sample_places(0, done.costs[-1].end, 2))
    assert len(done.costs) > samples + 6
    # Two in flight, one on its way to the writer, and what is left of the samples.
    assert max(held) <= samples + 3 and min(held) <= 4


def _shares_known(dask_scheduler: Any = None) -> int:
    return sum(str(key).startswith("openfab-share-") for key in dask_scheduler.tasks)


def test_memory_is_a_share_of_the_workers(client: Any, ball: openfab.World, tmp_path: Path) -> None:
    with pytest.raises(openfab.InputError, match="memory"):
        over.print_world(ball, client, tmp_path / "x.ofr", voxel=0.01, memory="30MB")
    done = over.print_world(ball, client, tmp_path / "x.ofr", voxel=0.1)
    assert 0 < done.info.memory_bytes <= 0.6 * 2e9
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize(
    ("arguments", "kind", "text"),
    [
        ({"uniforms": {"ball.skn": 1}}, openfab.InputError, "skn"),
        ({"printer": "nonesuch"}, openfab.InputError, "nonesuch"),
        ({"slices": (5, 5)}, openfab.InputError, "`slices`: `5:5` is an empty"),
        ({"in_flight": -1}, openfab.InputError, "`in_flight` cannot be -1"),
        ({"threads": 0}, openfab.InputError, "`threads` cannot be 0"),
        ({"out": "ball.npy"}, openfab.InputError, "slice by slice"),
        ({"out": "ball.xyz"}, openfab.InputError, "format"),
        ({"out": "nowhere/ball.ofr"}, openfab.Error, "nowhere"),
    ],
)
def test_wrong_arguments_are_errors(
    client: Any, ball: openfab.World, tmp_path: Path, arguments: dict[str, Any], kind: type[Exception], text: str
) -> None:
    with pytest.raises(kind, match=text):
        over.print_world(ball, client, **{"out": tmp_path / "x.ofr", "voxel": 0.5, **arguments})
    assert list(tmp_path.iterdir()) == []


def test_a_world_that_does_not_compile_is_an_error(client: Any, tmp_path: Path) -> None:
    (tmp_path / "ball.fl").write_text(BALL)
    world = openfab.World(printer="generic")
    white = openfab.Material("w", "#ffffff")
    world.add(openfab.sphere(2), openfab.Fablet(tmp_path / "ball.fl"), {"core": white, "shell": openfab.VOID})
    (tmp_path / "ball.fl").write_text(BALL.replace("smoothstep", "smothstep"))
    with pytest.raises(openfab.CompileError, match="smothstep") as found:
        over.print_world(world, client, tmp_path / "x.ofr", voxel=0.5)
    assert found.value.file == str(tmp_path / "ball.fl") and found.value.line == 6
    assert not (tmp_path / "x.ofr").exists()


@pytest.mark.parametrize(
    ("code", "late", "text"),
    [
        ("import sys; sys.modules['openfab'] = None", False, "cannot import OpenFab"),
        ("import openfab; openfab.__version__ = '0.0.1'", True, re.escape("has OpenFab 0.0.1")),
    ],
)
def test_workers_that_cannot_print_are_errors(
    ball: openfab.World, tmp_path: Path, code: str, late: bool, text: str
) -> None:
    (tmp_path / "early.py").write_text(code)
    with (
        distributed.LocalCluster(
            n_workers=0, threads_per_worker=1, dashboard_address=None, preload=[str(tmp_path / "early.py")]
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        # It joins while the print waits for workers, or before.
        cluster.scale(1)
        if not late:
            client.wait_for_workers(1)
        with pytest.raises(over.ClusterError, match=text):
            over.print_world(ball, client, tmp_path / "x.ofr", voxel=0.5)


INTERRUPTED = """
import signal, sys, time, openfab, distributed
from openfab import distributed as over

# Python leaves Ctrl-C ignored where this runs in the background of a script.
signal.signal(signal.SIGINT, signal.default_int_handler)

def progress(done, total):
    print("slice", flush=True)
    time.sleep(30)  # the print is not over before the signal is there, which ends the sleep

if __name__ == "__main__":
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            try:
                over.print_world(openfab.load(sys.argv[1]), client, sys.argv[2], progress=progress)
                print("complete", flush=True)
            except KeyboardInterrupt:
                print("interrupted", flush=True)
"""


def test_ctrl_c_ends_cleanly(gallery: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    world = gallery / "gyroid_block" / "gyroid.fab.json"
    (tmp_path / "program.py").write_text(INTERRUPTED)
    words = [sys.executable, str(tmp_path / "program.py"), str(world), str(out / "x.ofr")]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "slice\n"
        program.send_signal(signal.SIGINT)
        said, _ = program.communicate(timeout=300)  # which only a hang takes
    assert said.splitlines()[-1] == "interrupted"
    assert list(out.iterdir()) == []


def test_the_package_does_not_need_dask() -> None:
    code = """
import sys
sys.modules["distributed"] = None
import openfab
assert not any(name.split(".")[0] in ("dask", "tornado") for name in sys.modules)
try:
    import openfab.distributed
except ImportError as error:
    assert "pip install 'openfab[distributed]'" in str(error)
else:
    raise AssertionError
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_shares_are_cut_by_what_slabs_take() -> None:
    model = costs.CostModel(0, 100)
    assert costs.share_end(model, 0, 100, 100, 100, 4) == 1  # nothing is known
    # The upper half takes four times as long.
    for slab, seconds in ((10, 0.25), (40, 0.25), (60, 1.0), (90, 1.0)):
        model.add(costs.ShareCost(slab, slab + 1, seconds, seconds, 1000))
    low = costs.share_end(model, 0, 100, 100, 100, 1)
    high = costs.share_end(model, 70, 100, 100, 100, 1) - 70
    assert 30 <= low <= 42 and 4 <= high <= 10
    assert costs.share_end(model, 0, 7, 100, 100, 1) == 7  # up to what is printed already
    # A share is never empty, and the last ones are short.
    assert costs.share_end(model, 99, 100, 100, 100, 1) == 100
    assert costs.share_end(model, 90, 100, 100, 100, 2) - 90 < high


def test_what_is_not_known_is_cut_into_slabs() -> None:
    model = costs.CostModel(0, 100)
    model.add(costs.ShareCost(10, 11, 0.001, 0.001, 1))
    known = costs.settled([10, 50, 90], [50, 90], 100)
    assert known == 11
    assert costs.share_end(model, 0, 100, known, 100, 1) == 11
    assert costs.share_end(model, 11, 100, known, 100, 1) == 12
    assert costs.settled([10, 50, 90], [], 100) == 100 and costs.settled([10, 50], [10], 100) == 10


def test_samples_are_spread_and_few() -> None:
    places = costs.sample_places(3, 103, 2)
    assert places[0] == 3 and len(places) == costs.SAMPLES + 1
    assert max(b - a for a, b in zip(places, places[1:])) <= 12 and places[-1] > 90
    assert len(costs.sample_places(0, 1000, 50)) == 51
    assert costs.sample_places(5, 6, 8) == [5]
    assert len(costs.sample_places(0, 8, 1000)) <= 3
