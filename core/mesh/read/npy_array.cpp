// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/npy_array.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstring>

#include "mesh/read/messages.h"

namespace openfab::mesh {

namespace {

constexpr size_t kMostAxes = 4;

/// Returns what follows `'key':` in a header, without blanks before it; empty where it is missing.
std::string_view value_of(std::string_view header, const std::string& key) {
    size_t at = header.find("'" + key + "'");
    if (at == std::string_view::npos) return {};
    at = header.find(':', at);
    if (at == std::string_view::npos) return {};
    header.remove_prefix(at + 1);
    header.remove_prefix(std::min(header.find_first_not_of(' '), header.size()));
    return header;
}

bool read_shape(std::string_view text, std::vector<int64_t>* shape) {
    if (!text.starts_with('(')) return false;
    const size_t end = text.find(')');
    if (end == std::string_view::npos) return false;
    text = text.substr(1, end - 1);
    for (;;) {
        text.remove_prefix(std::min(text.find_first_not_of(" ,"), text.size()));
        if (text.empty()) return true;
        int64_t value = 0;
        const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (code != std::errc() || value < 0 || shape->size() == kMostAxes) return false;
        shape->push_back(value);
        text.remove_prefix(static_cast<size_t>(stop - text.data()));
    }
}

template <typename T>
double load(const char* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return static_cast<double>(value);
}

}  // namespace

Complaint NpyArray::parse(std::string_view bytes, NpyArray* out) {
    constexpr std::string_view kMagic = "\x93NUMPY";
    if (bytes.size() < 12 || !bytes.starts_with(kMagic)) return messages::kNoArrayOfNumPy;
    const auto byte = [&](size_t i) { return static_cast<size_t>(static_cast<uint8_t>(bytes[i])); };
    const bool long_header = byte(6) >= 2;
    const size_t begin = long_header ? 12 : 10;
    size_t length = byte(8) | byte(9) << 8;
    if (long_header) length |= byte(10) << 16 | byte(11) << 24;
    if (length > bytes.size() - begin) return messages::kArrayHeaderCutShort;
    const std::string_view header = bytes.substr(begin, length);
    const std::string_view type = value_of(header, "descr");
    const std::string_view order = value_of(header, "fortran_order");
    std::vector<int64_t> shape;
    if (type.size() < 5 || order.empty() || !read_shape(value_of(header, "shape"), &shape))
        return messages::kArrayHeaderWrong;
    const char end = type[1], kind = type[2];
    const int32_t width = type[3] - '0';
    const bool fine =
        (kind == 'f' && (width == 4 || width == 8)) ||
        ((kind == 'i' || kind == 'u') && (width == 1 || width == 2 || width == 4 || width == 8)) ||
        (kind == 'b' && width == 1);
    if (type[0] != '\'' || type[4] != '\'' || !fine || (end != '<' && end != '|'))
        return {fmt::format(messages::kArrayNumbersType, type.substr(0, type.find(','))),
                messages::kArrayNumbersTypeHelp};
    if (!order.starts_with("False"))
        return {messages::kArrayFirstIndexFastest, messages::kArrayFirstIndexFastestHelp};
    int64_t size = 1;
    const int64_t most = static_cast<int64_t>(bytes.size() - begin - length) / width;
    for (const int64_t n : shape) {
        if (n > 0 && size > most / n) return messages::kArrayCutShort;
        size *= n;
    }
    if (size > most) return messages::kArrayCutShort;
    out->shape_ = std::move(shape);
    out->size_ = size;
    out->kind_ = kind;
    out->width_ = width;
    out->data_ = bytes.data() + begin + length;
    return {};
}

double NpyArray::at(int64_t i) const {
    const char* from = data_ + i * width_;
    if (kind_ == 'f') return width_ == 4 ? load<float>(from) : load<double>(from);
    const bool with_sign = kind_ == 'i';
    switch (width_) {
        case 1:
            return with_sign ? load<int8_t>(from) : load<uint8_t>(from);
        case 2:
            return with_sign ? load<int16_t>(from) : load<uint16_t>(from);
        case 4:
            return with_sign ? load<int32_t>(from) : load<uint32_t>(from);
        default:
            return with_sign ? load<int64_t>(from) : load<uint64_t>(from);
    }
}

std::string NpyArray::shape_text() const {
    return shape_.size() == 1 ? fmt::format("({},)", shape_[0])
                              : fmt::format("({})", fmt::join(shape_, ", "));
}

}  // namespace openfab::mesh
