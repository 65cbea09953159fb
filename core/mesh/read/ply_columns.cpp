// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/ply_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

#include "base/color.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

/// Columns that form one attribute.
struct PlyVector {
    std::string name;
    size_t columns = 1;
};

struct PlyParts {
    const char* attribute;
    std::array<const char*, 4> names;  ///< up to the first nullptr
};

constexpr PlyParts kKnown[] = {{"n", {"nx", "ny", "nz"}},
                               {"n", {"normal_x", "normal_y", "normal_z"}},
                               {"uv", {"u", "v"}},
                               {"uv", {"s", "t"}},
                               {"uv", {"texture_u", "texture_v"}},
                               {"uv", {"texture_s", "texture_t"}},
                               {"color", {"red", "green", "blue"}},
                               {"color", {"r", "g", "b"}},
                               {"color", {"diffuse_red", "diffuse_green", "diffuse_blue"}}};

/// Suffixes of component names; at least two form a vector.
constexpr std::array<const char*, 4> kSuffixes[] = {
    {"_x", "_y", "_z", "_w"}, {"_0", "_1", "_2", "_3"}, {"_r", "_g", "_b", "_a"}, {"_u", "_v"}};

/// Returns the attribute that starts with columns[at]; all components have one type.
PlyVector vector_at(const std::vector<PlyColumn>& columns, size_t at) {
    const auto is = [&](size_t i, const std::string& name) {
        return at + i < columns.size() && columns[at + i].property->name == name &&
               columns[at + i].property->type == columns[at].property->type;
    };
    for (const auto& [attribute, names] : kKnown) {
        size_t found = 0;
        while (found < names.size() && names[found] != nullptr && is(found, names[found]))
            ++found;
        if (found == names.size() || names[found] == nullptr) return {attribute, found};
    }
    const std::string& first = columns[at].property->name;
    for (const auto& suffixes : kSuffixes) {
        if (first.size() < 3 || !first.ends_with(suffixes[0])) continue;
        const std::string stem = first.substr(0, first.size() - 2);
        size_t found = 0;
        while (found < suffixes.size() && suffixes[found] != nullptr &&
               is(found, stem + suffixes[found]))
            ++found;
        if (found >= 2) return {stem, found};
    }
    return {first, 1};
}

std::string objection(const Mesh& mesh, const PlyVector& vector,
                      const std::vector<PlyColumn>& parts, const char* element) {
    if (mesh.find(vector.name) != nullptr) return messages::kNameOfOtherAttribute;
    for (const PlyColumn& part : parts) {
        if (part.odd >= 0) return fmt::format(messages::kValueTooLargeAt, element, part.odd);
    }
    return {};
}

MeshAttribute int_attribute(const PlyVector& vector, const std::vector<PlyColumn>& parts,
                            const std::vector<std::array<int32_t, 3>>& rows) {
    MeshAttribute a;
    a.name = vector.name;
    a.is_int = true;
    a.components = static_cast<int32_t>(parts.size());
    for (const auto& row : rows) {
        for (const PlyColumn& part : parts) {
            const double value = part.values[row[0]];
            a.faces.push_back(static_cast<int32_t>(static_cast<int64_t>(value)));
        }
    }
    return a;
}

/// Returns the value of full light: that of the type, or for floats and larger types of what is
/// written, 1, 255 or 65535.
double color_range(const std::vector<PlyColumn>& parts) {
    const PlyType type = parts[0].property->type;
    if (type == PlyType::kUint8) return 255;
    double largest = 0;
    for (const PlyColumn& part : parts) {
        for (const double value : part.values)
            largest = std::max(largest, value);
    }
    if (!is_ply_integer(type) && largest <= 1) return 1;
    return largest <= 255 ? 255 : 65535;
}

MeshAttribute float_attribute(const PlyVector& vector, const std::vector<PlyColumn>& parts,
                              const std::vector<std::array<int32_t, 3>>& corners) {
    MeshAttribute a;
    a.name = vector.name;
    a.components = static_cast<int32_t>(parts.size());
    a.corners = corners;
    a.values.reserve(parts[0].values.size() * parts.size());
    const double range = vector.name == "color" ? color_range(parts) : 0;
    double last = 0;
    float last_linear = 0;  // neighbours are often alike
    for (size_t row = 0; row < parts[0].values.size(); ++row) {
        for (const PlyColumn& part : parts) {
            const double value = part.values[row];
            if (range > 0 && value != last) {
                last = value;
                last_linear =
                    static_cast<float>(srgb_to_linear(std::clamp(value / range, 0.0, 1.0)));
            }
            a.values.push_back(range > 0 ? last_linear : static_cast<float>(value));
        }
    }
    return a;
}

}  // namespace

void add_ply_attributes(const std::vector<PlyColumn>& columns, const char* element,
                        const std::vector<std::array<int32_t, 3>>& corners, MeshSource* out) {
    for (size_t at = 0; at < columns.size();) {
        const PlyVector vector = vector_at(columns, at);
        const auto first = columns.begin() + static_cast<std::ptrdiff_t>(at);
        const std::vector<PlyColumn> parts(first,
                                           first + static_cast<std::ptrdiff_t>(vector.columns));
        at += vector.columns;
        if (std::string why = objection(out->mesh, vector, parts, element); !why.empty()) {
            out->warnings.push_back(fmt::format(messages::kPropertyLeftOut, out->origin.file,
                                                vector.name, element, why));
            continue;
        }
        const bool is_int = std::string_view(element) == "face" &&
                            is_ply_integer(parts[0].property->type) && vector.name != "color";
        out->mesh.attributes.push_back(is_int ? int_attribute(vector, parts, corners)
                                              : float_attribute(vector, parts, corners));
    }
}

void tell_ply_transparency(const std::vector<PlyColumn>& columns, MeshSource* out) {
    const auto is = [](const PlyColumn& column, std::string_view name) {
        return column.property->name == name;
    };
    for (size_t i = 1; i < columns.size(); ++i) {
        const bool is_alpha = (is(columns[i], "alpha") && is(columns[i - 1], "blue")) ||
                              (is(columns[i], "a") && is(columns[i - 1], "b"));
        if (!is_alpha) continue;
        const double full = color_range({columns[i]});
        const auto clear = std::count_if(columns[i].values.begin(), columns[i].values.end(),
                                         [&](double value) { return value < full; });
        if (clear == 0) continue;
        out->left_out.push_back({messages::kTransparentColours, out->origin.file,
                                 messages::kTransparentColoursHelp, clear});
    }
}

}  // namespace openfab::mesh
