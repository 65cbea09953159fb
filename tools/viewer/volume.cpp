// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/volume.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/color.h"
#include "base/run_main.h"

namespace openfab::viewer {

namespace {

constexpr double kMostCells = 2e6;
constexpr int32_t kMostSide = 384;
constexpr int32_t kAcross = 4, kAlong = 2;  ///< samples of a cell in a slice, along x and y
constexpr size_t kSamples = size_t{kAcross} * kAlong;
constexpr int32_t kMostParts = 2;
constexpr auto kMoment = std::chrono::milliseconds(250);

/// Red, green and blue in linear light, times alpha, and alpha: clear materials have little of it,
/// so there are no bits to lose.
using Sum = std::array<float, 4>;

Sum sum_of(const std::array<uint8_t, 4>& rgba) {
    Sum sum{};
    for (size_t c = 0; c < 3; ++c)
        sum[c] = static_cast<float>(srgb_to_linear(rgba[c] / 255.0)) * rgba[3];
    sum[3] = rgba[3];
    return sum;
}

/// The slice that stands for a part of a layer of cells.
int32_t sampled_slice(const pipeline::PrintInfo& info, int32_t layers, int32_t layer, int32_t part,
                      int32_t parts) {
    const double at = (layer + (part + 0.5) / parts) * info.size.z / layers;
    return std::min(static_cast<int32_t>(at), info.size.z - 1);
}

bool has_slice(const pipeline::PrintInfo& info, int32_t z) {
    return z >= info.slice_begin && z < info.slice_end;
}

int32_t parts_a_layer(const pipeline::PrintInfo& info, int32_t layers) {
    return std::min(kMostParts, std::max(1, info.size.z / layers));
}

/// Colours what nothing is visible in like the densest neighbour, so that interpolation between
/// cells does not darken rims.
void color_empty_cells(const Vec3i& cells, std::vector<uint8_t>* rgba) {
    const int64_t strides[3] = {4, int64_t{4} * cells.x, int64_t{4} * cells.x * cells.y};
    uint8_t* cell = rgba->data();
    for (int32_t z = 0; z < cells.z; ++z) {
        for (int32_t y = 0; y < cells.y; ++y) {
            for (int32_t x = 0; x < cells.x; ++x, cell += 4) {
                if (cell[3] != 0) continue;
                const int32_t place[3] = {x, y, z};
                const uint8_t* best = nullptr;
                for (int a = 0; a < 3; ++a) {
                    const uint8_t* below = place[a] > 0 ? cell - strides[a] : nullptr;
                    const uint8_t* above = place[a] + 1 < cells[a] ? cell + strides[a] : nullptr;
                    for (const uint8_t* other : {below, above}) {
                        if (other != nullptr && other[3] > (best == nullptr ? 0 : best[3]))
                            best = other;
                    }
                }
                if (best != nullptr) std::copy_n(best, 3, cell);
            }
        }
    }
}

}  // namespace

Vec3i volume_cells(const pipeline::PrintInfo& info) {
    const auto cells_of = [&](double side_mm) {
        Vec3i cells;
        for (int a = 0; a < 3; ++a) {
            const double wanted = std::ceil(info.size[a] * info.pitch_mm[a] / side_mm);
            cells[a] = static_cast<int32_t>(
                std::clamp(wanted, 1.0, static_cast<double>(std::min(info.size[a], kMostSide))));
        }
        return cells;
    };
    double side_mm = std::max({info.pitch_mm.x, info.pitch_mm.y, info.pitch_mm.z}) / 8;
    Vec3i cells = cells_of(side_mm);
    while (double{1} * cells.x * cells.y * cells.z > kMostCells) {
        side_mm *= 1.03;
        cells = cells_of(side_mm);
    }
    return cells;
}

int32_t volume_steps(const pipeline::PrintInfo& info, const pipeline::PrintInfo* other) {
    const int32_t layers = volume_cells(info).z;
    const int32_t parts = parts_a_layer(info, layers);
    int32_t steps = 0;
    for (int32_t layer = 0; layer < layers; ++layer) {
        for (int32_t part = 0; part < parts; ++part) {
            const int32_t z = sampled_slice(info, layers, layer, part, parts);
            if (has_slice(info, z) || (other != nullptr && has_slice(*other, z))) ++steps;
        }
    }
    return steps;
}

Volume::Volume(SliceStore* store, SliceStore* other)
    : store_(store),
      other_(other),
      difference_(store->file().info(), (other == nullptr ? store : other)->file().info(),
                  store->file().info().size.x) {
    const pipeline::PrintInfo& info = store->file().info();
    cells_ = volume_cells(info);
    parts_ = parts_a_layer(info, cells_.z);
    const auto places = [](int32_t voxels, int32_t cells, int32_t samples) {
        std::vector<int32_t> made;
        for (int32_t i = 0; i < cells * samples; ++i)
            made.push_back(
                static_cast<int32_t>((i + 0.5) * voxels / (double{1} * cells * samples)));
        return made;
    };
    xs_ = places(info.size.x, cells_.x, kAcross);
    ys_ = places(info.size.y, cells_.y, kAlong);
    if (other != nullptr) {
        for (int32_t x = 0; x < info.size.x; ++x)
            cell_of_x_.push_back(static_cast<int32_t>(int64_t{x} * cells_.x / info.size.x));
        for (int32_t y = 0; y < info.size.y; ++y)
            cell_of_y_.push_back(static_cast<int32_t>(int64_t{y} * cells_.y / info.size.y));
    }
    const auto begin_of = [&](int32_t layer, int32_t part) {
        return static_cast<int32_t>(int64_t{info.size.z} * (int64_t{layer} * parts_ + part) /
                                    (int64_t{cells_.z} * parts_));
    };
    // Every 2^n-th layer first, then those between.
    int32_t coarsest = 1;
    while (coarsest < cells_.z)
        coarsest *= 2;
    for (int32_t part = 0; part < parts_; ++part) {
        for (int32_t stride = coarsest; stride >= 1; stride /= 2) {
            for (int32_t layer = 0; layer < cells_.z; layer += stride) {
                if (stride < coarsest && layer % (2 * stride) == 0) continue;
                const int32_t z = sampled_slice(info, cells_.z, layer, part, parts_);
                if (has_slice(info, z) || (other != nullptr && has_slice(other->file().info(), z)))
                    steps_.push_back(
                        {layer, part, z, begin_of(layer, part), begin_of(layer, part + 1)});
            }
        }
    }
    const auto parts = static_cast<size_t>(parts_) * static_cast<size_t>(cells_.z);
    has_part_.assign(parts, 0);
    codes_.resize(parts * layer_cells() * kSamples);
    thread_ = std::thread([this] { run_thread([this] { run(); }); });
}

Volume::~Volume() {
    stop_ = true;
    thread_.join();
}

void Volume::sample(const uint8_t* rows, std::vector<uint8_t>* codes) const {
    const pipeline::PrintInfo& info = store_->file().info();
    const size_t row_bytes = store_->file().row_bytes();
    for (int32_t cy = 0; cy < cells_.y; ++cy) {
        for (int32_t j = 0; j < kAlong; ++j) {
            const auto y =
                static_cast<size_t>(ys_[static_cast<size_t>(cy) * kAlong + static_cast<size_t>(j)]);
            const uint8_t* row = rows + y * row_bytes;
            uint8_t* to = codes->data() +
                          static_cast<size_t>(cy) * static_cast<size_t>(cells_.x) * kSamples +
                          static_cast<size_t>(j * kAcross);
            for (int32_t cx = 0; cx < cells_.x; ++cx, to += kSamples) {
                for (int32_t i = 0; i < kAcross; ++i) {
                    const int32_t x =
                        xs_[static_cast<size_t>(cx) * kAcross + static_cast<size_t>(i)];
                    to[i] = info.bits == 8
                                ? row[x]
                                : static_cast<uint8_t>((row[x >> 1] >> ((x & 1) * 4)) & 15);
                }
            }
        }
    }
}

bool Volume::is_there(const Step& step) const {
    const auto has = [](const SliceStore& store, int32_t end) {
        const prints::PrintFile& file = store.file();
        return std::min(end, file.info().slice_end) <=
               file.info().slice_begin + file.whole_slices();
    };
    if (other_ == nullptr) return has(*store_, step.z + 1);
    return has(*store_, step.end) && has(*other_, step.end);
}

Result<void> Volume::read(const Step& step, std::vector<uint8_t>* codes) {
    if (!has_slice(store_->file().info(), step.z)) {
        std::fill(codes->begin(), codes->end(), uint8_t{0});
    } else if (Result<void> read =
                   store_->visit(step.z, [&](const uint8_t* rows) { sample(rows, codes); });
               !read) {
        return read;
    }
    if (other_ == nullptr) return {};
    std::vector<uint8_t> marks(layer_cells());
    for (int32_t z = step.begin; z < step.end && !stop_; ++z) {
        if (Result<void> compared = compare(z, &marks); !compared) return compared;
    }
    for (size_t cell = 0; cell < marks.size(); ++cell) {
        if (marks[cell] != 0) std::fill_n(codes->data() + cell * kSamples, kSamples, kDifferent);
    }
    return {};
}

Result<void> Volume::compare(int32_t z, std::vector<uint8_t>* marks) {
    const size_t first_bytes = store_->file().row_bytes(),
                 second_bytes = other_->file().row_bytes();
    const auto mark = [&](const uint8_t* first, const uint8_t* second) {
        for (size_t y = 0; y < cell_of_y_.size(); ++y) {
            const uint8_t* row =
                difference_.row(first == nullptr ? nullptr : first + y * first_bytes,
                                second == nullptr ? nullptr : second + y * second_bytes);
            if (row == nullptr) continue;
            uint8_t* to =
                marks->data() + static_cast<size_t>(cell_of_y_[y]) * static_cast<size_t>(cells_.x);
            for (size_t x = 0; x < cell_of_x_.size(); ++x) {
                if (row[x] == kDifferent) to[cell_of_x_[x]] = 1;
            }
        }
    };
    Result<void> inner;
    const auto with_first = [&](const uint8_t* first) {
        if (has_slice(other_->file().info(), z)) {
            inner = other_->visit(z, [&](const uint8_t* second) { mark(first, second); });
        } else {
            mark(first, nullptr);
        }
    };
    if (!has_slice(store_->file().info(), z)) {
        with_first(nullptr);
    } else if (Result<void> outer = store_->visit(z, with_first); !outer) {
        return outer;
    }
    return inner;
}

void Volume::run() {
    std::vector<uint8_t> codes(layer_cells() * kSamples);
    std::vector<Step> left = steps_;
    while (!stop_ && !left.empty()) {
        std::vector<Step> later;
        for (const Step& step : left) {
            if (stop_) return;
            if (!is_there(step)) {
                later.push_back(step);
                continue;
            }
            const Result<void> read = this->read(step, &codes);
            const std::lock_guard lock(mutex_);
            const auto place = static_cast<size_t>(step.layer) * static_cast<size_t>(parts_) +
                               static_cast<size_t>(step.part);
            if (read) {
                std::copy(codes.begin(), codes.end(),
                          codes_.begin() + static_cast<std::ptrdiff_t>(place * codes.size()));
                has_part_[place] = 1;
            } else {
                trouble_ = read.error().text();
            }
            ++done_;
            changed_.notify_all();
        }
        left = std::move(later);
        if (!left.empty()) std::this_thread::sleep_for(kMoment);
    }
}

void Volume::wait_for_more(int32_t known) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kMoment, [&] { return done_ > known || !trouble_.empty(); });
}

std::string Volume::trouble() {
    const std::lock_guard lock(mutex_);
    return trouble_;
}

std::vector<uint8_t> Volume::colors(const Palette& palette) {
    std::array<Sum, 256> table{};
    for (size_t code = 0; code < table.size(); ++code)
        table[code] = sum_of(palette[code]);
    const size_t layer_bytes = layer_cells() * 4;
    const size_t part_bytes = layer_cells() * kSamples;
    std::vector<uint8_t> rgba(layer_bytes * static_cast<size_t>(cells_.z));
    std::unique_lock lock(mutex_);
    std::vector<Sum> sums(layer_cells());
    for (int32_t layer = 0; layer < cells_.z; ++layer) {
        uint8_t* out = rgba.data() + layer_bytes * static_cast<size_t>(layer);
        std::fill(sums.begin(), sums.end(), Sum{});
        uint32_t voxels = 0;
        for (int32_t part = 0; part < parts_; ++part) {
            const auto place = static_cast<size_t>(layer) * static_cast<size_t>(parts_) +
                               static_cast<size_t>(part);
            if (has_part_[place] == 0) continue;
            voxels += kSamples;
            const uint8_t* codes = codes_.data() + place * part_bytes;
            for (Sum& sum : sums) {
                for (size_t i = 0; i < kSamples; ++i) {
                    const Sum& one = table[*codes++];
                    for (size_t c = 0; c < one.size(); ++c)
                        sum[c] += one[c];
                }
            }
        }
        if (voxels == 0) {
            if (layer > 0) std::copy_n(out - layer_bytes, layer_bytes, out);
            continue;
        }
        for (const Sum& sum : sums) {
            if (sum[3] > 0) {
                for (size_t c = 0; c < 3; ++c)
                    out[c] = srgb_of(double{sum[c]} / double{sum[3]});
                const double alpha = double{sum[3]} / voxels;
                out[3] = static_cast<uint8_t>(std::clamp(std::lround(alpha), 1L, 255L));
            }
            out += 4;
        }
    }
    lock.unlock();
    color_empty_cells(cells_, &rgba);
    return rgba;
}

}  // namespace openfab::viewer
