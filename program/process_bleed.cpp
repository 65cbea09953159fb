// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "base/hash.h"
#include "base/text.h"
#include "program/messages.h"
#include "program/process.h"
#include "runtime/pipeline/slab_parts.h"

namespace openfab::program {

namespace {

constexpr const char* kVoidName = "void";

/// A code, of `void` 0; -1: no material of the print; -2: `*`.
int32_t code_of(const pipeline::PrintInput& input, const std::string& name) {
    if (name == "*") return -2;
    const uint8_t code = material_code(input.materials, name);
    if (code != 0) return code;
    return name == kVoidName ? 0 : -1;
}

std::string name_of(const pipeline::PrintInput& input, int32_t code) {
    return code == 0 ? kVoidName : input.materials[static_cast<size_t>(code - 1)].name;
}

using Pairs = std::map<std::pair<int32_t, int32_t>, Vec3d>;

/// Returns whether the pair had another spread.
bool set_pair(int32_t a, int32_t b, const Vec3d& sigma_um, bool replace, Pairs* pairs) {
    if (a == b) return false;
    const auto key = std::minmax(a, b);
    const auto [known, fresh] = pairs->try_emplace({key.first, key.second}, sigma_um);
    const bool other = !fresh && known->second != sigma_um;
    if (replace) known->second = sigma_um;
    return other;
}

/// Returns the spread of each pair. Those named come first, those with one `*` next.
Pairs pairs_of(const world::Bleed& bleed, const pipeline::PrintInput& input, int32_t materials,
               std::vector<std::string>* warnings) {
    Pairs pairs;
    for (int stars = 0; stars <= 2; ++stars) {
        Pairs of_rank;
        for (const world::PairBleed& pair : bleed.pairs) {
            if ((pair.a == "*" ? 1 : 0) + (pair.b == "*" ? 1 : 0) != stars) continue;
            const int32_t a = code_of(input, pair.a), b = code_of(input, pair.b);
            for (const std::string& name : {pair.a, pair.b}) {
                if (code_of(input, name) != -1) continue;
                std::string told = fmt::format(messages::kBleedIdle, printable(name),
                                               suggest_material(input.materials, name));
                if (std::ranges::find(*warnings, told) == warnings->end())
                    warnings->push_back(std::move(told));
            }
            if (a == -1 || b == -1) continue;
            if (std::max(a, b) > materials) {
                warnings->push_back(fmt::format(messages::kBleedOfSupport, pair.a, pair.b));
                continue;
            }
            bool again = false;
            for (int32_t i = a == -2 ? 1 : a; i <= (a == -2 ? materials : a); ++i) {
                for (int32_t j = b == -2 ? 1 : b; j <= (b == -2 ? materials : b); ++j)
                    again = set_pair(i, j, pair.sigma_um, true, &of_rank) || again;
            }
            // With one `*`, two may meet at the pair of their names.
            if (again && stars != 1)
                warnings->push_back(fmt::format(messages::kBleedTwice, pair.a, pair.b));
        }
        for (const auto& [key, sigma] : of_rank)
            set_pair(key.first, key.second, sigma, false, &pairs);
    }
    for (int32_t i = 1; i <= materials; ++i) {
        for (int32_t j = i + 1; j <= materials; ++j)
            set_pair(i, j, bleed.sigma_um, false, &pairs);
    }
    std::erase_if(pairs, [](const auto& pair) { return pair.second == Vec3d{}; });
    return pairs;
}

/// `2 steps; white and black 40 x 40 x 20 um; …`, cut where there are many.
std::string describe(const Pairs& pairs, const pipeline::PrintInput& input, int32_t steps,
                     bool show) {
    constexpr size_t kMost = 400;
    std::string text = steps > 0 ? fmt::format("undone in {} steps", steps) : "not undone";
    if (show) text += ", shown";
    for (const auto& [key, sigma] : pairs) {
        text += fmt::format("; {} and {} {} x {} x {} um", name_of(input, key.first),
                            name_of(input, key.second), sigma.x, sigma.y, sigma.z);
        if (text.size() > kMost) return text + " …";
    }
    return text;
}

}  // namespace

Result<std::shared_ptr<const process::Bleed>> open_bleed(const Options& options,
                                                         const world::Printer& printer,
                                                         pipeline::PrintInput* input) {
    const std::optional<world::Bleed>& bleed = printer.process.bleed;
    const std::shared_ptr<const process::Bleed> none;
    // A solid has no mixtures.
    if (options.altered.solid) return none;
    if (!bleed) {
        if (options.as_built) return none;
        if (options.bleed == "show" || options.bleed == "both") {
            return user_error(fmt::format(messages::kBleedNotKnown, options.bleed));
        }
        return none;
    }
    const bool show = options.bleed == "show" || options.bleed == "both";
    const int32_t steps = options.bleed == "undo" || options.bleed == "both" ? bleed->steps : 0;
    if (steps == 0 && !show) return none;
    const int32_t materials = pipeline::model_materials(
        input->parts, static_cast<int32_t>(input->materials.size()), input->support_code);
    const Pairs pairs = pairs_of(*bleed, *input, materials, &input->warnings);
    std::vector<process::PairSpread> spreads;
    for (const auto& [key, sigma] : pairs) {
        const Vec3d& pitch = input->pitch_mm;
        spreads.push_back(
            {static_cast<uint8_t>(key.first),
             static_cast<uint8_t>(key.second),
             {sigma.x * 1e-3 / pitch.x, sigma.y * 1e-3 / pitch.y, sigma.z * 1e-3 / pitch.z}});
    }
    if (spreads.empty()) return none;
    auto made = std::make_shared<process::Bleed>(std::move(spreads), steps, show);
    constexpr int32_t kMost = process::Bleed::kMostReach;
    for (int axis = 0; axis < 3; ++axis) {
        if (made->reach()[axis] <= kMost) continue;
        return user_error(
            fmt::format(messages::kBleedTooFar, made->reach()[axis], "xyz"[axis], kMost));
    }
    if (made->leaves_parts()) input->margin_vox = made->reach();
    input->process.emplace_back("bleed", describe(pairs, *input, steps, show));
    // What is told may be cut.
    Hasher hash;
    hash.add(steps);
    hash.add(int32_t{show});
    for (const auto& [key, sigma] : pairs) {
        hash.add(key.first), hash.add(key.second);
        for (int axis = 0; axis < 3; ++axis)
            hash.add(sigma[axis]);
    }
    input->process.emplace_back("hash of bleed", fmt::format("{:016x}", hash.value()));
    return std::shared_ptr<const process::Bleed>(std::move(made));
}

}  // namespace openfab::program
