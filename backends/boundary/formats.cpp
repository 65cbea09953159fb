// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/formats.h"

#include <fmt/format.h>

#include "backends/boundary/colored_sink.h"
#include "backends/boundary/mesh_sink.h"
#include "backends/boundary/messages.h"
#include "backends/boundary/mixed_sink.h"
#include "backends/boundary/position_index.h"

namespace openfab::boundary {

namespace {

template <std::unique_ptr<MeshWriter> (*make_writer)(const std::filesystem::path&)>
Result<std::unique_ptr<pipeline::SliceSink>> open(const backends::OutputSettings& settings) {
    return std::unique_ptr<pipeline::SliceSink>(
        std::make_unique<MeshSink>(make_writer(settings.path)));
}

/// With colours where somebody has mixtures, and the machine takes them.
Result<std::unique_ptr<pipeline::SliceSink>> open_threemf(
    const backends::OutputSettings& settings) {
    if (settings.mixtures == nullptr) return open<make_threemf_writer>(settings);
    return std::unique_ptr<pipeline::SliceSink>(
        std::make_unique<ColoredSink>(settings.path, settings.mixtures));
}

/// Finished prints have one material a voxel.
Result<std::unique_ptr<pipeline::SliceSink>> open_mixed(const backends::OutputSettings& settings) {
    if (settings.mixtures == nullptr)
        return user_error(messages::kNoMixtures, messages::kNoMixturesHelp);
    return std::unique_ptr<pipeline::SliceSink>(
        std::make_unique<MixedSink>(settings.path, settings.mixtures));
}

std::vector<backends::FormatFile> stl_files(const std::string& path,
                                            const std::vector<pipeline::SliceMaterial>& materials) {
    pipeline::PrintInfo info;
    info.materials = materials;
    std::vector<backends::FormatFile> files;
    for (size_t m = 0; m < materials.size(); ++m)
        files.push_back({stl_path(path, info, m), true});
    return files;
}

/// A 3MF places what it holds; of an STL, slicers leave out what lies below 0.
std::string below_bed(const pipeline::PrintInfo& info) {
    const double lowest = info.origin_mm.z + info.slice_begin * info.pitch_mm.z;
    return lowest < 0 ? fmt::format(messages::kBelowBed, lowest) : "";
}

}  // namespace

const backends::Format kThreemfFormat{
    .name = "3mf",
    .extension = ".3mf",
    .kind = backends::FormatKind::kMesh,
    .not_resumed = messages::kMeshNotResumed,
    .ended_early = messages::kEndedEarly,
    .bytes_per_column = [](size_t) { return kMesherBytesPerColumn; },
    .files = backends::one_renamed_file,
    .open = open_threemf,
    .mixture_bytes_per_column = colored_bytes_per_column,
};

const backends::Format kApartFormat{
    .name = "3mf-apart",
    .extension = ".3mf",
    .kind = backends::FormatKind::kMesh,
    .not_resumed = messages::kMeshNotResumed,
    .ended_early = messages::kEndedEarly,
    // Positions of two planes, where every voxel differs from its neighbours.
    .bytes_per_column =
        [](size_t) { return kMesherBytesPerColumn + PositionIndex::kBytesPerColumn; },
    .files = backends::one_renamed_file,
    .open = open<make_apart_writer>,
};

const backends::Format kFilamentFormat{
    .name = "filament",
    .extension = ".3mf",
    .kind = backends::FormatKind::kMesh,
    .not_resumed = messages::kMeshNotResumed,
    .ended_early = messages::kEndedEarly,
    .bytes_per_column = [](size_t) { return kMesherBytesPerColumn; },
    .files = backends::one_renamed_file,
    .open = open<make_filament_writer>,
};

const backends::Format kMixedFormat{
    .name = "filament-mixed",
    .extension = ".3mf",
    .kind = backends::FormatKind::kMesh,
    .not_resumed = messages::kMeshNotResumed,
    .ended_early = messages::kEndedEarly,
    .bytes_per_column = [](size_t) { return kMesherBytesPerColumn; },
    .files = backends::one_renamed_file,
    .open = open_mixed,
    .mixture_bytes_per_column = mixed_bytes_per_column,
    .needs_mixtures = true,
};

const backends::Format kStlFormat{
    .name = "stl",
    .extension = ".stl",
    .kind = backends::FormatKind::kMesh,
    .not_resumed = messages::kMeshNotResumed,
    .ended_early = messages::kEndedEarly,
    .note = below_bed,
    .bytes_per_column = [](size_t) { return kMesherBytesPerColumn; },
    .files = stl_files,
    .open = open<make_stl_writer>,
};

}  // namespace openfab::boundary
