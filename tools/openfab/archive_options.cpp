// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Which options of a print an archive keeps.

#include <algorithm>
#include <iterator>

#include "base/talking_program.h"
#include "runtime/process/kinds/kinds.h"
#include "tools/openfab/archive.h"

namespace openfab::tools {

namespace {

using enum OptionRole;

/// All options of `openfab print` but those of effects: one that is not here is refused, so that a new one is thought of.
constexpr ArchivedOption kOptions[] = {
    {"INPUT", kPath},
    {"--printer", kPath},
    {"--process", kPath},
    {"--fablet", kPath},
    {"--schedule", kPath},
    {"--param", kKept},
    {"--format", kKept},
    {"--as-built", kKept},
    {"--voxel", kKept},
    {"--dpi", kKept},
    {"--layer", kKept},
    {"--pitch", kKept},
    {"--mesh-pitch", kKept},
    {"--draft", kKept},
    {"--crop", kKept},
    {"--z", kKept},
    {"--slices", kKept},
    {"--part", kKept},
    {"--only-object", kKept},
    {"--set", kKept},
    {kProgramsWord, kKept},
    {"--dither", kKept},
    {"--support", kKept},
    {"--seed", kKept},
    {"--png", kKept},
    {"--grey-material", kKept},
    {"--flip-x", kKept},
    {"--sampling", kKept},
    {"--fractions-supersample", kKept},
    {"--solid", kKept},
    {"--around", kKept},
    {"--cell", kKept},
    {"--cell-at", kKept},
    {"--lattice", kKept},
    {"--output", kDropped},
    {"--allow", kDropped},
    {"--token-file", kDropped},
    {"--tls-ca", kDropped},
    {"--preview", kDropped},
    {"--memory", kDropped},
    {"--threads", kDropped},
    {"--fractions", kDropped},
    {"--stats", kDropped},
    {"--progress", kDropped},
    {"--slab-limit", kDropped},
    {"--no-cache", kDropped},
    {"--resume", kDropped},
    {"--check", kDropped},
    {"--check-picture", kDropped},
    {"--groups-in-flight", kDropped},
    {"--any-pitch", kRefused},
    {"--no-cull", kDropped},
    {"--isa", kDropped},
    {"--probe", kDropped},
    {"--estimate", kDropped},
    {"--dry-run", kDropped},
    {"--help", kDropped},
    {"--field", kRefused},
    {"--field-origin", kRefused},
    {"--field-spacing", kRefused},
    {"--extents", kRefused},
};

}  // namespace

const ArchivedOption* find_archived_option(std::string_view name) {
    if (const process::Kind* kind = process::find_option(name); kind != nullptr) {
        static constexpr ArchivedOption kFile{"", kPath}, kChoice{"", kKept};
        return kind->option.choices.empty() ? &kFile : &kChoice;
    }
    const auto* found = std::find_if(std::begin(kOptions), std::end(kOptions),
                                     [&](const ArchivedOption& each) { return each.name == name; });
    return found == std::end(kOptions) ? nullptr : found;
}

}  // namespace openfab::tools
