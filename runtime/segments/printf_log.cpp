// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/segments/printf_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <utility>

#include "base/check.h"

namespace openfab::segments {

namespace {

// Pending lines beyond this are cut to what can still be shown.
constexpr size_t kPendingRoom = 4096;

/// Formats one printf conversion; the compiler has checked the value's type.
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

std::string format_values(const openfab_printf& print, const openfab_segments& segments,
                          const States& states, int32_t index) {
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
        append_value(std::string(at, end + 1), segments.states[state], states[state][index], &out);
        at = end + 1;
    }
    while (!out.empty() && out.back() == '\n')
        out.pop_back();
    return out;
}

}  // namespace

PrintfLog::Count& PrintfLog::count_of(const openfab_printf* print) {
    for (Count& count : counts_) {
        if (count.print == print) return count;
    }
    return counts_.emplace_back(Count{print, 0, 0});
}

void PrintfLog::add(const openfab_segments& segments, const openfab_printf& print,
                    std::span<const int32_t> groups, const States& states,
                    const PointAt& point_at) {
    int64_t all = 0;
    const bool full =  // by earlier batches
        std::any_of(counts_.begin(), counts_.end(), [&](const Count& count) {
            return count.print == &print && count.kept == most_lines();
        });
    for (const int32_t group : groups) {
        for (int32_t l = 0; l < kLanes; ++l) {
            const int32_t index = kLanes * group + l;
            if (states[print.guard][index] == 0) continue;
            const std::optional<std::array<float, 3>> at = point_at(index);
            if (!at) continue;
            ++all;
            if (full) continue;
            Line line{&print, fmt::format("{}:{}: at ({}, {}, {}) mm: {}", print.source, print.line,
                                          (*at)[0], (*at)[1], (*at)[2],
                                          format_values(print, segments, states, index))};
            pending_.push_back({index, std::move(line)});
            if (pending_.size() > sorted_ + kPendingRoom) shorten();
        }
    }
    if (all > 0) count_of(&print).all += all;
}

/// Sorts by index, stably, and drops all but the first lines of each printf.
void PrintfLog::shorten() {
    std::stable_sort(pending_.begin(), pending_.end(),
                     [](const Pending& a, const Pending& b) { return a.index < b.index; });
    std::vector<Count> seen;
    std::erase_if(pending_, [&](const Pending& p) {
        auto found = std::find_if(seen.begin(), seen.end(),
                                  [&](const Count& c) { return c.print == p.line.print; });
        if (found == seen.end()) found = seen.insert(seen.end(), Count{p.line.print, 0, 0});
        return ++found->kept > most_lines();
    });
    sorted_ = pending_.size();
}

void PrintfLog::end_batch() {
    if (pending_.empty()) return;
    shorten();
    for (Pending& p : pending_) {
        Count& count = count_of(p.line.print);
        if (count.kept == most_lines()) continue;
        ++count.kept;
        lines_.push_back(std::move(p.line));
    }
    pending_.clear();
    sorted_ = 0;
}

void PrintfLog::append(PrintfLog* later) {
    OPENFAB_CHECK(later->pending_.empty());  // its batches have ended
    for (Line& line : later->lines_) {
        Count& count = count_of(line.print);
        if (count.kept == most_lines()) continue;
        ++count.kept;
        lines_.push_back(std::move(line));
    }
    for (const Count& more : later->counts_)
        count_of(more.print).all += more.all;
    later->clear();
}

void PrintfLog::clear() {
    pending_.clear();
    sorted_ = 0;
    lines_.clear();
    counts_.clear();
}

std::vector<std::pair<const openfab_printf*, int64_t>> PrintfLog::left_out() const {
    std::vector<std::pair<const openfab_printf*, int64_t>> out;
    for (const Count& count : counts_) {
        if (count.all > count.kept) out.emplace_back(count.print, count.all - count.kept);
    }
    return out;
}

}  // namespace openfab::segments
