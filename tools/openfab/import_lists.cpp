// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/import_lists.h"
#include "base/json_text.h"

#include <algorithm>

namespace openfab::tools {

namespace {

/// Groups beyond those of an object are as its last.
std::string padded(std::vector<std::string> values, size_t count) {
    values.resize(count, values.back());
    return one_or_list(values, [](const std::string& v) { return v; });
}

}  // namespace

void ImportLists::add(size_t object, const std::string& fablet, const std::string& name,
                      std::vector<std::string> values) {
    Counts& counts = counts_[fablet];
    counts.groups = std::max(counts.groups, values.size());
    lists_.push_back({object, fablet, name, std::move(values)});
}

void ImportLists::add_maps(size_t object, std::vector<std::string> textures) {
    Counts& counts = counts_["textured"];
    counts.maps = std::max(counts.maps, textures.size());
    maps_.emplace_back(object, std::move(textures));
}

void ImportLists::add_mixture(size_t object, Mixture mixture) {
    Counts& counts = counts_["mixed"];
    counts.groups = std::max(counts.groups, mixture.size());
    for (const auto& group : mixture)
        counts.parts = std::max(counts.parts, group.size());
    mixtures_.emplace_back(object, std::move(mixture));
}

void ImportLists::write(std::vector<ObjectText>* objects) {
    std::map<size_t, UniformTexts> first;  // by object
    for (const List& list : lists_)
        first[list.object].emplace_back(list.name,
                                        padded(list.values, counts_.at(list.fablet).groups));
    for (const auto& [object, names] : maps_) {
        std::vector<std::string> texts;
        for (const std::string& name : names)
            texts.push_back(json_string(name));
        first[object].emplace_back("maps", padded(texts, counts_.at("textured").maps));
    }
    for (auto& [object, mixture] : mixtures_) {
        const Counts& counts = counts_.at("mixed");
        std::vector<std::string> names, shares;
        mixture.resize(counts.groups, mixture.back());
        for (const auto& group : mixture) {
            for (size_t p = 0; p < counts.parts; ++p) {
                const bool real = p < group.size();
                names.push_back(json_string(real ? group[p].first : group[0].first));
                shares.push_back(number(real ? group[p].second : 0));
            }
        }
        first[object].emplace_back("materials", padded(names, names.size()));
        first[object].emplace_back("shares", padded(shares, shares.size()));
    }
    for (auto& [object, uniforms] : first) {
        UniformTexts& others = (*objects)[object].uniforms;
        others.insert(others.begin(), uniforms.begin(), uniforms.end());
    }
}

}  // namespace openfab::tools
