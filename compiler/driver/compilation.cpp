// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/compilation.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "abi/kernel_call.h"
#include "base/hash.h"
#include "base/say.h"
#include "compiler/driver/derivatives.h"
#include "compiler/frontend/frontend.h"

namespace openfab::driver {

namespace fs = std::filesystem;

using Clock = std::chrono::steady_clock;

namespace {

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::string time_line(const std::string& step, double seconds) {
    return fmt::format("{:>8.3f} s  {}\n", seconds, step);
}

}  // namespace

Compilation::Outcome Compilation::run() {
    Outcome out;
    run_front_end(&out);
    if (out.code == kExitDone) take_derivatives(&out);
    if (out.code == kExitDone) out.code = schedules_.load(options_.back_end.schedules, isas());
    if (out.code == kExitDone) run_all_passes(&out);
    return out;
}

int Compilation::prepare() {
    const Outcome out = run();
    print_diagnostics(out.sink, sources_, common_);
    return out.fault.empty() ? out.code : fail(out.fault, out.code);
}

void Compilation::report_time(const std::string& step, double seconds) const {
    if (options_.time) say(time_line(step, seconds));
}

void Compilation::report_kernels(const std::vector<lower::KernelTime>& kernels) const {
    if (options_.time) say(kernel_report(kernels));
}

std::string kernel_report(const std::vector<lower::KernelTime>& kernels) {
    std::string text;
    size_t compiled = 0;
    for (const lower::KernelTime& kernel : kernels) {
        if (!kernel.compiled) continue;
        text += time_line("kernel " + kernel.kernel, kernel.seconds);
        ++compiled;
    }
    return text + fmt::format("{} kernels compiled, {} from the cache\n", compiled,
                              kernels.size() - compiled);
}

void Compilation::run_front_end(Outcome* out) {
    const Clock::time_point begin = Clock::now();
    for (const std::string& path : options_.files) {
        std::optional<ir::Module> module =
            frontend::compile_to_ir(sources_, path, out->sink, &out->fault,
                                    {.enable_printf = options_.enable_printf,
                                     .dither = options_.dither ? &*options_.dither : nullptr});
        if (!out->fault.empty()) {
            out->code = unread_exit_code(path);
            return;
        }
        if (!module) out->code = kExitUserInput;
        if (module) units_.push_back({std::move(*module), {}});
    }
    if (out->code == kExitDone) refuse_equal_names(out);
    if (out->code == kExitDone) report_time("front end", seconds_since(begin));
}

/// Puts derivatives beside the amounts of the fablets that declare such uniforms.
void Compilation::take_derivatives(Outcome* out) {
    for (SourceUnit& unit : units_) {
        for (ir::Fablet& fablet : unit.module.fablets) {
            unit.directions.emplace_back();
            if (options_.derivatives.empty()) continue;
            if (!differentiate(options_.derivatives, &fablet, &unit.directions.back(), &out->sink))
                out->code = kExitUserInput;
        }
    }
}

/// A world tells fablets of one name apart by the file names of their sources.
void Compilation::refuse_equal_names(Outcome* out) {
    std::map<std::pair<std::string, std::string>, std::pair<size_t, const ir::Fablet*>> known;
    for (size_t k = 0; k < units_.size(); ++k) {
        const std::string file = fs::path(options_.files[k]).filename().string();
        for (const ir::Fablet& fablet : units_[k].module.fablets) {
            const auto [first, is_new] =
                known.emplace(std::pair(file, fablet.name), std::pair(k, &fablet));
            const auto& [of_file, other] = first->second;
            std::error_code unknown;
            if (is_new || fs::equivalent(options_.files[of_file], options_.files[k], unknown))
                continue;
            out->sink.report(fablet.span, diag::kRedeclared, fablet.name)
                .note(other->span, "here, in a file of the same name")
                .help("rename one of the two, or its file");
            out->code = kExitUserInput;
        }
    }
}

namespace {

/// Hashes the meaning of the fablet, which targets, schedules and passes do not change: prints with
/// equal hashes have the same bits, so one may resume the other.
uint64_t hash_of(const ir::Fablet& fablet) {
    const std::string text = fmt::format("abi {}\n", OPENFAB_ABI_VERSION) + ir::dump(fablet);
    return xxh3(text);
}

}  // namespace

void Compilation::run_all_passes(Outcome* out) {
    const Clock::time_point begin = Clock::now();
    for (size_t k = 0; k < units_.size(); ++k) {
        SourceUnit& unit = units_[k];
        const fs::path path = options_.files[k];
        unit.results.reserve(unit.module.fablets.size());
        for (size_t n = 0; n < unit.module.fablets.size(); ++n) {
            const ir::Fablet& fablet = unit.module.fablets[n];
            const std::vector<int32_t>& directions = unit.directions[n];
            unit.results.push_back(run_passes(fablet, options_.back_end, !directions.empty()));
            const passes::PipelineResult& result = unit.results.back();
            if (!result.fault.empty()) {
                out->code = kExitBug;
                out->fault = result.fault;
                return;
            }
            if (refuse_long_stages(fablet, result, &out->sink)) {
                out->code = kExitUserInput;
                return;
            }
            fablets_.push_back({&fablet, &result.stages, path.filename().string(), 0, directions});
        }
    }
    if (fablets_.empty()) {
        out->code = kExitUserInput;
        out->fault = "the files contain no fablet";
        return;
    }
    for (lower::FabletUnit& fablet : fablets_)
        fablet.hash = hash_of(*fablet.fablet);
    report_time("passes", seconds_since(begin));
}

std::vector<openfab_isa> Compilation::isas() const {
    std::vector<openfab_isa> out(abi::isas().begin(), abi::isas().end());
    if (options_.target == "both") std::erase(out, OPENFAB_ISA_AVX512);
    for (const openfab_isa isa : abi::isas()) {
        if (options_.target == abi::isa_name(isa)) return {isa};
    }
    return out;
}

lower::ProgramOptions Compilation::program_options(lower::KernelCache* cache) const {
    lower::ProgramOptions program;
    program.cache = cache;
    program.threads = options_.threads;
    program.isas = isas();
    program.schedules = schedules_.bound();
    program.foretell = [](const std::string& text) { note(text); };
    return program;
}

}  // namespace openfab::driver
