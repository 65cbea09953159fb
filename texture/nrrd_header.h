// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The head of an NRRD file, https://teem.sourceforge.net/nrrd/format.html, which the cache needs to
// know the file that holds the data, and the converter for all else.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "base/input_file.h"
#include "base/result.h"
#include "texture/cache.h"

namespace openfab::texture {

struct NrrdHeader {
    std::map<std::string, std::string> fields;
    int64_t begin = 0;  ///< the first byte behind it

    /// What a field says; empty where it is missing.
    std::string field(const std::string& name) const;
    /// The file that holds the data, from the header's folder; empty: this one.
    std::string data_file() const;
};

/// Lines up to the empty one, at most 1 MB of them. An error where the file does not begin as NRRD.
Result<NrrdHeader> read_nrrd_header(const InputFile& file);

/// The file of this name that the header in `file` says its data are in: below the roots, or, where
/// there are none, below the folder of `file` or its project's. Errors do not name `file`.
Result<InputFile> open_data_file(const std::filesystem::path& file, const std::string& name,
                                 const ReadLimits& limits);

}  // namespace openfab::texture
