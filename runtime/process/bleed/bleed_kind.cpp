// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `bleed` of a process and `--bleed`: which pairs run into each other, and how far.

#include "runtime/process/bleed/bleed_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "base/at.h"
#include "base/hash.h"
#include "base/text.h"
#include "runtime/process/bleed/bleed.h"
#include "runtime/process/bleed/messages.h"

namespace openfab::process {

namespace {

using world::JsonReader;

/// How far two materials run into each other before they set.
struct PairBleed {
    std::string a,
        b;  ///< `void` is where nothing is printed; `*` all materials that no other entry has
    Vec3d sigma_um;
};

struct ProfileBleed {
    Vec3d sigma_um;  ///< of pairs that are not listed, void not among them
    std::vector<PairBleed> pairs;
    int32_t steps = 2;  ///< in which it is undone
};

Vec3d read_sigma(const JsonValue& value, JsonReader* json) {
    constexpr double kMost_um = 10'000;
    if (value.is(JsonValue::Kind::kNumber)) {
        const double s = json->number(value, "`sigma_um`", 0, kMost_um);
        return {s, s, s};
    }
    const std::vector<double> n = json->numbers(value, "`sigma_um`", 3, kMost_um);
    for (const double s : n) {
        if (s < 0)
            json->fail(value, fmt::format(messages::kSigmaNegative, s),
                       messages::kSigmaNegativeHelp);
    }
    return {n[0], n[1], n[2]};
}

PairBleed read_pair(const JsonValue& value, JsonReader* json) {
    static const world::KeySet keys = {
        "pairs", {"materials", "sigma_um"}, {"materials", "sigma_um"}};
    PairBleed out;
    if (!json->object(value, keys, "an entry of `pairs`")) return out;
    const JsonValue& names = value.find("materials")->value;
    if (!names.is(JsonValue::Kind::kArray) || names.items.size() != 2) {
        json->fail(names, messages::kPairWithoutTwoNames, messages::kPairWithoutTwoNamesHelp);
        return out;
    }
    out.a = json->string(names.items[0], "a name in `materials`");
    out.b = json->string(names.items[1], "a name in `materials`");
    if (json->ok() && out.a == out.b && out.a != "*")
        json->fail(names, fmt::format(messages::kBleedsIntoItself, out.a),
                   messages::kBleedsIntoItselfHelp);
    out.sigma_um = read_sigma(value.find("sigma_um")->value, json);
    return out;
}

ProfileBleed read_entry(const JsonValue& value, JsonReader* json) {
    static const world::KeySet keys = {"bleed", {"sigma_um", "pairs", "steps"}, {}};
    constexpr int kMostSteps = 8;
    constexpr size_t kMostPairs = 10'000;
    ProfileBleed out;
    if (!json->object(value, keys, "`bleed`")) return out;
    if (const JsonMember* p = value.find("sigma_um")) out.sigma_um = read_sigma(p->value, json);
    if (const JsonMember* p = value.find("steps"))
        out.steps = json->integer(p->value, "`steps` of `bleed`", 0, kMostSteps);
    const JsonMember* pairs = value.find("pairs");
    if (pairs == nullptr) return out;
    if (!pairs->value.is(JsonValue::Kind::kArray) || pairs->value.items.size() > kMostPairs) {
        json->fail(pairs->value, fmt::format(messages::kPairsNoArray, pairs->value.kind_name()),
                   fmt::format(messages::kPairsNoArrayHelp, kMostPairs));
        return out;
    }
    for (const JsonValue& item : pairs->value.items) {
        if (!json->ok()) break;
        out.pairs.push_back(read_pair(item, json));
    }
    return out;
}

constexpr const char* kVoidName = "void";

/// A code, of `void` 0; -1: no material of the print; -2: `*`.
int32_t code_of(const Print& print, const std::string& name) {
    if (name == "*") return -2;
    const uint8_t code = material_code(print.materials, name);
    if (code != 0) return code;
    return name == kVoidName ? 0 : -1;
}

std::string name_of(const Print& print, int32_t code) {
    return code == 0 ? kVoidName : at(print.materials, code - 1).name;
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
Pairs pairs_of(const ProfileBleed& bleed, const Print& print, std::vector<std::string>* warnings) {
    const int32_t materials = print.mixed_materials;
    Pairs pairs;
    for (int stars = 0; stars <= 2; ++stars) {
        Pairs of_rank;
        for (const PairBleed& pair : bleed.pairs) {
            if ((pair.a == "*" ? 1 : 0) + (pair.b == "*" ? 1 : 0) != stars) continue;
            const int32_t a = code_of(print, pair.a), b = code_of(print, pair.b);
            for (const std::string& name : {pair.a, pair.b}) {
                if (code_of(print, name) != -1) continue;
                std::string told = fmt::format(messages::kBleedIdle, printable(name),
                                               suggest_material(print.materials, name));
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
std::string describe(const Pairs& pairs, const Print& print, int32_t steps, bool show) {
    constexpr size_t kMost = 400;
    std::string text = steps > 0 ? fmt::format("undone in {} steps", steps) : "not undone";
    if (show) text += ", shown";
    for (const auto& [key, sigma] : pairs) {
        text += fmt::format("; {} and {} {} x {} x {} um", name_of(print, key.first),
                            name_of(print, key.second), sigma.x, sigma.y, sigma.z);
        if (text.size() > kMost) return text + " …";
    }
    return text;
}

class DescribedBleed : public Described {
  public:
    explicit DescribedBleed(std::optional<ProfileBleed> bleed) : bleed_(std::move(bleed)) {}

    Result<std::unique_ptr<Effect>> open(const Print& print, const std::string& asked,
                                         const Told& told) const override {
        if (print.solid) return std::unique_ptr<Effect>();
        const bool both = asked == "both", show = both || asked == "show";
        if (!bleed_ && show && !print.as_built)
            return user_error(fmt::format(messages::kBleedNotKnown, asked));
        const int32_t steps = bleed_ && (both || asked == "undo") ? bleed_->steps : 0;
        if (!bleed_ || (steps == 0 && !show)) return std::unique_ptr<Effect>();
        const Pairs pairs = pairs_of(*bleed_, print, told.warnings);
        if (pairs.empty()) return std::unique_ptr<Effect>();
        const Vec3d& pitch = print.pitch_mm;
        std::vector<PairSpread> spreads;
        for (const auto& [key, sigma] : pairs) {
            spreads.push_back(
                {static_cast<uint8_t>(key.first),
                 static_cast<uint8_t>(key.second),
                 {sigma.x * 1e-3 / pitch.x, sigma.y * 1e-3 / pitch.y, sigma.z * 1e-3 / pitch.z}});
        }
        auto effect = std::make_unique<Bleed>(std::move(spreads), steps, show);
        constexpr int32_t kMost = Bleed::kMostReach;
        for (int axis = 0; axis < 3; ++axis) {
            if (effect->reach()[axis] <= kMost) continue;
            return user_error(
                fmt::format(messages::kBleedTooFar, effect->reach()[axis], "xyz"[axis], kMost));
        }
        told.provenance->emplace_back("bleed", describe(pairs, print, steps, show));
        // What is told may be cut.
        Hasher hash;
        hash.add(steps);
        hash.add(int32_t{show});
        for (const auto& [key, sigma] : pairs) {
            hash.add(key.first), hash.add(key.second);
            for (int axis = 0; axis < 3; ++axis)
                hash.add(sigma[axis]);
        }
        told.provenance->emplace_back("hash of bleed", fmt::format("{:016x}", hash.value()));
        return std::unique_ptr<Effect>(std::move(effect));
    }

  private:
    std::optional<ProfileBleed> bleed_;
};

constexpr std::string_view kChoices[] = {"undo", "show", "both", "off"};

}  // namespace

const Kind kBleedKind{
    .key = "bleed",
    .option = {.name = "--bleed",
               .value = "CHOICE",
               .help =
                   "of the process: undo it (the default), show the result without that, both (the "
                   "result with it), or off",
               .choices = kChoices,
               .usual = "undo",
               .usual_as_built = "both"},
    .read = [](const JsonValue* entry, JsonReader* json) -> std::unique_ptr<const Described> {
        std::optional<ProfileBleed> bleed;
        if (entry != nullptr) bleed = read_entry(*entry, json);
        return std::make_unique<DescribedBleed>(std::move(bleed));
    },
};

}  // namespace openfab::process
