// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The command lines of `openfab specimens`.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "tools/openfab/command_lines.h"
#include "tools/openfab/specimens.h"
#include "tools/specimens/pieces.h"

namespace openfab::tools {

namespace {

void add_make(CLI::App* specimens, Action* action) {
    CLI::App* command =
        specimens->add_subcommand("make", "write trays of test pieces, and a list of them");
    auto a = std::make_shared<SpecimenTrayArguments>();
    command->add_option("--printer", a->printer, "a printer, as `openfab printers` lists them")
        ->required();
    command->add_option("-o,--output", a->folder, "the folder to make")->required();
    command
        ->add_option(
            "--piece", a->piece,
            fmt::format("{} (default: d638-iv)", fmt::join(specimens::piece_names(), ", ")))
        ->type_name("NAME");
    command
        ->add_option("--material", a->materials,
                     "a material (repeatable); labels are of the first that is not clear")
        ->allow_extra_args(false);
    command->add_option("--steps", a->steps,
                        "of mixtures of two materials, from one to the other (default: 5)");
    command
        ->add_option("--mixture", a->mixtures,
                     "shares of the materials (repeatable), such as 0.2,0.3,0.5, instead of steps")
        ->allow_extra_args(false)
        ->type_name("SHARES");
    command
        ->add_option("--fablet", a->fablet,
                     "a fablet of yours, FILE.fl or FILE.fl:NAME, instead of mixtures")
        ->type_name("FILE");
    command->add_option("--set", a->settings, "a uniform of it (repeatable): NAME=VALUE")
        ->allow_extra_args(false);
    command->add_option("--sweep", a->sweep,
                        "the uniform in which pieces differ: NAME=VALUE,VALUE,...");
    command->add_option("--copies", a->copies, "of each kind (default: 5, as the standards want)");
    command->add_option("--thickness", a->thickness, "default: the standard's");
    command
        ->add_option(
            "--along", a->along,
            "the tray's axis along which pieces are pulled or pressed (default: x, of discs z)")
        ->check(CLI::IsMember({"x", "y", "z"}));
    command->add_option("--gap", a->gap, "between pieces (default: 5mm)");
    command->callback([a, action] { *action = [a] { return make_specimens(*a); }; });
}

void add_read(CLI::App* specimens, Action* action) {
    CLI::App* command =
        specimens->add_subcommand("read", "make tables of the curves that a testing machine wrote");
    auto a = std::make_shared<SpecimenReadArguments>();
    command
        ->add_option("FOLDER", a->folder,
                     "that of `openfab specimens make`; the tables are written there")
        ->required();
    command
        ->add_option("--curves", a->curves,
                     "a folder with a file per specimen, named by its label, such as 7.csv")
        ->required();
    command
        ->add_option("--source", a->source,
                     "who measured it, how, at which temperature and rate; goes into the tables")
        ->required();
    command->add_option("--temperature", a->temperature,
                        "at which it was measured, such as 23C; with --rate");
    command->add_option("--rate", a->rate,
                        "of loading, such as 0.01/s, or the time up to the strain of use, 100s");
    command
        ->add_option("--strain", a->strain,
                     "the column of strain or extension: its name, or its number from 1")
        ->type_name("COLUMN");
    command->add_option("--stress", a->stress, "the column of stress or force, likewise")
        ->type_name("COLUMN");
    command->add_option("--length", a->length,
                        "by which extensions are divided (default: the free length between the "
                        "grips, of discs the height)");
    command
        ->add_option("--range", a->range,
                     "of strains between which the modulus is the slope (default: 0.0005:0.0025, "
                     "as in ISO 527-1)")
        ->type_name("FROM:TO");
    command
        ->add_option("--nu", a->poisson,
                     "Poisson's ratio of a material (repeatable), NAME=NUMBER, for mechanics.json")
        ->allow_extra_args(false);
    command->callback([a, action] { *action = [a] { return read_specimens(*a); }; });
}

}  // namespace

void add_specimens(CLI::App& app, Action* action) {
    CLI::App* specimens = app.add_subcommand(
        "specimens", "make trays of standard test pieces, and data of what was measured on them");
    specimens->require_subcommand(1);
    add_make(specimens, action);
    add_read(specimens, action);
}

}  // namespace openfab::tools
