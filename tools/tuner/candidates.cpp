// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/candidates.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "tools/tuner/messages.h"

namespace openfab::tuner {

namespace {

/// Schedules of one generation after the first.
constexpr size_t kGeneration = 8;

}  // namespace

void sort_by_ratio(std::vector<Candidate*>* candidates) {
    std::erase_if(*candidates, [](const Candidate* candidate) {
        return !candidate->usable() || candidate->trial.ratios.empty();
    });
    std::stable_sort(
        candidates->begin(), candidates->end(),
        [](const Candidate* a, const Candidate* b) { return a->ratio() < b->ratio(); });
}

Candidate* Candidates::propose(Setting setting) {
    const auto text = space_.text(setting);
    if (std::holds_alternative<schedule::Fault>(text)) return nullptr;
    const std::string& lines = std::get<std::string>(text);
    if (lines == first_text_ || !tried_.insert(lines).second) return nullptr;
    Candidate& candidate = candidates_.emplace_back();
    candidate.trial.changes = space_.changes(setting);
    candidate.setting = std::move(setting);
    candidate.text = lines;
    if (const Trial* known = journal_.find(candidate.text)) candidate.trial = *known;
    return &candidate;
}

Candidate* Candidates::best() {
    Candidate* out = nullptr;
    for (Candidate& candidate : candidates_) {
        if (!candidate.usable() || candidate.trial.ratios.size() + 1 < kRounds) continue;
        if (out == nullptr || candidate.ratio() < out->ratio()) out = &candidate;
    }
    return out;
}

std::vector<Candidate*> Candidates::first_generation() {
    std::vector<Candidate*> out;
    for (size_t k = 0; k < space_.knobs().size(); ++k) {
        for (size_t c = 0; c < space_.knobs()[k].changes.size(); ++c) {
            if (Candidate* candidate = propose({{k, c}})) out.push_back(candidate);
        }
    }
    return out;
}

std::vector<Candidate*> Candidates::next_generation() {
    std::vector<Candidate*> out;
    const Candidate* best = this->best();
    const Setting from = best != nullptr && best->ratio() < 1 ? best->setting : Setting();
    std::vector<Candidate*> good;
    for (Candidate& candidate : candidates_)
        good.push_back(&candidate);
    sort_by_ratio(&good);
    for (const Candidate* candidate : good) {
        if (out.size() >= kGeneration / 2 || candidate->ratio() >= 1) break;
        Setting joined = candidate->setting;
        joined.insert(from.begin(), from.end());
        if (Candidate* made = propose(joined)) out.push_back(made);
    }
    constexpr int kAttempts = 200;
    for (int attempt = 0; attempt < kAttempts && out.size() < kGeneration; ++attempt) {
        Setting changed = from;
        const size_t flips = 1 + random_() % 2;
        for (size_t k = 0; k < flips; ++k) {
            const size_t knob = random_() % space_.knobs().size();
            const size_t changes = space_.knobs()[knob].changes.size();
            const size_t choice = random_() % (changes + 1);
            changed.erase(knob);
            if (choice < changes) changed[knob] = choice;
        }
        if (Candidate* made = propose(changed)) out.push_back(made);
    }
    return out;
}

Candidate* Candidates::with_text(const std::string& text) {
    for (Candidate& candidate : candidates_) {
        if (candidate.text == text) return &candidate;
    }
    Candidate& candidate = candidates_.emplace_back();
    candidate.text = text;
    if (const Trial* known = journal_.find(text)) candidate.trial = *known;
    if (candidate.trial.changes.empty()) candidate.trial.changes = {messages::kScheduleOfFile};
    return &candidate;
}

}  // namespace openfab::tuner
