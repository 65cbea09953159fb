// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/exchange/element_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "base/text.h"

namespace openfab::mechanics {

namespace {

std::string upper(std::string text) {
    for (char& c : text)
        c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return text;
}

/// Whether such a program could take a name for that of a set of ours.
bool is_own_label(const std::string& name) {
    const std::string label = upper(name);
    return label == kAllNodes || label == kLoaded || label.starts_with(kHeldPrefix) ||
           label.starts_with(kMostPrefix);
}

/// As programs of the nineties take names.
std::string plain_name(const std::string& name, std::set<std::string>* used) {
    std::string out;
    for (const char c : name)
        out += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    const bool letter = !out.empty() && std::isalpha(static_cast<unsigned char>(out[0])) != 0;
    if (!letter || is_own_label(out)) out = "m_" + out;
    constexpr size_t kLongest = 60;
    out.resize(std::min(out.size(), kLongest));
    const std::string first = out;
    // Such programs do not tell lower from upper case.
    for (int i = 2; !used->insert(upper(out)).second; ++i) {
        out = fmt::format("{}_{}", first, i);
        if (is_own_label(out)) out = "m_" + out;
    }
    return out;
}

/// A number whose equals are one section.
float rounded(float v, bool coarsely) {
    if (!coarsely || v == 0) return v;
    constexpr double kStep = 1e-3;
    const double sign = v < 0 ? -1 : 1;
    return static_cast<float>(
        sign * std::exp(kStep * std::round(std::log(std::abs(static_cast<double>(v))) / kStep)));
}

using Key = std::tuple<uint8_t, float, float, float>;  ///< material, lambda, mu, density

std::map<Key, int32_t> keys_of(const Voxels& v, const std::vector<int64_t>& elements, bool coarsely,
                               std::vector<int32_t>* section) {
    std::map<Key, int32_t> keys;
    section->clear();
    for (const int64_t one : elements) {
        const auto e = static_cast<size_t>(one);
        const Key key{v.code[e], rounded(v.lambda[e], coarsely), rounded(v.mu[e], coarsely),
                      rounded(v.density[e], coarsely)};
        section->push_back(keys.emplace(key, static_cast<int32_t>(keys.size())).first->second);
    }
    return keys;
}

}  // namespace

ElementMesh mesh_of(const Grid& grid, const Voxels& v) {
    ElementMesh out;
    out.grid = grid;
    out.origin_mm = v.origin_mm;
    out.materials = v.materials;
    std::vector<uint8_t> used(static_cast<size_t>(grid.node_count()));
    const size_t m = v.materials.size();
    std::vector<uint8_t> pure;  // whether each element is one material and whole
    for (int64_t e = 0; e < grid.element_count(); ++e) {
        const auto at = static_cast<size_t>(e);
        if (!(v.mu[at] > 0)) continue;
        out.elements.push_back(e);
        out.material.push_back(v.code[at]);
        float largest = 0;
        for (size_t k = 0; k < m; ++k) {
            const float share =
                v.shares.empty() ? (k + 1 == v.code[at] ? 1.F : 0.F) : v.shares[at * m + k];
            out.shares.push_back(share);
            largest = std::max(largest, share);
        }
        pure.push_back(largest > 0.9999F);
        for (const uint8_t d : {uint8_t{4}, uint8_t{5}})
            for (const int64_t node : nodes_of(grid, {e, d}))
                used[static_cast<size_t>(node)] = 1;
    }
    for (size_t n = 0; n < used.size(); ++n)
        if (used[n]) out.nodes.push_back(static_cast<int64_t>(n));
    constexpr size_t kManySections = 500;
    std::map<Key, int32_t> keys = keys_of(v, out.elements, false, &out.section);
    if (keys.size() > kManySections) keys = keys_of(v, out.elements, true, &out.section);
    std::vector<uint8_t> section_pure(keys.size(), 1);
    for (size_t i = 0; i < out.elements.size(); ++i)
        if (!pure[i]) section_pure[static_cast<size_t>(out.section[i])] = 0;
    out.sections.resize(keys.size());
    std::set<std::string> names;
    // Whole materials take their names before mixtures do.
    for (const bool whole : {true, false})
        for (const auto& [key, number] : keys) {
            const auto at = static_cast<size_t>(number);
            if ((section_pure[at] != 0) != whole) continue;
            const auto& [code, lambda, mu, density] = key;
            const double l = static_cast<double>(lambda), g = static_cast<double>(mu);
            const std::string& material =
                v.materials[static_cast<size_t>(std::max<int>(code, 1)) - 1];
            out.sections[at] = {plain_name(whole ? material : "mix_" + material, &names),
                                g * (3 * l + 2 * g) / (l + g), l / (2 * (l + g)),
                                static_cast<double>(density)};
        }
    return out;
}

std::array<int64_t, 8> ElementMesh::corners(size_t element) const {
    const std::array<int64_t, 4> low = nodes_of(grid, {elements[element], 4}),
                                 high = nodes_of(grid, {elements[element], 5});
    constexpr size_t kOrder[4] = {0, 1, 3, 2};
    std::array<int64_t, 8> out{};
    for (size_t k = 0; k < 4; ++k) {
        out[k] = index_of(low[kOrder[k]]);
        out[4 + k] = index_of(high[kOrder[k]]);
    }
    return out;
}

int64_t ElementMesh::index_of(int64_t node) const {
    return std::ranges::lower_bound(nodes, node) - nodes.begin();
}

Vec3 ElementMesh::place_mm(size_t node) const {
    const int64_t n = nodes[node];
    return {
        origin_mm[0] + static_cast<double>(n % grid.nodes[0]) * grid.pitch_mm[0],
        origin_mm[1] + static_cast<double>(n / grid.nodes[0] % grid.nodes[1]) * grid.pitch_mm[1],
        origin_mm[2] + static_cast<double>(n / grid.nodes[0] / grid.nodes[1]) * grid.pitch_mm[2]};
}

std::vector<std::string> shown_names(const std::vector<std::string>& materials) {
    std::vector<std::string> out;
    std::set<std::string> used;
    for (const std::string& material : materials) {
        std::string name = printable(material);
        std::erase(name, '"');
        if (name.empty()) name = "material";
        const std::string first = name;
        for (int i = 2; !used.insert(name).second; ++i)
            name = fmt::format("{} {}", first, i);
        out.push_back(std::move(name));
    }
    return out;
}

std::vector<std::pair<std::string, std::vector<float>>> element_fields(const ElementMesh& mesh) {
    std::vector<std::pair<std::string, std::vector<float>>> out{
        {"young_MPa", {}}, {"poisson", {}}, {"density_g_cm3", {}}};
    for (const int32_t s : mesh.section) {
        const Section& one = mesh.sections[static_cast<size_t>(s)];
        out[0].second.push_back(static_cast<float>(one.young_MPa));
        out[1].second.push_back(static_cast<float>(one.poisson));
        out[2].second.push_back(static_cast<float>(one.density_g_cm3));
    }
    const size_t m = mesh.materials.size();
    const std::vector<std::string> names = shown_names(mesh.materials);
    for (size_t k = 0; k < m; ++k) {
        std::vector<float> share;
        for (size_t e = 0; e < mesh.elements.size(); ++e)
            share.push_back(mesh.shares[e * m + k]);
        out.emplace_back("share_" + names[k], std::move(share));
    }
    return out;
}

}  // namespace openfab::mechanics
