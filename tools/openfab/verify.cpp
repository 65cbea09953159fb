// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab verify FILE`: every checksum, every slice, the index; of other outputs than .ofr files what they
// record of themselves.

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <memory>
#include <string_view>

#include "backends/ofr/ofr_reader.h"
#include "backends/zarr/store.h"
#include "base/input_file.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/verify_files.h"
#include "tools/openfab/verify_store.h"

namespace openfab::tools {

namespace {

/// Returns the first bytes of a file; none of what cannot be opened.
std::string first_bytes(const std::string& file) {
    std::array<char, 6> bytes{};
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return {};
    const Result<size_t> read = opened->read(0, bytes.data(), bytes.size());
    return read ? std::string(bytes.data(), *read) : std::string();
}

}  // namespace

Result<void> verify(const std::string& file, const std::string& memory) {
    const Result<int64_t> bytes = parse_memory_option(memory);
    if (!bytes) return bytes.error();
    if (file != "-") {
        std::error_code ignored;
        if (std::filesystem::is_directory(file, ignored))
            return zarr::is_store(file) ? verify_store(file, *bytes) : verify_folder(file, *bytes);
        const std::string first = first_bytes(file);
        if (first == "\x93NUMPY" || file.ends_with(".npy")) return verify_array(file);
        if (first.starts_with("PK")) return verify_package(file, *bytes);
        if (file.ends_with(".stl")) return verify_stl(file);
    }
    Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(file, *bytes);
    if (!reader) return reader.error();
    for (;;) {
        Result<bool> more = (*reader)->next();
        if (!more) return more.error();
        if (!*more) break;
    }
    say(fmt::format(messages::kAllSlicesWhole, printable(file), (*reader)->whole_slices(),
                    (*reader)->hash()));
    return {};
}

}  // namespace openfab::tools
