// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The header of a MetaImage file (.mha, or .mhd with its numbers in a file of their own), as ITK writes it:
// lines `Key = Value`, the last of which is ElementDataFile.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::texture {

struct MetaHeader {
    std::map<std::string, std::string> fields;
    std::vector<std::string> listed;  ///< the lines behind `ElementDataFile = LIST`
    int64_t begin = 0;                ///< offset of the first byte behind it

    /// Returns the value of the first of these keys that it has; empty: of none.
    std::string field(const char* name, const char* other = nullptr,
                      const char* another = nullptr) const;
    /// Returns what it says of its data file or files (data_files.h); empty: they are this one.
    std::string data_file() const;
};

/// Returns whether a file is one by its name.
bool is_meta_image(const std::filesystem::path& file);
/// Reads the lines up to ElementDataFile, at most 1 MB. Fails where there is none.
Result<MetaHeader> read_meta_header(const InputFile& file);

}  // namespace openfab::texture
