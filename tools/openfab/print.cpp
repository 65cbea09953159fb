// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab print W.fab.json -o OUT`: compiles the world's fablets if they changed, then executes
// the print program with the same options, so that the output has the same bytes.

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "abi/kernel_call.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "program/options.h"
#include "program/output_check.h"
#include "texture/cache.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/programs.h"
#include "tools/openfab/stock.h"
#include "world/fablet_sources.h"
#include "world/world.h"

namespace openfab::tools {

namespace {

/// Removes `--fablet FILE` from the arguments: the only option that a print binary does not have.
Result<std::string> take_fablet(std::vector<std::string>* arguments) {
    constexpr std::string_view kOption = "--fablet";
    std::string fablet;
    for (size_t i = 0; i < arguments->size();) {
        const std::string argument = (*arguments)[i];
        const auto at = arguments->begin() + static_cast<std::ptrdiff_t>(i);
        if (argument == kOption) {
            if (i + 1 == arguments->size())
                return usage_error("`--fablet` needs a file of OpenFL source");
            fablet = (*arguments)[i + 1];
            arguments->erase(at, at + 2);
        } else if (argument.starts_with(std::string(kOption) + "=")) {
            fablet = argument.substr(kOption.size() + 1);
            arguments->erase(at);
        } else {
            ++i;
        }
    }
    return fablet;
}

/// The sources to compile, and their folder if it is temporary.
struct Sources {
    std::vector<std::filesystem::path> files;
    std::unique_ptr<TemporaryFolder> folder;
};

/// Writes the file of a stock fablet, to the cache if there is one.
Result<Sources> stock_sources(const std::string& fablet) {
    Sources sources;
    Result<std::filesystem::path> folder = texture::cache_folder("stock");
    if (!folder) {
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

Result<Sources> sources_of(const program::Options& options, const std::string& fablet) {
    const std::string& input = options.input;
    if (is_stock_fablet(fablet)) return stock_sources(fablet);
    Sources sources;
    if (!fablet.empty()) {
        sources.files.emplace_back(fablet);
        return sources;
    }
    if (!input.ends_with(".json")) {
        return usage_error(fmt::format(
            "`{}` is not a world (.fab.json); a mesh alone needs `--fablet FILE.fl`, or a "
            "stock fablet: "
            "{}",
            input, stock_fablet_names()));
    }
    Result<world::World> world = world::load_world(
        input, {{options.allow.begin(), options.allow.end()}, options.memory_bytes});
    if (!world) return world.error();
    Result<std::vector<std::filesystem::path>> files = world::fablet_sources(*world, input);
    if (!files) return files.error();
    sources.files = std::move(*files);
    return sources;
}

/// Lists the sources and all modules beside them.
std::vector<std::filesystem::path> with_modules(const std::vector<std::filesystem::path>& sources) {
    std::vector<std::filesystem::path> files = sources;
    for (const std::filesystem::path& source : sources) {
        std::error_code status;
        std::filesystem::path folder = source.parent_path();
        if (folder.empty()) folder = ".";
        for (std::filesystem::directory_iterator entry(folder, status), end;
             !status && entry != end; entry.increment(status)) {
            if (entry->path().extension() == ".fl") files.push_back(entry->path());
        }
    }
    return files;
}

/// Replaces this process by the print binary; returns only on failure.
Error exec_print_binary(const PrintBinary& program, const std::vector<std::string>& arguments) {
    const std::string name = program.path.empty() ? "openfab print" : program.path.string();
    std::vector<char*> argv{const_cast<char*>(name.c_str())};
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    // Print programs start this program for textures that are not in the cache yet.
    if (Result<std::filesystem::path> folder = program_folder(); folder) {
        ::setenv("OPENFAB_HELPER", (*folder / "openfab").c_str(), 0);
    }
    if (program.path.empty()) {
        ::fexecve(program.file.descriptor(), argv.data(), environ);
    } else {
        ::execv(program.path.c_str(), argv.data());
    }
    return outside_error(fmt::format("cannot start `{}`: {}", name, std::strerror(errno)));
}

Result<void> print_world(std::vector<std::string> arguments) {
    Result<std::string> fablet = take_fablet(&arguments);
    if (!fablet) return fablet.error();
    std::vector<const char*> argv{"openfab print"};
    for (const std::string& argument : arguments)
        argv.push_back(argument.c_str());
    Result<program::Options> options =
        program::parse_options(static_cast<int>(argv.size()), argv.data(), "openfab print");
    if (!options) return options.error();
    if (options->help) {
        show(fmt::format("{}\n--fablet FILE.fl names the fablet for a mesh; or one of {}.\n",
                         options->text, stock_fablet_names()));
        return {};
    }
    Result<Sources> sources = sources_of(*options, *fablet);
    if (!sources) return sources.error();
    // The print binary checks again, with all that the world names, but does not know these files.
    if (Result<void> apart = program::check_outputs(program::outputs_of(*options, "", {}),
                                                    with_modules(sources->files));
        !apart)
        return apart.error();
    // It runs here: the other sets are for programs that somebody builds to take elsewhere.
    const Result<PrintBinary> program = find_or_build_print_binary(
        sources->files, abi::best_isa(options->isa.value_or(program::kUsualIsa)),
        options->progress == program::ProgressMode::kNone);
    if (!program) return program.error();
    sources->folder.reset();  // exec runs no destructors
    return exec_print_binary(*program, arguments);
}

/// Replaces this process by a program beside it; returns an exit code where that fails.
int start_helper(const char* name, char** argv) {
    Result<std::filesystem::path> folder = program_folder();
    Error failed = folder ? Error{} : folder.error();
    if (folder) {
        const std::filesystem::path helper = *folder / name;
        ::setenv("OPENFAB_HELPER", (*folder / "openfab").c_str(), 0);
        ::execv(helper.c_str(), argv);
        failed = outside_error(
            fmt::format("cannot start `{}`: {}", helper.string(), std::strerror(errno)));
    }
    return say_error(failed);
}

}  // namespace

int texture_command(char** argv) {
    return start_helper("openfab-texture", argv + 1);
}

int text_command(char** argv) {
    return start_helper("openfab-text", argv + 1);
}

int tuner_command(char** argv) {
    return start_helper("openfab-tuner", argv);
}

int print_command(int argc, char** argv) {
    Result<void> done = print_world({argv + 2, argv + argc});
    if (done) done = written_out();
    if (done) return 0;
    // Compile errors have been printed by the compiler.
    return done.error().message.empty() ? exit_code(done.error().code) : say_error(done.error());
}

}  // namespace openfab::tools
