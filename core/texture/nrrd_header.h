// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The header of an NRRD file, https://teem.sourceforge.net/nrrd/format.html. The cache reads the
// name of the data file from it, the converter everything else.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"
#include "texture/cache.h"

namespace openfab::texture {

struct NrrdHeader {
    std::map<std::string, std::string> fields;  ///< by their names in lower case
    std::vector<std::string> listed;            ///< the lines behind `data file: LIST`
    int64_t begin = 0;                          ///< offset of the first byte behind it

    /// Returns the value of a field; empty where it is missing.
    std::string field(const std::string& name) const;
    /// Returns what it says of its data file or files (data_files.h); empty: they are this one.
    std::string data_file() const;
};

/// Reads the lines up to the empty one, at most 1 MB. Fails where the file is not NRRD.
Result<NrrdHeader> read_nrrd_header(const InputFile& file);

/// Opens the data file `name` of the header in `file`, which must lie below the roots or, where
/// there are none, below the folder of `file` or its project's. Errors do not name `file`.
Result<InputFile> open_data_file(const std::filesystem::path& file, const std::string& name,
                                 const ReadLimits& limits);

}  // namespace openfab::texture
