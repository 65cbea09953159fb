// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A folder of slices, PNG, TIFF or BMP, of which any slice can be read, also while a print still fills it.
// What the slices are is in its manifest.json; materials are shown in the colours of the slices,
// since it has no others.

#include <sys/stat.h>

#include <mutex>

#include "backends/raster/slice_files.h"
#include "backends/read/print_file.h"
#include "base/json.h"

namespace openfab::prints {

class FolderPrint final : public PrintFile {
  public:
    static Result<std::unique_ptr<FolderPrint>> open(const std::string& path, int64_t memory_bytes);

    /// Whether its slices are of the fractions of one material; read_slice refuses them, which have no codes.
    bool is_grey() const;
    /// Whether in its pictures +x points left.
    bool flips_x() const { return options_.flip_x; }
    /// Returns the files of a slice.
    std::vector<std::string> slice_files(int32_t z) const;

    int32_t whole_slices() const override;
    std::optional<pipeline::PrintTotals> totals() const override;
    bool look_again() override;
    bool was_replaced() const override;
    Result<void> read_slice(int32_t z, SliceBuffers* buffers) const override;

  private:
    explicit FolderPrint(std::string path) : PrintFile(std::move(path)) {}

    Result<JsonValue> read_manifest() const;
    Result<void> take_manifest(const JsonValue& manifest);
    /// Takes the totals where the manifest says that the print is complete.
    bool take_totals(const JsonValue& manifest);
    std::string slice_path(int32_t z, size_t file) const;

    raster::FolderOptions options_;
    mutable std::mutex mutex_;  ///< of all below
    int32_t found_ = 0;
    struct stat first_ {};  ///< of the first slice's file, once it is there
    std::optional<pipeline::PrintTotals> totals_;
};

}  // namespace openfab::prints
