// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/read/print_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "backends/read/folder_print.h"
#include "backends/read/gcvf_print.h"
#include "backends/read/messages.h"
#include "backends/read/ofr_print.h"
#include "backends/read/zarr_print.h"
#include "base/units.h"
#include "runtime/pipeline/print_hash.h"

namespace openfab::prints {

Result<std::unique_ptr<PrintFile>> PrintFile::open(const std::string& path, int64_t memory_bytes) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) {
        if (zarr::is_store(path)) return ZarrPrint::open(path, memory_bytes);
        Result<std::unique_ptr<FolderPrint>> folder = FolderPrint::open(path, memory_bytes);
        if (!folder) return folder.error();
        return std::unique_ptr<PrintFile>(std::move(*folder));
    }
    return is_gcvf(path) ? GcvfPrint::open(path, memory_bytes) : OfrPrint::open(path, memory_bytes);
}

Result<uint64_t> PrintFile::hash_of_slices() const {
    uint64_t hash = 0;
    SliceBuffers buffers;
    for (int32_t z = info_.slice_begin; z < info_.slice_end; ++z) {
        if (Result<void> read = read_slice(z, &buffers); !read) return read.error();
        hash += pipeline::slice_hash(z, buffers.rows.data(), row_bytes_, info_.size.y);
    }
    return hash;
}

Error PrintFile::error(const std::string& what) const {
    return user_error(fmt::format("{}: {}", path_, what));
}

Result<void> PrintFile::check_memory(int64_t bytes_a_slice, int64_t memory_bytes) const {
    if (bytes_a_slice <= memory_bytes / 4) return {};
    return user_error(fmt::format(messages::kSlicesTakeEach, path_, info_.size.x, info_.size.y,
                                  format_bytes(bytes_a_slice), format_bytes(memory_bytes)));
}

}  // namespace openfab::prints
