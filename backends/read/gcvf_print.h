// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A GCVF, the package of GrabCAD Print's voxel printing, of which any slice can be read: what gcvf_sink.h
// writes, and what other programs do. Its `ConfigFile.xml` names materials by the colours that its PNGs
// have; it says neither where a part lies nor whether pictures are mirrored, so they are taken as `png`
// slices are, +x right, +y up, from the origin on.

#include <optional>

#include "backends/read/print_file.h"
#include "base/input_file.h"
#include "mesh/read/zip_file.h"

namespace openfab::prints {

/// Whether a file is to be read as a GCVF, by its name.
bool is_gcvf(const std::string& path);

class GcvfPrint final : public PrintFile {
  public:
    static Result<std::unique_ptr<PrintFile>> open(const std::string& path, int64_t memory_bytes);
    ~GcvfPrint() override;

    int32_t whole_slices() const override { return whole_; }
    std::optional<pipeline::PrintTotals> totals() const override { return totals_; }
    bool look_again() override { return false; }
    std::optional<Note> note() const override { return note_; }
    bool was_replaced() const override;
    Result<void> read_slice(int32_t z, SliceBuffers* buffers) const override;

  private:
    explicit GcvfPrint(std::string path) : PrintFile(std::move(path)) {}

    Result<void> map_file();
    Result<void> read_config();
    std::string slice_name(int32_t z) const;

    std::optional<InputFile> file_;
    std::string_view bytes_;  ///< mapped; slices are read as they are asked for
    std::optional<mesh::ZipFile> zip_;
    std::string prefix_;
    int32_t first_name_ = 0;  ///< the number in the name of slice 0
    std::array<uint8_t, 4> background_{};
    int32_t whole_ = 0;
    std::optional<pipeline::PrintTotals> totals_;
    std::optional<Note> note_;
};

}  // namespace openfab::prints
