// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/arrange.h"

#include <fmt/format.h>

#include "base/units.h"
#include "tools/openfab/programs.h"
#include "tools/openfab/tray_worlds.h"
#include "world/world.h"

namespace openfab::tools {

Result<void> run_arrange(const ArrangeArguments& arguments) {
    const Result<int64_t> memory = parse_memory_option(arguments.memory);
    if (!memory) return memory.error();
    if (const Result<void> beside = check_beside(arguments.output, arguments.world); !beside)
        return beside;
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
        return usage_error(fmt::format("--turn {}: it is none, upright or all", arguments.turn));
    }
    options.misplaced =
        options.turns == Turns::kAll
            ? "cut it by `openfab split`"
            : "cut it by `openfab split`, or let it lie on its side by `--turn all`";
    const Result<world::World> world = world::load_world(
        arguments.world, {{arguments.allow.begin(), arguments.allow.end()}, *memory});
    if (!world) return world.error();
    const std::string& fit = arguments.fit.empty() ? world->printer : arguments.fit;
    if (fit.empty()) {
        return usage_error("the world names no printer: say by `--fit` what it is to fit");
    }
    const Result<MachineTray> machine = machine_tray(fit);
    if (!machine) return machine.error();
    options.machine = *machine;
    const Result<std::string> text = read_text_file(arguments.world, world::kLargestWorld);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, arguments.world, *memory);
    if (!root) return root.error();
    // A file that the world names stays named as it is there.
    if (const JsonMember* own = root->find("printer"); own != nullptr && arguments.fit.empty())
        options.machine.printer = own->value.text;
    return write_tray_worlds(*world, *root, options);
}

}  // namespace openfab::tools
