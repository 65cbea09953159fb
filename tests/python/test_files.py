# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The files behind Python worlds and outputs: their owners and their visibility."""

from __future__ import annotations

import gc
import os
import pickle
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from conftest import BALL

import openfab

WHITE, BLACK = openfab.Material("white", "#ffffff"), openfab.Material("black", "#000000")

BY_PICTURE = """fablet ByPicture {
    @uniform { ImageTexture2D picture; Material one, other; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = picture.Sample1(0.5, 0.5, 0, 0);
        mc.Set(one, t);
        mc.Set(other, 1 - t);
        return mc;
    }
}
"""


def pictured(gray: int) -> openfab.World:
    """Returns a world with a white share of gray / 255."""
    world = openfab.World(printer="generic")
    uniforms = {"picture": np.full((2, 2), gray, np.uint8), "one": WHITE, "other": BLACK}
    world.add(openfab.box(2, 2, 2), openfab.Fablet(text=BY_PICTURE), uniforms, name="box")
    return world


def white(print_: openfab.Print) -> int:
    return int((print_.array() == 1).sum())


def test_a_print_keeps_what_its_world_was(ball: openfab.World) -> None:
    one = ball.objects["ball"]
    hashes = {}
    for skin in (0.2, 1.5):
        one["skin"] = skin
        hashes[skin] = white(openfab.print_world(ball, voxel=0.3))
    assert hashes[0.2] != hashes[1.5]
    for _ in range(8):
        one["skin"] = 0.2
        first = openfab.print_world(ball, voxel=0.3)
        one["skin"] = 1.5
        second = openfab.print_world(ball, voxel=0.3)
        one["skin"] = 0.7
        openfab.print_world(ball, voxel=0.3).close()
        assert (white(first), white(second)) == (hashes[0.2], hashes[1.5])


def test_a_texture_is_there_while_a_print_reads_it() -> None:
    world = pictured(0)
    for _ in range(4):
        world.objects["box"]["picture"] = np.zeros((2, 2), np.uint8)
        print_ = openfab.print_world(world, voxel=0.5)
        world.objects["box"]["picture"] = np.full((2, 2), 255, np.uint8)
        gc.collect()
        assert white(print_) == 0
        assert white(openfab.print_world(world, voxel=0.5)) == 64


def test_prints_of_several_threads_have_their_own_uniforms(ball: openfab.World) -> None:
    skins = [0.2, 0.5, 1.0, 1.5]
    expected = [white(openfab.print_world(ball, voxel=0.3, uniforms={"ball.skin": skin})) for skin in skins]
    found: list[list[int]] = [[] for _ in skins]

    def work(k: int) -> None:
        for _ in range(6):
            found[k].append(white(openfab.print_world(ball, voxel=0.3, uniforms={"ball.skin": skins[k]}, threads=1)))

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(skins))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [[count] * 6 for count in expected] and len(set(expected)) == 4


def test_a_world_may_change_while_it_is_printed(ball: openfab.World) -> None:
    one, over, errors = ball.objects["ball"], threading.Event(), []

    def change() -> None:
        while not over.is_set():
            name = ball.add(openfab.sphere(1), one.fablet, dict(one), translate=(9, 0)).name
            one["skin"] = 0.5 if one["skin"] == 0.8 else 0.8
            ball.remove(name)

    def print_it() -> None:
        try:
            for _ in range(10):
                openfab.print_world(ball, voxel=1, threads=1).array()
        except openfab.Error as error:
            errors.append(error)

    changing = threading.Thread(target=change)
    printing = [threading.Thread(target=print_it) for _ in range(3)]
    for thread in (changing, *printing):
        thread.start()
    for thread in printing:
        thread.join()
    over.set()
    changing.join()
    assert errors == []


def test_files_of_worlds_go_with_their_prints(ball: openfab.World) -> None:
    print_ = openfab.print_world(ball, voxel=1)
    first = print_._snapshot.path
    openfab.print_world(ball, voxel=1).close()
    gc.collect()
    assert first.exists()
    del print_
    gc.collect()
    assert not first.exists() and not first.parent.exists()


AT_ONCE = """
import sys, tempfile, threading, time, openfab
text = sys.argv[1]
make = tempfile.mkdtemp
tempfile.mkdtemp = lambda *args, **keys: (time.sleep(0.1), make(*args, **keys))[1]  # so that the others come meanwhile
begin, errors = threading.Barrier(8), []
sys.setswitchinterval(1e-6)
def work(k):
    try:
        world = openfab.World(printer="generic", title="same")
        white, black = openfab.Material("white", "#ffffff"), openfab.Material("black", "#000000")
        world.add(openfab.sphere(2), openfab.Fablet(text=text), {"core": white, "shell": black})
        begin.wait()
        openfab.print_world(world, voxel=0.5, threads=1).array()
    except BaseException as error:
        errors.append(error)
threads = [threading.Thread(target=work, args=(k,)) for k in range(8)]
for thread in threads: thread.start()
for thread in threads: thread.join()
print(errors)
"""


def test_the_first_use_may_be_of_several_threads() -> None:
    program = [sys.executable, "-c", AT_ONCE, BALL]
    assert subprocess.run(program, capture_output=True, text=True, timeout=300).stdout == "[]\n"


FORKED = """
import multiprocessing, os, sys, openfab
world = openfab.World(printer="generic")
white, black = openfab.Material("white", "#ffffff"), openfab.Material("black", "#000000")
tetrahedron = openfab.Mesh([(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
world.add(tetrahedron, openfab.compile(text=sys.argv[1]), {"core": white, "shell": black})
def report(queue):
    array = openfab.print_world(world, voxel=0.1).array()
    queue.put((int(array.astype(bool).sum()), str(openfab._files.folder())))
context = multiprocessing.get_context("fork")
worker = context.Process(target=report, args=(queue := context.Queue(),))
worker.start()
(count, folder), _ = queue.get(timeout=300), worker.join()
print(os.path.exists(folder))
print((openfab.print_world(world, voxel=0.1).array() > 0).sum() == count)
running = openfab.print_world(world, voxel=0.01)
next(slices := iter(running))
child = os.fork()
if child == 0:
    try:
        openfab.print_world(world, voxel=0.1)
    except openfab.InputError as error:
        sys.exit(7 if "spawn" in str(error) else 1)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
print((openfab.print_world(world, voxel=0.1).array() > 0).sum() == count)
print(sum(1 for _ in slices) + 1 == running.info.slices[1], openfab._files.folder())
"""


def test_a_forked_child_leaves_the_files_of_its_parent() -> None:
    program = [sys.executable, "-c", FORKED, BALL]
    said = subprocess.run(program, capture_output=True, text=True, timeout=300).stdout.split()
    assert said[:5] == ["False", "True", "7", "True", "True"]
    assert not Path(said[5]).exists()


def test_a_label_is_no_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.fl").write_text("fablet Other {")
    for label in (f"{tmp_path}/there.fl", f"{tmp_path}/new.fl", "../new.fl", "..", "a\0b", "x" * 300, "/"):
        hashes = []
        for share in (1, 0.5):  # another text under the same label
            fablet = openfab.Fablet(text=BALL.replace("mc.Set(core, t)", f"mc.Set(core, {share})"), label=label)
            assert fablet.source().is_relative_to(openfab._files.folder())
            world = openfab.World(printer="generic")
            world.add(openfab.sphere(2), fablet, {"core": WHITE, "shell": BLACK})
            hashes.append(white(openfab.print_world(world, voxel=0.5)))
        assert hashes[0] > hashes[1]
    assert [path.name for path in tmp_path.iterdir()] == ["there.fl"]
    with pytest.raises(openfab.InputError, match="`label` is empty"):
        openfab.Fablet(text=BALL, label="")


def test_a_title_is_no_path() -> None:
    for title in ("", "..", "a/b", "x" * 300):
        world = openfab.World(printer="generic", title=title)
        world.add(openfab.sphere(2), openfab.Fablet(text=BALL), {"core": WHITE, "shell": BLACK})
        assert openfab.print_world(world, voxel=0.5).info.size == (4, 4, 4)


def test_uniforms_of_a_print_take_textures_and_materials() -> None:
    world = pictured(0)
    for picture in (np.full((2, 2), 255, np.uint8), openfab.Texture(np.ones((2, 2)))):
        assert white(openfab.print_world(world, voxel=0.5, uniforms={"box.picture": picture})) == 64
    print_ = openfab.print_world(world, voxel=0.5, uniforms={"box.other": openfab.Material("red", "#ff0000")})
    assert (print_.array() == 3).all()
    assert [material.name for material in print_.info.materials] == ["white", "black", "red"]
    assert white(openfab.print_world(world, voxel=0.5)) == 0


def test_textures_do_not_reach_a_file(gallery: Path) -> None:
    world = openfab.load(gallery / "magic_postcard" / "postcard.fab.json")
    with pytest.raises(openfab.InputError, match="textures of Python do not reach .* postcard.fab.json names"):
        openfab.print_world(world, uniforms={"card.picture": openfab.Texture(np.zeros((2, 2)))})


def test_worlds_can_be_pickled() -> None:
    world = pictured(128)
    vertices, faces = [(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    one = world.objects["box"]
    mesh = openfab.Mesh(vertices, faces, vertex_attributes={"s": range(4)})
    world.add(mesh, one.fablet, dict(one), translate=(3, 0, 0))
    expected = openfab.print_world(world, voxel=0.5).array()
    again = pickle.loads(pickle.dumps(world))
    del world, one, mesh
    gc.collect()
    np.testing.assert_array_equal(openfab.print_world(again, voxel=0.5).array(), expected)
    assert not next(iter(again.objects.values()))["picture"].file
    assert not list(again.objects.values())[1].mesh.vertices.flags.writeable


# Outputs


def test_a_name_with_a_slash_is_a_folder(ball: openfab.World, tmp_path: Path) -> None:
    for name in ("q.ofr/", "a.xyz/", "plain"):
        openfab.print_world(ball, f"{tmp_path}/{name}", printer="j750", voxel=0.5)
        assert (tmp_path / name).is_dir() and list((tmp_path / name).glob("slice_*.png"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.xyz", "plain", "q.ofr"]
    (tmp_path / "file.ofr").write_text("kept")
    with pytest.raises(openfab.Error, match=f"`{tmp_path}/file.ofr/`"):
        openfab.print_world(ball, f"{tmp_path}/file.ofr/", printer="j750", voxel=0.5)
    with pytest.raises(openfab.Error, match=f"`{tmp_path}/other.ofr/`: Is a directory"):
        openfab.print_world(ball, f"{tmp_path}/other.ofr/", format="ofr", voxel=0.5)
    assert (tmp_path / "file.ofr").read_text() == "kept"


@pytest.mark.parametrize("suffix", [".ofr", ".npy"])
def test_an_output_goes_through_a_link(ball: openfab.World, tmp_path: Path, suffix: str) -> None:
    (tmp_path / "real").mkdir()
    for name, before in (("there", b"before"), ("none", None)):
        real, link = tmp_path / "real" / f"{name}{suffix}", tmp_path / f"{name}{suffix}"
        if before is not None:
            real.write_bytes(before)
        link.symlink_to(real)
        openfab.print_world(ball, link, voxel=0.5)
        assert link.is_symlink() and real.stat().st_size > 100
    assert not list(tmp_path.glob("**/.*"))
    assert len(list((tmp_path / "real").iterdir())) == 2  # what goes with an array is beside its name


def test_pipes_and_devices_are_written_to(ball: openfab.World, tmp_path: Path) -> None:
    openfab.print_world(ball, tmp_path / "file.ofr", voxel=0.5)
    pipe, received = tmp_path / "pipe.ofr", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: received.append(pipe.read_bytes()))
    reader.start()
    openfab.print_world(ball, pipe, voxel=0.5)
    reader.join(timeout=300)
    assert received == [(tmp_path / "file.ofr").read_bytes()] and pipe.is_fifo()
    code = "import sys, pickle, openfab; openfab.print_world(pickle.load(sys.stdin.buffer), '-', voxel=0.5)"
    done = subprocess.run([sys.executable, "-c", code], input=pickle.dumps(ball), capture_output=True, timeout=300)
    assert done.stdout == received[0]


def test_a_folder_that_takes_no_files_is_an_outside_error(ball: openfab.World) -> None:
    with pytest.raises(openfab.OutsideError, match="^`/proc/ball.ofr` cannot be written"):
        openfab.print_world(ball, "/proc/ball.ofr", voxel=0.5)


def test_progress_of_a_file_comes_to_its_end(ball: openfab.World, tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []
    openfab.print_world(ball, tmp_path / "a.ofr", voxel=0.1, progress=lambda done, of: calls.append((done, of)))
    assert calls[-1] == (60, 60) and calls == sorted(calls)
