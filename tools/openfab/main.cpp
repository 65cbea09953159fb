// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab`: what most people type.

#include <string_view>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/say.h"
#include "tools/openfab/commands.h"

namespace openfab::tool {

namespace {

constexpr const char* kFooter = R"(Examples:
  openfab print card.fab.json -o slices        compile the world's fablets and print
  openfab print --help                         all options of a print
  openfab import robot.obj -o robot            a world of a mesh with its pictures
  openfab new soft_toy                         a folder with a fablet and a world
  openfab info card.ofr                        size, materials, amounts
  openfab verify card.ofr                      check every slice
  openfab export card.ofr -o slices            an .ofr as a folder of PNGs
)";

int tool_main(int argc, char** argv) {
    prepare_streams();
    clean_up_on_signals();
    if (argc > 1 && std::string_view(argv[1]) == "print") return print_command(argc, argv);
    if (argc > 1 && std::string_view(argv[1]) == "texture") return texture_command(argv);
    CLI::App app("OpenFab: programs in, printer slices out.", "openfab");
    app.require_subcommand(1);
    Action action;
    // Listed for --help; handled above.
    app.add_subcommand("print",
                       "print a world: slices for a printer, an .ofr file or stream, pictures");
    add_new(app, &action);
    add_import(app, &action);
    add_info(app, &action);
    add_verify(app, &action);
    add_export(app, &action);
    app.add_subcommand("texture", "convert an image for prints, which call this themselves");
    app.footer(kFooter);  // last, so that the commands above do not take it over
    Result<void> done;
    try {
        app.parse(argc, argv);
        done = action();
    } catch (const CLI::CallForHelp&) {
        show(app.help());
    } catch (const CLI::CallForAllHelp&) {
        show(app.help("", CLI::AppFormatMode::All));
    } catch (const CLI::ParseError& error) {
        done = command_line_error(app, error, "openfab");
    }
    if (done) done = written_out();
    return done ? 0 : say_error(done.error());
}

}  // namespace

}  // namespace openfab::tool

int main(int argc, char** argv) {
    return openfab::tool::tool_main(argc, argv);
}
