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

#include "base/allowance.h"
#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/talking_program.h"
#include "base/units.h"
#include "mechanics/command/commands.h"
#include "mechanics/messages.h"
#include "mechanics/part/shown.h"

namespace openfab::mechanics {

namespace {

constexpr const char* kExamples =
    R"(  openfab mechanics cell gyroid.fl --cell 8mm --polar gyroid.png
  openfab mechanics cell gyroid.fl --cell 8mm --sweep thin=0.4:1.6:5 -o table.json
  openfab mechanics part hook.fab.json --case carry --voxel 0.5mm --preview hook.png -o hook.vti
  openfab mechanics conduct sensor.fab.json --case sense --voxel 0.5mm -o sensor.vti
  openfab mechanics stand hook.fab.json --voxel 0.5mm
  openfab mechanics strengthen hook.fab.json --field need --safety 2 -o strong.fab.json
  openfab mechanics export hook.fab.json --case carry --voxel 1mm -o hook.inp -o hook.vtu
)";

/// What is parsed later.
struct Texts {
    std::string voxel, memory, temperature, rate;
};

Result<void> complete(const Texts& texts, CommonOptions* o) {
    if (!texts.voxel.empty()) {
        const Result<std::array<double, 3>> mm = parse_sizes(texts.voxel);
        if (!mm) return usage_error(fmt::format(messages::kVoxelWrong, mm.error().text()));
        o->voxel_mm = *mm;
    }
    const Result<Conditions> conditions = parse_conditions(texts.temperature, texts.rate);
    if (!conditions) return conditions.error();
    o->conditions = *conditions;
    const Result<int64_t> memory = parse_memory_option(texts.memory);
    if (!memory) return memory.error();
    o->memory_bytes = *memory;
    const Result<std::filesystem::path> programs = program_folder();
    if (!programs) return programs.error();
    o->programs = *programs;
    return {};
}

void add_common(CLI::App* app, CommonOptions* o, Texts* texts) {
    app->add_option("--materials", o->materials,
                    "a file of E, nu, strength and density (default: NAME.mechanics.json or "
                    "mechanics.json beside FILE)")
        ->type_name("FILE");
    app->add_option("--temperature", texts->temperature,
                    "at which moduli are, where the file has several, such as 23C")
        ->type_name("T");
    app->add_option("--rate", texts->rate,
                    "likewise, such as 0.01/s, 1Hz, or the time in which the load is applied, 100s")
        ->type_name("RATE");
    app->add_option("--voxel", texts->voxel,
                    "side of an element, as 1mm, or its three sides, as 42x85x27um")
        ->type_name("LENGTH");
    CLI::Option* const parts =
        app->add_option(
               "--supersample", o->supersample,
               "an element is the mean of N x N x N parts (default: of the printer's voxels)")
            ->type_name("N")
            ->check(CLI::Range(1, 16));
    CLI::Option* const law =
        app->add_option("--law", o->law,
                        fmt::format("of mixtures: {} (default: the file's, else hs-lower)",
                                    fmt::join(kLawNames, ", ")))
            ->type_name("LAW")
            ->check(CLI::IsMember(
                std::vector<std::string>(std::begin(kLawNames), std::end(kLawNames))));
    // Codes have no mixtures.
    CLI::Option* const codes =
        app->add_flag("--codes", o->codes,
                      "elements are the printer's voxels as dithered, one material each")
            ->excludes(parts)
            ->excludes(law);
    app->add_option("--dither", o->dither, "of --codes, as `openfab print` has it")
        ->type_name("RULE")
        ->needs(codes);
    app->add_option("--set", o->settings, "OBJECT.UNIFORM=VALUE (repeatable)")
        ->allow_extra_args(false)
        ->type_name("SETTING");
    app->add_option("--allow", o->allow,
                    "a folder that a world may read besides its own (repeatable)")
        ->allow_extra_args(false)
        ->type_name("FOLDER");
    app->add_flag_callback(
        kProgramsWord, [o] { o->allow.emplace_back(kProgramsWord); }, kProgramsHelp);
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
    o->threads = usable_cores();
}

using Action = std::function<Result<void>()>;

/// Runs a command with its number of threads.
template <typename Options>
Result<void> run_with(Options* options, const Texts& texts, Result<void> (*run)(const Options&)) {
    if (Result<void> done = complete(texts, &options->common); !done) return done;
    constexpr bool kFablets = std::is_same_v<Options, CellOptions>;
    if (Result<void> fine = check_is_world(options->common.input, kFablets); !fine) return fine;
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
    command->add_flag("--conductivity", o->conductivity, "of heat and current, too");
    command->add_flag("--converge", o->converge,
                      "again at half the pitch: what the elements' size costs");
    command->add_option("--polar", o->polar, "a picture of Young's modulus by direction, .png")
        ->type_name("FILE");
    command->add_option("-o,--output", o->output, "all numbers, as JSON")->type_name("FILE");
    add_common(command, &o->common, texts.get());
    command->callback([=] { *action = [=] { return run_with(o.get(), *texts, run_cell); }; });
}

void add_part(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "part", "strength of what is built: displacements, stresses, safety, weakest places");
    auto o = std::make_shared<PartCommandOptions>();
    auto texts = std::make_shared<Texts>();
    command->add_option("WORLD", o->common.input, "a world (.fab.json) with `cases`")->required();
    command->add_option("--case", o->load_case, "of the world's cases (default: the only one)")
        ->type_name("NAME");
    command
        ->add_option(
            "-o,--output", o->outputs,
            "results: .vti (volumes), .npy (numpy), .json (all numbers), .ofr (colours for "
            "`openfab view`); repeatable")
        ->allow_extra_args(false)
        ->type_name("FILE");
    CLI::Option* const preview =
        command->add_option("--preview", o->preview, "a picture of the loaded part, .png")
            ->type_name("FILE");
    command
        ->add_option("--show", o->show,
                     "in it and in .ofr: von-mises (default), displacement, tension, compression, "
                     "safety")
        ->type_name("WHAT")
        ->check(CLI::IsMember(std::vector<std::string>(std::begin(kShown), std::end(kShown))));
    command->add_option("--view", o->view, "of it: TURN:TILT in degrees (default: 30:25)")
        ->type_name("ANGLES")
        ->needs(preview);
    command
        ->add_option("--require", o->require, "a safety factor: exit code 1 if it is not reached")
        ->type_name("FACTOR")
        ->check(CLI::Range(0.0, 1e6));
    command->add_flag("--loose", o->loose, "leave out pieces that nothing holds");
    command->add_flag("--thin", o->thin, "take walls that the pitch does not resolve as they come");
    command
        ->add_option(
            "--buckling", o->buckling,
            "when the factor at which the part buckles is computed: auto (default: where it "
            "is slender), always, never")
        ->type_name("WHEN")
        ->check(CLI::IsMember({"auto", "always", "never"}));
    command->add_flag("--full", o->full,
                      "elements as C3D8 of CalculiX, stiffer in bending, for comparisons");
    command->add_flag("--converge", o->converge,
                      "again at half the pitch: what the elements' size costs");
    add_common(command, &o->common, texts.get());
    command->callback([=] { *action = [=] { return run_with(o.get(), *texts, run_part); }; });
}

void add_conduct(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "conduct", "current or heat through what is built: resistance, temperatures, densities");
    auto o = std::make_shared<ConductOptions>();
    auto texts = std::make_shared<Texts>();
    command
        ->add_option("WORLD", o->common.input,
                     "a world (.fab.json) with `cases` of `volt` or `celsius`")
        ->required();
    command->add_option("--case", o->load_case, "of the world's cases (default: the only one)")
        ->type_name("NAME");
    command
        ->add_option("-o,--output", o->outputs,
                     "results: .vti (volumes), .npy (numpy), .json (all numbers), .ofr (densities, "
                     "for `openfab view`); repeatable")
        ->allow_extra_args(false)
        ->type_name("FILE");
    command->add_flag("--converge", o->converge,
                      "again at half the pitch: what the elements' size costs");
    add_common(command, &o->common, texts.get());
    command->callback([=] { *action = [=] { return run_with(o.get(), *texts, run_conduct); }; });
}

void add_stand(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "stand", "without loads: whether it stands, its own weight, thinnest walls, softest modes");
    auto o = std::make_shared<StandOptions>();
    auto texts = std::make_shared<Texts>();
    command->add_option("WORLD", o->common.input, "a world (.fab.json)")->required();
    command->add_option("--modes", o->modes, "how many of the softest (default: 4)")
        ->type_name("N")
        ->check(CLI::Range(0, 30));
    command
        ->add_option("--while-printing", o->while_printing,
                     "look at so many heights on the way up, too: does it stand, its own weight")
        ->type_name("N")
        ->check(CLI::Range(0, 1000));
    command
        ->add_option(
            "-o,--output", o->outputs,
            "results: .json (all numbers), .vti (own weight, and where modes are weak), .ofr "
            "(where modes are weak, for `openfab view`)")
        ->allow_extra_args(false)
        ->type_name("FILE");
    command->add_option("--preview", o->preview, "a picture of where modes are weak, .png")
        ->type_name("FILE");
    command->add_flag("--loose", o->loose, "leave out pieces that do not stand on the ground");
    command->add_flag("--thin", o->thin, "take walls that the pitch does not resolve as they come");
    add_common(command, &o->common, texts.get());
    command->callback([=] { *action = [=] { return run_with(o.get(), *texts, run_stand); }; });
}

void add_strengthen(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "strengthen", "grows a field that the fablet reads until the part is strong enough");
    auto o = std::make_shared<StrengthenOptions>();
    auto texts = std::make_shared<Texts>();
    auto reach = std::make_shared<std::string>();
    command->add_option("WORLD", o->common.input, "a world (.fab.json) with `cases`")->required();
    command->add_option("--case", o->load_case, "of the world's cases (default: the only one)")
        ->type_name("NAME");
    command->add_option("--field", o->field, "the texture of the world that is grown, from 0")
        ->required()
        ->type_name("NAME");
    command->add_option("-o,--output", o->output, "the world with the field, NAME.fab.json")
        ->required()
        ->type_name("FILE");
    command->add_option("--safety", o->safety, "the factor that is wanted (default: 1.5)")
        ->type_name("FACTOR")
        ->check(CLI::Range(0.01, 1e4));
    command->add_option("--limit", o->limit, "of the field (default: 1)")
        ->type_name("VALUE")
        ->check(CLI::Range(1e-6, 1e6));
    command
        ->add_option("--reach", *reach,
                     "how far around a weak place it grows (default: four elements)")
        ->type_name("LENGTH");
    command->add_option("--rounds", o->rounds, "at most (default: 20)")
        ->type_name("N")
        ->check(CLI::Range(1, 1000));
    command->add_flag("--loose", o->loose, "leave out pieces that nothing holds");
    command->add_flag("--thin", o->thin, "take walls that the pitch does not resolve as they come");
    add_common(command, &o->common, texts.get());
    command->callback([=] {
        *action = [=]() -> Result<void> {
            if (!reach->empty()) {
                const Result<double> mm = parse_length_mm(*reach);
                if (!mm) return usage_error(fmt::format(messages::kReachWrong, mm.error().text()));
                o->reach_mm = *mm;
            }
            return run_with(o.get(), *texts, run_strengthen);
        };
    });
}

void add_export(CLI::App& app, Action* action) {
    CLI::App* command =
        app.add_subcommand("export", "what is built, as hexahedra for other programs");
    auto o = std::make_shared<ExportOptions>();
    auto texts = std::make_shared<Texts>();
    command->add_option("WORLD", o->common.input, "a world (.fab.json)")->required();
    command
        ->add_option("-o,--output", o->outputs,
                     "a mesh: .inp (Abaqus, CalculiX), .vtu (ParaView), .msh (gmsh), .xdmf; "
                     "repeatable")
        ->required()
        ->allow_extra_args(false)
        ->type_name("FILE");
    command->add_option("--case", o->load_case, "of the world's cases, too (.inp)")
        ->type_name("NAME");
    command->add_flag("--loose", o->loose, "leave out pieces that nothing holds");
    command->add_flag("--thin", o->thin, "take walls that the pitch does not resolve as they come");
    add_common(command, &o->common, texts.get());
    command->callback([=] { *action = [=] { return run_with(o.get(), *texts, run_export); }; });
}

int mechanics_main(int argc, char** argv) {
    prepare_streams();
    // Whatever is computed is not written before it is complete, so a signal may end it at once.
    clean_up_on_signals();
    CLI::App app("How stiff is it, and will it hold?", "openfab mechanics");
    app.require_subcommand(1);
    Action action;
    add_cell(app, &action);
    add_part(app, &action);
    add_conduct(app, &action);
    add_stand(app, &action);
    add_strengthen(app, &action);
    add_export(app, &action);
    add_examples(&app, kExamples);
    return run_command_line(&app, argc, argv, "openfab mechanics", [&] { return action(); });
}

}  // namespace

}  // namespace openfab::mechanics

int main(int argc, char** argv) {
    return openfab::run_main(openfab::mechanics::mechanics_main, argc, argv);
}
