// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openflc run`: compiles fablets in memory and prints in this process; with --watch, again
// whenever one of the print's inputs changes.

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "abi/kernel_call.h"
#include "base/clean_exit.h"
#include "base/clock.h"
#include "base/say.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/compilation.h"
#include "compiler/lower/code/jit.h"
#include "compiler/lower/code/kernel_cache.h"
#include "program/interrupt.h"
#include "program/job.h"
#include "program/options.h"
#include "program/print_main.h"

namespace openfab::driver {

namespace {

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;

constexpr auto kPollInterval = std::chrono::milliseconds(100);

/// A snapshot of files: when each was last written.
class Snapshot {
  public:
    /// Adds files, but for those that it has.
    void add(const std::vector<fs::path>& files) {
        for (const fs::path& file : files)
            times_.emplace(file, time_of(file));
    }
    bool changed() const {
        for (const auto& [file, time] : times_) {
            if (time_of(file) != time) return true;
        }
        return false;
    }

  private:
    // A file that is missing for a moment, while an editor replaces it, counts as unchanged until
    // it reappears.
    static fs::file_time_type time_of(const fs::path& file) {
        std::error_code gone;
        const fs::file_time_type time = fs::last_write_time(file, gone);
        return gone ? fs::file_time_type::min() : time;
    }

    std::map<fs::path, fs::file_time_type> times_;
};

class Run {
  public:
    Run(const RunOptions& options, const CommonOptions& common, const program::Options& print)
        : options_(options),
          common_(common),
          print_(print),
          stop_(options.watch
                    ? program::install_interrupt(kExitDone, "")
                    : program::install_interrupt(exit_code(ErrorCode::kInterrupted),
                                                 "error: interrupted before the first slice\n")) {
        print_.isa = abi::best_isa(print_.isa.value_or(program::kUsualIsa));
        compile_.emplace(options_.compilation);
        compile_->target = abi::isa_name(*print_.isa);
        const Result<fs::path> kept = lower::KernelCache::own_folder();
        cache_.emplace(kept ? *kept : fs::path());
        if (!kept && print_.progress != program::ProgressMode::kNone)
            note(fmt::format("no kernel is kept for the next run: {}", kept.error().text()));
    }

    int once() {
        if (const int code = compile(); code != kExitDone) return code;
        spare_sources();
        const int code = program::finish(program::run_print(print_, program_->fablets(), stop_),
                                         print_.progress);
        // Who ends a print does not wait for a kernel that it can do without.
        if (code == exit_code(ErrorCode::kInterrupted)) end_cleanly(code);
        const int compiled = finish(program_.get());
        return code != kExitDone ? code : compiled;
    }

    /// Runs until Ctrl-C. Errors in a fablet or the world do not end it.
    int watch() {
        std::vector<fs::path> sources(options_.compilation.files.begin(),
                                      options_.compilation.files.end());
        std::vector<fs::path> read_files;  // of the world; some are named by others of them
        bool fablet_changed = true;
        double began = 0;  // of the process; later when a change was seen
        while (!stop_) {
            // Before they are read, so that a change from now on counts.
            Snapshot of_world, of_sources;
            of_world.add(program::named_files(print_));
            of_world.add(read_files);
            of_sources.add(sources);
            if (fablet_changed) {
                retire();
                compile();
            }
            if (!sources_.empty()) sources = sources_;
            of_sources.add(sources);
            const auto changed = [&] { return of_world.changed() || of_sources.changed(); };
            std::vector<fs::path> files;
            if (program_ != nullptr) files = print_until(changed, began);
            if (!files.empty()) read_files = std::move(files);
            of_world.add(read_files);
            if (!stop_) say("watching; Ctrl-C ends\n");
            while (!stop_ && !changed())
                std::this_thread::sleep_for(kPollInterval);
            began = process_age_seconds();
            // A world may name another dither rule.
            const std::optional<frontend::DitherRule> before = compile_->dither;
            const bool other_rule = of_world.changed() && take_rule() && compile_->dither != before;
            fablet_changed = program_ == nullptr || of_sources.changed() || other_rule;
        }
        return kExitDone;
    }

  private:
    /// Takes the world's dither rule, if it names one, unless an option does.
    Result<void> take_rule() {
        if (options_.compilation.dither) return {};
        const auto rule = program::load_rule(print_);
        if (!rule) return rule.error();
        compile_->dither.reset();
        if (*rule) compile_->dither = {(*rule)->source.string(), (*rule)->rule};
        return {};
    }

    int compile() {
        const Clock::time_point begin = Clock::now();
        if (const Result<void> taken = take_rule(); !taken)
            return program::finish(taken, print_.progress);
        Compilation compilation(*compile_, common_);
        const int code = compilation.prepare();
        sources_ = compilation.sources().files();
        if (code != kExitDone) return code;
        lower::ProgramOptions program = compilation.program_options(&*cache_);
        // An estimate asks how quick the print will be; a `printf` shows which voxels are evaluated.
        if (print_.progress == program::ProgressMode::kNone) program.foretell = nullptr;
        program.bounds_later = !print_.estimate && !print_.dry_run && !compile_->enable_printf;
        auto loaded = lower::load_program(compilation.fablets(), program);
        if (auto* fault = std::get_if<lower::Fault>(&loaded)) return compilation.report(*fault);
        program_ = std::move(std::get<std::unique_ptr<lower::LoadedProgram>>(loaded));
        compilation.report_kernels(program_->times());
        const std::chrono::duration<double> seconds = Clock::now() - begin;
        compilation.report_time("source to kernels", seconds.count());
        return kExitDone;
    }

    /// Waits for what a program still compiles and says how it went. Returns an exit code.
    int finish(lower::LoadedProgram* program) const {
        const auto finished = program->later().finish();
        if (const auto* fault = std::get_if<lower::Fault>(&finished))
            return fail(fault->trouble, fault->is_outside ? kExitOutside : kExitBug);
        const auto& times = std::get<std::vector<lower::KernelTime>>(finished);
        if (options_.compilation.time && !times.empty()) say(kernel_report(times));
        return kExitDone;
    }

    /// Puts the program aside until it has compiled what it began: the next one does not wait.
    void retire() {
        if (program_ != nullptr) {
            program_->later().give_up();
            retired_.push_back(std::move(program_));
        }
        std::erase_if(retired_, [&](const std::unique_ptr<lower::LoadedProgram>& program) {
            return program->later().done() && (finish(program.get()), true);
        });
    }

    /// No output may overwrite an input of the compilation.
    void spare_sources() {
        print_.inputs.clear();
        for (const fs::path& source : sources_)
            print_.inputs.push_back(source.string());
    }

    /// Prints, and stops early if an input changes meanwhile. Returns the files of the world that were read.
    template <typename Changed>
    std::vector<fs::path> print_until(const Changed& changed, double began) {
        std::atomic<bool> interrupt{false};
        std::atomic<bool> over{false};
        std::thread guard([&] {
            while (!over && !interrupt) {
                if (stop_ || changed()) interrupt = true;
                std::this_thread::sleep_for(kPollInterval);
            }
        });
        std::vector<fs::path> files;
        spare_sources();
        const Result<void> done =
            program::run_print(print_, program_->fablets(), interrupt, &files, began);
        over = true;
        guard.join();
        if (done || done.error().code != ErrorCode::kInterrupted)
            program::finish(done, print_.progress);
        return files;
    }

    const RunOptions& options_;
    const CommonOptions& common_;
    program::Options print_;
    const std::atomic<bool>& stop_;
    std::optional<CompilationOptions> compile_;
    std::optional<lower::KernelCache> cache_;
    std::vector<fs::path> sources_;
    std::unique_ptr<lower::LoadedProgram> program_;
    std::vector<std::unique_ptr<lower::LoadedProgram>> retired_;
};

}  // namespace

int run(RunOptions options, const CommonOptions& common, const std::vector<std::string>& words) {
    std::vector<const char*> rest = {"openflc run"};
    for (const std::string& word : words) {
        if (word.ends_with(".fl")) {
            options.compilation.files.push_back(word);
        } else {
            rest.push_back(word.c_str());
        }
    }
    if (options.compilation.files.empty()) {
        return fail("no fablet given; write `openflc run FILE.fl WORLD.fab.json -o OUT`",
                    kExitUsage);
    }
    const Result<program::Options> print =
        program::parse_options(static_cast<int>(rest.size()), rest.data(), "openflc run FILE.fl");
    if (!print) return program::finish(print.error());
    program::keep_print_lines(options.print_lines);
    Run program(options, common, *print);
    return options.watch ? program.watch() : program.once();
}

}  // namespace openfab::driver
