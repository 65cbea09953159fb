// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "base/own_folder.h"
#include "base/replace_file.h"
#include "base/start_program.h"
#include "compiler/driver/compilation.h"

namespace openfab::driver {

namespace {

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The link line of a print program, which the build writes beside the runtime's archives: one
/// argument a line, `lib:NAME` for a file in the same folder.
std::optional<std::vector<std::string>> read_link_line(std::string* fault) {
    const Result<fs::path> programs = program_folder();
    const fs::path folder = programs ? programs->parent_path() / "lib" : fs::path();
    std::ifstream file(folder / "openfab_print.link");
    if (!file) {
        *fault = fmt::format("{}: the runtime that print programs are linked with is missing",
                             (folder / "openfab_print.link").string());
        return std::nullopt;
    }
    std::vector<std::string> out;
    for (std::string line; std::getline(file, line);) {
        if (line.empty() || line[0] == '#') continue;
        constexpr std::string_view kLocal = "lib:";
        out.push_back(line.starts_with(kLocal) ? (folder / line.substr(kLocal.size())).string()
                                               : line);
    }
    return out;
}

/// The option by which a compiler driver links with a quicker linker than its usual one, which is most of a small
/// fablet's build and takes twice the time of gold; empty where none is on the PATH.
std::string quick_linker() {
    const char* const path = std::getenv("PATH");
    std::istringstream folders(path != nullptr ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        if (!folder.starts_with('/')) continue;
        for (const std::string name : {"mold", "gold"}) {
            if (access(fmt::format("{}/ld.{}", folder, name).c_str(), X_OK) == 0)
                return "-fuse-ld=" + name;
        }
    }
    return "";
}

class Build {
  public:
    Build(const BuildOptions& options, const CommonOptions& common)
        : options_(options), compilation_(options.compilation, common) {}

    int run() {
        if (const int code = compilation_.prepare(); code != kExitDone) return code;
        for (const fs::path& source : compilation_.sources().files()) {
            std::error_code none;
            if (fs::equivalent(source, options_.output, none)) {
                return fail(fmt::format("`-o {}` would overwrite the source `{}`; name another "
                                        "output",
                                        options_.output, source.string()),
                            kExitUserInput);
            }
        }
        if (const Result<void> output = check_replaceable(options_.output); !output)
            return fail(output.error().text(), kExitUserInput);
        // Without a folder that can be trusted every kernel is compiled.
        const Result<fs::path> kept = lower::KernelCache::own_folder();
        lower::KernelCache cache(kept ? *kept : fs::path());
        lower::ProgramOptions program = compilation_.program_options(&cache);
        program.compiler = options_.compiler;
        std::string fault;
        const std::optional<std::vector<std::string>> link_line = read_link_line(&fault);
        if (!link_line) return fail(fault, kExitOutside);
        const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
        if (!folder) return fail(folder.error().text(), kExitOutside);
        auto compiled = lower::compile_program(compilation_.fablets(), program, (*folder)->path());
        if (auto* trouble = std::get_if<lower::Fault>(&compiled))
            return compilation_.report(*trouble);
        const auto& objects = std::get<lower::ProgramObjects>(compiled);
        compilation_.report_kernels(objects.times.each);
        compilation_.report_time("kernels", objects.times.kernels);
        compilation_.report_time("table", objects.times.table);
        return link(objects, *link_line);
    }

  private:
    int link(const lower::ProgramObjects& objects, const std::vector<std::string>& link_line) {
        const Clock::time_point begin = Clock::now();
        // Linked to a temporary file and renamed, so that a failure leaves no partial program.
        // Absolute, since linkers interpret names that begin with `-` or `@`.
        std::error_code error;
        const fs::path output = fs::absolute(options_.output, error);
        const auto not_linked = [&](const std::string& why) {
            const std::string remedy = lower::remedy_of(why, output.parent_path());
            return fail(fmt::format("{}: cannot be linked: {}", options_.output,
                                    remedy.empty() ? why : remedy),
                        kExitOutside);
        };
        const Result<std::unique_ptr<TemporaryFolder>> beside =
            TemporaryFolder::create(output.parent_path());
        if (!beside) return not_linked(beside.error().text());
        const std::string unfinished = ((*beside)->path() / "program").string();
        const bool usual = options_.linker.empty();
        std::vector<std::string> command = {usual ? "c++" : options_.linker, "-o", unfinished};
        for (const fs::path& object : objects.objects)
            command.push_back(object.string());
        command.insert(command.end(), link_line.begin(), link_line.end());
        command.insert(command.end(), {"-Wl,--gc-sections", "-Wl,--strip-debug"});
        std::string trouble = "none";
        if (const std::string quick = quick_linker(); usual && !quick.empty()) {
            command.push_back(quick);
            trouble = lower::run_tool(command, (*beside)->path());
            command.pop_back();
        }
        // What the quick one refuses the usual one may take.
        if (!trouble.empty()) trouble = lower::run_tool(command, (*beside)->path());
        if (!trouble.empty()) return not_linked(trouble);
        fs::rename(unfinished, options_.output, error);
        if (error) return not_linked(error.message());
        compilation_.report_time("link", seconds_since(begin));
        return kExitDone;
    }

    const BuildOptions& options_;
    Compilation compilation_;
};

}  // namespace

int build(const BuildOptions& options, const CommonOptions& common) {
    return Build(options, common).run();
}

}  // namespace openfab::driver
