// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-fit`: finds uniforms for which a print is what is wanted. `openfab` starts it; it is a program of its own
// because it holds the compiler, the whole runtime and an optimiser.

#include <CLI/CLI.hpp>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "tools/fit/fit.h"
#include "tools/tuner/command.h"

namespace openfab::fit {

namespace {

constexpr const char* kExamples =
    R"(  openfab fit ball.fab.json goals.json                      wanted, as mixtures, as printed
  openfab fit ball.fab.json goals.json -o fitted.fab.json   a world of what was found
  openfab fit ball.fab.json goals.json --history fit.svg    how it got there
)";

void declare(CLI::App* app, FitOptions* options) {
    app->add_option("-o,--output", options->output,
                    "a world to write with the uniforms that were found, NEW.fab.json")
        ->type_name("FILE");
    app->add_flag("--write", options->write, "write them into the world itself");
    app->add_option("--json", options->json_file, "write all numbers to this file, too")
        ->type_name("FILE");
    app->add_option("--history", options->history_file,
                    "write what was tried: a table (.csv) or a picture (.svg)")
        ->type_name("FILE");
    app->add_option("--search-seed", options->search_seed,
                    "of the starts that are tried after the first (default: 0)")
        ->type_name("N");
    tuner::add_schedule_options(app, &options->schedules);
    tuner::take_print_options(app, "openfab fit", kExamples);
}

int fit_main(int argc, char** argv) {
    prepare_streams();
    clean_up_on_signals();
    CLI::App app(
        "Finds the uniforms for which a print is what is wanted: amounts, weight, cost, "
        "deflection, "
        "resistance, stiffness.",
        "openfab fit WORLD GOALS.json");
    FitOptions options;
    declare(&app, &options);
    return run_command_line(&app, argc, argv, "openfab fit", [&] {
        options.print = app.remaining();
        return run_fit(options);
    });
}

}  // namespace

}  // namespace openfab::fit

int main(int argc, char** argv) {
    return openfab::run_main(openfab::fit::fit_main, argc, argv);
}
