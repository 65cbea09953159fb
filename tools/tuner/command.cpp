// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/command.h"

#include "program/options.h"

namespace openfab::tuner {

void take_print_options(CLI::App* command, const std::string& program,
                        const std::string& examples) {
    command->allow_extras()->fallthrough(false);
    const char* const ask[] = {"print", "--help"};
    const Result<program::Options> help = program::parse_options(2, ask, program, false);
    if (!help) return;
    command->footer("Examples:\n" + examples +
                    "\nOptions of the print, which keeps no slices:\n\n" + help->text);
}

void add_schedule_options(CLI::App* command, driver::ScheduleOptions* options) {
    command
        ->add_option("--schedule", options->paths,
                     "a schedule in place of a built-in one, or a folder of them (repeatable)")
        ->type_size(1)
        ->allow_extra_args(false);
    command
        ->add_option("--param", options->params,
                     "NAME=NUMBER, a value for a parameter of the schedules (repeatable)")
        ->type_size(1)
        ->allow_extra_args(false);
}

}  // namespace openfab::tuner
