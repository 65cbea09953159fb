// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "base/at.h"
#include "base/check.h"

namespace openfab::render {

namespace {

constexpr uint32_t kKernelSum = 4096;
constexpr double kKernelEnd = 2.5;  ///< standard deviations

/// Half of a Gaussian of integers whose whole sums up to kKernelSum.
std::vector<uint32_t> make_kernel(double sigma_cells) {
    const auto radius = static_cast<size_t>(kKernelEnd * sigma_cells);
    std::vector<double> weights;
    double sum = 0;
    for (size_t i = 0; i <= radius; ++i) {
        const double x = static_cast<double>(i) / sigma_cells;
        weights.push_back(std::exp(-0.5 * x * x));
        sum += weights.back() * (i == 0 ? 1 : 2);
    }
    std::vector<uint32_t> kernel;
    uint32_t rest = kKernelSum;
    for (size_t i = radius; i > 0; --i) {
        kernel.push_back(static_cast<uint32_t>(std::lround(weights[i] / sum * kKernelSum)));
        rest -= 2 * kernel.back();
    }
    kernel.push_back(rest);
    std::reverse(kernel.begin(), kernel.end());
    return kernel;
}

int32_t radius_of(const std::vector<uint32_t>& kernel) {
    return static_cast<int32_t>(kernel.size()) - 1;
}

uint32_t hash_of(uint64_t seed, uint64_t place) {
    uint64_t x = seed ^ (place * 0x9e3779b97f4a7c15ULL);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
    return static_cast<uint32_t>((x ^ (x >> 31)) >> 32);
}

/// How far the surface is smoothed: the standard deviation, of the widest side of a cell. A wall of
/// one such side stays, since a slab is there as long as it is thicker than 1.35 deviations.
constexpr double kSmoothing = 0.7;

/// What a tracer makes of a block whose coverages differ: clearances, of one beside it, too.
constexpr size_t kOfMixedBlock = 576;

std::array<std::vector<uint32_t>, 3> kernels_of(const VolumeGrid& grid) {
    const Vec3d mm = grid.cell_mm();
    const double sigma = kSmoothing * std::max({mm.x, mm.y, mm.z});
    return {make_kernel(sigma / mm.x), make_kernel(sigma / mm.y), make_kernel(sigma / mm.z)};
}

size_t window_of(const std::vector<uint32_t>& kernel) {
    return 2 * static_cast<size_t>(radius_of(kernel)) + 1;
}

Vec3i reach_of(const std::array<std::vector<uint32_t>, 3>& kernels) {
    return {radius_of(kernels[0]), radius_of(kernels[1]), radius_of(kernels[2])};
}

/// With void ones on both sides.
int32_t blocks_of(int32_t cells) {
    constexpr int32_t kGroup = Volume::kGroup;
    const int32_t blocks = (cells + Volume::kSide - 1) / Volume::kSide + 2 * kGroup;
    return (blocks + kGroup - 1) / kGroup * kGroup;
}

Vec3i with_margin(const VolumeGrid& grid, const Vec3i& margin) {
    const Vec3i cells = grid.cells();
    return {cells.x + 2 * margin.x, cells.y + 2 * margin.y, cells.z + 2 * margin.z};
}

}  // namespace

// ------------------------------------------------------------------------------------- the volume

int64_t Volume::bytes() const {
    return static_cast<int64_t>((codes_.capacity() + coverages_.capacity()) * sizeof(uint32_t) +
                                code_pool_.capacity() +
                                coverage_pool_.capacity() * sizeof(uint16_t));
}

bool Volume::inside(const Vec3i& block, uint8_t* rows) const {
    const uint32_t entry = coverages_[index_of(block)];
    if ((entry & kUniform) != 0) {
        const bool is_inside = (entry & ~kUniform) >= kSurface;
        std::fill_n(rows, kSide * kSide, static_cast<uint8_t>(is_inside ? 0xff : 0));
        return false;
    }
    const uint16_t* at = coverage_pool_.data() + size_t{entry} * kBlockVoxels;
    int32_t most = 0;
    int32_t least = 0xff;
    for (int32_t i = 0; i < kSide * kSide; ++i, at += kSide) {
        int32_t row = 0;
        for (int32_t x = 0; x < kSide; ++x)
            row |= (at[x] >= kSurface ? 1 : 0) << x;
        rows[i] = static_cast<uint8_t>(row);
        most |= row;
        least &= row;
    }
    return most != 0 && least != 0xff;
}

// ----------------------------------------------------------------------------------- the builder

void VolumeGrid::coarsen() {
    const Vec3d mm = cell_mm();
    const int axis = mm.x <= mm.y && mm.x <= mm.z ? 0 : mm.y <= mm.z ? 1 : 2;
    ++cell[axis];
}

int64_t VolumeBuilder::least_bytes(const VolumeGrid& grid) {
    const std::array<std::vector<uint32_t>, 3> kernels = kernels_of(grid);
    const Vec3i cells = with_margin(grid, reach_of(kernels));
    const double layer = static_cast<double>(cells.x) * cells.y;
    const auto windows = static_cast<double>(window_of(kernels[2]));
    const double blocks =
        static_cast<double>(blocks_of(cells.x)) * blocks_of(cells.y) * blocks_of(cells.z);
    const size_t counted = grid.is_own() ? 0 : grid.codes.size();
    // A window of codes and coverages, a slab of both, what is gathered, what is between; two tables of
    // blocks, and the macrocells and clearances that a tracer makes of them.
    constexpr double kOfBlock = 22;
    const double bytes =
        layer * (3 * windows + 3 * Volume::kSide + 15 + 2 * static_cast<double>(counted)) +
        blocks * kOfBlock;
    return bytes < 9e18 ? static_cast<int64_t>(bytes) : INT64_MAX;
}

VolumeBuilder::VolumeBuilder(const VolumeGrid& grid, int64_t memory_bytes, uint64_t seed)
    : grid_(grid),
      memory_bytes_(memory_bytes),
      seed_(seed),
      mixtures_(static_cast<int32_t>(grid.codes.size())) {
    kernel_ = kernels_of(grid_);
    margin_ = reach_of(kernel_);
    cells_ = with_margin(grid_, margin_);
    const size_t cells = cells_of_layer();
    solid_.resize(cells);
    codes_.resize(cells);
    for (size_t m = 0; m < grid_.codes.size(); ++m)
        place_of_[grid_.codes[m]] = static_cast<uint16_t>(m);
    if (!grid_.is_own()) counts_.resize(cells * grid_.codes.size());
    between_.resize(cells);
    nothing_.codes.resize(cells);
    nothing_.coverage.resize(cells);
    window_.resize(window_of(kernel_[2]));
    slab_codes_.resize(cells * Volume::kSide);
    slab_coverage_.resize(cells * Volume::kSide);
    volume_.blocks_ = {blocks_of(cells_.x), blocks_of(cells_.y), blocks_of(cells_.z)};
    volume_.pitch_mm_ = grid_.cell_mm();
    for (int a = 0; a < 3; ++a)
        volume_.origin_mm_[a] = grid_.origin_mm[a] - (Volume::kGroup * Volume::kSide + margin_[a]) *
                                                         volume_.pitch_mm_[a];
    const auto blocks = static_cast<size_t>(volume_.blocks_.x) *
                        static_cast<size_t>(volume_.blocks_.y) *
                        static_cast<size_t>(volume_.blocks_.z);
    volume_.codes_.assign(blocks, Volume::kUniform);
    volume_.coverages_.assign(blocks, Volume::kUniform);
    const Vec3d mm = grid_.cell_mm();
    for (int32_t z = -margin_.z; z <= margin_.z; ++z) {
        for (int32_t y = -margin_.y; y <= margin_.y; ++y) {
            for (int32_t x = -margin_.x; x <= margin_.x; ++x)
                nearby_.push_back({x, y, z});
        }
    }
    std::stable_sort(nearby_.begin(), nearby_.end(), [&](const Vec3i& a, const Vec3i& b) {
        const auto far = [&](const Vec3i& v) {
            return length(Vec3d{v.x * mm.x, v.y * mm.y, v.z * mm.z});
        };
        return far(a) < far(b);
    });
}

bool VolumeBuilder::add(int32_t z, const uint8_t* codes) {
    while (open_ < z / grid_.cell.z + margin_.z) {
        if (!close_cells()) return false;
    }
    const auto width = static_cast<size_t>(grid_.voxels.x);
    for (int32_t y = 0; y < grid_.voxels.y; ++y) {
        const uint8_t* const row = codes + static_cast<size_t>(y) * width;
        const size_t cell_row =
            static_cast<size_t>(y / grid_.cell.y + margin_.y) * static_cast<size_t>(cells_.x);
        int32_t cell = margin_.x;
        int32_t in_cell = 0;
        for (int32_t x = 0; x < grid_.voxels.x; ++x) {
            if (row[x] != 0) {
                const size_t i = cell_row + static_cast<size_t>(cell);
                ++solid_[i];
                if (counts_.empty()) {
                    codes_[i] = row[x];
                } else {
                    count(i, row[x]);
                }
            }
            if (++in_cell == grid_.cell.x) {
                in_cell = 0;
                ++cell;
            }
        }
    }
    return true;
}

void VolumeBuilder::count(size_t cell, uint8_t code) {
    uint16_t* const counts = counts_.data() + cell * grid_.codes.size();
    if (++counts[place_of_[code]] < UINT16_MAX) return;
    for (size_t m = 0; m < grid_.codes.size(); ++m)
        counts[m] /= 2;
}

bool VolumeBuilder::close_cells() {
    Layer& made = window_[static_cast<size_t>(open_) % window_.size()];
    made.codes.resize(cells_of_layer());
    made.coverage.resize(cells_of_layer());
    std::vector<uint8_t>& solid = made.codes;  // until the codes are put there
    made.is_void = true;
    const auto all = static_cast<uint32_t>(grid_.cell.x * grid_.cell.y * grid_.cell.z);
    for (int32_t y = 0; y < cells_.y; ++y) {
        for (int32_t x = 0; x < cells_.x; ++x) {
            const size_t i =
                static_cast<size_t>(y) * static_cast<size_t>(cells_.x) + static_cast<size_t>(x);
            solid[i] = static_cast<uint8_t>((255 * solid_[i] + all / 2) / all);
            if (solid_[i] == 0) continue;
            made.is_void = false;
            if (!counts_.empty()) {
                const uint64_t place =
                    static_cast<uint64_t>(open_) * static_cast<uint64_t>(cells_of_layer()) + i;
                codes_[i] = mixtures_.draw(counts_.data() + i * grid_.codes.size(),
                                           static_cast<uint16_t>(hash_of(seed_, place)));
            }
            tight_.add(Vec3i{x, y, open_});
        }
    }
    smooth(solid, &made.coverage);
    made.codes.swap(codes_);
    std::fill(codes_.begin(), codes_.end(), uint8_t{0});
    std::fill(solid_.begin(), solid_.end(), 0U);
    std::fill(counts_.begin(), counts_.end(), uint16_t{0});
    ++open_;
    const int32_t reach = radius_of(kernel_[2]);
    return open_ <= reach || emit(open_ - 1 - reach);
}

void VolumeBuilder::smooth(const std::vector<uint8_t>& solid, std::vector<uint16_t>* out) {
    const auto width = static_cast<size_t>(cells_.x);
    const std::vector<uint32_t>& kx = kernel_[0];
    for (int32_t y = 0; y < cells_.y; ++y) {
        const uint8_t* const in = solid.data() + static_cast<size_t>(y) * width;
        uint16_t* const to = between_.data() + static_cast<size_t>(y) * width;
        for (int32_t x = 0; x < cells_.x; ++x) {
            uint32_t sum = kx[0] * in[x];
            for (int32_t i = 1; i <= radius_of(kx); ++i) {
                if (x >= i) sum += at(kx, i) * in[x - i];
                if (x + i < cells_.x) sum += at(kx, i) * in[x + i];
            }
            to[x] = static_cast<uint16_t>(sum >> 4);
        }
    }
    const std::vector<uint32_t>& ky = kernel_[1];
    for (int32_t y = 0; y < cells_.y; ++y) {
        uint16_t* const to = out->data() + static_cast<size_t>(y) * width;
        for (size_t x = 0; x < width; ++x) {
            uint32_t sum = ky[0] * between_[static_cast<size_t>(y) * width + x];
            for (int32_t i = 1; i <= radius_of(ky); ++i) {
                const uint32_t weight = at(ky, i);
                if (y >= i) sum += weight * between_[static_cast<size_t>(y - i) * width + x];
                if (y + i < cells_.y)
                    sum += weight * between_[static_cast<size_t>(y + i) * width + x];
            }
            to[x] = static_cast<uint16_t>(sum / kKernelSum);
        }
    }
}

const VolumeBuilder::Layer& VolumeBuilder::layer(int32_t z) const {
    const bool is_held =
        z < open_ && z >= std::max(0, open_ - static_cast<int32_t>(window_.size()));
    return is_held ? window_[static_cast<size_t>(z) % window_.size()] : nothing_;
}

bool VolumeBuilder::emit(int32_t z) {
    OPENFAB_CHECK_EQ(z, emitted_);
    const std::vector<uint32_t>& kz = kernel_[2];
    const size_t cells = cells_of_layer();
    const size_t first = static_cast<size_t>(z % Volume::kSide) * cells;
    uint16_t* const coverage = slab_coverage_.data() + first;
    uint8_t* const codes = slab_codes_.data() + first;
    std::vector<uint32_t> sums(cells);
    const auto add = [&](int32_t from, uint32_t weight) {
        const Layer& one = layer(from);
        if (one.is_void) return;
        for (size_t i = 0; i < cells; ++i)
            sums[i] += weight * one.coverage[i];
    };
    for (int32_t i = 0; i <= radius_of(kz); ++i) {
        add(z - i, at(kz, i));
        if (i > 0) add(z + i, at(kz, i));
    }
    for (size_t i = 0; i < cells; ++i)
        coverage[i] = static_cast<uint16_t>(sums[i] / kKernelSum);
    std::copy(layer(z).codes.begin(), layer(z).codes.end(), codes);
    spread_codes(z, codes, coverage);
    ++emitted_;
    return emitted_ % Volume::kSide != 0 || store_slab();
}

/// Gives void cells at the surface, some of whose points are inside, the code of the nearest solid one.
void VolumeBuilder::spread_codes(int32_t z, uint8_t* codes, const uint16_t* coverage) const {
    constexpr uint16_t kLeast = Volume::kFull / 5;  // where interpolation may reach one half
    for (int32_t y = 0; y < cells_.y; ++y) {
        for (int32_t x = 0; x < cells_.x; ++x) {
            const size_t i =
                static_cast<size_t>(y) * static_cast<size_t>(cells_.x) + static_cast<size_t>(x);
            if (codes[i] != 0 || coverage[i] < kLeast) continue;
            for (const Vec3i& by : nearby_) {
                const int32_t nx = x + by.x;
                const int32_t ny = y + by.y;
                if (nx < 0 || ny < 0 || nx >= cells_.x || ny >= cells_.y) continue;
                const uint8_t found =
                    layer(z + by.z).codes[static_cast<size_t>(ny) * static_cast<size_t>(cells_.x) +
                                          static_cast<size_t>(nx)];
                if (found == 0) continue;
                codes[i] = found;
                break;
            }
        }
    }
}

bool VolumeBuilder::store_slab() {
    const int32_t slab = (emitted_ - 1) / Volume::kSide;
    std::array<uint8_t, Volume::kBlockVoxels> codes{};
    std::array<uint16_t, Volume::kBlockVoxels> coverage{};
    const size_t cells = cells_of_layer();
    const auto store = [&](const auto& block, auto* pool, uint32_t* entry) {
        if (std::all_of(block.begin(), block.end(), [&](auto v) { return v == block[0]; })) {
            *entry = Volume::kUniform | block[0];
            return true;
        }
        if (pool->size() + block.size() > pool->capacity()) {
            // What is copied to grow counts, too.
            const size_t more = std::max(pool->size() / 4, size_t{1} << 16);
            const auto bytes = static_cast<int64_t>((2 * pool->size() + more) * sizeof(block[0]));
            const size_t mixed = volume_.coverage_pool_.size() / Volume::kBlockVoxels;
            if (volume_.bytes() + bytes + static_cast<int64_t>(mixed * kOfMixedBlock) +
                    least_bytes(grid_) >
                memory_bytes_)
                return false;
            pool->reserve(pool->size() + more);
        }
        *entry = static_cast<uint32_t>(pool->size() / block.size());
        pool->insert(pool->end(), block.begin(), block.end());
        return true;
    };
    for (int32_t by = 0; by * Volume::kSide < cells_.y; ++by) {
        for (int32_t bx = 0; bx * Volume::kSide < cells_.x; ++bx) {
            codes.fill(0);
            coverage.fill(0);
            const int32_t wide = std::min(Volume::kSide, cells_.x - bx * Volume::kSide);
            const int32_t deep = std::min(Volume::kSide, cells_.y - by * Volume::kSide);
            for (int32_t z = 0; z < Volume::kSide; ++z) {
                for (int32_t y = 0; y < deep; ++y) {
                    const size_t from = static_cast<size_t>(z) * cells +
                                        static_cast<size_t>(by * Volume::kSide + y) *
                                            static_cast<size_t>(cells_.x) +
                                        static_cast<size_t>(bx * Volume::kSide);
                    const size_t to = Volume::place(0, y, z);
                    std::copy_n(slab_codes_.begin() + static_cast<std::ptrdiff_t>(from), wide,
                                codes.begin() + static_cast<std::ptrdiff_t>(to));
                    std::copy_n(slab_coverage_.begin() + static_cast<std::ptrdiff_t>(from), wide,
                                coverage.begin() + static_cast<std::ptrdiff_t>(to));
                }
            }
            const size_t index =
                volume_.index_of({bx + Volume::kGroup, by + Volume::kGroup, slab + Volume::kGroup});
            if (!store(codes, &volume_.code_pool_, &volume_.codes_[index]) ||
                !store(coverage, &volume_.coverage_pool_, &volume_.coverages_[index]))
                return false;
        }
    }
    std::fill(slab_codes_.begin(), slab_codes_.end(), uint8_t{0});
    std::fill(slab_coverage_.begin(), slab_coverage_.end(), uint16_t{0});
    return true;
}

bool VolumeBuilder::finish(Volume* out) {
    while (open_ < cells_.z) {
        if (!close_cells()) return false;
    }
    while (emitted_ < cells_.z) {
        if (!emit(emitted_)) return false;
    }
    if (emitted_ % Volume::kSide != 0 && !store_slab()) return false;
    const Vec3d mm = grid_.cell_mm();
    for (int a = 0; a < 3 && !tight_.empty(); ++a) {
        volume_.solid_mm_.lo[a] = grid_.origin_mm[a] + (tight_.lo[a] - margin_[a]) * mm[a];
        volume_.solid_mm_.hi[a] = grid_.origin_mm[a] + (tight_.hi[a] + 1 - margin_[a]) * mm[a];
    }
    *out = std::move(volume_);
    return true;
}

}  // namespace openfab::render
