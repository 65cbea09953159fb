// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_mixed.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "base/scan_number.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {
namespace {

constexpr size_t kMostFilaments = 1000;
constexpr size_t kMostComponents = 16;

using Shares = std::vector<std::pair<int32_t, double>>;

std::vector<std::string_view> pieces(std::string_view text, char mark) {
    std::vector<std::string_view> out;
    while (out.size() < kMostFilaments) {
        const size_t end = std::min(text.find(mark), text.size());
        out.push_back(text.substr(0, end));
        if (end == text.size()) break;
        text.remove_prefix(end + 1);
    }
    return out;
}

/// Item `i` of a list of the settings, as text; empty: there is none.
std::string_view item(const JsonValue& settings, std::string_view key, size_t i) {
    const JsonMember* member = settings.find(key);
    if (member == nullptr || i >= member->value.items.size()) return {};
    return member->value.items[i].text;
}

/// Reads filaments and their weights; none if one is not a number. Weights that are missing are 1.
Shares shares_of(const std::vector<std::string_view>& filaments,
                 const std::vector<std::string_view>& weights) {
    Shares out;
    const bool weighted = !weights.empty() && !weights.front().empty();
    if (weighted && weights.size() != filaments.size()) return {};
    for (size_t i = 0; i < filaments.size() && i < kMostComponents; ++i) {
        int64_t filament = 0;
        double weight = 1;
        if (!scan_integer(trim_threemf(filaments[i]), 1, kMostFilaments, &filament).empty())
            return {};
        if (weighted && !scan_number(trim_threemf(weights[i]), &weight).empty()) return {};
        out.emplace_back(static_cast<int32_t>(filament), weight);
    }
    return out;
}

class Mixer {
  public:
    Mixer(std::string_view place, std::vector<ThreemfFilament>* filaments, ThreemfTold* told)
        : place_(place), filaments_(*filaments), told_(*told), whole_(filaments->size()) {}

    /// Sets the mixture of filament `number`, from 1, as shares of those that are none.
    void mix(size_t number, Shares shares) {
        double sum = 0;
        bool fine = !shares.empty() && number >= 1 && number <= kMostFilaments;
        for (const auto& [filament, weight] : shares) {
            fine = fine && weight >= 0 && filament >= 1 &&
                   static_cast<size_t>(filament) <= whole_ &&
                   static_cast<size_t>(filament) != number;
            sum += weight;
        }
        if (!fine || !(sum > 0)) {
            told_.add(messages::kMixtureOfNoFilaments, std::string(place_),
                      messages::kMixtureOfNoFilamentsHelp);
            return;
        }
        for (auto& [filament, weight] : shares)
            weight /= sum;
        if (filaments_.size() < number) filaments_.resize(number);
        filaments_[number - 1].mixture = std::move(shares);
    }

    /// Replaces components that are mixtures by what they are mixed of. Those that are mixed of themselves, or of more
    /// than there may be, are none.
    void flatten() {
        std::vector<Visit> visits(filaments_.size(), Visit::kNone);
        for (size_t i = 0; i < filaments_.size(); ++i)
            (void)flatten(i, &visits);
    }

    void tell_gradient() {
        told_.add(messages::kMixedGradients, std::string(place_), messages::kMixedGradientsHelp);
    }

    void set_whole(size_t count) { whole_ = count; }

  private:
    enum class Visit : uint8_t { kNone, kBegun, kDone, kFailed };

    /// Whether filament `i`, from 0, is one, or a mixture of such.
    bool flatten(size_t i, std::vector<Visit>* visits) {
        Visit& visit = (*visits)[i];
        if (visit != Visit::kNone) return visit == Visit::kDone;
        visit = Visit::kBegun;
        bool fine = true, nested = false;
        std::map<int32_t, double> sums;
        Shares& own = filaments_[i].mixture;
        for (const auto& [filament, weight] : own) {
            const auto other = static_cast<size_t>(filament - 1);
            fine = fine && flatten(other, visits);
            if (!fine) break;
            const Shares& inner = filaments_[other].mixture;
            nested = nested || !inner.empty();
            if (inner.empty()) sums[filament] += weight;
            for (const auto& [deeper, share] : inner)
                sums[deeper] += weight * share;
        }
        fine = fine && sums.size() <= kMostComponents;
        if (!fine) {
            told_.add(messages::kMixtureOfNoFilaments, std::string(place_),
                      messages::kMixtureOfNoFilamentsHelp);
            own.clear();
        } else if (nested) {
            own.assign(sums.begin(), sums.end());
        }
        visit = fine ? Visit::kDone : Visit::kFailed;
        return fine;
    }

    std::string_view place_;
    std::vector<ThreemfFilament>& filaments_;
    ThreemfTold& told_;
    size_t whole_;  ///< filaments that may be components
};

/// A row of Snapmaker's: `a,b,enabled,custom,percent of b,…`, then fields that begin with letters:
/// `g` components and `w` weights of three and more, unless the mode is `m2`; `d1` deleted; `r` a
/// gradient. Returns whether it counts as a filament.
bool read_row(std::string_view row, Shares* shares, bool* gradient) {
    const std::vector<std::string_view> fields = pieces(row, ',');
    if (fields.size() < 5 || trim_threemf(fields[2]) != "1") return false;
    std::string_view components, weights, mode;
    for (size_t i = 5; i < fields.size(); ++i) {
        const std::string_view field = trim_threemf(fields[i]);
        if (field == "d1") return false;
        if (field.starts_with('g')) components = field.substr(1);
        if (field.starts_with('w')) weights = field.substr(1);
        if (field.starts_with('m')) mode = field.substr(1);
        if (field.starts_with("r1")) *gradient = true;
    }
    const std::vector<std::string_view> several = pieces(components, '/');
    if (several.size() > 2 && mode != "2") {
        *shares = shares_of(several, pieces(weights, '/'));
        return true;
    }
    *shares = shares_of({fields[0], fields[1]}, {});
    double percent = 50;
    if (shares->size() != 2 || !scan_number(trim_threemf(fields[4]), &percent).empty() ||
        !(percent >= 0 && percent <= 100)) {
        shares->clear();
    } else {
        (*shares)[0].second = 100 - percent;
        (*shares)[1].second = percent;
    }
    return true;
}

/// A flag of a list of the settings: text in slicers' own files, which scripts write as numbers or truths.
bool is_set(const JsonValue& settings, std::string_view key, size_t i) {
    const JsonMember* member = settings.find(key);
    if (member == nullptr || i >= member->value.items.size()) return false;
    const JsonValue& flag = member->value.items[i];
    return flag.boolean || flag.number == 1 || flag.text == "1" || flag.text == "true";
}

}  // namespace

void mix_filaments(const JsonValue& settings, std::string_view place,
                   std::vector<ThreemfFilament>* filaments, ThreemfTold* told) {
    Mixer mixer(place, filaments, told);
    const size_t count = filaments->size();
    for (size_t i = 0; i < count; ++i) {
        if (!is_set(settings, "filament_is_mixed", i)) continue;
        mixer.mix(i + 1,
                  shares_of(pieces(item(settings, "filament_mixed_components", i), ','),
                            pieces(item(settings, "filament_mixed_sublayer_ratios", i), ',')));
        if (is_set(settings, "filament_mixed_gradient", i)) mixer.tell_gradient();
    }
    mixer.flatten();
    const JsonMember* rows = settings.find("mixed_filament_definitions");
    if (rows == nullptr) return;
    std::string_view text = rows->value.text;
    if (!rows->value.items.empty()) text = rows->value.items.front().text;
    size_t next = count + 1;
    for (const std::string_view row : pieces(text, ';')) {
        Shares shares;
        bool gradient = false;
        if (!read_row(row, &shares, &gradient)) continue;
        mixer.mix(next++, std::move(shares));
        if (gradient) mixer.tell_gradient();
    }
    mixer.flatten();
}

void mix_extruders(const JsonValue& spectrum, std::string_view place,
                   std::vector<ThreemfFilament>* filaments, ThreemfTold* told) {
    const auto integer = [](const JsonValue& of, std::string_view key) {
        const JsonMember* member = of.find(key);
        const double value = member != nullptr ? member->value.number : 0;
        const bool fine = value >= 1 && value <= static_cast<double>(kMostFilaments);
        return fine ? static_cast<size_t>(value) : 0;
    };
    const auto color = [](const JsonValue& of) -> std::optional<ThreemfColor> {
        const JsonMember* member = of.find("color");
        if (member == nullptr) return {};
        return parse_threemf_color(member->value.text);
    };
    if (const JsonMember* extruders = spectrum.find("physical_extruders")) {
        for (const JsonValue& one : extruders->value.items) {
            const size_t id = integer(one, "id");
            if (id == 0) continue;
            if (filaments->size() < id) filaments->resize(id);
            ThreemfFilament& filament = (*filaments)[id - 1];
            if (!filament.color) filament.color = color(one);
            // Ours have one.
            const JsonMember* name = one.find("name");
            if (name != nullptr && filament.name.empty()) filament.name = name->value.text;
        }
    }
    const JsonMember* extruders = spectrum.find("virtual_extruders");
    if (extruders == nullptr) return;
    Mixer mixer(place, filaments, told);
    for (const JsonValue& one : extruders->value.items) {
        Shares shares;
        const JsonMember* components = one.find("components");
        const size_t count = components != nullptr ? components->value.items.size() : 0;
        for (size_t i = 0; i < std::min(count, kMostComponents); ++i) {
            const JsonValue& part = components->value.items[i];
            const JsonMember* ratio = part.find("ratio");
            shares.emplace_back(static_cast<int32_t>(integer(part, "extruder")),
                                ratio != nullptr ? ratio->value.number : 1);
        }
        mixer.mix(integer(one, "id"), std::move(shares));
    }
    mixer.flatten();
}

}  // namespace openfab::mesh
