// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/ply_values.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "base/scan_number.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

static_assert(std::endian::native == std::endian::little);

bool is_space(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

}  // namespace

Complaint PlyValues::next_binary(PlyType type, double* out) {
    const size_t size = ply_type_bytes(type);
    if (bytes_.size() - at_ < size) return {messages::kFileEndsHere, messages::kWasCutShort};
    char raw[8] = {};
    std::memcpy(raw, bytes_.data() + at_, size);
    if (header_.big_endian) std::reverse(raw, raw + size);
    at_ += size;
    const auto as = [&]<typename T>(T value) {
        std::memcpy(&value, raw, sizeof value);
        return static_cast<double>(value);
    };
    switch (type) {
        case PlyType::kInt8:
            *out = as(int8_t{});
            break;
        case PlyType::kUint8:
            *out = as(uint8_t{});
            break;
        case PlyType::kInt16:
            *out = as(int16_t{});
            break;
        case PlyType::kUint16:
            *out = as(uint16_t{});
            break;
        case PlyType::kInt32:
            *out = as(int32_t{});
            break;
        case PlyType::kUint32:
            *out = as(uint32_t{});
            break;
        case PlyType::kFloat32:
            *out = as(float{});
            break;
        case PlyType::kFloat64:
            *out = as(double{});
            break;
    }
    return {};
}

Complaint PlyValues::next_ascii(PlyType type, double* out) {
    while (at_ < bytes_.size() && is_space(bytes_[at_]))
        line_ += bytes_[at_++] == '\n';
    const size_t start = at_;
    while (at_ < bytes_.size() && !is_space(bytes_[at_]))
        ++at_;
    const std::string_view token = bytes_.substr(start, at_ - start);
    if (token.empty()) return {messages::kFileEndsHere, messages::kWasCutShort};
    if (!is_ply_integer(type)) {
        if (token == "nan" || token == "-nan" || token == "NaN") {
            *out = NAN;
            return {};
        }
        return scan_number(token, out);
    }
    static constexpr int64_t kLeast[] = {-128, 0, -32768, 0, INT32_MIN, 0};
    static constexpr int64_t kMost[] = {127, 255, 32767, 65535, INT32_MAX, UINT32_MAX};
    int64_t value = 0;
    const auto t = static_cast<size_t>(type);
    std::string wrong = scan_integer(token, kLeast[t], kMost[t], &value);
    *out = static_cast<double>(value);
    return wrong;
}

}  // namespace openfab::mesh
