// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/boundary/filament_mixtures.h"

#include <fmt/format.h>

#include <algorithm>

#include "backends/boundary/mesh_sink.h"
#include "base/json_text.h"

namespace openfab::boundary {

namespace {

constexpr size_t kMostParts = 3;  // of a mixture, as PrusaSlicer's own

std::string hex(const std::array<uint8_t, 4>& color) {
    return fmt::format("#{:02X}{:02X}{:02X}", color[0], color[1], color[2]);
}

}  // namespace

Quarters quarters_of(std::span<const float> amounts) {
    struct Part {
        size_t filament = 0;
        double amount = 0;
        uint32_t quarters = 0;
    };
    std::array<Part, kMostParts> parts{};
    size_t count = 0;
    // The largest first; of equal ones that with the lower number.
    for (size_t m = 0; m < std::min(amounts.size(), kMostFilaments); ++m) {
        Part one{m, static_cast<double>(amounts[m]), 0};
        if (!(one.amount > 0)) continue;
        for (size_t i = 0; i < count; ++i)
            if (one.amount > parts[i].amount) std::swap(one, parts[i]);
        if (count < kMostParts) parts[count++] = one;
    }
    double sum = 0;
    for (size_t i = 0; i < count; ++i)
        sum += parts[i].amount;
    if (!(sum > 0)) return 0;
    uint32_t left = kQuartersOfAll;
    for (size_t i = 0; i < count; ++i) {
        parts[i].quarters = static_cast<uint32_t>(parts[i].amount / sum * kQuartersOfAll);
        left -= parts[i].quarters;
    }
    for (; left > 0; --left) {
        Part* most = parts.data();
        const auto rest = [&](const Part& p) {
            return p.amount / sum * kQuartersOfAll - static_cast<double>(p.quarters);
        };
        for (size_t i = 1; i < count; ++i)
            if (rest(parts[i]) > rest(*most)) most = &parts[i];
        ++most->quarters;
    }
    Quarters out = 0;
    for (size_t i = 0; i < count; ++i)
        out |= Quarters{parts[i].quarters} << (3 * parts[i].filament);
    return out;
}

void FilamentMixtures::begin(const std::vector<pipeline::SliceMaterial>& materials) {
    materials_ = materials;
    mixtures_.clear();
    numbers_.clear();
    for (size_t m = 0; m < materials.size(); ++m)
        numbers_[Quarters{kQuartersOfAll} << (3 * m)] = static_cast<uint8_t>(m + 1);
}

uint8_t FilamentMixtures::number(Quarters mixture) {
    const auto found = numbers_.find(mixture);
    if (found != numbers_.end()) return found->second;
    if (numbers_.size() == kMostFilaments) return 0;
    mixtures_.push_back(mixture);
    return numbers_[mixture] = static_cast<uint8_t>(numbers_.size() + 1);
}

std::vector<pipeline::SliceMaterial> FilamentMixtures::all() const {
    std::vector<pipeline::SliceMaterial> out = materials_;
    const MixtureColors colors(materials_);
    for (const Quarters mixture : mixtures_) {
        pipeline::SliceMaterial& one = out.emplace_back();
        std::vector<float> amounts;
        for (size_t m = 0; m < materials_.size(); ++m) {
            const uint32_t quarters = share_of(mixture, m);
            amounts.push_back(static_cast<float>(quarters) / kQuartersOfAll);
            if (quarters == 0) continue;
            one.name +=
                fmt::format("{}{} {}", one.name.empty() ? "" : " + ", quarters, materials_[m].name);
        }
        const Rgba color = colors.of(amounts);
        for (size_t c = 0; c < 4; ++c)
            one.preview[c] = static_cast<uint8_t>(color >> (24 - 8 * c));
    }
    return out;
}

std::string FilamentMixtures::json() const {
    if (mixtures_.empty()) return {};
    const std::vector<pipeline::SliceMaterial> listed = all();
    JsonText json(JsonText::Layout::kIndentedLists);
    json.begin_object().member("version", 1).key("physical_extruders").begin_array();
    const auto begin_one = [&](size_t k) {
        json.begin_object().member("id", static_cast<int32_t>(k + 1));
        json.member("color", hex(listed[k].preview));
    };
    for (size_t m = 0; m < materials_.size(); ++m) {
        begin_one(m);
        json.member("name", materials_[m].name).end_object();
    }
    json.end_array().key("virtual_extruders").begin_array();
    for (size_t k = 0; k < mixtures_.size(); ++k) {
        begin_one(materials_.size() + k);
        json.member("kind", "fullspectrum").key("components").begin_array();
        for (size_t m = 0; m < materials_.size(); ++m) {
            const uint32_t quarters = share_of(mixtures_[k], m);
            if (quarters == 0) continue;
            json.begin_object().member("extruder", static_cast<int32_t>(m + 1));
            json.member("ratio", static_cast<double>(quarters) / kQuartersOfAll).end_object();
        }
        json.end_array().end_object();
    }
    json.end_array().end_object();
    return json.take();
}

}  // namespace openfab::boundary
