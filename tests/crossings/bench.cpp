// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/result.h"
#include "tests/crossings/fablets.h"
#include "tests/support/places/places.h"

namespace openfab::testing {

namespace {

constexpr const char* kPrinter = R"({"name": "m", "pitch_mm": [0.25, 0.25, 0.25],
    "build_volume_mm": [40, 40, 40], "native_format": "ofr", "max_materials": 6})";
constexpr const char* kMechanics = R"({"materials": {
    "shell": {"E_MPa": 900, "nu": 0.3, "strength_MPa": 20, "density_g_cm3": 1.1, "conductivity_W_mK": 0.2},
    "left": {"E_MPa": 300, "nu": 0.3, "strength_MPa": 10, "density_g_cm3": 1.2, "conductivity_W_mK": 0.3},
    "right": {"E_MPa": 600, "nu": 0.3, "strength_MPa": 10, "density_g_cm3": 1.3, "conductivity_W_mK": 0.5}}})";

/// Kernels are compiled once for all of the table's worlds, whose sources are one file.
RunOptions run_options() {
    RunOptions out;
    out.environment = {{"OPENFAB_CACHE", Bench::cache()},
                       {"OPENFAB_HELPER", program("openfab").string()}};
    return out;
}

bool refused(const Outcome& outcome) {
    return outcome.exit_code == 1 || outcome.exit_code == 2;
}

}  // namespace

std::map<std::string, std::string> files_of(const Kind& kind, Form form, const Change& change) {
    std::map<std::string, std::string> out{
        {"w.fab.json", world_text(kind, form, change)},
        {"crossings.fl", read_file(source_dir() / "tests/crossings/crossings.fl")},
        {"m.printer.json", kPrinter},
        {"mechanics.json", kMechanics},
        {"cuts.json", cuts_file()}};
    for (const auto* files : {&kind.files, &change.files})
        out.insert(files->begin(), files->end());
    return out;
}

Bench::Bench(const Kind& kind, Form form, const Change& change) : kind_(kind), change_(change) {
    for (const auto& [name, text] : files_of(kind, form, change))
        write(name, text);
}

std::string Bench::cache() {
    return (build_dir() / "tests/crossings_cache").string();
}

Outcome Bench::openfab(std::vector<std::string> arguments, bool prints) const {
    arguments.insert(arguments.begin(), program("openfab").string());
    if (prints) arguments.insert(arguments.end(), kind_.options.begin(), kind_.options.end());
    RunOptions with = run_options();
    with.folder = scratch_.path();
    return run(arguments, with);
}

Made Bench::print_here() const {
    std::vector<std::string> words{world()};
    for (const auto* more : {&change_.options, &kind_.options})
        words.insert(words.end(), more->begin(), more->end());
    for (const auto& [name, value] : run_options().environment)
        ::setenv(name.c_str(), value.c_str(), 1);
    // Files that options name are beside the world.
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(scratch_.path());
    MemorySink sink;
    const Result<void> done =
        openfab::testing::print_here(fablets_of("crossings.fl"), words, &sink);
    std::filesystem::current_path(before);
    Made made;
    made.outcome.exit_code = done ? 0 : exit_code(done.error().code);
    if (!done) {
        made.outcome.err = shown(done.error());
        return made;
    }
    const pipeline::PrintInfo& info = sink.info;
    for (int a = 0; a < 3; ++a) {
        const auto at = static_cast<size_t>(a);
        made.voxels.size[at] = info.size[a];
        made.voxels.origin_mm[at] = info.origin_mm[a];
        made.voxels.pitch_mm[at] = info.pitch_mm[a];
    }
    made.voxels.codes = sink.codes();
    return made;
}

Outcome Bench::print(const std::string& output, const std::vector<std::string>& more) const {
    std::vector<std::string> words{"print", world(), "-o", path(output)};
    words.insert(words.end(), change_.options.begin(), change_.options.end());
    words.insert(words.end(), more.begin(), more.end());
    return openfab(words);
}

Cell compare(const Made& made, const Made& expected) {
    const int code = made.outcome.exit_code, twin = expected.outcome.exit_code;
    if (!made.wrong.empty()) return {Verdict::kWrong, made.wrong};
    if (refused(made.outcome) && made.numbers.empty() && made.voxels.codes.empty())
        return {Verdict::kRefused, made.outcome.err};
    // Tools that find something end with 1, and say in numbers what.
    if (twin != 0 && expected.numbers.empty())
        return {Verdict::kWrong, "the twin is not made: " + expected.outcome.err};
    if (code != twin) {
        return {Verdict::kWrong, fmt::format("ends with {}, the twin with {}: {}{}", code, twin,
                                             made.outcome.err, expected.outcome.err)};
    }
    bool equal = true;
    std::string worst;
    if (!made.voxels.codes.empty() || !expected.voxels.codes.empty()) {
        if (expected.voxels.solid() < 20) return {Verdict::kWrong, "the twin is next to nothing"};
        const Difference difference = compare(made.voxels, expected.voxels);
        if (!difference.within(kShare)) return {Verdict::kWrong, difference.text(), true};
        equal = difference.none();
        worst = difference.text();
    }
    if (made.numbers.size() != expected.numbers.size()) {
        return {
            Verdict::kWrong,
            fmt::format("{} numbers, the twin {}", made.numbers.size(), expected.numbers.size()),
            true};
    }
    for (const auto& [name, value] : made.numbers) {
        const auto found = expected.numbers.find(name);
        if (found == expected.numbers.end())
            return {Verdict::kWrong, fmt::format("the twin has no {}", name)};
        const double off = std::fabs(value - found->second);
        if (!(off <= kNumbers * std::max(std::fabs(value), std::fabs(found->second)) + 1e-9))
            return {Verdict::kWrong, fmt::format("{}: {}, the twin {}", name, value, found->second),
                    true};
        equal = equal && off <= 1e-9 * std::fabs(value);
    }
    return {equal ? Verdict::kEqual : Verdict::kBounded, worst};
}

}  // namespace openfab::testing
