// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The command line that all converters of textures share: `openfab-texture`, and the optional ones of
// volumes, to which it passes its own arguments on.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "base/result.h"
#include "texture/volume.h"

namespace openfab::tools {

struct TextureJob {
    std::string input, output;
    bool is_volume = false;
    bool check = false;  ///< nothing is written; `output` is empty
    texture::VolumeOptions options;
    texture::ReadLimits limits;
};

/// Parses the arguments. Returns the exit code where the program is to end now, having said why.
std::optional<int> parse_texture_job(int argc, char** argv, TextureJob* job);

using MakeVolume = Result<void>(const std::filesystem::path& source,
                                const std::filesystem::path& out,
                                const texture::VolumeOptions& options,
                                const texture::ReadLimits& limits);
/// What an optional converter does, whose library may crash (guarded.h). Returns the exit code.
int convert_guarded(int argc, char** argv, MakeVolume* make);

/// Calls `make` while standard error is closed, as libraries write to it what is reported from their
/// results. Returns the exit code, having said what went wrong.
int do_quietly(const std::function<Result<void>()>& make);

}  // namespace openfab::tools
