// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The interface between the slab loop and its outputs: files, folders, pictures.

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/process/effect_change.h"

namespace openfab::pipeline {

struct SliceMaterial {
    std::string name;
    std::array<uint8_t, 4> key{};
    std::array<uint8_t, 4> preview{};
    double density_g_cm3 = 0;
    std::string channel;
};

/// The parameters of a print, known before the first slice.
struct PrintInfo {
    Vec3i size;  ///< voxels of the grid along x, y, z
    Vec3d pitch_mm;
    Vec3d origin_mm;                       ///< lowest corner of the grid in build space
    int32_t slice_begin = 0;               ///< first slice that will be written
    int32_t slice_end = 0;                 ///< one past the last
    int32_t bits = 4;                      ///< bits a voxel in packed rows: 4 or 8
    std::vector<SliceMaterial> materials;  ///< code 1 is materials[0]; code 0 is void
    int32_t support_code = 0;              ///< material code of support; 0: none or unknown
    std::string printer;
    std::string title;  ///< the world's or mesh's name
    uint64_t seed = 0;
    /// Everything else that determines the voxels, as names and short texts (settings, hashes): if
    /// these and the fields above are equal, so are the prints. Empty where unknown.
    std::vector<std::pair<std::string, std::string>> provenance;
};

/// One slice of packed material codes. Row 0 is the lowest y; in a row, x rises; at 4 bits a byte
/// holds voxel 2n in its low and 2n+1 in its high half; a row takes row_bytes = ceil(size.x * bits
/// / 8) and the unused half is 0.
struct SliceView {
    int32_t z = 0;
    const uint8_t* data = nullptr;
    size_t row_bytes = 0;
    int32_t width = 0;
    int32_t height = 0;

    uint8_t code(int32_t x, int32_t y, int32_t bits) const {
        const uint8_t* row = data + static_cast<size_t>(y) * row_bytes;
        return bits == 8 ? row[x] : static_cast<uint8_t>((row[x >> 1] >> ((x & 1) * 4)) & 15);
    }
};

/// The totals of a print, known at the end, for manifests and indexes.
struct PrintTotals {
    bool complete = false;  ///< false: interrupted or failed; what was written stays valid
    int64_t voxels_solid = 0;
    std::vector<int64_t> voxels_by_code;  ///< [0] void inside the grid
    uint64_t hash = 0;                    ///< of all slices, independent of format (print_hash.h)
    Box3i tight;                          ///< printed voxels, hi exclusive
    std::vector<process::EffectChange> changes;  ///< while the print ran

    /// Adds those of other slices of the same print; `complete` stays.
    void add(const PrintTotals& more) {
        voxels_solid += more.voxels_solid;
        voxels_by_code.resize(std::max(voxels_by_code.size(), more.voxels_by_code.size()));
        for (size_t code = 0; code < more.voxels_by_code.size(); ++code)
            voxels_by_code[code] += more.voxels_by_code[code];
        hash += more.hash;  // hashes of disjoint slices add up: print_hash.h
        tight.add(more.tight);
    }
};

/// Consumes slices in order of z. `encode` is called from worker threads, for different slices at
/// once, and touches no shared state; `commit` is called from one thread, in order, with the result
/// of `encode`.
class SliceSink {
  public:
    virtual ~SliceSink() = default;
    virtual Result<void> begin(const PrintInfo& info) = 0;
    /// Called once after begin: passes the whole slices that an interrupted print has left in this
    /// output to `show`, in order from the first, and returns their number; the print continues
    /// after them. Fails with kInterrupted where `show` returns false. After an error the output is
    /// unchanged, even by finish. The default: no slices.
    virtual Result<int32_t> resume(const std::function<bool(const SliceView&)>& show) {
        (void)show;
        return 0;
    }
    /// Compresses or draws one slice. Must not fail for valid input.
    virtual std::vector<uint8_t> encode(const SliceView& slice) const = 0;
    /// Takes the bytes over, so that a sink may hand them on without a copy.
    virtual Result<void> commit(int32_t z, std::vector<uint8_t> bytes) = 0;
    /// Called once after the last commit, even if the print ended early; then `totals.complete` is
    /// false.
    virtual Result<void> finish(const PrintTotals& totals) = 0;
};

}  // namespace openfab::pipeline
