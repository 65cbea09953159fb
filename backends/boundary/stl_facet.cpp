// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/stl_facet.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <string_view>

namespace openfab::boundary {

static_assert(std::endian::native == std::endian::little, "STL is written as it lies in memory");

std::array<uint8_t, kStlHeaderBytes> stl_header(const std::string& title, uint32_t triangles) {
    std::array<uint8_t, kStlHeaderBytes> out{};
    std::memcpy(out.data(), title.data(), std::min(title.size(), kStlTitleBytes));
    std::memcpy(out.data() + kStlTitleBytes, &triangles, sizeof triangles);
    return out;
}

namespace {

constexpr std::string_view kPrintMark = " print=", kDigestMark = " xxh3=";
constexpr size_t kDigits = 16;
constexpr size_t kDigestAt = kStlTitleBytes - kDigestMark.size() - kDigits;
constexpr size_t kPrintAt = kDigestAt - kPrintMark.size() - kDigits;
static_assert(kPrintAt == kStlOwnTitleBytes);

bool read_mark(const char* title, size_t at, std::string_view mark, uint64_t* out) {
    const char* const end = title + at + mark.size() + kDigits;
    return std::string_view(title + at, mark.size()) == mark &&
           std::from_chars(title + at + mark.size(), end, *out, 16).ptr == end;
}

}  // namespace

void put_stl_marks(const StlMarks& marks, std::array<uint8_t, kStlHeaderBytes>* header) {
    const std::string text = fmt::format("{}{:0{}x}{}{:0{}x}", kPrintMark, marks.print, kDigits,
                                         kDigestMark, marks.digest, kDigits);
    // Zeros would end the title before it.
    uint8_t* const title = header->data();
    std::replace(title, title + kPrintAt, uint8_t{0}, static_cast<uint8_t>(' '));
    std::copy(text.begin(), text.end(), title + kPrintAt);
}

std::optional<StlMarks> stl_marks(const std::array<uint8_t, kStlHeaderBytes>& header) {
    const char* const title = reinterpret_cast<const char*>(header.data());
    StlMarks marks;
    if (!read_mark(title, kPrintAt, kPrintMark, &marks.print) ||
        !read_mark(title, kDigestAt, kDigestMark, &marks.digest))
        return {};
    return marks;
}

std::string safe_file_name(const std::string& name) {
    std::string out;
    for (char c : name) {
        const bool fine = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '-' || c == '.';
        out += fine ? c : '_';
    }
    return out;
}

void put_stl_facet(const std::array<Vec3f, 3>& corners, uint8_t* out) {
    const auto corner = [&](size_t i) { return vec_cast<double>(corners[i]); };
    const Vec3d area = cross(corner(1) - corner(0), corner(2) - corner(0));
    const double size = length(area);
    Vec3f normal;
    for (int axis = 0; axis < 3 && size > 0; ++axis)
        normal[axis] = static_cast<float>(area[axis] / size + 0.0);  // no -0
    static_assert(sizeof normal + sizeof corners + 2 == kStlFacetBytes);
    std::memcpy(out, &normal, sizeof normal);
    std::memcpy(out + sizeof normal, corners.data(), sizeof corners);
    std::memset(out + sizeof normal + sizeof corners, 0, 2);
}

}  // namespace openfab::boundary
