// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab`: the user's command-line tool.

#include <CLI/CLI.hpp>
#include <csignal>
#include <string_view>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "base/talking_program.h"
#include "tools/openfab/command_lines.h"
#include "tools/openfab/commands.h"

namespace openfab::tools {

namespace {

constexpr const char* kExamples =
    R"(  openfab print card.fab.json -o slices        compile the world's fablets and print
  openfab print --help                         all options of a print
  openfab import robot.obj -o robot            a world from a mesh with its pictures
  openfab new soft_toy                         a folder with a fablet and a world
  openfab coupon --printer j750 -o coupon      a plate to look at and to measure
  openfab specimens make --printer j750 --material VeroClear -o bars
  openfab text Ada -o name.obj --size 8mm      a mesh of a name
  openfab info card.ofr                        size, materials, amounts
  openfab verify card.ofr                      check every slice
  openfab export card.ofr -o slices            an .ofr as a folder of PNGs
  openfab merge low.ofr high.ofr -o card.ofr   parts made with `--slices`
  openfab printers j850                        what a printer takes, with sources
  openfab archive card.ofr -o card.zip         what it was made from, to print it again
  openfab cache --files                        what is kept between prints
  openfab property modulus.json -o modulus.fl  measured mixtures as a module
  openfab split bear.fab.json --fit j750 -o pieces.fab.json
  openfab arrange zoo.fab.json --fit j750 -o trays.fab.json
  openfab check card.fab.json -o faults.png    details that the machine will not print well
  openfab compensate bear.obj scan.stl -o bear.field.json
  openfab view card.ofr                        slices, cuts and a volume in a browser
  openfab render card.ofr -o card.png          how it will look
  openfab mechanics cell gyroid.fl --cell 8mm  how stiff a lattice's cell is
  openfab profile card.fab.json                where the time of a print goes
  openfab tune card.fab.json -o card.sched     a schedule that is faster on this machine
  openfab fit ball.fab.json goals.json         uniforms for a wanted amount or weight
  openfab receive --listen tcp://127.0.0.1:7000 -o card.ofr
)";

/// A command that is a program of its own, beside this one: with what it alone links.
struct HelperCommand {
    const char* name;
    const char* what;
    const char* program;
    bool takes_name = false;  ///< runs several commands, and gets the name
};
constexpr HelperCommand kHelperCommands[] = {
    {"render", "show how a print will look: light traced through its voxels", "openfab-render"},
    {"profile", "show where the time of a print goes, and what limits each stage", "openfab-tuner",
     true},
    {"tune", "search the schedule that prints a world fastest on this machine", "openfab-tuner",
     true},
    {"fit", "find the uniforms for which a print is what is wanted", "openfab-fit"},
    {"mechanics", "compute stiffness and strength: cells, parts", "openfab-mechanics"},
    {"text", "make a mesh or a picture from a text", "openfab-text"},
    {"color", "print colours as a measured printer makes them: charts, ICC profiles",
     "openfab-color"},
    {"texture", "convert an image for prints (they call this themselves)", "openfab-texture"},
};

int tool_main(int argc, char** argv) {
    prepare_streams();
    clean_up_on_signals();
    std::signal(SIGXFSZ, SIG_IGN);  // a file above the limit is an error with a message
    if (argc > 1 && std::string_view(argv[1]) == "print") return print_command(argc, argv);
    for (const HelperCommand& command : kHelperCommands) {
        if (argc > 1 && std::string_view(argv[1]) == command.name)
            return start_helper(command.program, command.takes_name ? argv : argv + 1);
    }
    CLI::App app("OpenFab: programs in, printer slices out.", "openfab");
    app.require_subcommand(1);
    app.set_version_flag("--version", "openfab " OPENFAB_VERSION);
    Action action;
    // Listed for --help, as the helpers are below; handled above.
    app.add_subcommand("print",
                       "print a world: slices for a printer, an .ofr file or stream, pictures");
    add_commands(app, &action);
    for (const HelperCommand& command : kHelperCommands)
        app.add_subcommand(command.name, command.what);
    add_examples(&app, kExamples);
    return run_command_line(&app, argc, argv, "openfab", [&] { return action(); });
}

}  // namespace

}  // namespace openfab::tools

int main(int argc, char** argv) {
    return openfab::run_main(openfab::tools::tool_main, argc, argv);
}
