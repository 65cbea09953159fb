// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// An `.ofr` file of which any slice can be read, also while a print still writes it. A finished
// file is opened by its index; of one without, slices are found from head to head, so that what was
// written since costs a few bytes a slice to see.

#include <mutex>

#include "backends/ofr/format.h"
#include "backends/read/print_file.h"
#include "base/input_file.h"

namespace openfab::prints {

class OfrPrint final : public PrintFile {
  public:
    static Result<std::unique_ptr<PrintFile>> open(const std::string& path, int64_t memory_bytes);

    int32_t whole_slices() const override;
    std::optional<pipeline::PrintTotals> totals() const override;
    bool look_again() override;
    bool was_replaced() const override;
    Result<void> read_slice(int32_t z, SliceBuffers* buffers) const override;

  private:
    OfrPrint(std::string path, InputFile file)
        : PrintFile(std::move(path)), file_(std::move(file)) {}

    Result<void> read_header();
    /// Returns whether the file has an index, which then is taken.
    bool take_index(uint64_t offset);
    bool take_index_at_end();
    int64_t bytes_now() const;
    bool read_exactly(uint64_t at, void* to, size_t bytes) const;

    InputFile file_;
    mutable std::mutex mutex_;  ///< of all below
    std::vector<uint64_t> offsets_;
    uint64_t end_ = 0;  ///< of the last whole slice
    std::optional<pipeline::PrintTotals> totals_;
};

}  // namespace openfab::prints
