// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-tuner`: profiles prints and tunes their schedules. `openfab` starts it; it is a program of
// its own because it holds the compiler and the whole runtime.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/units.h"
#include "program/options.h"
#include "tools/tuner/command.h"
#include "tools/tuner/messages.h"
#include "tools/tuner/profile.h"
#include "tools/tuner/tune.h"

namespace openfab::tuner {

namespace {

using Action = std::function<Result<void>()>;

/// Parses the value of an option, between limits.
Result<double> seconds_of(const char* option, const std::string& text, double least, double most) {
    Result<double> seconds = parse_duration(text);
    if (!seconds) return usage_error(fmt::format("`{}`: {}", option, seconds.error().text()));
    if (*seconds >= least && *seconds <= most) return seconds;
    return usage_error(fmt::format(messages::kWriteATime, option, text, format_seconds(least),
                                   format_seconds(most)));
}

void add_profile(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand("profile", "show where the time of a print goes");
    auto options = std::make_shared<ProfileOptions>();
    auto time = std::make_shared<std::string>("10s");
    command
        ->add_option("--time", *time,
                     "approximate time to print: as many slabs as fit into it (default: 10s)")
        ->type_name("TIME");
    command->add_flag("--whole", options->whole, "the whole print, however long it takes");
    command->add_option("--json", options->json_file, "write the figures to this file, too")
        ->type_name("FILE");
    add_schedule_options(command, &options->schedules);
    take_print_options(
        command, "openfab profile",
        "  openfab profile card.fab.json                   slabs spread over the print\n"
        "  openfab profile card.fab.json --whole --json p.json   all of it, and its figures\n"
        "  openfab profile card.fab.json --schedule mine.sched   with a schedule of yours\n");
    command->callback([options, time, command, action] {
        *action = [options, time, words = command->remaining()]() -> Result<void> {
            const Result<double> seconds = seconds_of("--time", *time, 0.1, 86400);
            if (!seconds) return seconds.error();
            options->seconds = *seconds;
            options->print = words;
            return run_profile(*options);
        };
    });
}

void add_tune(CLI::App& app, Action* action) {
    CLI::App* command =
        app.add_subcommand("tune", "search the schedule that prints a world fastest");
    auto options = std::make_shared<TuneOptions>();
    auto budget = std::make_shared<std::string>("5m");
    command
        ->add_option("-o,--output", options->output,
                     "the schedule to write, FILE.sched; an existing one is tried, too")
        ->type_name("FILE");
    command
        ->add_option(
            "--budget", *budget,
            "how long to search and verify (default: 5m); setting up the print comes on top")
        ->type_name("TIME");
    command
        ->add_option("--journal", options->journal,
                     "record of attempts, to continue from (default: FILE.sched.journal)")
        ->type_name("FILE");
    add_schedule_options(command, &options->schedules);
    take_print_options(
        command, "openfab tune",
        "  openfab tune card.fab.json -o card.sched        for five minutes; again to continue\n"
        "  openfab tune card.fab.json -o card.sched --budget 1h --draft 2\n"
        "  openfab print card.fab.json -o card.ofr --schedule card.sched   uses it\n");
    command->callback([options, budget, command, action] {
        *action = [options, budget, words = command->remaining()]() -> Result<void> {
            const Result<double> seconds = seconds_of("--budget", *budget, 1, 86400);
            if (!seconds) return seconds.error();
            options->budget_seconds = *seconds;
            options->print = words;
            return run_tune(*options);
        };
    });
}

int tuner_main(int argc, char** argv) {
    prepare_streams();
    clean_up_on_signals();
    CLI::App app("Profiles prints and tunes their schedules.", "openfab");
    app.require_subcommand(1);
    Action action;
    add_profile(app, &action);
    add_tune(app, &action);
    return run_command_line(&app, argc, argv, "openfab", [&] { return action(); });
}

}  // namespace

}  // namespace openfab::tuner

int main(int argc, char** argv) {
    return openfab::run_main(openfab::tuner::tuner_main, argc, argv);
}
