// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/process/kinds/kinds.h"

#include <algorithm>
#include <array>

#include "runtime/process/bleed/bleed_kind.h"
#include "runtime/process/nozzles/nozzle_kind.h"

namespace openfab::process {

namespace {

constexpr std::array kKinds{&kNozzleKind, &kBleedKind};

/// Fails where no kind has the key of an entry.
void check_key(const world::ProcessEntry& entry, world::JsonReader* json) {
    world::KeySet keys{"process", world::process_keys(), {}};
    for (const Kind* kind : kKinds)
        keys.keys.push_back(kind->key);
    JsonValue process;
    process.kind = JsonValue::Kind::kObject;
    process.members.push_back(entry.member);
    json->object(process, keys, "`process`");
}

}  // namespace

std::span<const Kind* const> kinds() {
    return kKinds;
}

const Kind* find_option(std::string_view name) {
    const auto* known =
        std::ranges::find(kKinds, name, [](const Kind* k) { return k->option.name; });
    return known == kKinds.end() || name.empty() ? nullptr : *known;
}

std::string asked_of(const Kind& kind, const Asked& asked, bool as_built) {
    const auto given = asked.find(std::string(kind.option.name));
    if (given != asked.end()) return given->second;
    return std::string(as_built ? kind.option.usual_as_built : kind.option.usual);
}

Result<std::vector<std::unique_ptr<const Described>>> read_effects(const world::Process& process) {
    for (const world::ProcessEntry& entry : process.effects) {
        world::JsonReader json(entry.file);
        check_key(entry, &json);
        if (!json.ok()) return json.error();
    }
    std::vector<std::unique_ptr<const Described>> out;
    for (const Kind* kind : kKinds) {
        const auto entry = std::ranges::find(process.effects, kind->key,
                                             [](const auto& e) { return e.member.key; });
        const bool has = entry != process.effects.end();
        world::JsonReader json(has ? entry->file : std::string());
        out.push_back(kind->read(has ? &entry->member.value : nullptr, &json));
        if (!json.ok()) return json.error();
    }
    return out;
}

Result<std::vector<std::unique_ptr<Effect>>> open_effects(const Print& print, const Asked& asked,
                                                          const Told& told) {
    auto described = read_effects(print.printer.process);
    if (!described) return described.error();
    std::vector<std::unique_ptr<Effect>> out;
    for (size_t k = 0; k < kKinds.size(); ++k) {
        auto effect =
            (*described)[k]->open(print, asked_of(*kKinds[k], asked, print.as_built), told);
        if (!effect) return effect.error();
        if (*effect != nullptr) out.push_back(std::move(*effect));
    }
    return out;
}

}  // namespace openfab::process
