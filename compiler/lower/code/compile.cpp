// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/compile.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>
#include <system_error>

#include "abi/kernel_call.h"
#include "base/own_folder.h"
#include "compiler/lower/algorithm/kernel.h"
#include "compiler/lower/algorithm/sample_parts.h"
#include "compiler/lower/code/base_target.h"
#include "compiler/lower/schedule/apply_schedule.h"
#include "compiler/lower/schedule/hoist_storage.h"
#include "compiler/lower/schedule/kernel_memory.h"
#include "compiler/lower/schedule/print_loops.h"
#include "texture/cache.h"

namespace openfab::lower {

namespace {

using Halide::Target;

/// Code checks the shapes of its buffers under a user's schedule. The built-in ones read and write
/// exactly what compiler/lower/algorithm/kernel.h says, and the checks are half of the compile time.
Target target_of(const KernelRequest& request) {
    const bool checked = request.schedule != nullptr;
    // strict_float is what makes all targets, widths and schedules give the same bits. FMA stays
    // off.
    Target target = base_target({Target::StrictFloat, Target::NoRuntime, Target::NoBoundsQuery});
    target.set_feature(Target::NoAsserts, !checked);
    target.set_feature(Target::Profile, request.profiled);
    if (request.isa >= OPENFAB_ISA_AVX2) target.set_features({Target::AVX, Target::AVX2});
    if (request.isa == OPENFAB_ISA_AVX512)
        target.set_features({Target::AVX512, Target::AVX512_Skylake});
    return target;
}

/// Returns the most places that the runtime passes to a kernel in one call.
int64_t most_places(ir::StageKind kind) {
    const bool columns = kind == ir::StageKind::kVolume || kind == ir::StageKind::kVolumeDemand;
    return columns ? OPENFAB_MOST_COLUMNS : OPENFAB_MOST_PLACES;
}

/// The stack on which kernels are lowered. Statements of code that is written out are nested: Halide
/// uses some 90 bytes an operation (docs/measurements/schedules.md). Only what is used takes memory.
constexpr size_t kCompilerStackBytes = size_t{256} << 20;

/// Runs what goes as deep as statements are nested, and does not throw.
template <typename Work>
auto on_large_stack(const Work& work) {
    std::optional<decltype(work())> out;
    Halide::Internal::run_with_large_stack([&] { out = work(); });
    return *std::move(out);
}

/// Lowered code. Its last owner frees statements inside statements.
using SharedModule = std::shared_ptr<const Halide::Module>;

SharedModule share(Halide::Module module) {
    return {new Halide::Module(std::move(module)), [](const Halide::Module* last) {
                Halide::Internal::run_with_large_stack([&] { delete last; });
            }};
}

struct Lowered {
    ScheduledKernel kernel;
    SharedModule module;
    KernelMemory memory;
};

Fault schedule_fault(schedule::Fault what) {
    Fault fault;
    fault.schedule = std::move(what);
    return fault;
}

/// Halide's warnings are about a schedule that is refused, in words that are not ours.
class SilentReporter : public Halide::CompileTimeErrorReporter {
  public:
    void warning(const char* /*message*/) override {}
    void error(const char* message) override { throw Halide::CompileError(message); }
};

/// Schedules a kernel and lowers it. A user's schedule is checked again where only the lowered code
/// shows what it does.
std::variant<Lowered, Fault> lower_kernel(const KernelRequest& request) {
    const schedule::Schedule& schedule = schedule_of(request);
    const bool checked = request.schedule != nullptr;
    std::optional<ScheduledKernel> scheduled;
    static SilentReporter reporter;
    static std::once_flag once;
    std::call_once(once, [] {
        Halide::set_custom_compile_time_error_reporter(&reporter);
        Halide::set_compiler_stack_size(kCompilerStackBytes);
    });
    try {
        const Kernel kernel = make_kernel(*request.stage, request.inside, request.isa);
        std::variant<ScheduledKernel, schedule::Fault> applied =
            apply_schedule(schedule, kernel, !checked);
        if (auto* fault = std::get_if<schedule::Fault>(&applied))
            return schedule_fault(std::move(*fault));
        scheduled = std::get<ScheduledKernel>(std::move(applied));
        const auto lower = [&] {
            Halide::Pipeline pipeline(kernel.output);
            pipeline.add_custom_lowering_pass(make_expander(kernel.deferred));
            pipeline.add_custom_lowering_pass(make_storage_hoister(*scheduled));
            return share(pipeline.compile_to_module(kernel.arguments, request.function,
                                                    target_of(request),
                                                    Halide::LinkageType::ExternalPlusArgv));
        };
        if (checked && !scheduled->unrolled().empty()) {
            const SharedModule module = lower();
            if (auto fault =
                    on_large_stack([&] { return check_copies(schedule, *scheduled, *module); }))
                return schedule_fault(std::move(*fault));
            scheduled->unroll_loops();
        }
        if (checked && scheduled->has_part_vectors()) {
            const SharedModule module = lower();
            if (auto fault =
                    on_large_stack([&] { return check_part_vectors(*scheduled, *module); }))
                return schedule_fault(std::move(*fault));
            scheduled->vectorize_parts();
        }
        SharedModule module = lower();
        const int64_t places = most_places(request.stage->kind);
        KernelMemory memory;
        if (checked) {
            if (auto fault =
                    on_large_stack([&] { return check_code_size(schedule, *scheduled, *module); }))
                return schedule_fault(std::move(*fault));
            auto measured = on_large_stack(
                [&] { return check_lowered(schedule, *scheduled, *module, places); });
            if (auto* fault = std::get_if<schedule::Fault>(&measured))
                return schedule_fault(std::move(*fault));
            memory = std::get<KernelMemory>(measured);
        } else {
            // All that a schedule may store, where it is not known.
            memory = on_large_stack([&] {
                         return measure_memory(*scheduled, *module, places);
                     }).value_or(KernelMemory{kMostStoredBytes});
        }
        return Lowered{std::move(*scheduled), std::move(module), memory};
    } catch (const Halide::Error& error) {
        if (checked && scheduled)
            return schedule_fault(fault_of_lowering(schedule, *scheduled, error.what()));
        return fault_of(fmt::format("{}: {}", request.function, error.what()));
    }
}

/// Writes a kernel to a file; returns what it stores.
std::variant<KernelMemory, Fault> write_kernel(const KernelRequest& request,
                                               Halide::OutputFileType type,
                                               const std::string& path) {
    std::variant<Lowered, Fault> lowered = lower_kernel(request);
    if (auto* fault = std::get_if<Fault>(&lowered)) return std::move(*fault);
    const std::string trouble = on_large_stack([&]() -> std::string {
        try {
            std::get<Lowered>(lowered).module->compile({{type, path}});
        } catch (const Halide::Error& error) {
            return error.what();
        }
        return {};
    });
    if (!trouble.empty()) return fault_of(fmt::format("{}: {}", request.function, trouble));
    return std::get<Lowered>(lowered).memory;
}

/// The whole of a file; empty with errno where that fails.
std::optional<std::string> read_all(int file) {
    struct stat status {};
    if (::fstat(file, &status) != 0) return std::nullopt;
    std::string out(static_cast<size_t>(status.st_size), '\0');
    for (size_t done = 0; done < out.size();) {
        const ssize_t got =
            ::pread(file, out.data() + done, out.size() - done, static_cast<off_t>(done));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return std::nullopt;
        done += static_cast<size_t>(got);
    }
    return out;
}

std::string list_funcs(const KernelRequest& request) {
    const Kernel kernel = make_kernel(*request.stage, request.inside, request.isa);
    const schedule::Schedule& schedule = schedule_of(request);
    std::ostringstream out;
    out << fmt::format("kernel {} for {}\n", kernel_name(request.stage->kind),
                       abi::isa_name(request.isa));
    for (const Halide::Argument& argument : kernel.arguments) {
        out << fmt::format("  argument {}\n", argument.name);
    }
    for (const NamedFunc& named : kernel.funcs) {
        std::vector<std::string> vars;
        for (const auto& [name, var] : named.vars)
            vars.push_back(name);
        out << fmt::format("  func {}({})\n", named.name, fmt::join(vars, ", "));
        const Halide::Func func = named.func;
        size_t k = 0;
        const Halide::Tuple values = func.values();
        for (const Halide::Expr& value : values.as_vector()) {
            out << fmt::format("    value {}: ", k++) << value << '\n';
        }
        if (!func.has_update_definition()) continue;
        k = 0;
        const Halide::Tuple updates = func.update_values(0);
        for (const Halide::Expr& value : updates.as_vector()) {
            out << fmt::format("    update {}: ", k++) << value << '\n';
        }
    }
    out << fmt::format("schedule {}\n{}", schedule.path, schedule::text_of(schedule));
    return out.str();
}

/// Returns the schedule in force as a file that gives the same again.
std::string show_schedule(const KernelRequest& request) {
    const schedule::Schedule& schedule = schedule_of(request);
    std::string out = fmt::format("# {}, bound to {}\npipeline {}\n", schedule.path,
                                  abi::isa_name(request.isa), kernel_name(request.stage->kind));
    for (const schedule::Param& param : schedule.params)
        out += fmt::format("# {} = {} in {}\n", param.name.text, param.value, param.set());
    return out + schedule::text_of(schedule);
}

}  // namespace

std::string code_source(const KernelRequest& request) {
    const auto dump = [](const ir::Stage* stage) {
        return stage != nullptr ? ir::dump(*stage) : "";
    };
    return fmt::format("{} {}{}{}\n{}\n{}{}{}", abi::isa_name(request.isa),
                       request.schedule != nullptr ? "checked" : "unchecked",
                       request.profiled ? " profiled" : "",
                       request.inside.after_segments ? " after segments" : "",
                       schedule::text_of(schedule_of(request)), ir::dump(*request.stage),
                       dump(request.inside.demand), dump(request.inside.dither));
}

std::variant<CompiledKernel, Fault> compile_object(const KernelRequest& request) {
    // Halide writes to files only. This one is in memory, so that nothing is left of it.
    const int file = ::memfd_create("openfab kernel", MFD_CLOEXEC);
    const auto trouble = [&] {
        return fault_of(
            fmt::format("{}: {}", request.function, std::generic_category().message(errno)));
    };
    if (file < 0) return trouble();
    auto written = write_kernel(request, Halide::OutputFileType::object,
                                fmt::format("/proc/self/fd/{}", file));
    std::variant<CompiledKernel, Fault> out;
    if (auto* fault = std::get_if<Fault>(&written)) {
        out = std::move(*fault);
    } else if (std::optional<std::string> bytes = read_all(file)) {
        out = CompiledKernel{std::move(*bytes), std::get<KernelMemory>(written).bytes};
    } else {
        out = trouble();
    }
    ::close(file);
    return out;
}

std::variant<std::string, Fault> emit_text(const KernelRequest& request, TextForm form) {
    if (form == TextForm::kHalide) {
        try {
            return list_funcs(request);
        } catch (const Halide::Error& error) {
            return fault_of(error.what());
        }
    }
    if (form == TextForm::kSchedule) return show_schedule(request);
    if (form == TextForm::kLoops) {
        std::variant<Lowered, Fault> lowered = lower_kernel(request);
        if (auto* fault = std::get_if<Fault>(&lowered)) return std::move(*fault);
        const Lowered& all = std::get<Lowered>(lowered);
        const std::vector<FuncStorage> storage = on_large_stack([&] {
            return list_storage(all.kernel, *all.module, most_places(request.stage->kind));
        });
        return print_loops(all.kernel, storage) +
               fmt::format("a call stores {} bytes at most\n", all.memory.bytes);
    }
    const Halide::OutputFileType type = form == TextForm::kStmt ? Halide::OutputFileType::stmt
                                        : form == TextForm::kLlvm
                                            ? Halide::OutputFileType::llvm_assembly
                                            : Halide::OutputFileType::assembly;
    // Halide writes to files only, and requires this suffix.
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) {
        Fault fault = fault_of(folder.error().message);
        fault.is_outside = true;
        return fault;
    }
    const std::string name = ((*folder)->path() / "text").string();
    auto written = write_kernel(request, type, name);
    std::ifstream file(name, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (auto* fault = std::get_if<Fault>(&written)) return std::move(*fault);
    return text;
}

}  // namespace openfab::lower
