// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// openflc: the OpenFL compiler.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "abi/kernel_call.h"
#include "base/clean_exit.h"
#include "base/command_line.h"
#include "base/run_main.h"
#include "base/say.h"
#include "compiler/driver/commands.h"
#include "compiler/lower/code/fatal_errors.h"
#include "compiler/passes/pipeline.h"
#include "program/options.h"

namespace openfab::driver {

namespace {

using Action = std::function<int()>;

// Each add_ function declares a command, which sets `*action` when it is the one given.

void add_check(CLI::App& app, const CommonOptions& common, Action* action) {
    CLI::App* command =
        app.add_subcommand("check", "Check fablets and modules, and report errors and warnings");
    auto files = std::make_shared<std::vector<std::string>>();
    command->add_option("FILE.fl", *files, "OpenFL files")->required();
    auto derivatives = std::make_shared<bool>(false);
    command->add_flag(
        "--derivatives", *derivatives,
        "warn where mixtures jump as uniforms change: there derivatives are those of one side");
    command->callback([files, derivatives, &common, action] {
        *action = [files, derivatives, &common] { return check(*files, *derivatives, common); };
    });
}

void add_format(CLI::App& app, const CommonOptions& common, Action* action) {
    CLI::App* command = app.add_subcommand("fmt", "Lay out fablets and modules in one style");
    auto options = std::make_shared<FormatOptions>();
    command
        ->add_option("FILE.fl", options->files,
                     "OpenFL files, which are rewritten; `-`: standard input to standard output")
        ->required();
    command->add_flag("--check", options->check,
                      "write nothing; name the files that would change, and fail");
    command->callback([options, &common, action] {
        *action = [options, &common] { return format_files(*options, common); };
    });
}

void add_lsp(CLI::App& app, Action* action) {
    CLI::App* command = app.add_subcommand(
        "lsp", "Serve an editor: the Language Server Protocol on standard input and output");
    // Clients add this flag to tell the transport.
    auto stdio = std::make_shared<bool>(true);
    command->add_flag("--stdio", *stdio, "standard input and output, which is the only transport");
    command->callback([action, stdio] { *action = serve_editor; });
}

void add_describe(CLI::App& app, const CommonOptions& common, Action* action) {
    CLI::App* command =
        app.add_subcommand("describe", "Print fablets, uniforms and varyings as JSON");
    auto file = std::make_shared<std::string>();
    command->add_option("FILE.fl", *file, "an OpenFL file")->required();
    command->callback([file, &common, action] {
        *action = [file, &common] { return describe_file(*file, common); };
    });
}

/// The instruction sets of machines of this one's kind.
std::vector<std::string> target_names() {
    std::vector<std::string> out;
    for (const openfab_isa isa : abi::isas())
        out.emplace_back(abi::isa_name(isa));
    return out;
}

void add_schedule_options(CLI::App* command, ScheduleOptions* options) {
    command
        ->add_option("--schedule", options->paths,
                     "file that replaces the built-in schedule of the pipeline it is named "
                     "after (slab.sched, surface.avx2.sched, …), or a folder of such files")
        ->type_size(1)
        ->allow_extra_args(false);
    command
        ->add_option("--param", options->params,
                     "NAME=NUMBER, a value for a parameter of the schedules")
        ->type_size(1)
        ->allow_extra_args(false);
}

void add_emit(CLI::App& app, const CommonOptions& common, Action* action) {
    CLI::App* command = app.add_subcommand("emit", "Print a stage in one of the compiler's forms");
    auto options = std::make_shared<EmitOptions>();
    options->target = target_names()[target_names().size() > 1 ? 1 : 0];
    command->add_option("FILE.fl", options->file, "an OpenFL file")->required();
    command->add_option("--stage", options->stage, "the stage to print")
        ->check(
            CLI::IsMember({"surface", "surface_bounds", "slab", "volume_bounds", "volume_demand",
                           "dither", "shape", "shape_attributes", "shape_bounds", "grow"}));
    command->add_option("--as", options->form, "the form to print it in")
        ->check(CLI::IsMember(
            {"tokens", "ast", "ir", "halide", "schedule", "loops", "stmt", "llvm", "asm"}))
        ->capture_default_str();
    command->add_option("--fablet", options->fablet,
                        "the fablet to print, if the file has several");
    command->add_option("--target", options->target, "the instruction set to print it for")
        ->check(CLI::IsMember(target_names()))
        ->capture_default_str();
    add_schedule_options(command, &options->schedules);
    command->add_flag("--prints", options->enable_printf, "compile `printf` and `assert` in");
    command->callback([options, &common, action] {
        *action = [options, &common] { return emit(*options, common); };
    });
}

std::vector<std::string> optional_passes() {
    std::vector<std::string> out;
    for (const passes::PassName& pass : passes::pass_names())
        if (pass.optional) out.emplace_back(pass.name);
    return out;
}

void add_passes(CLI::App& app, const CommonOptions& common, Action* action) {
    CLI::App* command = app.add_subcommand(
        "passes", "Write a page with a fablet's stages after each of the compiler's passes");
    auto options = std::make_shared<PassesOptions>();
    command->add_option("FILE.fl", options->file, "an OpenFL file")->required();
    command->add_option("-o,--output", options->output, "the page, for a browser")
        ->capture_default_str();
    command->add_option("--fablet", options->fablet, "the fablet to show, if the file has several");
    command->add_option("--no-pass", options->disabled, "leave a pass out")
        ->check(CLI::IsMember(optional_passes()));
    command->add_flag("--prints", options->enable_printf, "compile `printf` and `assert` in");
    command->callback([options, &common, action] {
        *action = [options, &common] { return show_passes(*options, common); };
    });
}

void add_compilation_options(CLI::App* command, CompilationOptions* options) {
    std::vector<std::string> all;
    for (const passes::PassName& pass : passes::pass_names())
        all.emplace_back(pass.name);
    command->add_option("--jobs", options->threads, "kernels compiled at once; 0: all cores")
        ->check(CLI::Range(0, 1024));
    command->add_flag("--prints", options->enable_printf, "compile `printf` and `assert` in");
    command->add_option(
        "--dither-rule",
        [options](const std::vector<std::string>& words) {
            const size_t colon = words[0].rfind(':');
            if (colon == std::string::npos || colon == 0 || colon + 1 == words[0].size())
                throw CLI::ValidationError("--dither-rule",
                                           "write FILE.fl:NAME, a module and its function");
            options->dither = {words[0].substr(0, colon), words[0].substr(colon + 1)};
            return true;
        },
        "FILE.fl:NAME, a function of a module: the dither rule of fablets without one");
    command->add_flag("--time", options->time, "print the seconds of each step");
    add_schedule_options(command, &options->back_end.schedules);
    command->add_option("--no-pass", options->back_end.disabled, "leave a pass out")
        ->check(CLI::IsMember(optional_passes()));
    command
        ->add_option("--dump-after", options->back_end.dump_after, "print each stage after a pass")
        ->check(CLI::IsMember(all));
    command->add_flag("--time-passes", options->back_end.time_passes,
                      "print the seconds of each pass");
}

void add_build(CLI::App& app, const CommonOptions& common, Action* action) {
    CLI::App* command =
        app.add_subcommand("build", "Compile fablets to a self-contained print program");
    auto options = std::make_shared<BuildOptions>();
    std::vector<std::string> targets = target_names();
    targets.insert(targets.end(), {"both", "all"});
    command->add_option("FILE.fl", options->compilation.files, "OpenFL files")->required();
    command->add_option("-o,--output", options->output, "the program to write")->required();
    command
        ->add_option("--target", options->compilation.target,
                     "instruction sets; all give the same bits. `both` are sse41 and avx2, `all` "
                     "these and avx512")
        ->check(CLI::IsMember(targets))
        ->capture_default_str();
    command->add_option("--cc", options->compiler, "C compiler")->capture_default_str();
    command->add_option(
        "--linker", options->linker,
        "C++ compiler driver that links (default: c++, by mold or gold where there is one)");
    add_compilation_options(command, &options->compilation);
    command->callback([options, &common, action] {
        *action = [options, &common] { return build(*options, common); };
    });
}

void add_run(CLI::App& app, const CommonOptions& common, Action* action) {
    CLI::App* command = app.add_subcommand(
        "run", "Compile fablets in memory and print: FILE.fl WORLD.fab.json -o OUT …");
    auto options = std::make_shared<RunOptions>();
    command
        ->add_option("--print-lines", options->print_lines,
                     "lines that each `printf` shows at most (default: 100)")
        ->check(CLI::Range(1, 1000000))
        ->type_name("N");
    command->add_flag("--watch", options->watch,
                      "print again whenever a fablet, the world, a mesh or an image changes");
    add_compilation_options(command, &options->compilation);
    // Arguments that openflc does not know, in order.
    command->allow_extras()->fallthrough(false);
    const std::vector<const char*> ask = {"run", "--help"};
    const Result<program::Options> help =
        program::parse_options(2, ask.data(), "openflc run FILE.fl");
    if (help) command->footer("Everything else is for the print:\n\n" + help->text);
    command->callback([options, &common, action, command] {
        *action = [options, &common, words = command->remaining()] {
            return run(*options, common, words);
        };
    });
}

void end_by_fault(const lower::Fault& fault) {
    const int code = fail(fault.trouble, fault.is_outside ? kExitOutside : kExitBug);
    end_cleanly(code);
    for (;;)
        ::pause();
}

int openflc_main(int argc, char** argv) {
    prepare_streams();
    clean_up_on_signals();
    lower::end_fatal_errors_by(end_by_fault);
    CLI::App app{"The OpenFL compiler: fablets in, kernels or a print program out.", "openflc"};
    app.require_subcommand(1);
    app.set_version_flag("--version", "openflc " OPENFAB_VERSION);
    CommonOptions common;
    std::string diagnostics = "text";
    app.add_option("--diagnostics", diagnostics, "how errors and warnings are printed")
        ->check(CLI::IsMember({"text", "json"}))
        ->capture_default_str();
    app.fallthrough();
    Action action;
    add_check(app, common, &action);
    add_format(app, common, &action);
    add_lsp(app, &action);
    add_describe(app, common, &action);
    add_emit(app, common, &action);
    add_passes(app, common, &action);
    add_build(app, common, &action);
    add_run(app, common, &action);
    add_examples(&app,
                 "  openflc check postcard.fl\n"
                 "  openflc fmt postcard.fl\n"
                 "  openflc emit --stage slab --as ir postcard.fl\n"
                 "  openflc passes postcard.fl -o passes.html\n"
                 "  openflc describe postcard.fl\n"
                 "  openflc build postcard.fl -o postcard-print\n"
                 "  openflc lsp\n");
    int code = kExitDone;
    try {
        if (argc == 1) {
            show(app.help());  // who gives no command wants to know them
        } else {
            app.parse(argc, argv);
            common.json_diagnostics = diagnostics == "json";
            code = action ? action() : kExitUsage;
        }
    } catch (const CLI::CallForHelp&) {
        show(app.help());
    } catch (const CLI::CallForVersion& version) {
        show(std::string(version.what()) + "\n");
    } catch (const CLI::ParseError& error) {
        return fail(command_line_error(app, error, "openflc").text(), kExitUsage);
    }
    const Result<void> written = written_out();
    return written || code != kExitDone ? code : fail(written.error().text(), kExitOutside);
}

}  // namespace

}  // namespace openfab::driver

int main(int argc, char** argv) {
    return openfab::run_main(openfab::driver::openflc_main, argc, argv);
}
