// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab print W.fab.json -o OUT`: compiles the world's fablets if they changed, then executes
// the print program with the same options, so that the output has the same bytes.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "abi/kernel_call.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/start_program.h"
#include "base/system_reason.h"
#include "program/options.h"
#include "program/output_check.h"
#include "program/print_record.h"
#include "runtime/process/kinds/kinds.h"
#include "texture/cache.h"
#include "tools/openfab/check.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/programs.h"
#include "tools/openfab/stock.h"
#include "world/fablet_sources.h"
#include "world/world.h"

namespace openfab::tools {

namespace {

/// Options that a print binary does not have: they are for its compilation, and for a check before it runs.
struct CompileOptions {
    std::string fablet;
    ScheduleArguments schedules;
    bool check = false;
    std::string check_picture;
    std::vector<std::string> words;  ///< of the compilation, as given
    std::string record;              ///< these as JSON, and whether the check was made
};

/// Removes those options from the arguments.
Result<CompileOptions> take_compile_options(std::vector<std::string>* arguments) {
    CompileOptions taken;
    struct Option {
        std::string_view name, needs;
        std::function<void(std::string value)> take;
    };
    const auto keep_word = [&](std::string_view name, const std::string& value) {
        taken.words.emplace_back(name);
        taken.words.push_back(value);
    };
    const std::array<Option, 4> options{{
        {"--fablet", messages::kAnOpenFlFile,
         [&](std::string value) {
             keep_word("--fablet", value);
             taken.fablet = std::move(value);
         }},
        {"--schedule", messages::kAScheduleOrFolder,
         [&](std::string value) {
             keep_word("--schedule", value);
             taken.schedules.paths.push_back(std::move(value));
         }},
        {"--param", "NAME=NUMBER",
         [&](std::string value) {
             keep_word("--param", value);
             taken.schedules.params.push_back(std::move(value));
         }},
        {"--check-picture", messages::kAPngFile,
         [&](std::string value) {
             taken.check = true;
             taken.check_picture = std::move(value);
         }},
    }};
    std::vector<std::string> others;
    for (size_t i = 0; i < arguments->size(); ++i) {
        const std::string& argument = (*arguments)[i];
        if (argument == "--check") {
            taken.check = true;
            continue;
        }
        const auto option = std::find_if(options.begin(), options.end(), [&](const Option& each) {
            return argument.starts_with(each.name) &&
                   (argument.size() == each.name.size() || argument[each.name.size()] == '=');
        });
        if (option == options.end()) {
            others.push_back(argument);
        } else if (argument.size() > option->name.size()) {
            option->take(argument.substr(option->name.size() + 1));
        } else if (i + 1 < arguments->size()) {
            option->take((*arguments)[++i]);
        } else {
            return usage_error(fmt::format(messages::kOptionNeeds, option->name, option->needs));
        }
    }
    JsonText record;
    record.begin_array();
    for (size_t i = 0; i + 1 < taken.words.size(); i += 2)
        record.begin_array().value(taken.words[i]).value(taken.words[i + 1]).end_array();
    if (taken.check) record.begin_array().value("--check").end_array();
    taken.record = record.end_array().take();
    *arguments = std::move(others);
    return taken;
}

/// The sources to compile, and their folder if it is temporary.
struct Sources {
    std::vector<std::filesystem::path> files;
    std::optional<world::DitherRef> dither;
    std::unique_ptr<TemporaryFolder> folder;
};

/// Writes the file of a stock fablet, to the cache if there is one.
Result<Sources> stock_sources(const std::string& fablet) {
    Sources sources;
    Result<std::filesystem::path> folder = texture::cache_folder("stock");
    if (!texture::check_keeps(folder)) {
        Result<std::unique_ptr<TemporaryFolder>> made = TemporaryFolder::create();
        if (!made) return made.error();
        sources.folder = std::move(*made);
        folder = sources.folder->path();
    }
    Result<std::filesystem::path> source = stock_source(fablet, *folder);
    if (!source) return source.error();
    sources.files.push_back(std::move(*source));
    return sources;
}

world::FileRules file_rules(const program::Options& options) {
    return world::rules_of(options.allow, options.memory_bytes);
}

Result<Sources> sources_of(const program::Options& options, const std::string& fablet) {
    const std::string& input = options.input;
    if (find_stock_fablet(fablet) != nullptr) return stock_sources(fablet);
    Sources sources;
    if (!fablet.empty()) sources.files.emplace_back(fablet);
    if (!input.ends_with(".json")) {
        if (!fablet.empty()) return sources;
        return usage_error(fmt::format(messages::kMeshNeedsFablet, input, stock_fablet_names()));
    }
    // The print binary reads the meshes.
    Result<world::World> world =
        world::load_world(input, file_rules(options), world::MeshFiles::kSkip);
    if (!world) return world.error();
    if (fablet.empty()) {
        Result<std::vector<std::filesystem::path>> files = world::fablet_sources(*world, input);
        if (!files) return files.error();
        sources.files = std::move(*files);
    }
    sources.dither = std::move(world->dither);
    return sources;
}

/// Looks at what will be printed, by the limits of the machine; an error where it finds something.
Result<void> check_print(const program::Options& options, const CompileOptions& compilation) {
    CheckArguments check;
    check.file = options.input;
    check.printer = options.printer;
    check.process = options.process_file;
    check.picture = compilation.check_picture;
    check.allow = options.allow;
    check.threads = options.threads.value_or(0);
    if (options.memory_given) check.memory = fmt::format("{}B", options.memory_bytes);
    check.pitch_mm = [&](const Vec3d& printer_mm) {
        return program::print_pitch(options, printer_mm);
    };
    check.print_words = compilation.words;
    const auto word = [&](const char* name, const std::string& value) {
        if (value.empty()) return;
        check.print_words.emplace_back(name);
        check.print_words.push_back(value);
    };
    // Its own print leaves effects on neighbours as they are.
    for (const auto& [name, value] : options.effects) {
        if (process::find_option(name)->option.choices.empty()) word(name.c_str(), value);
    }
    word("--dither", options.dither);
    word("--support", options.support);
    word("--seed", options.seed == 0 ? "" : fmt::format("{}", options.seed));
    for (const std::string& setting : options.settings)
        word("--set", setting);
    return run_check(check);
}

/// Replaces this process by the print binary; returns only on failure.
Error exec_print_binary(const PrintBinary& program, const CompileOptions& compilation,
                        const std::vector<std::string>& arguments) {
    const std::string name = program.path.empty() ? "openfab print" : program.path.string();
    std::vector<char*> argv{const_cast<char*>(name.c_str())};
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    // Print programs start this program for textures that are not in the cache yet.
    if (Result<std::filesystem::path> folder = program_folder(); folder) {
        ::setenv("OPENFAB_HELPER", (*folder / "openfab").c_str(), 0);
    }
    // The record of the print tells how it was compiled, too.
    ::setenv(program::kCompilationVariable, compilation.record.c_str(), 1);
    if (program.path.empty()) {
        ::fexecve(program.file.descriptor(), argv.data(), environ);
    } else {
        ::execv(program.path.c_str(), argv.data());
    }
    return outside_error(fmt::format(messages::kCannotStartProgram, name, system_reason(errno)));
}

}  // namespace

Result<void> run_print(std::vector<std::string> arguments) {
    const Result<CompileOptions> compilation = take_compile_options(&arguments);
    if (!compilation) return compilation.error();
    std::vector<const char*> argv{"openfab print"};
    for (const std::string& argument : arguments)
        argv.push_back(argument.c_str());
    Result<program::Options> options =
        program::parse_options(static_cast<int>(argv.size()), argv.data(), "openfab print");
    if (!options) return options.error();
    if (options->help) {
        show(fmt::format(
            "{}\n--fablet FILE.fl names the fablet for a mesh; or one of {}.\n"
            "--schedule FILE.sched, or a folder of such files, and --param NAME=NUMBER "
            "are for the\ncompilation of its kernels (repeatable). --check looks for "
            "details that the machine will not print\nwell, as `openfab check` does, and prints "
            "nothing if it finds anything;\n--check-picture FILE.png shows the places.\n",
            options->text, stock_fablet_names()));
        return {};
    }
    Result<Sources> sources = sources_of(*options, compilation->fablet);
    if (!sources) return sources.error();
    // It runs here: the other sets are for programs that somebody builds to take elsewhere.
    const PrintProgram wanted{sources->files,
                              abi::best_isa(options->isa.value_or(program::kUsualIsa)),
                              compilation->schedules, sources->dither};
    // The print binary checks again, with all that the world names, but does not know these files.
    if (Result<void> apart =
            program::check_outputs(program::outputs_of(*options, nullptr, {}), inputs_of(wanted));
        !apart)
        return apart.error();
    if (compilation->check) {
        if (const Result<void> fine = check_print(*options, *compilation); !fine) return fine;
    }
    const Result<PrintBinary> program =
        find_or_build_print_binary(wanted, options->progress == program::ProgressMode::kNone);
    if (!program) return program.error();
    sources->folder.reset();  // exec runs no destructors
    return exec_print_binary(*program, *compilation, arguments);
}

int start_helper(const char* name, char** argv) {
    Result<std::filesystem::path> folder = program_folder();
    Error failed = folder ? Error{} : folder.error();
    if (folder) {
        const std::filesystem::path helper = *folder / name;
        ::setenv("OPENFAB_HELPER", (*folder / "openfab").c_str(), 0);
        ::execv(helper.c_str(), argv);
        failed = outside_error(
            fmt::format(messages::kCannotStartProgram, helper.string(), system_reason(errno)));
    }
    return say_error(failed);
}

int print_command(int argc, char** argv) {
    Result<void> done = run_print({argv + 2, argv + argc});
    if (done) done = written_out();
    if (done) return 0;
    // Compile errors have been printed by the compiler.
    return say_error(done.error());
}

}  // namespace openfab::tools
