# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""DICOM written by pydicom and highdicom: each voxel has the number that was written, where it was written, or is refused.

Needs a build with the reader: OPENFAB_TOOL=build/optional/bin/openfab scripts/test-import -k dicom."""

from __future__ import annotations

import itertools
from pathlib import Path

import highdicom
import numpy as np
import pydicom
import pytest
from conftest import TOOL, run
from highdicom.sr.coding import CodedConcept
from oftx import Refused, volume
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset
from pydicom.sr.codedict import codes
from pydicom.uid import (
    CTImageStorage,
    DeflatedExplicitVRLittleEndian,
    ExplicitVRBigEndian,
    ExplicitVRLittleEndian,
    ImplicitVRLittleEndian,
    JPEG2000Lossless,
    JPEGLSLossless,
    RLELossless,
    generate_uid,
)

pytestmark = pytest.mark.skipif(
    not TOOL.with_name("openfab-texture-dicom").exists(), reason="this build has no reader of DICOM"
)

SHAPE = (5, 7, 6)  # z, y, x
STEP = (3.0, 0.75, 0.5)  # mm
FIRST = (-10.0, 20.0, 30.0)  # mm, x, y and z
SYNTAXES = [ImplicitVRLittleEndian, ExplicitVRLittleEndian, ExplicitVRBigEndian, DeflatedExplicitVRLittleEndian,
            RLELossless, JPEG2000Lossless, JPEGLSLossless]
# bits allocated, bits stored, signed
KINDS = [(8, 8, 0), (16, 16, 0), (16, 16, 1), (16, 12, 0), (16, 12, 1), (32, 32, 0), (32, 32, 1)]
AXES = [(np.array(across), np.array(down)) for across, down in itertools.permutations(
    [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], 2) if np.dot(across, down) == 0]


def slices(stored: np.ndarray, across=(1, 0, 0), down=(0, 1, 0), slope=1.0, intercept=0.0, bits=16, signed=0, kept=None):
    """Returns a data set for each plane, not compressed."""
    series, study, frame = generate_uid(), generate_uid(), generate_uid()
    across, down = np.array(across, float), np.array(down, float)
    out = []
    for k, plane in enumerate(stored):
        data = FileDataset("", {}, file_meta=FileMetaDataset(), preamble=bytes(128))
        data.file_meta.MediaStorageSOPClassUID = data.SOPClassUID = CTImageStorage
        data.file_meta.MediaStorageSOPInstanceUID = data.SOPInstanceUID = generate_uid()
        data.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
        data.Modality, data.SeriesInstanceUID, data.StudyInstanceUID = "CT", series, study
        data.FrameOfReferenceUID, data.SeriesNumber, data.InstanceNumber = frame, 1, k + 1
        data.PatientID, data.PatientName, data.PatientBirthDate, data.PatientSex = "1", "a", "", ""
        data.StudyID, data.AccessionNumber, data.StudyDate, data.StudyTime = "1", "1", "20240105", "120000"
        data.ReferringPhysicianName = ""
        data.ImageOrientationPatient = [*map(float, across), *map(float, down)]
        data.ImagePositionPatient = [*map(float, np.array(FIRST) + k * STEP[0] * np.cross(across, down))]
        data.PixelSpacing, data.SliceThickness = [STEP[1], STEP[2]], STEP[0]
        data.Rows, data.Columns = plane.shape
        data.SamplesPerPixel, data.PhotometricInterpretation = 1, "MONOCHROME2"
        data.BitsAllocated, data.BitsStored = bits, kept or bits
        data.HighBit, data.PixelRepresentation = data.BitsStored - 1, signed
        data.RescaleSlope, data.RescaleIntercept = slope, intercept
        data.PixelData = plane.astype(f"<{'i' if signed else 'u'}{bits // 8}").tobytes()
        data["PixelData"].VR = "OB" if bits == 8 else "OW"
        out.append(data)
    return out


def write(folder: Path, data: list, syntax=ExplicitVRLittleEndian, order=None) -> Path:
    folder.mkdir()
    for k, one in enumerate(data):
        if syntax.is_compressed and syntax != DeflatedExplicitVRLittleEndian:
            one.compress(syntax, generate_instance_uid=False)
        elif syntax == ExplicitVRBigEndian:
            width = one.BitsAllocated // 8
            one.PixelData = np.frombuffer(one.PixelData, f"<u{width}").astype(f">u{width}").tobytes()
        one.file_meta.TransferSyntaxUID = syntax
        name = f"IM{order[k] if order is not None else k:03}"
        one.save_as(folder / name, enforce_file_format=True, little_endian=syntax.is_little_endian,
                    implicit_vr=syntax.is_implicit_VR)
    return folder


def numbers(bits: int, kept: int, signed: int, seed: int = 1) -> np.ndarray:
    """Returns numbers of all bits, of which a float holds each."""
    kept = min(kept, 24)
    low = -(1 << kept - 1) if signed else 0
    drawn = np.random.default_rng(seed).integers(low, low + (1 << kept), SHAPE)
    drawn[0, 0, :2] = low, low + (1 << kept) - 1
    return drawn


@pytest.mark.parametrize("syntax", SYNTAXES, ids=lambda s: s.name)
@pytest.mark.parametrize("bits, kept, signed", KINDS)
def test_each_cell(tmp_path, syntax, bits, kept, signed):
    stored = numbers(bits, kept, signed)
    order = np.random.default_rng(2).permutation(len(stored))  # names say nothing of places
    try:
        folder = write(tmp_path / "scan", slices(stored, slope=0.5, intercept=-1024, bits=bits, signed=signed, kept=kept),
                       syntax, order)
    except (ValueError, NotImplementedError, RuntimeError) as trouble:
        pytest.skip(f"pydicom does not write it: {trouble}")
    back = pydicom.dcmread(folder / f"IM{order[1]:03}")
    if not np.array_equal(back.pixel_array, stored[1]):
        pytest.skip("pydicom does not read back what it wrote")
    try:
        seen = volume(folder)
    except Refused as refused:
        assert bits == 32 and syntax in (JPEG2000Lossless, JPEGLSLossless, RLELossless), str(refused)
        return
    wanted = (stored * 0.5 - 1024).astype(np.float32)
    assert np.array_equal(seen.values[..., 0], wanted)
    assert np.allclose(seen.extent, (6 * STEP[2], 7 * STEP[1], 5 * STEP[0]))
    assert np.allclose(seen.origin, np.array(FIRST) - np.array(STEP[::-1]) / 2)


@pytest.mark.parametrize("across, down", AXES)
def test_axes_are_put_in_order(tmp_path, across, down):
    stored = numbers(16, 16, 1)
    seen = volume(write(tmp_path / "scan", slices(stored, across, down, signed=1)))
    normal = np.cross(across, down)
    for k, j, i in np.ndindex(*SHAPE):
        at = np.array(FIRST) + across * i * STEP[2] + down * j * STEP[1] + normal * k * STEP[0]
        sides = np.array(seen.values.shape[2::-1])
        index = (at - seen.origin) / (np.array(seen.extent) / sides) - 0.5
        x, y, z = np.round(index).astype(int)
        assert np.abs(index - (x, y, z)).max() < 1e-4
        assert seen.values[z, y, x, 0] == stored[k, j, i]


def test_columns_of_a_wide_scan_but_for_the_sixth_decimal(tmp_path):
    stored = np.arange(2 * 2 * 512).reshape(2, 2, 512)
    for k, (aside, straight) in enumerate([(1e-6, True), (5e-6, False)]):
        folder = write(tmp_path / f"scan{k}", slices(stored, (1, aside, 0), (-aside, 1, 0)))
        if straight:
            assert np.array_equal(volume(folder).values[..., 0], stored)
        else:
            with pytest.raises(Refused, match="outside"):
                volume(folder)


def test_tilted_slices_are_interpolated(tmp_path):
    turn = np.radians(30)
    across, down = (np.cos(turn), np.sin(turn), 0), (-np.sin(turn), np.cos(turn), 0)
    k, j, i = np.mgrid[: SHAPE[0], : SHAPE[1], : SHAPE[2]]
    folder = write(tmp_path / "scan", slices(2 * i + 3 * j + 5 * k, across, down))
    seen = volume(folder, "--outside=-1000", "--pitch=0.25mm")
    sides = np.array(seen.values.shape[2::-1])
    z, y, x = np.mgrid[: sides[2], : sides[1], : sides[0]]
    at = np.stack([x, y, z], -1) + 0.5
    index = (seen.origin + at * np.array(seen.extent) / sides - FIRST) @ np.stack([across, down, np.cross(across, down)], 1)
    index /= np.array(STEP[::-1])
    inside = np.all((index >= 0) & (index <= np.array(SHAPE[::-1]) - 1), -1)
    assert inside.any()
    assert np.abs(seen.values[..., 0] - index @ (2, 3, 5))[inside].max() < 1e-5 * 40
    assert seen.values[..., 0][np.any(index < -2, -1)].max() == -1000


@pytest.mark.parametrize("kind", ["BINARY", "FRACTIONAL", "LABELMAP"])
@pytest.mark.parametrize("omit", [False, True])
@pytest.mark.parametrize("syntax", [ExplicitVRLittleEndian, RLELossless], ids=lambda s: s.name)
def test_segmentations(tmp_path, kind, omit, syntax):
    if kind == "BINARY" and syntax == RLELossless:
        pytest.skip("bits are not compressed")
    source = slices(np.zeros(SHAPE, int))
    random = np.random.default_rng(3)
    labels = random.integers(0, 3, SHAPE).astype("uint8")
    labels[2] = 0  # an empty plane between others
    names = ["bone", "tissue"]
    described = [
        highdicom.seg.SegmentDescription(
            k + 1, name, codes.SCT.MorphologicallyAbnormalStructure, codes.SCT.Bone, "MANUAL"
        )
        for k, name in enumerate(names)
    ]
    pixels = labels
    if kind == "FRACTIONAL":
        pixels = np.stack([labels == 1, (labels == 2) * 0.5], -1).astype("float32")
    made = highdicom.seg.Segmentation(
        source, pixels, kind, described, generate_uid(), 2, generate_uid(), 1, "a", "b", "1", "1",
        omit_empty_frames=omit, max_fractional_value=200, transfer_syntax_uid=syntax,
    )
    file = tmp_path / "seg.dcm"
    made.save_as(file)
    if kind == "LABELMAP":
        whole = volume(file)
        assert np.array_equal(whole.values[..., 0], labels)
    else:
        with pytest.raises(Refused, match="bone.*tissue"):
            volume(file)
    for number, name in enumerate(names, 1):
        wanted = (labels == number) * (100 / 200 if kind == "FRACTIONAL" and number == 2 else 1)
        for chosen in (name, str(number)):
            seen = volume(file, f"--segment={chosen}")
            assert np.allclose(seen.values[..., 0], wanted, rtol=1e-7, atol=0)
            assert np.allclose(seen.origin, np.array(FIRST) - np.array(STEP[::-1]) / 2)
    told = run("import", file, "-o", tmp_path / "world")
    assert "2 segments" in told


@pytest.mark.parametrize("kind", ["float32", "float64", "uint16"])
def test_parametric_maps(tmp_path, kind):
    values = np.random.default_rng(5).integers(0, 1000, SHAPE).astype(kind)
    if kind != "uint16":
        values = values / np.array(8, kind)
    mapping = highdicom.pm.RealWorldValueMapping(
        "a", "b", CodedConcept("1", "99X", "no unit"), (0, 10000) if kind == "uint16" else (0.0, 10000.0), slope=0.25, intercept=-3
    )
    made = highdicom.pm.ParametricMap(
        slices(np.zeros(SHAPE, int)), values, generate_uid(), 3, generate_uid(), 1, "a", "b", "1", "1",
        contains_recognizable_visual_features=False, real_world_value_mappings=[mapping],
        window_center=1, window_width=1,
    )
    file = tmp_path / "map.dcm"
    made.save_as(file)
    assert np.array_equal(volume(file).values[..., 0], (values * 0.25 - 3).astype("float32"))


def test_frames_of_other_times_are_chosen(tmp_path):
    data = slices(numbers(16, 12, 0)[:1])[0]
    data.SOPClassUID = data.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.4.1"  # Enhanced MR
    stored = np.stack([np.full(SHAPE[1:], 10 * (2 * t + z)) for t, z in itertools.product(range(3), range(2))])
    shared = Dataset()
    shared.PlaneOrientationSequence = [Dataset()]
    shared.PlaneOrientationSequence[0].ImageOrientationPatient = data.ImageOrientationPatient
    shared.PixelMeasuresSequence = [Dataset()]
    shared.PixelMeasuresSequence[0].PixelSpacing = data.PixelSpacing
    shared.PixelMeasuresSequence[0].SliceThickness = STEP[0]
    frames = []
    for t, z in itertools.product(range(3), range(2)):
        frame = Dataset()
        frame.PlanePositionSequence = [Dataset()]
        frame.PlanePositionSequence[0].ImagePositionPatient = [FIRST[0], FIRST[1], FIRST[2] + STEP[0] * z]
        frame.FrameContentSequence = [Dataset()]
        frame.FrameContentSequence[0].TemporalPositionIndex = t + 1
        frame.FrameContentSequence[0].DimensionIndexValues = [t + 1, z + 1]
        frames.append(frame)
    data.SharedFunctionalGroupsSequence, data.PerFrameFunctionalGroupsSequence = [shared], frames
    for name in ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing"):
        delattr(data, name)
    data.RescaleSlope, data.RescaleIntercept = 1, 0
    data.NumberOfFrames, data.PixelData = len(frames), stored.astype("<u2").tobytes()
    folder = write(tmp_path / "scan", [data])
    with pytest.raises(Refused, match="1, 2, 3.*`time`"):
        volume(folder)
    for t in range(3):
        seen = volume(folder, f"--time={t + 1}")
        assert np.array_equal(seen.values[:, 0, 0, 0], [20 * t, 20 * t + 10])
    with pytest.raises(Refused):
        volume(folder, "--time=4")
