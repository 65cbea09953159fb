// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/hdf5_kind.h"

#include <array>
#include <string>
#include <string_view>

namespace openfab::tools {

bool is_hdf5(const InputFile& file) {
    constexpr std::string_view kSignature("\x89HDF\r\n\x1a\n");
    for (int64_t at = 0; at < file.bytes(); at = at == 0 ? 512 : 2 * at) {
        std::array<char, kSignature.size()> bytes{};
        const Result<size_t> got = file.read(at, bytes.data(), bytes.size());
        if (got && std::string_view(bytes.data(), *got) == kSignature) return true;
    }
    return false;
}

bool is_vtk_hdf(const InputFile& file) {
    if (!is_hdf5(file)) return false;
    std::string begin(1 << 16, '\0');
    const Result<size_t> got = file.read(0, begin.data(), begin.size());
    return got && begin.substr(0, *got).find("VTKHDF") != std::string::npos;
}

}  // namespace openfab::tools
