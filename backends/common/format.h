// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a program must know of an output format. Each backend describes its own; backends/formats has them all.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "backends/common/mixture_inlet.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::backends {

/// What a print says about its output.
struct OutputSettings {
    std::string path;
    bool resume = false;        ///< continues the interrupted print at the path
    std::string grey_material;  ///< that grey pictures are of; empty: the first
    bool png_indexed = false;   ///< with a palette instead of RGBA
    bool flip_x = false;        ///< in pictures +x points left
    bool front_end_makes_support = true;
    /// Through which fractions come, for a machine that takes a mesh's colours; null: none come.
    MixtureInlet* mixtures = nullptr;
    std::string handoff;  ///< the printer's own lines for its operator
};

enum class FormatKind : uint8_t {
    kFile,    ///< one file, with a second one beside it at most
    kFolder,  ///< a folder of pictures, one or several a slice
    kMesh,    ///< boundaries of materials: voxels have a pitch of their own and are not dithered
};

/// A file that an output makes.
struct FormatFile {
    std::filesystem::path path;
    bool renamed = false;  ///< written as `PATH.part` until it is whole
};

struct Format {
    std::string_view name;       ///< as `--format` takes it
    std::string_view extension;  ///< of the output, or of the pictures in its folder; with the dot
    FormatKind kind = FormatKind::kFile;
    bool flips_x = false;      ///< has pictures that `--flip-x` mirrors
    bool has_palette = false;  ///< that `--png indexed` asks for
    /// Has the fractions of one material: `openfab print` makes it of means over parts of voxels, what is
    /// opened here of codes alone.
    bool of_fractions = false;
    bool streams = false;  ///< can go to standard output and to a receiver
    /// Why an interrupted print in it cannot be continued, and the way out; empty: it can.
    std::string_view not_resumed = {};
    /// What a print that ends early says where an output is whole or not there; empty: its slices are kept.
    std::string_view ended_early = {};
    /// What is to be known of a print that is written in it; null, or an empty text: nothing.
    std::string (*note)(const pipeline::PrintInfo& info) = nullptr;
    /// Memory for each voxel of a slice besides the packed rows, for so many materials; null: none.
    int64_t (*bytes_per_column)(size_t materials) = nullptr;
    /// The files of an output; null: the output's path alone.
    std::vector<FormatFile> (*files)(
        const std::string& path, const std::vector<pipeline::SliceMaterial>& materials) = nullptr;
    /// Creates the output, or reopens it to be resumed.
    Result<std::unique_ptr<pipeline::SliceSink>> (*open)(const OutputSettings& settings) = nullptr;
    /// Of a format that has the colours of mixtures: the memory of these, likewise, with so many slices in
    /// flight; null: it has none.
    int64_t (*mixture_bytes_per_column)(int32_t slices) = nullptr;
    bool needs_mixtures =
        false;  ///< for every printer, not only for those that take a mesh's colours
    /// Encodes a slice as the sink does; null where the output is not made slice by slice.
    std::vector<uint8_t> (*encode)(const pipeline::SliceView& slice,
                                   const pipeline::PrintInfo& info,
                                   const OutputSettings& settings) = nullptr;
};

/// Files of an output that is one file, written under another name until it is whole.
inline std::vector<FormatFile> one_renamed_file(const std::string& path,
                                                const std::vector<pipeline::SliceMaterial>&) {
    return {{path, true}};
}

}  // namespace openfab::backends
