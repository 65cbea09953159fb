# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import gc
import json
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
from conftest import BALL

import openfab

Tool = Callable[..., dict[str, Any]]

# Worlds with a surface stage, pictures, volumes of space, queries of other objects, many parts; coarse, to be quick.
WORLDS = [
    ("magic_postcard/postcard.fab.json", 6),
    ("gyroid_block/gyroid.fab.json", 6),
    ("rhino/holes.fab.json", 10),
    ("coupon/coupon.fab.json", 6),
    ("microlens_array/microlens.fab.json", 4),
]


@pytest.mark.parametrize(("name", "draft"), WORLDS)
def test_the_gallery_has_the_bits_of_the_tool(gallery: Path, tool: Tool, name: str, draft: int) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", openfab.PrintWarning)
        print_ = openfab.print_world(openfab.load(gallery / name), draft=draft)
        for _ in print_:
            pass
    expected = tool(gallery / name, "--draft", str(draft))
    assert print_.statistics["complete"]
    for key in ("hash", "size_voxels", "voxels_by_material"):
        assert print_.statistics[key] == expected[key], key


def test_slices_are_those_of_the_array_that_the_tool_writes(gallery: Path, tool: Tool, tmp_path: Path) -> None:
    world = gallery / "gyroid_block" / "gyroid.fab.json"
    tool(world, "--draft", "8", "-o", str(tmp_path / "tool.npy"))
    codes = openfab.print_world(openfab.load(world), draft=8).array()
    np.testing.assert_array_equal(codes, np.load(tmp_path / "tool.npy"))


@pytest.mark.parametrize("suffix", [".ofr", ".npy"])
def test_an_output_has_the_bytes_of_the_tool(gallery: Path, tool: Tool, tmp_path: Path, suffix: str) -> None:
    world = gallery / "gyroid_block" / "gyroid.fab.json"
    tool(world, "--draft", "8", "-o", str(tmp_path / f"tool{suffix}"))
    print_ = openfab.print_world(openfab.load(world), tmp_path / f"mine{suffix}", draft=8)
    assert print_.statistics["complete"]
    made = sorted(path.name for path in tmp_path.iterdir() if path.name.startswith("mine"))
    # The command line keeps a record beside its output, for `openfab archive`.
    files = [path.name for path in tmp_path.iterdir() if not path.name.endswith(".job.json")]
    assert made == sorted(name.replace("tool", "mine") for name in files if name.startswith("tool"))
    assert (tmp_path / f"mine{suffix}").read_bytes() == (tmp_path / f"tool{suffix}").read_bytes()


def test_slices_are_read_only_and_outlive_the_print(ball: openfab.World) -> None:
    print_ = openfab.print_world(ball, voxel=0.2)
    slices = list(print_)
    info = print_.info
    before = [one.codes.sum() for one in slices]
    del print_, ball
    gc.collect()
    assert len(slices) == info.slices[1]
    assert [one.codes.sum() for one in slices] == before
    for one in slices:
        assert one.codes.shape == (info.size[1], info.size[0]) and one.codes.dtype == np.uint8
        assert not one.codes.flags.writeable and not one.codes.flags.owndata
        with pytest.raises(ValueError):
            one.codes[0, 0] = 1


def test_statistics_count_what_the_slices_hold(ball: openfab.World) -> None:
    print_ = openfab.print_world(ball, voxel=0.2)
    codes = print_.array()
    counts = np.bincount(codes.ravel(), minlength=3)
    names = [material.name for material in print_.info.materials]
    assert dict(zip(names, counts[1:])) == print_.statistics["voxels_by_material"]
    assert print_.statistics["title"] == "ball"
    assert 0 < print_.statistics["seconds_first_slice"] <= print_.statistics["seconds_total"]


def test_prints_at_once_do_not_disturb_each_other(ball: openfab.World, gallery: Path) -> None:
    other = openfab.load(gallery / "gyroid_block" / "gyroid.fab.json")
    alone = openfab.print_world(ball, voxel=0.2).array(), openfab.print_world(other, draft=10).array()
    both = openfab.print_world(ball, voxel=0.2), openfab.print_world(other, draft=10)
    iterators = [iter(one) for one in both]
    found: list[list[np.ndarray]] = [[], []]
    live = {0, 1}
    while live:
        for k in sorted(live):
            one = next(iterators[k], None)
            if one is None:
                live.discard(k)
            else:
                found[k].append(one.codes)
    for k in (0, 1):
        np.testing.assert_array_equal(np.stack(found[k]), alone[k])


def test_other_threads_run_while_a_print_is_waited_for(gallery: Path) -> None:
    turns = 0
    over = threading.Event()

    def watch() -> None:
        nonlocal turns
        while not over.is_set():
            time.sleep(0.001)
            turns += 1

    watcher = threading.Thread(target=watch)
    watcher.start()
    array = openfab.print_world(openfab.load(gallery / "gyroid_block" / "gyroid.fab.json"), draft=2).array()
    over.set()
    watcher.join()
    # A lock that is held for each slab of eight slices lets the watcher in between them alone. On a busy machine the watcher
    # sleeps much longer than it asks for.
    assert turns > len(array) // 7


def test_the_print_waits_for_its_reader(ball: openfab.World) -> None:
    slices = iter(openfab.print_world(ball, voxel=0.05, threads=2))
    next(slices)
    time.sleep(0.5)
    (running,) = openfab.printing._running
    done, total = running._core.progress
    assert 0 < done < total
    del slices  # and with it the print
    gc.collect()
    assert not openfab.printing._running


def test_a_loop_that_is_left_ends_the_print(ball: openfab.World) -> None:
    print_ = openfab.print_world(ball, voxel=0.05)
    for one in print_:
        if one.z == 3:
            break
    print_.close()
    assert not print_.statistics["complete"]


def test_slices_are_given_once(ball: openfab.World, tmp_path: Path) -> None:
    taken = openfab.print_world(ball, voxel=0.3)
    assert sum(1 for _ in taken) == taken.info.slices[1]
    left = openfab.print_world(ball, voxel=0.3)
    next(iter(left))
    closed = openfab.print_world(ball, voxel=0.3)
    closed.close()
    for print_ in (taken, left, closed, openfab.print_world(ball, tmp_path / "ball.ofr", voxel=0.3)):
        with pytest.raises(openfab.InputError, match="the slices of the print (were taken|are gone)"):
            print_.array()
        with pytest.raises(openfab.InputError, match="the slices of the print (were taken|are gone)"):
            iter(print_)


def test_an_array_is_whole(ball: openfab.World) -> None:
    print_ = openfab.print_world(ball, voxel=0.05, progress=lambda done, total: print_.close() if done == 3 else None)
    with pytest.raises(openfab.InputError, match="closed after 3 of 120 slices"):
        print_.array()


def test_a_print_that_is_closed_at_once_has_no_grid(ball: openfab.World) -> None:
    print_ = openfab.print_world(ball, voxel=0.05)
    print_.close()
    if print_._core.info["size"] == (0, 0, 0):  # the set-up may have been quicker
        with pytest.raises(openfab.InputError, match="closed before its set-up"):
            print_.info
        assert print_._repr_html_() == "<div>Print(World(&#x27;ball&#x27;, 1 objects, 1 placements), closed)</div>"


def test_uniforms_change_the_print_and_compile_nothing(ball: openfab.World) -> None:
    openfab.print_world(ball, voxel=0.3).array()
    program = openfab.world.snapshot(ball).program()
    thin = openfab.print_world(ball, voxel=0.3, uniforms={"ball.skin": 0.1})
    thin.array()
    ball.objects["ball"]["skin"] = 0.1
    same = openfab.print_world(ball, voxel=0.3)
    same.array()
    assert openfab.world.snapshot(ball).program() is program
    assert thin.statistics["hash"] == same.statistics["hash"]
    assert thin.statistics["voxels_by_material"]["white"] > 0


def test_fractions_are_those_that_the_tool_writes(gallery: Path, tool: Tool, tmp_path: Path) -> None:
    world = gallery / "gyroid_block" / "gyroid.fab.json"
    tool(world, "--draft", "10", "--fractions", str(tmp_path / "mix.npy"), "--sampling", "centre")
    slices = list(openfab.print_world(openfab.load(world), draft=10, fractions=True))
    mine = np.stack([one.fractions for one in slices if one.fractions is not None])
    np.testing.assert_array_equal(mine, np.load(tmp_path / "mix.npy"))


def test_a_box_has_the_mixtures_of_the_whole(gallery: Path) -> None:
    world = openfab.load(gallery / "magic_postcard" / "postcard.fab.json")
    whole = openfab.sample(world, voxel=0.4, sampling="centre")
    assert whole.fractions.max() == 1
    size = np.array(whole.fractions.shape[2::-1])
    rng = np.random.default_rng(7)
    for _ in range(6):
        lo = rng.integers(-3, size - 4)
        hi = np.minimum(lo + rng.integers(1, size), size + 3)
        corner = np.array(whole.origin_mm)
        part = openfab.sample(world, (corner + 0.4 * (lo + 1e-4), corner + 0.4 * (hi - 1e-4)), voxel=0.4, sampling="centre")
        np.testing.assert_allclose(part.origin_mm, corner + 0.4 * lo, atol=1e-9)
        expected = np.zeros((*(hi - lo)[::-1], whole.fractions.shape[3]), np.float32)
        a, b = np.clip(lo, 0, size), np.clip(hi, 0, size)
        inner = tuple(slice(x, y) for x, y in zip((a - lo)[::-1], (b - lo)[::-1]))
        outer = tuple(slice(x, y) for x, y in zip(a[::-1], b[::-1]))
        expected[inner] = whole.fractions[outer]
        np.testing.assert_array_equal(part.fractions, expected)


def test_samples_answer_for_points(ball: openfab.World) -> None:
    samples = openfab.sample(ball, ((-3, -3, 0), (3, 3, 6)), voxel=(0.5, 0.25, 0.5), sampling="centre")
    assert samples.fractions.shape == (12, 24, 12, 2)
    np.testing.assert_allclose(samples.at([(0, 0, 3), (50, 0, 0), (2.9, 2.9, 0.1)]).sum(axis=1), [1, 0, 0])
    density = samples.mean({"white": 2.0, "black": 1.0}, void=0.25)
    assert density[6, 12, 6] == 2 and density[0, 0, 0] == 0.25


def test_previews_are_the_tools_pictures(gallery: Path, tool: Tool, tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    world = gallery / "gyroid_block" / "gyroid.fab.json"
    front, model = tmp_path / "front.png", tmp_path / "model.png"
    tool(world, "--draft", "8", "--preview", f"{front},view=top", "--preview", f"{model},view=model:40:20,cut=x")
    mine = openfab.preview(openfab.load(world), "top", "model:40:20,cut=x", draft=8)
    for picture, file in zip(mine, (front, model)):
        np.testing.assert_array_equal(picture, np.asarray(image.open(file)))


def test_progress_comes_to_its_end(ball: openfab.World, tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []
    openfab.print_world(ball, voxel=0.3, progress=lambda done, total: calls.append((done, total))).array()
    assert calls[-1][0] == calls[-1][1] and calls == sorted(calls)


def test_printf_goes_to_python(ball: openfab.World, capsys: pytest.CaptureFixture[str]) -> None:
    noisy = BALL.replace("return mc;", 'printf("t = %f", t); return mc;')
    world = openfab.World(printer="generic")
    uniforms = {"core": openfab.Material("w", "#ffffff"), "shell": openfab.VOID}
    world.add(openfab.sphere(1), openfab.Fablet(text=noisy), uniforms)
    openfab.print_world(world, voxel=0.3, enable_printf=True).array()
    assert "t = " in capsys.readouterr().out


INTERRUPTED = """
import signal, sys, pathlib, openfab
# Python leaves Ctrl-C ignored where this runs in the background of a script.
signal.signal(signal.SIGINT, signal.default_int_handler)
world = openfab.load(sys.argv[1])
out = pathlib.Path(sys.argv[2]) / "x.ofr" if len(sys.argv) > 2 else None
print("ready", flush=True)
try:
    print_ = openfab.print_world(world, out, draft=1)
    for one in print_:
        print("slice", flush=True)
    print("complete", flush=True)
except KeyboardInterrupt:
    assert not openfab.printing._running
    print("interrupted", flush=True)
"""


@pytest.mark.parametrize("to_file", [False, True])
def test_ctrl_c_ends_cleanly(gallery: Path, tmp_path: Path, to_file: bool) -> None:
    world = gallery / "gyroid_block" / "gyroid.fab.json"
    folder = tmp_path / "out"
    folder.mkdir()
    words = [sys.executable, "-c", INTERRUPTED, str(world), *([str(folder)] if to_file else [])]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "ready\n"
        if not to_file:
            assert program.stdout.readline() == "slice\n"
        else:
            deadline = time.monotonic() + 300  # which only a hang reaches
            while not list(folder.glob(".*/*")) and time.monotonic() < deadline:
                time.sleep(0.01)
        program.send_signal(signal.SIGINT)
        said, _ = program.communicate(timeout=300)
    assert program.returncode == 0
    assert said.splitlines()[-1] == "interrupted"
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"draft": 0}, "draft"),
        ({"voxel": "0.1 parsec"}, "`voxel`"),
        ({"uniforms": {"ball.skn": 1}}, "skn"),
        ({"printer": "nonesuch"}, "nonesuch"),
        ({"slices": (5, 5)}, "`slices`: `5:5` is an empty"),
        ({"out": "ball.xyz"}, "format"),
        ({"out": "nowhere/ball.ofr"}, "nowhere"),
    ],
)
def test_wrong_arguments_are_errors(ball: openfab.World, arguments: dict[str, Any], text: str) -> None:
    with pytest.raises(openfab.Error, match=text):
        openfab.print_world(ball, **{"voxel": 0.5, **arguments}).array()


def test_an_output_spares_the_inputs(tmp_path: Path, gallery: Path) -> None:
    (tmp_path / "ball.fl").write_text(BALL)
    world = openfab.World(printer="generic")
    world.add(
        openfab.sphere(2), openfab.Fablet(tmp_path / "ball.fl"),
        {"core": openfab.Material("w", "#ffffff"), "shell": openfab.VOID},
    )
    with pytest.raises(openfab.InputError, match="overwrite"):
        openfab.print_world(world, tmp_path / "ball.fl", format="ofr", voxel=0.5)
    assert (tmp_path / "ball.fl").read_text().startswith("fablet Ball")


def test_a_notebook_shows_it_without_a_network(ball: openfab.World) -> None:
    assert ball._repr_png_().startswith(b"\x89PNG")
    print_ = openfab.print_world(ball, voxel=0.2)
    assert "voxels of" in print_._repr_html_() and "<img" not in print_._repr_html_()
    print_.array()
    page = print_._repr_html_()
    assert page.count("data:image/png;base64,") == len(print_.thumbnails) + 1
    assert "http" not in page and 'type="range"' in page


def test_statistics_are_json_like(ball: openfab.World) -> None:
    print_ = openfab.print_world(ball, voxel=0.5)
    with pytest.raises(openfab.InputError):
        print_.statistics
    print_.array()
    json.dumps(print_.statistics)
