// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/volume/point_prints.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <utility>

#include "base/check.h"

namespace openfab::slab {

namespace {

// Pending lines beyond this are cut to what can still be shown.
constexpr size_t kPendingRoom = 4096;

/// One conversion as printf has it; the compiler has made the value's type fit.
void append_value(const std::string& conversion, openfab_scalar_type type, uint32_t bits,
                  std::string* out) {
    char text[512];
    int length = 0;
    if (type == OPENFAB_FLOAT) {
        length = std::snprintf(text, sizeof text, conversion.c_str(),
                               static_cast<double>(std::bit_cast<float>(bits)));
    } else if (type == OPENFAB_UINT) {
        length = std::snprintf(text, sizeof text, conversion.c_str(), bits);
    } else {
        length = std::snprintf(text, sizeof text, conversion.c_str(), static_cast<int32_t>(bits));
    }
    if (length > 0) out->append(text, std::min(static_cast<size_t>(length), sizeof text - 1));
}

std::string format_values(const openfab_print& print, const openfab_phases& phases,
                          const phases::States& states, int32_t index) {
    std::string out;
    const char* at = print.format;
    int32_t next = 0;
    while (*at != '\0') {
        if (*at != '%' || at[1] == '%') {
            out += *at;
            at += *at == '%' ? 2 : 1;
            continue;
        }
        const char* end = std::strpbrk(at, "diuxXfFeEgG");
        if (end == nullptr || next == print.value_count) break;
        const int32_t state = print.values[next++];
        append_value(std::string(at, end + 1), phases.states[state], states[state][index], &out);
        at = end + 1;
    }
    while (!out.empty() && out.back() == '\n')
        out.pop_back();
    return out;
}

/// attr.voxelCenter of a place, in the order of operations of abi/fablet_table.h.
std::string centre_text(const PrintPart& part, const int32_t* corner, int32_t place) {
    const auto half = [](int32_t index) { return static_cast<float>(index) + 0.5f; };
    const float x = half(corner[0] + place / 8 % 8);
    const float y = half(corner[1] + place / 64 % 8);
    const float z = half(corner[2] + place % 8);
    std::array<float, 3> at{};
    for (size_t a = 0; a < 3; ++a) {
        const auto f = [&](size_t base) { return part.frame[base + a]; };
        at[a] = ((x * f(OPENFAB_FRAME_STEP_I) + y * f(OPENFAB_FRAME_STEP_J)) +
                 z * f(OPENFAB_FRAME_STEP_K)) +
                f(OPENFAB_FRAME_ORIGIN) + f(OPENFAB_FRAME_CENTER);
    }
    return fmt::format("({}, {}, {}) mm", at[0], at[1], at[2]);
}

}  // namespace

PointPrints::Count& PointPrints::count_of(const openfab_print* print) {
    for (Count& count : counts_) {
        if (count.print == print) return count;
    }
    return counts_.emplace_back(Count{print, 0, 0});
}

void PointPrints::add(const PrintPart& part, const openfab_phases& phases, const int32_t* corners,
                      const openfab_print& print, std::span<const int32_t> groups,
                      const phases::States& states) {
    int64_t all = 0;
    for (const int32_t group : groups) {
        for (int32_t l = 0; l < phases::kLanes; ++l) {
            const int32_t place = phases::kLanes * group + l;
            if (states[print.guard][place] == 0) continue;
            ++all;
            Line line{&print, fmt::format("{}:{}: at {}: {}", print.source, print.line,
                                          centre_text(part, corners + 3 * (place / 512), place),
                                          format_values(print, phases, states, place))};
            pending_.push_back({place, std::move(line)});
            if (pending_.size() > sorted_ + kPendingRoom) shorten();
        }
    }
    if (all > 0) count_of(&print).all += all;
}

/// Sorts by place, stably, and drops what comes after the first lines of each print.
void PointPrints::shorten() {
    std::stable_sort(pending_.begin(), pending_.end(),
                     [](const Pending& a, const Pending& b) { return a.place < b.place; });
    std::vector<Count> seen;
    std::erase_if(pending_, [&](const Pending& p) {
        auto found = std::find_if(seen.begin(), seen.end(),
                                  [&](const Count& c) { return c.print == p.line.print; });
        if (found == seen.end()) found = seen.insert(seen.end(), Count{p.line.print, 0, 0});
        return ++found->kept > kMostLines;
    });
    sorted_ = pending_.size();
}

void PointPrints::end_batch() {
    if (pending_.empty()) return;
    shorten();
    for (Pending& p : pending_) {
        Count& count = count_of(p.line.print);
        if (count.kept == kMostLines) continue;
        ++count.kept;
        lines_.push_back(std::move(p.line));
    }
    pending_.clear();
    sorted_ = 0;
}

void PointPrints::append(PointPrints* later) {
    OPENFAB_CHECK(later->pending_.empty());  // its batches were ended
    for (Line& line : later->lines_) {
        Count& count = count_of(line.print);
        if (count.kept == kMostLines) continue;
        ++count.kept;
        lines_.push_back(std::move(line));
    }
    for (const Count& more : later->counts_)
        count_of(more.print).all += more.all;
    later->clear();
}

void PointPrints::clear() {
    pending_.clear();
    sorted_ = 0;
    lines_.clear();
    counts_.clear();
}

std::vector<std::pair<const openfab_print*, int64_t>> PointPrints::left_out() const {
    std::vector<std::pair<const openfab_print*, int64_t>> out;
    for (const Count& count : counts_) {
        if (count.all > count.kept) out.emplace_back(count.print, count.all - count.kept);
    }
    return out;
}

}  // namespace openfab::slab
