// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/tuner/workload.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "abi/kernel_call.h"
#include "backends/formats/formats.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "program/output_check.h"
#include "program/outputs.h"
#include "program/prepare.h"
#include "tools/tuner/messages.h"
#include "world/fablet_sources.h"
#include "world/world.h"

namespace openfab::tuner {

Result<program::Options> parse_print(const std::vector<std::string>& words,
                                     const std::string& program,
                                     std::vector<program::NamedOutput> outputs) {
    const auto refuse = [&](const std::string& option) {
        return usage_error(fmt::format(messages::kKeepsNoSlices, program, option));
    };
    std::vector<const char*> argv{program.c_str()};
    for (const std::string& word : words) {
        // Else it would ask for an output.
        if (word == "--resume") return refuse(word);
        argv.push_back(word.c_str());
    }
    Result<program::Options> options =
        program::parse_options(static_cast<int>(argv.size()), argv.data(), program, false);
    if (!options || options->help) return options;
    const std::pair<const char*, bool> refused[] = {
        {"-o", !options->output.empty()},
        {"--token-file", !options->token_file.empty()},
        {"--tls-ca", !options->tls_ca.empty()},
        {"--preview", !options->previews.empty()},
        {"--fractions", !options->fractions_file.empty()},
        {"--probe", options->probe_mm.has_value()},
        {"--stats", !options->stats_file.empty()},
        {"--estimate", options->estimate},
        {"--dry-run", options->dry_run},
    };
    for (const auto& [option, given] : refused) {
        if (given) return refuse(option);
    }
    if (!options->input.ends_with(".json")) {
        return usage_error(fmt::format(messages::kNotAWorld, options->input));
    }
    if (options->format.empty()) options->format = "ofr";
    options->more_outputs = std::move(outputs);
    return options;
}

Result<std::unique_ptr<Workload>> Workload::create(const program::Options& print,
                                                   const driver::ScheduleOptions& schedules) {
    std::unique_ptr<Workload> out(new Workload);
    out->print_ = print;
    out->print_.isa = abi::best_isa(print.isa.value_or(program::kUsualIsa));
    // Without a folder that can be trusted kernels are kept in memory alone.
    const Result<std::filesystem::path> kept = lower::KernelCache::own_folder();
    out->cache_ = std::make_unique<lower::KernelCache>(kept ? *kept : std::filesystem::path());
    Result<void> keeps = kept ? check_writable(*kept) : kept.error();
    if (kept && !keeps)
        keeps = with_context(keeps.error(), fmt::format(messages::kInFolder, kept->string()));
    if (!keeps && print.progress != program::ProgressMode::kNone)
        note(fmt::format(messages::kKernelNotKept, keeps.error().text()));
    const Result<world::World> world = world::load_world(
        print.input, world::rules_of(print.allow, print.memory_bytes), world::MeshFiles::kSkip);
    if (!world) return world.error();
    const auto sources = world::fablet_sources(*world, print.input);
    if (!sources) return sources.error();
    for (const std::filesystem::path& source : *sources)
        out->options_.files.push_back(source.string());
    if (world->dither) out->options_.dither = {world->dither->source.string(), world->dither->rule};
    out->options_.target = abi::isa_name(out->isa());
    out->options_.back_end.schedules = schedules;
    out->compilation_ = std::make_unique<driver::Compilation>(out->options_, out->common_);
    const int code = out->compilation_->prepare();
    if (code == driver::kExitDone) {
        std::vector<std::filesystem::path> inputs = world->files;
        for (const std::filesystem::path& file : out->compilation_->sources().files()) {
            inputs.push_back(file);
            out->print_.inputs.push_back(file.string());
        }
        const Result<void> apart = program::check_outputs(
            out->print_, backends::find_format(out->print_.format), {}, inputs);
        if (!apart) return apart.error();
        return out;
    }
    Error said{ErrorCode::kInternal, "", "", {}};
    for (const ErrorCode known : {ErrorCode::kUserInput, ErrorCode::kUsage, ErrorCode::kOutside}) {
        if (exit_code(known) == code) said.code = known;
    }
    return said;
}

std::unique_ptr<Workload::Derivatives> Workload::compile_derivatives(
    const std::vector<std::string>& names) const {
    driver::CompilationOptions options = options_;
    options.derivatives = names;
    driver::Compilation compilation(options, common_);
    const driver::Compilation::Outcome outcome = compilation.run();
    const std::vector<diag::Diagnostic> said = outcome.sink.sorted();
    const bool jumps = std::ranges::any_of(
        said, [](const diag::Diagnostic& one) { return one.id == diag::kJump.id; });
    if (outcome.code != driver::kExitDone || jumps) return nullptr;
    auto loaded =
        lower::load_program(compilation.fablets(), compilation.program_options(cache_.get()));
    if (std::holds_alternative<lower::Fault>(loaded)) return nullptr;
    auto out = std::make_unique<Derivatives>();
    out->program = std::move(std::get<std::unique_ptr<lower::LoadedProgram>>(loaded));
    for (const lower::FabletUnit& unit : compilation.fablets())
        out->directions.push_back(unit.directions);
    return out;
}

Error Workload::report(const lower::Fault& fault) const {
    const int code = compilation_->report(fault);
    return Error{
        code == driver::kExitUserInput ? ErrorCode::kUserInput : ErrorCode::kInternal, "", "", {}};
}

Result<std::unique_ptr<pipeline::PrintJob>> Workload::set_up(const openfab_fablet_list& fablets,
                                                             const std::atomic<bool>& interrupt) {
    Result<program::PreparedPrint> ready =
        program::prepare_print(print_, fablets, {.interrupt = interrupt});
    if (!ready) return ready.error();
    printer_ = ready->job.printer;
    return std::move(ready->print);
}

Result<std::unique_ptr<pipeline::SliceSink>> Workload::open_sink(
    const std::filesystem::path& folder) const {
    program::Options options = print_;
    options.output = program::output_in(folder, *backends::find_format(print_.format));
    return program::open_output(options, printer_);
}

void use_slab_kernels(const openfab_fablet_list& from, const openfab_fablet_list& to,
                      openfab_isa isa) {
    for (int32_t k = 0; k < to.count; ++k) {
        // The tables of a loaded program are its own memory; only the view of them is constant.
        auto& kernel = const_cast<openfab_kernel&>(to.fablets[k]->slab);
        const openfab_kernel& other = from.fablets[k]->slab;
        kernel.fn[isa] = other.fn[isa];
        kernel.arg_count = other.arg_count;
        kernel.args = other.args;
    }
}

std::vector<int32_t> spread_slabs(const Vec2<int32_t>& range, int32_t count, int32_t run,
                                  double shift) {
    const int32_t all = range.y - range.x;
    std::set<int32_t> chosen;
    if (count >= all) {
        for (int32_t slab = range.x; slab < range.y; ++slab)
            chosen.insert(slab);
    } else {
        const int32_t runs = std::max(1, count / run);
        for (int32_t k = 0; k < runs; ++k) {
            const double distance = static_cast<double>(all) / runs;
            const auto first = static_cast<int32_t>(std::floor((k + shift) * distance));
            for (int32_t n = 0; n < std::min(run, count); ++n)
                chosen.insert(range.x + std::min(first + n, all - 1));
        }
    }
    return {chosen.begin(), chosen.end()};
}

}  // namespace openfab::tuner
