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

/// What all formats of meshes have.
constexpr backends::Format mesh_format(std::string_view name, std::string_view extension,
                                       decltype(backends::Format::open) open) {
    backends::Format format;
    format.name = name;
    format.extension = extension;
    format.kind = backends::FormatKind::kMesh;
    format.not_resumed = messages::kMeshNotResumed;
    format.ended_early = messages::kEndedEarly;
    format.bytes_per_column = [](size_t) { return kMesherBytesPerColumn; };
    format.files = backends::one_renamed_file;
    format.open = open;
    return format;
}

constexpr backends::Format threemf_format() {
    backends::Format format = mesh_format("3mf", ".3mf", open_threemf);
    format.mixture_bytes_per_column = colored_bytes_per_column;
    return format;
}

/// Positions of two planes, where every voxel differs from its neighbours.
constexpr backends::Format apart_format() {
    backends::Format format = mesh_format("3mf-apart", ".3mf", open<make_apart_writer>);
    format.bytes_per_column = [](size_t) {
        return kMesherBytesPerColumn + PositionIndex::kBytesPerColumn;
    };
    return format;
}

constexpr backends::Format mixed_format() {
    backends::Format format = mesh_format("filament-mixed", ".3mf", open_mixed);
    format.mixture_bytes_per_column = mixed_bytes_per_column;
    format.needs_mixtures = true;
    return format;
}

constexpr backends::Format stl_format() {
    backends::Format format = mesh_format("stl", ".stl", open<make_stl_writer>);
    format.note = below_bed;
    format.files = stl_files;
    return format;
}

}  // namespace

constinit const backends::Format kThreemfFormat = threemf_format();
constinit const backends::Format kApartFormat = apart_format();
constinit const backends::Format kFilamentFormat =
    mesh_format("filament", ".3mf", open<make_filament_writer>);
constinit const backends::Format kMixedFormat = mixed_format();
constinit const backends::Format kStlFormat = stl_format();

}  // namespace openfab::boundary
