// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volumes whose libraries are optional: which program converts them, and how it is started.

#include <filesystem>

#include "base/result.h"
#include "texture/volume.h"

namespace openfab::tools {

struct OptionalConverter {
    const char* program;  ///< beside this one, where its library was found
    const char* what;     ///< it reads
    const char* remedy;   ///< where it is missing
};

/// Returns the converter that a volume needs, by its first bytes, else by its name; nullptr where this
/// program reads it. XDMF needs one where any of the numbers of the step that the options name are in an HDF5
/// file, and so does VTKHDF. A folder is DICOM where one of its files is.
const OptionalConverter* optional_converter(const std::filesystem::path& volume,
                                            const texture::VolumeOptions& options);

/// Replaces the process by the converter, with the same arguments. Returns only where that fails: a
/// converter that was not built is an error that names what to install.
Error execute(const OptionalConverter& converter, char** argv);

}  // namespace openfab::tools
