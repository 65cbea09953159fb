// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the pixels of a DICOM file are stored (PS3.5, chapter 10), also in ways that the library does not
// know: it gives up at them, though the rest of such a file is like that of others.

#include <istream>
#include <memory>
#include <string>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

enum class Packing {
    kPlain,
    kDeflatedFile,    ///< all that follows the first elements
    kCodec,           ///< JPEG, RLE and the like
    kRawFrames,       ///< in items, as they are
    kDeflatedFrames,  ///< in items, each by itself
    kUnread,
};

struct TransferSyntax {
    std::string identifier;
    Packing packing = Packing::kPlain;
    std::string codec;  ///< the identifier by which the library decodes frames
    std::string name;   ///< of what is not read
    bool is_big_endian = false;
};

/// Returns the identifier that a file's first elements state; empty where there is none.
std::string stated_syntax(const InputFile& file);

/// Likewise what kind of object the file is (its SOP class), also of a file whose other elements are damaged.
std::string stated_class(const InputFile& file);

/// Says how pixels of this identifier are stored.
TransferSyntax transfer_syntax(const std::string& identifier);

/// Whether the library reads the elements of such files; of others, see open_renamed.
bool is_known_to_library(const std::string& identifier);

/// Opens the file as one of a syntax of the same elements that the library knows. Takes memory for all of it.
Result<std::unique_ptr<std::istream>> open_renamed(const InputFile& file,
                                                   const std::string& identifier,
                                                   int64_t memory_bytes);

}  // namespace openfab::tools
