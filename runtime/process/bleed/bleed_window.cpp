// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/process/bleed/bleed_window.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <tuple>

#include "base/at.h"

namespace openfab::process {

namespace {

/// Weights are multiples of 2^-16 whose sum is exactly 1: where nothing varies nothing changes, and
/// the last bits of a library's exp do not matter.
BleedKernels::Taps taps_of(double sigma_vox) {
    constexpr double kWidth = 3, kWhole = 65536;
    const auto radius = static_cast<int32_t>(std::ceil(kWidth * sigma_vox - 1e-9));
    if (radius <= 0) return {1.0f};
    std::vector<double> weights;
    double sum = 0;
    for (int32_t i = 0; i <= radius; ++i) {
        weights.push_back(std::exp(-0.5 * i * i / (sigma_vox * sigma_vox)));
        sum += i == 0 ? 1 : 2 * weights.back();
    }
    BleedKernels::Taps taps(weights.size());
    double middle = kWhole;
    for (size_t i = 1; i < taps.size(); ++i) {
        const double each = std::floor(weights[i] / sum * kWhole + 0.5);
        taps[i] = static_cast<float>(each / kWhole);
        middle -= 2 * each;
    }
    taps[0] = static_cast<float>(middle / kWhole);
    while (taps.size() > 1 && taps.back() == 0)
        taps.pop_back();
    return taps;
}

/// to[i] = sum of taps over from, for `count` values that lie `stride` from their neighbours.
void convolve_row(const float* from, const BleedKernels::Taps& taps, ptrdiff_t stride,
                  int32_t count, float* to) {
    for (int32_t i = 0; i < count; ++i)
        to[i] = taps[0] * from[i];
    for (size_t t = 1; t < taps.size(); ++t) {
        const float weight = taps[t];
        const float *below = from - static_cast<ptrdiff_t>(t) * stride,
                    *above = from + static_cast<ptrdiff_t>(t) * stride;
        for (int32_t i = 0; i < count; ++i)
            to[i] += weight * (below[i] + above[i]);
    }
}

}  // namespace

BleedKernels::BleedKernels(const std::vector<PairSpread>& of) {
    std::set<uint8_t> all;
    for (const PairSpread& pair : of)
        all.insert({pair.a, pair.b});
    channels.assign(all.begin(), all.end());
    const auto place = [&](uint8_t channel) {
        return static_cast<size_t>(std::lower_bound(channels.begin(), channels.end(), channel) -
                                   channels.begin());
    };
    for (const PairSpread& pair : of) {
        const std::array<Taps, 3> wanted{taps_of(pair.sigma_vox.x), taps_of(pair.sigma_vox.y),
                                         taps_of(pair.sigma_vox.z)};
        const auto known = std::find(taps.begin(), taps.end(), wanted);
        const auto kernel = static_cast<size_t>(known - taps.begin());
        if (known == taps.end()) {
            taps.push_back(wanted);
            spreads.emplace_back(channels.size(), false);
        }
        pairs.push_back({place(pair.a), place(pair.b), kernel});
        spreads[kernel][place(pair.a)] = spreads[kernel][place(pair.b)] = true;
        for (int axis = 0; axis < 3; ++axis) {
            radius[axis] =
                std::max(radius[axis], static_cast<int32_t>(at(wanted, axis).size()) - 1);
        }
    }
    // Sums have one order, whatever that of the file.
    std::sort(pairs.begin(), pairs.end(), [](const Pair& l, const Pair& r) {
        return std::tie(l.kernel, l.a, l.b) < std::tie(r.kernel, r.a, r.b);
    });
}

void BleedWindow::reset(const Vec3i& size, size_t places) {
    size_ = size;
    const size_t count =
        static_cast<size_t>(size.x) * static_cast<size_t>(size.y) * static_cast<size_t>(size.z);
    for (std::vector<Field>* fields : {&target_, &now_, &after_, &spread_})
        fields->resize(places);
    spread_.resize(2 * places + 1);  // and shares, and fractions times these
    for (Field& field : now_)
        field.assign(count, 0.0f);
    for (std::vector<Field>* fields : {&after_, &spread_}) {
        for (Field& field : *fields)
            field.resize(count);
    }
    along_x_.resize(count);
    along_y_.resize(count);
}

template <typename Row>
void BleedWindow::for_rows(const Vec3i& border, const Row& row) const {
    for (int32_t z = border.z; z < size_.z - border.z; ++z) {
        for (int32_t y = border.y; y < size_.y - border.y; ++y)
            row(at(border.x, y, z), static_cast<size_t>(std::max(size_.x - 2 * border.x, 0)));
    }
}

void BleedWindow::convolve(const Field& from, const std::array<BleedKernels::Taps, 3>& taps,
                           const Vec3i& border, const Vec3i& radius, Field* to) {
    const ptrdiff_t row = size_.x, plane = row * size_.y;
    const auto pass = [&](const Vec3i& inside, const Field& in, const BleedKernels::Taps& weights,
                          ptrdiff_t stride, Field* out) {
        for_rows(inside, [&](size_t first, size_t count) {
            convolve_row(in.data() + first, weights, stride, static_cast<int32_t>(count),
                         out->data() + first);
        });
    };
    pass({border.x, border.y - radius.y, border.z - radius.z}, from, taps[0], 1, &along_x_);
    pass({border.x, border.y, border.z - radius.z}, along_x_, taps[1], row, &along_y_);
    pass(border, along_y_, taps[2], plane, to);
}

/// Sets after_ to what the materials exchange, farther than `border` inside. Behind the spreads lie the share
/// of each voxel in that, empty where all take part whole, and fractions times these.
void BleedWindow::bleed(const BleedKernels& kernels, const Vec3i& border) {
    const size_t places = now_.size();
    const Field* const shares = spread_[places].empty() ? nullptr : &spread_[places];
    if (shares != nullptr) {
        for (size_t place = 0; place < places; ++place) {
            const Field& now = now_[place];
            Field& shared = spread_[places + 1 + place];
            for (size_t i = 0; i < now.size(); ++i)
                shared[i] = (*shares)[i] * now[i];
        }
    }
    for (Field& field : after_)
        std::fill(field.begin(), field.end(), 0.0f);
    size_t pair = 0;
    for (size_t kernel = 0; kernel < kernels.taps.size(); ++kernel) {
        for (size_t place = 0; place < places; ++place) {
            if (!kernels.spreads[kernel][place]) continue;
            const Field& from = shares != nullptr ? spread_[places + 1 + place] : now_[place];
            convolve(from, kernels.taps[kernel], border, kernels.radius, &spread_[place]);
        }
        for (; pair < kernels.pairs.size() && kernels.pairs[pair].kernel == kernel; ++pair) {
            const size_t a = kernels.pairs[pair].a, b = kernels.pairs[pair].b;
            for_rows(border, [&](size_t first, size_t count) {
                const float *now_a = now_[a].data() + first, *now_b = now_[b].data() + first,
                            *spread_a = spread_[a].data() + first,
                            *spread_b = spread_[b].data() + first;
                float *to_a = after_[a].data() + first, *to_b = after_[b].data() + first;
                for (size_t i = 0; i < count; ++i) {
                    const float more = now_b[i] * spread_a[i] - now_a[i] * spread_b[i];
                    to_a[i] += more;
                    to_b[i] -= more;
                }
            });
        }
    }
    if (shares == nullptr) return;
    for (Field& field : after_) {
        for_rows(border, [&](size_t first, size_t count) {
            for (size_t i = first; i < first + count; ++i)
                field[i] *= (*shares)[i];
        });
    }
}

/// Makes fractions of after_ that are none possible: none below 0, and their sum that of the target.
void BleedWindow::keep_possible(const Vec3i& border) {
    for_rows(border, [&](size_t first, size_t count) {
        for (size_t i = first; i < first + count; ++i) {
            float wanted = 0, sum = 0;
            for (size_t place = 0; place < now_.size(); ++place) {
                wanted += target_[place][i];
                const float kept = std::max(after_[place][i], 0.0f);
                now_[place][i] = kept;
                sum += kept;
            }
            const float scale = sum > 0 ? wanted / sum : 0;
            for (Field& field : now_)
                field[i] *= scale;
        }
    });
}

void BleedWindow::run(const BleedKernels& kernels, int32_t steps, bool show) {
    for (size_t place = 0; place < now_.size(); ++place)
        target_[place] = now_[place];
    // Fractions and what is added to them, or taken off.
    const auto set_after = [&](const std::vector<Field>& to, float sign, const Vec3i& border) {
        for (size_t place = 0; place < now_.size(); ++place) {
            const Field& start = to[place];
            Field& after = after_[place];
            for_rows(border, [&](size_t first, size_t count) {
                for (size_t i = first; i < first + count; ++i)
                    after[i] = start[i] + sign * after[i];
            });
        }
        keep_possible(border);
    };
    // The share of each voxel in what is undone: so much that none of its fractions falls below 0. What one
    // cannot take, the others do not give, so that volumes stay.
    Field& shares = spread_[now_.size()];
    shares.clear();
    Vec3i border;
    if (steps > 0) {
        border = border + kernels.radius;
        bleed(kernels, border);
        shares.assign(now_.front().size(), 0.0f);
        for_rows(border, [&](size_t first, size_t count) {
            for (size_t i = first; i < first + count; ++i) {
                float share = 1;
                for (size_t place = 0; place < now_.size(); ++place) {
                    const float less = after_[place][i], there = target_[place][i];
                    if (less > there) share = std::min(share, there / less);
                }
                shares[i] = share;
            }
        });
    }
    for (int32_t step = 0; step < steps; ++step) {
        border = border + kernels.radius;
        bleed(kernels, border);
        set_after(target_, -1, border);
    }
    if (!show) return;
    shares.clear();
    border = border + kernels.radius;
    bleed(kernels, border);
    set_after(now_, 1, border);
}

}  // namespace openfab::process
