// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// openflc: the OpenFL compiler.

#include <fmt/format.h>

#include <string>

#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/say.h"
#include "base/text.h"
#include "compiler/diag/render.h"
#include "compiler/driver/commands.h"

namespace openfab::driver {

void print_diagnostics(const diag::Sink& sink, const source::SourceManager& sources,
                       const CommonOptions& common) {
    say(common.json_diagnostics ? printable_json(diag::render_json(sink, sources))
                                : diag::render_text(sink, sources));
}

int fail(const std::string& what, int code) {
    say(fmt::format("openflc: {}: {}\n", code == kExitBug ? "internal error" : "error", what));
    return code;
}

namespace {

int run(int argc, char** argv) {
    CLI::App app{"The OpenFL compiler: fablets in, kernels or a print program out.", "openflc"};
    app.require_subcommand(1);
    CommonOptions common;
    std::string diagnostics = "text";
    app.add_option("--diagnostics", diagnostics, "how errors and warnings are printed")
        ->check(CLI::IsMember({"text", "json"}))
        ->capture_default_str();
    app.fallthrough();
    Action action;
    add_check(app, common, &action);
    add_describe(app, common, &action);
    add_emit(app, common, &action);
#ifdef OPENFAB_WITH_BACK_END
    add_build(app, common, &action);
#endif
#ifdef OPENFAB_WITH_PRINT
    add_run(app, common, &action);
#endif
    // Last, so that the commands above do not take it over.
    app.footer(
        "Examples:\n"
        "  openflc check postcard.fl\n"
        "  openflc emit --stage volume --as ir postcard.fl\n"
        "  openflc describe postcard.fl");
    int code = kExitDone;
    try {
        app.parse(argc, argv);
        common.json_diagnostics = diagnostics == "json";
        code = action ? action() : kExitUsage;
    } catch (const CLI::CallForHelp&) {
        show(app.help());
    } catch (const CLI::ParseError& error) {
        return fail(command_line_error(app, error, "openflc").message, kExitUsage);
    }
    const Result<void> written = written_out();
    return written || code != kExitDone ? code : fail(written.error().message, kExitOutside);
}

}  // namespace

}  // namespace openfab::driver

int main(int argc, char** argv) {
    openfab::prepare_streams();
    openfab::clean_up_on_signals();
    return openfab::driver::run(argc, argv);
}
