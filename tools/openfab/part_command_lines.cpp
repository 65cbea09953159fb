// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The command lines of what is done to parts before they are printed.

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "tools/openfab/arrange.h"
#include "tools/openfab/check.h"
#include "tools/openfab/command_lines.h"
#include "tools/openfab/compensate.h"
#include "tools/openfab/split.h"

namespace openfab::tools {

namespace {

void add_split(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "split", "cut objects larger than a machine into pieces, and put them on trays");
    auto a = std::make_shared<SplitArguments>();
    command->add_option("WORLD", a->world, "a world (.fab.json)")->required();
    command
        ->add_option(
            "--fit", a->fit,
            "a printer (`openfab print --help` names them), or a size such as 490x390x200mm")
        ->required()
        ->type_name("MACHINE");
    command
        ->add_option("-o,--output", a->output,
                     "the world to write, in the folder of the other: NAME.fab.json; "
                     "NAME-2.fab.json, ... are "
                     "more trays, NAME.cuts.json has the cuts")
        ->required();
    command->add_option("--object", a->object, "cut this one alone (default: all that do not fit)");
    command->add_option("--peg", a->peg, "diameter of dowels, 0mm for none (default: 6mm)");
    command->add_option("--material", a->material, "of dowels (default: the world's first)");
    command->add_option("--clearance", a->clearance, "of their holes, all around (default: 0.1mm)");
    command->add_option("--skin", a->skin,
                        "least distance of holes from the surface (default: 1.5mm)");
    command->add_option("--number", a->number,
                        "height of the names in cut faces, 0mm for none (default: 6mm)");
    command->add_option("--gap", a->gap, "between pieces on a tray (default: 5mm)");
    command->add_option("--seam", a->seam,
                        "an attribute of the mesh's corners: 0 where seams should be, 1 for "
                        "normal, more where they are worse");
    command
        ->add_option("--look", a->look,
                     "a print of the uncut world (.ofr, a draft will do): seams go where its "
                     "colours change")
        ->type_name("PRINT");
    command
        ->add_option("--stress", a->stress,
                     "a volume, such as from `openfab mechanics part -o` (FILE, or FILE:ARRAY): "
                     "sections go where it is small")
        ->type_name("VOLUME");
    add_world_options(command, &a->allow, &a->settings);
    add_memory_option(command, &a->memory);
    command->callback([a, action] { *action = [a] { return run_split(*a); }; });
}

void add_arrange(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "arrange", "put everything that a world builds on a machine's trays, one world per tray");
    auto a = std::make_shared<ArrangeArguments>();
    command
        ->add_option("WORLD", a->worlds,
                     "a world (.fab.json), or several that differ only in what they build")
        ->required();
    command
        ->add_option("--fit", a->fit,
                     "a printer, or a size such as 490x390x200mm (default: the world's printer)")
        ->type_name("MACHINE");
    command
        ->add_option(
            "-o,--output", a->output,
            "the world to write, in the folder of the other: NAME.fab.json; NAME-2.fab.json, ... "
            "are more trays")
        ->required();
    command
        ->add_option("--copies", a->copies,
                     "how many of everything that the world builds, as 12, or of one object, as "
                     "NAME=12 (repeatable; default: 1)")
        ->allow_extra_args(false)
        ->type_name("N|NAME=N");
    command->add_option("--gap", a->gap, "between things on a tray (default: 5mm)");
    command
        ->add_option("--turn", a->turn,
                     "how things may be turned: none, upright (about z, the default), or all (on "
                     "their sides if they fit no other way)")
        ->type_name("CHOICE");
    add_world_options(command, &a->allow, &a->settings);
    add_memory_option(command, &a->memory);
    command->callback([a, action] { *action = [a] { return run_arrange(*a); }; });
}

void add_check(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "check",
        "find thin walls, narrow gaps, loose islands, trapped volumes, forbidden contacts");
    auto a = std::make_shared<CheckArguments>();
    command->add_option("FILE", a->file, "a world (.fab.json), or a print (.ofr)")->required();
    command->add_option("--printer", a->printer, "with the limits in its profile, under `checks`")
        ->type_name("NAME");
    command->add_option("--process", a->process, "items that replace those of the profile")
        ->type_name("FILE");
    command->add_option("-o,--picture", a->picture, "a PNG that shows the places");
    command->add_option("--report", a->report, "a JSON file with all of them");
    command->add_option("--wall", a->wall, "thinner walls and wires, such as 0.4mm");
    command->add_option("--gap", a->gap, "narrower gaps");
    command->add_option("--hole", a->hole, "holes of a smaller diameter");
    command->add_option("--island", a->island, "smaller loose islands, such as 0.5mm3");
    command->add_option("--trapped", a->trapped, "void and support that cannot get out, if larger");
    command
        ->add_option("--apart", a->apart, "two materials that must not touch, such as water,salt")
        ->allow_extra_args(false);
    command
        ->add_option("--draft", a->draft,
                     "check at this multiple of the pitch (default: 1, or as memory allows)")
        ->check(CLI::Range(1, 64));
    command
        ->add_option("--parts", a->parts,
                     "look at the N x N x N parts of each voxel (default: 3, or as memory allows)")
        ->check(CLI::Range(1, 8));
    command->add_option("--threads", a->threads, "of the print (default: all cores)")
        ->check(CLI::Range(1, 1024));
    add_world_options(command, &a->allow, &a->settings);
    add_memory_option(command, &a->memory);
    command->callback([a, action] { *action = [a] { return run_check(*a); }; });
}

void add_compensate(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "compensate", "make a displacement field from the intended and the measured shape");
    auto a = std::make_shared<CompensateArguments>();
    command
        ->add_option(
            "NOMINAL", a->nominal,
            "the intended mesh, or a .csv of points: intended and measured x,y,z of each, in mm")
        ->required();
    command->add_option("MEASURED", a->measured, "the measured mesh, in the same place");
    command
        ->add_option("-o,--output", a->output, "NAME.json for `field` of a process, and NAME.npy")
        ->required();
    command->add_option("--cell", a->cell, "of the field's grid (default: a 12th of the part)");
    command->add_option("--smooth", a->smoothness,
                        "weight of second differences against a measured place (default: 0.001)");
    add_memory_option(command, &a->memory);
    command->callback([a, action] { *action = [a] { return run_compensate(*a); }; });
}

}  // namespace

void add_part_commands(CLI::App& app, Action* action) {
    add_split(app, action);
    add_arrange(app, action);
    add_check(app, action);
    add_compensate(app, action);
}

}  // namespace openfab::tools
