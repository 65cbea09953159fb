// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/arrange.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "base/near_miss.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/openfab/extents.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/pieces_text.h"
#include "tools/openfab/programs.h"
#include "tools/openfab/tray_worlds.h"
#include "world/build_reader.h"
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

/// Repeats what is built: all of it by a number alone, an object's placements by `NAME=N`.
Result<void> repeat_build(const std::vector<std::string>& copies, world::World* world) {
    std::vector<std::string> names;
    for (const world::Object& object : world->objects)
        names.push_back(object.name);
    std::optional<size_t> of_all;
    std::map<std::string, size_t> of_object;
    for (const std::string& text : copies) {
        const size_t equals = text.rfind('=');
        const std::string number = text.substr(equals == std::string::npos ? 0 : equals + 1);
        size_t count = 0;
        const char* end = number.data() + number.size();
        const auto read = std::from_chars(number.data(), end, count);
        if (read.ec != std::errc() || read.ptr != end || count < 1 ||
            count > world::kMostPlacements) {
            return usage_error(fmt::format(messages::kBadCopies, printable(text),
                                           world::kMostPlacements,
                                           names.empty() ? "NAME" : printable(names.front())));
        }
        if (equals == std::string::npos) {
            of_all = count;
            continue;
        }
        const std::string name = text.substr(0, equals);
        if (std::ranges::find(world->build, name, [&](const world::Placement& p) {
                return world->objects[static_cast<size_t>(p.object)].name;
            }) == world->build.end()) {
            return usage_error(fmt::format(messages::kCopiesOfNothing, printable(text),
                                           printable(name), suggest(name, names)));
        }
        of_object[name] = count;
    }
    std::vector<world::Placement> build;
    for (const world::Placement& placed : world->build) {
        const auto own = of_object.find(world->objects[static_cast<size_t>(placed.object)].name);
        const size_t count = own != of_object.end() ? own->second : of_all.value_or(1);
        if (build.size() + count > world::kMostPlacements)
            return usage_error(fmt::format(messages::kTooManyCopies, world::kMostPlacements));
        build.insert(build.end(), count, placed);
    }
    world->build = std::move(build);
    return {};
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
    if (const Result<void> repeated = repeat_build(arguments.copies, &loaded->world); !repeated)
        return repeated;
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
