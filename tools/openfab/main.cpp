// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab`: what most people type.

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <string_view>

#include "runtime/base/caret.h"
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
    std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is a write error with a message
    if (argc > 1 && std::string_view(argv[1]) == "print") return print_command(argc, argv);
    if (argc > 1 && std::string_view(argv[1]) == "texture") return texture_command(argv);
    CLI::App app("OpenFab: programs in, printer slices out.", "openfab");
    app.footer(kFooter);
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
    app.add_subcommand("texture", "make the filtered pyramid of an image (print binaries call it)");
    try {
        app.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
        fmt::print("{}", app.help());
        return 0;
    } catch (const CLI::CallForAllHelp&) {
        fmt::print("{}", app.help("", CLI::AppFormatMode::All));
        return 0;
    } catch (const CLI::ParseError& error) {
        fmt::print(stderr, "error: {}; `openfab --help` lists the commands\n", error.what());
        return exit_code(ErrorCode::kUsage);
    }
    Result<void> done = action();
    if (done && std::fflush(stdout) != 0) done = outside_error("cannot write to standard output");
    if (done) return 0;
    fmt::print(stderr, "{}", render_error(done.error()));
    return exit_code(done.error().code);
}

}  // namespace

}  // namespace openfab::tool

int main(int argc, char** argv) {
    return openfab::tool::tool_main(argc, argv);
}
