// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-mechanics`: stiffness and strength of what is printed. `openfab mechanics` executes this program.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/units.h"
#include "mechanics/command/commands.h"

namespace openfab::mechanics {

namespace {

constexpr const char* kFooter = R"(Examples:
  openfab mechanics cell gyroid.fl --cell 8mm --polar gyroid.png
  openfab mechanics cell gyroid.fl --cell 8mm --sweep thin=0.4:1.6:5 -o table.json
)";

/// What is parsed later.
struct Texts {
    std::string voxel, memory;
};

Result<void> complete(const Texts& texts, CommonOptions* o) {
    if (!texts.voxel.empty()) {
        const Result<double> mm = parse_length_mm(texts.voxel);
        if (!mm) return usage_error(fmt::format("`--voxel`: {}", mm.error().text()));
        if (!(*mm > 0)) return usage_error("`--voxel`: a pitch is above 0");
        o->voxel_mm = *mm;
    }
    const Result<int64_t> memory = parse_memory_option(texts.memory);
    if (!memory) return memory.error();
    o->memory_bytes = *memory;
    std::error_code status;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", status);
    if (status) return outside_error("cannot find the program's own folder: " + status.message());
    o->programs = self.parent_path();
    return {};
}

void add_common(CLI::App* app, CommonOptions* o, Texts* texts) {
    app->add_option("--materials", o->materials,
                    "a file of E, nu, strength and density (default: NAME.mechanics.json or "
                    "mechanics.json beside FILE)")
        ->type_name("FILE");
    app->add_option("--voxel", texts->voxel, "side of an element")->type_name("LENGTH");
    app->add_option("--supersample", o->supersample,
                    "an element is the mean of N x N x N parts (default: 2)")
        ->type_name("N")
        ->check(CLI::Range(1, 16));
    app->add_option("--law", o->law,
                    fmt::format("of mixtures: {} (default: the file's, else hs-lower)",
                                fmt::join(kLawNames, ", ")))
        ->type_name("LAW")
        ->check(
            CLI::IsMember(std::vector<std::string>(std::begin(kLawNames), std::end(kLawNames))));
    app->add_flag("--codes", o->codes, "elements are the voxels as dithered, one material each");
    app->add_option("--dither", o->dither, "of --codes, as `openfab print` has it")
        ->type_name("RULE");
    app->add_option("--set", o->settings, "OBJECT.UNIFORM=VALUE (repeatable)")
        ->allow_extra_args(false)
        ->type_name("SETTING");
    app->add_option("--allow", o->allow,
                    "a folder that a world may read besides its own (repeatable)")
        ->allow_extra_args(false)
        ->type_name("FOLDER");
    app->add_option("--tolerance", o->tolerance, "of the residual (default: 1e-6)")
        ->type_name("R")
        ->check(CLI::Range(1e-12, 0.1));
    app->add_option("--iterations", o->most_iterations, "at most (default: 400)")
        ->type_name("N")
        ->check(CLI::Range(1, 1000000));
    app->add_option("--threads", o->threads, "default: all cores")
        ->type_name("N")
        ->check(CLI::Range(1, 1024));
    app->add_option("--memory", texts->memory,
                    "memory budget of the whole process (default: 1.5GB)")
        ->type_name("SIZE");
    app->add_flag("-q,--quiet", o->quiet, "say nothing but errors and results");
    o->threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

using Action = std::function<Result<void>()>;

/// Runs a command with its number of threads.
template <typename Options>
Result<void> run_with(Options* options, const Texts& texts, Result<void> (*run)(const Options&)) {
    if (Result<void> done = complete(texts, &options->common); !done) return done;
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<size_t>(options->common.threads));
    return run(*options);
}

void add_cell(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "cell", "the stiffness of a periodic cell: tensor, engineering constants, anisotropy");
    auto o = std::make_shared<CellOptions>();
    auto texts = std::make_shared<Texts>();
    command->add_option("FILE", o->common.input, "a fablet (.fl) or a world (.fab.json)")
        ->required();
    command->add_option("--cell", o->cell, "its size, as 5mm, or 5mmx5mmx3mm")
        ->required()
        ->type_name("SIZE");
    command->add_option("--object", o->object, "of a world (default: its first)")
        ->type_name("NAME");
    command
        ->add_option("--sweep", o->sweep,
                     "a uniform, as thickness=0.4:1.6:5: a row of a table each")
        ->type_name("SWEEP");
    command->add_flag("--conductivity", o->conductivity, "of heat or current, too");
    command->add_option("--polar", o->polar, "a picture of Young's modulus by direction, .png")
        ->type_name("FILE");
    command->add_option("-o,--output", o->output, "all numbers, as JSON")->type_name("FILE");
    add_common(command, &o->common, texts.get());
    command->callback([=] { *action = [=] { return run_with(o.get(), *texts, run_cell); }; });
}

int mechanics_main(int argc, char** argv) {
    prepare_streams();
    // Whatever is computed is not written before it is complete, so a signal may end it at once.
    clean_up_on_signals();
    CLI::App app("How stiff is it, and will it hold?", "openfab mechanics");
    app.require_subcommand(1);
    Action action;
    add_cell(app, &action);
    app.footer(kFooter);
    return run_command_line(&app, argc, argv, "openfab mechanics", [&] { return action(); });
}

}  // namespace

}  // namespace openfab::mechanics

int main(int argc, char** argv) {
    return openfab::run_main(openfab::mechanics::mechanics_main, argc, argv);
}
