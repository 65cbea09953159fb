// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/meshes/zip_archive.h"

#include <libdeflate.h>

#include <cstdint>

namespace openfab::testing {

namespace {

template <typename T>
void append(std::string* bytes, T value) {
    bytes->append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string zip_archive(const std::vector<std::pair<std::string, std::string>>& files) {
    std::string out;
    std::string directory;
    for (const auto& [name, content] : files) {
        std::string packed = content;
        const bool deflated = !directory.empty();
        if (deflated) {
            libdeflate_compressor* compressor = libdeflate_alloc_compressor(6);
            packed.resize(libdeflate_deflate_compress_bound(compressor, content.size()));
            packed.resize(libdeflate_deflate_compress(compressor, content.data(), content.size(),
                                                      packed.data(), packed.size()));
            libdeflate_free_compressor(compressor);
        }
        std::string common;
        append(&common, uint16_t{20});
        append(&common, uint16_t{0});
        append(&common, static_cast<uint16_t>(deflated ? 8 : 0));
        append(&common, uint32_t{0});
        append(&common, libdeflate_crc32(0, content.data(), content.size()));
        append(&common, static_cast<uint32_t>(packed.size()));
        append(&common, static_cast<uint32_t>(content.size()));
        append(&common, static_cast<uint16_t>(name.size()));
        append(&common, uint16_t{0});
        directory += std::string("PK\1\2\24\0", 6) + common;
        append(&directory, uint16_t{0});
        append(&directory, uint16_t{0});
        append(&directory, uint16_t{0});
        append(&directory, uint32_t{0});
        append(&directory, static_cast<uint32_t>(out.size()));
        directory += name;
        out += "PK\3\4" + common + name + packed;
    }
    const auto start = static_cast<uint32_t>(out.size());
    out += directory + "PK\5\6";
    append(&out, uint32_t{0});
    append(&out, static_cast<uint16_t>(files.size()));
    append(&out, static_cast<uint16_t>(files.size()));
    append(&out, static_cast<uint32_t>(directory.size()));
    append(&out, start);
    append(&out, uint16_t{0});
    return out;
}

}  // namespace openfab::testing
