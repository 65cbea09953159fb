// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/printed_values.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "base/json_text.h"

namespace openfab::viewer {

namespace {

std::vector<float> numbers_of(std::string_view text) {
    std::vector<float> out;
    while (!text.empty()) {
        const size_t end = std::min(text.find_first_of(", "), text.size());
        const std::string_view word = text.substr(0, end);
        if (!word.empty()) {
            float value = std::numeric_limits<float>::quiet_NaN();
            if (std::from_chars(word.data(), word.data() + word.size(), value).ec ==
                std::errc::result_out_of_range)
                value = 0;
            out.push_back(value);
        }
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return out;
}

int32_t number_of(const JsonValue& json, const char* name) {
    const JsonValue* found = member_of(json, name);
    return found == nullptr ? 0 : static_cast<int32_t>(found->number);
}

bool is_true(const JsonValue& json, const char* name) {
    const JsonValue* found = member_of(json, name);
    return found != nullptr && found->is(JsonValue::Kind::kBool) && found->boolean;
}

}  // namespace

PrintedValues::PrintedValues(const JsonValue& printed) : has_places_(is_true(printed, "places")) {
    const JsonValue* values = member_of(printed, "values");
    if (values == nullptr) return;
    for (const JsonValue& one : values->items) {
        const JsonValue* type = member_of(one, "type");
        values_[number_of(one, "node")] = {type == nullptr ? std::string() : type->text,
                                           static_cast<size_t>(number_of(one, "numbers")),
                                           {}};
    }
}

void PrintedValues::read(std::string_view text) {
    for (size_t from = 0; from < text.size();) {
        const size_t to = std::min(text.find('\n', from), text.size());
        line(text.substr(from, to - from));
        from = to + 1;
    }
}

/// `ball.fl:7: at (1, 2, 3) mm: =4 0.5`
void PrintedValues::line(std::string_view line) {
    constexpr std::string_view kAt = ": at (";
    constexpr std::string_view kMm = ") mm: ";
    const size_t at = line.find(kAt);
    if (at == std::string_view::npos) return;
    const size_t mm = line.find(kMm, at);
    if (mm == std::string_view::npos || mm + kMm.size() >= line.size()) return;
    const std::string_view point = line.substr(at + kAt.size(), mm - at - kAt.size());
    const std::string_view rest = line.substr(mm + kMm.size());
    const std::vector<float> read = numbers_of(rest.substr(1));
    if (rest[0] == '@' && read.size() == 4) {
        point_ = point;
        places_.push_back({read[1], read[2], read[3]});
    } else if (rest[0] == '=' && !read.empty()) {
        if (!has_places_ && point != point_) {
            point_ = point;
            const std::vector<float> p = numbers_of(point);
            if (p.size() == 3) places_.push_back({p[0], p[1], p[2]});
        }
        const auto found = values_.find(static_cast<int32_t>(read[0]));
        if (found == values_.end() || read.size() != found->second.numbers + 1 || places_.empty())
            return;
        found->second.at[places_.size() - 1].assign(read.begin() + 1, read.end());
    }
}

}  // namespace openfab::viewer
