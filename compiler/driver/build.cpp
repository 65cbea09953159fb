// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "compiler/driver/back_end.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/frontend.h"
#include "compiler/lower/program.h"
#include "compiler/passes/pipeline.h"

namespace openfab::driver {

namespace {

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;

struct BuildOptions {
    std::vector<std::string> files;
    std::string output;
    std::string target = "both";
    std::string compiler = "cc";
    std::string linker = "c++";
    int threads = 0;
    bool time = false;
    BackEndOptions back_end;
};

int fail(const std::string& what, int code) {
    fmt::print(stderr, "openflc: error: {}\n", what);
    return code;
}

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// One source file on its way. Units point into it, so it does not move.
struct SourceUnit {
    ir::Module module;
    std::vector<passes::PipelineResult> results;
};

/// Link line of a print program, made by the build beside the runtime's archives: one argument a
/// line, `lib:NAME` for a file of the same folder.
std::optional<std::vector<std::string>> read_link_line(std::string* fault) {
    std::error_code error;
    const fs::path self = fs::read_symlink("/proc/self/exe", error);
    const fs::path folder = self.parent_path().parent_path() / "lib";
    std::ifstream file(folder / "openfab_print.link");
    if (error || !file) {
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

class Build {
  public:
    Build(const BuildOptions& options, const CommonOptions& common)
        : options_(options), common_(common) {}

    int run() {
        if (const int code = front(); code != kExitDone) return code;
        if (const int code = schedule(); code != kExitDone) return code;
        if (const int code = middle(); code != kExitDone) return code;
        return back();
    }

  private:
    void spent(const char* phase, double seconds) const {
        if (options_.time) fmt::print(stderr, "{:>8.3f} s  {}\n", seconds, phase);
    }

    int front() {
        const Clock::time_point begin = Clock::now();
        diag::Sink sink;
        bool complete = true;
        for (const std::string& path : options_.files) {
            std::string fault;
            std::optional<ir::Module> module = compile_to_ir(sources_, path, sink, &fault);
            if (!fault.empty()) return fail(fault, kExitOutside);
            complete = complete && module.has_value();
            if (module) units_.push_back({std::move(*module), {}});
        }
        print_diagnostics(sink, sources_, common_);
        if (!complete) return kExitUserInput;
        spent("front end", seconds_since(begin));
        return kExitDone;
    }

    int schedule() {
        if (options_.back_end.schedule.empty()) return kExitDone;
        return load_schedule(options_.back_end.schedule, &sources_, common_, &schedule_);
    }

    int middle() {
        const Clock::time_point begin = Clock::now();
        for (size_t k = 0; k < units_.size(); ++k) {
            SourceUnit& unit = units_[k];
            const fs::path path = options_.files[k];
            unit.results.reserve(unit.module.fablets.size());
            for (const ir::Fablet& fablet : unit.module.fablets) {
                unit.results.push_back(run_passes(fablet, options_.back_end));
                const passes::PipelineResult& result = unit.results.back();
                if (!result.fault.empty()) return fail("internal: " + result.fault, kExitBug);
                fablets_.push_back({&fablet, &result.stages, path.filename().string(), 0});
            }
        }
        if (fablets_.empty()) return fail("the files hold no fablet", kExitUserInput);
        for (lower::FabletUnit& fablet : fablets_)
            fablet.hash = hash_of(fablet);
        spent("passes", seconds_since(begin));
        return kExitDone;
    }

    /// Of everything that the fablet's kernels are made from.
    uint64_t hash_of(const lower::FabletUnit& fablet) const {
        std::string text = fmt::format("abi {} target {}\n", OPENFAB_ABI_VERSION, options_.target);
        text += ir::print(*fablet.fablet);
        for (const ir::Stage* stage : {&fablet.stages->surface, &fablet.stages->surface_bounds,
                                       &fablet.stages->volume, &fablet.stages->volume_bounds}) {
            text += ir::print(*stage);
        }
        text += schedule_.schedule.text;
        return XXH3_64bits(text.data(), text.size());
    }

    int back() {
        lower::ProgramOptions program;
        program.threads = options_.threads;
        program.compiler = options_.compiler;
        if (options_.target == "sse41") program.isas = {OPENFAB_ISA_SSE41};
        if (options_.target == "avx2") program.isas = {OPENFAB_ISA_AVX2};
        if (!schedule_.kernel.empty()) {
            program.schedule = &schedule_.schedule;
            program.schedule_kernel = schedule_.kernel;
        }
        std::string fault;
        const std::optional<std::vector<std::string>> link_line = read_link_line(&fault);
        if (!link_line) return fail(fault, kExitOutside);
        const lower::ScratchFolder folder;
        if (folder.path().empty()) return fail("no temporary folder can be made", kExitOutside);
        auto compiled = lower::compile_program(fablets_, program, folder.path());
        if (auto* trouble = std::get_if<lower::Fault>(&compiled)) {
            return report_fault(*trouble, schedule_, sources_, common_);
        }
        const auto& objects = std::get<lower::ProgramObjects>(compiled);
        spent("kernels", objects.times.kernels);
        spent("table", objects.times.table);
        return link(objects, *link_line);
    }

    int link(const lower::ProgramObjects& objects, const std::vector<std::string>& link_line) {
        const Clock::time_point begin = Clock::now();
        // Linked beside its place and moved there, so that a failure leaves no half of a program.
        const std::string unfinished = fmt::format("{}.{}.tmp", options_.output, getpid());
        std::vector<std::string> command = {options_.linker, "-o", unfinished};
        for (const fs::path& object : objects.objects)
            command.push_back(object.string());
        command.insert(command.end(), link_line.begin(), link_line.end());
        command.insert(command.end(), {"-Wl,--gc-sections", "-Wl,--strip-debug"});
        const std::string trouble = lower::run_tool(command);
        std::error_code error;
        if (trouble.empty()) fs::rename(unfinished, options_.output, error);
        if (!trouble.empty() || error) {
            std::error_code ignored;
            fs::remove(unfinished, ignored);
            return fail(fmt::format("{}: cannot be linked: {}", options_.output,
                                    trouble.empty() ? error.message() : trouble),
                        kExitOutside);
        }
        spent("link", seconds_since(begin));
        return kExitDone;
    }

    const BuildOptions& options_;
    const CommonOptions& common_;
    source::SourceManager sources_;
    std::deque<SourceUnit> units_;
    std::vector<lower::FabletUnit> fablets_;
    UserSchedule schedule_;
};

}  // namespace

void add_build(CLI::App& app, const CommonOptions& common, Action* action) {
    CLI::App* command =
        app.add_subcommand("build", "Compile fablets to a self-contained print program");
    auto options = std::make_shared<BuildOptions>();
    command->add_option("FILE.fl", options->files, "OpenFL files")->required();
    command->add_option("-o,--output", options->output, "the program to write")->required();
    command->add_option("--target", options->target, "instruction sets; both give the same bits")
        ->check(CLI::IsMember({"sse41", "avx2", "both"}))
        ->capture_default_str();
    command->add_option("--threads", options->threads, "kernels compiled at once; 0: all cores")
        ->check(CLI::Range(0, 1024));
    command->add_option("--cc", options->compiler, "C compiler")->capture_default_str();
    command->add_option("--linker", options->linker, "C++ compiler driver that links")
        ->capture_default_str();
    command->add_flag("--time", options->time, "print the seconds of each phase");
    add_back_end_options(command, &options->back_end);
    command->callback([options, &common, action] {
        *action = [options, &common] { return Build(*options, common).run(); };
    });
}

}  // namespace openfab::driver
