# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints to object storage, against a server of the tests' own that speaks S3."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from s3_server import S3Server

import openfab

distributed = pytest.importorskip("distributed")
pytest.importorskip("s3fs")

from openfab import distributed as over  # noqa: E402

# Half and half, so that slices do not get smaller than a bit a voxel.
MIXED = """fablet Mixed {
    @uniform { Material one, other; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(one, 0.5);
        mc.Set(other, 0.5);
        return mc;
    }
}
"""


@pytest.fixture
def storage(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[S3Server]:
    with S3Server("prints") as server:
        for name, value in {
            "AWS_ENDPOINT_URL": server.url, "AWS_ACCESS_KEY_ID": "a", "AWS_SECRET_ACCESS_KEY": "b",
            "AWS_DEFAULT_REGION": "us-east-1", "AWS_CONFIG_FILE": str(tmp_path / "none"),
            "AWS_SHARED_CREDENTIALS_FILE": str(tmp_path / "none"), "AWS_MAX_ATTEMPTS": "1",
        }.items():
            monkeypatch.setenv(name, value)
        import fsspec

        monkeypatch.setitem(fsspec.config.conf, "s3", {"default_block_size": 5 << 20})
        yield server


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def test_a_file_on_s3_has_the_bytes_of_one_process(
    client: Any, ball: openfab.World, storage: S3Server, tmp_path: Path
) -> None:
    openfab.print_world(ball, tmp_path / "alone.ofr", voxel=0.2)
    over.print_world(ball, client, "s3://prints/some/ball.ofr", voxel=0.2)
    assert storage.objects == {("prints", "some/ball.ofr"): (tmp_path / "alone.ofr").read_bytes()}


def test_a_large_file_goes_in_parts(client: Any, storage: S3Server, tmp_path: Path) -> None:
    world = openfab.World(printer="generic")
    one, other = openfab.Material("one", "#ffffff"), openfab.Material("other", "#000000")
    world.add(openfab.box(8, 8, 8), openfab.Fablet(text=MIXED), {"one": one, "other": other})
    openfab.print_world(world, tmp_path / "alone.ofr", voxel=0.02, dither="decorrelated")
    alone = (tmp_path / "alone.ofr").read_bytes()
    assert len(alone) > 6 << 20
    over.print_world(world, client, "s3://prints/large.ofr", voxel=0.02, dither="decorrelated")
    assert storage.objects["prints", "large.ofr"] == alone and storage.in_parts == 1 and not storage.uploads

    def stop(done: int, total: int) -> None:
        if done > total * 0.9:
            raise RuntimeError("enough")

    # One that ends early leaves the object that was there, and no open upload.
    with pytest.raises(RuntimeError, match="enough"):
        over.print_world(world, client, "s3://prints/large.ofr", voxel=0.02, seed=3, progress=stop)
    assert storage.objects["prints", "large.ofr"] == alone and not storage.uploads


def test_a_folder_on_s3_has_the_files_of_one_process(
    client: Any, ball: openfab.World, storage: S3Server, tmp_path: Path
) -> None:
    openfab.print_world(ball, tmp_path / "alone", voxel=0.4, format="png")
    over.print_world(ball, client, "s3://prints/slices", voxel=0.4, format="png")
    assert storage.objects == {
        ("prints", f"slices/{path.name}"): path.read_bytes() for path in (tmp_path / "alone").iterdir()
    }


@pytest.mark.parametrize("out", ["s3://nowhere/ball.ofr", "s3://nowhere/slices", "s3://prints/ball.ofr"])
def test_storage_that_refuses_is_an_error(client: Any, ball: openfab.World, storage: S3Server, out: str) -> None:
    storage.refuses = out.startswith("s3://prints")
    with pytest.raises(openfab.OutsideError, match=f"`{out}` cannot be written"):
        over.print_world(ball, client, out, voxel=0.5, format="ofr" if out.endswith(".ofr") else "png")
    assert not storage.objects and not storage.uploads
