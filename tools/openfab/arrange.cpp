// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/arrange.h"

#include <fmt/format.h>

#include <iterator>
#include <optional>
#include <utility>

#include "base/units.h"
#include "tools/openfab/extents.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/pieces_text.h"
#include "tools/openfab/programs.h"
#include "tools/openfab/tray_worlds.h"
#include "world/world.h"

namespace openfab::tools {

namespace {

struct Loaded {
    world::World world;
    world::WorldEdit text;
};

/// Returns a world without what it builds, however it is written.
std::string all_but_the_build(const world::WorldEdit& text) {
    JsonValue root = text.tree();
    std::erase_if(root.members, [](const JsonMember& m) {
        return m.key == "build" || m.key == "groups" || m.key == "arrange";
    });
    return text_of(root);
}

/// Reads the first world, with what the others build besides.
Result<Loaded> load(const ArrangeArguments& arguments, int64_t memory) {
    std::optional<Loaded> out;
    for (size_t i = 0; i < arguments.worlds.size(); ++i) {
        const std::string& file = arguments.worlds[i];
        Result<world::World> world =
            world::load_world(file, world::rules_of(arguments.allow, memory));
        if (!world) return world.error();
        if (const Result<void> known = find_extents(
                file, {arguments.allow, arguments.settings, arguments.memory}, &*world);
            !known)
            return known.error();
        Result<world::WorldEdit> text = world::WorldEdit::of_file(file, memory);
        if (!text) return text.error();
        if (i == 0) {
            out.emplace(std::move(*world), std::move(*text));
            continue;
        }
        if (all_but_the_build(*text) != all_but_the_build(out->text)) {
            return user_error(fmt::format(messages::kWorldsDiffer, arguments.worlds[0], file),
                              messages::kArrangeEachAlone);
        }
        // Objects have the same numbers there.
        std::move(world->build.begin(), world->build.end(), std::back_inserter(out->world.build));
    }
    return std::move(*out);
}

}  // namespace

Result<void> run_arrange(const ArrangeArguments& arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    for (const std::string& world : arguments.worlds) {
        if (const Result<void> beside = check_beside(arguments.output, world); !beside)
            return beside;
    }
    TrayOptions options;
    options.output = arguments.output;
    const Result<double> gap = length_option("--gap", arguments.gap);
    if (!gap) return gap.error();
    options.gap_mm = *gap;
    if (arguments.turn == "none") {
        options.turns = Turns::kNone;
    } else if (arguments.turn == "upright") {
        options.turns = Turns::kUpright;
    } else if (arguments.turn != "all") {
        return usage_error(fmt::format(messages::kTurnChoice, arguments.turn));
    }
    options.misplaced =
        options.turns == Turns::kAll ? messages::kCutItWithSplit : messages::kCutItOrTurnIt;
    Result<Loaded> loaded = load(arguments, *memory);
    if (!loaded) return loaded.error();
    const world::World* const world = &loaded->world;
    const std::string& fit = arguments.fit.empty() ? world->printer : arguments.fit;
    if (fit.empty()) {
        return usage_error(messages::kWorldNamesNoPrinter);
    }
    const Result<MachineTray> machine = machine_tray(fit);
    if (!machine) return machine.error();
    options.machine = *machine;
    // A file that the world names stays named as it is there.
    if (const JsonMember* own = loaded->text.tree().find("printer");
        own != nullptr && arguments.fit.empty())
        options.machine.printer = own->value.text;
    return write_tray_worlds(*world, loaded->text, options);
}

}  // namespace openfab::tools
