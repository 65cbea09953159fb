// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/compile.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>

#include "abi/halide_hooks.h"
#include "base/own_folder.h"
#include "compiler/lower/apply_schedule.h"
#include "compiler/lower/kernel.h"
#include "compiler/lower/kernel_memory.h"
#include "compiler/lower/print_loops.h"
#include "texture/sample.h"

namespace openfab::lower {

namespace {

using Halide::Target;

constexpr int64_t kMostBlocks = 16;    // volume::BlockEvaluator::kBatch
constexpr int64_t kMostLanes = 16384;  // vertices, patches; groups of a segment are fewer

/// `checked`: the code tests its buffers' shapes. Our own schedules read and write what
/// compiler/lower/kernel.h says and no more, and the tests' cost in compile time is half of
/// everything; a user's schedule keeps them.
Target target_of(openfab_isa isa, bool checked) {
    // strict_float is what makes all targets, widths and schedules give the same bits. FMA stays
    // off.
    Target target(Target::Linux, Target::X86, 64,
                  {Target::SSE41, Target::StrictFloat, Target::NoRuntime, Target::NoBoundsQuery});
    target.set_feature(Target::NoAsserts, !checked);
    if (isa == OPENFAB_ISA_AVX2) target.set_features({Target::AVX, Target::AVX2});
    return target;
}

Fault internal_fault(std::string message) {
    Fault fault;
    fault.internal = std::move(message);
    return fault;
}

const Schedule& schedule_of(const KernelRequest& request) {
    if (request.schedule != nullptr) return *request.schedule;
    return default_schedule(kernel_name(request.stage->kind), isa_name(request.isa));
}

/// Returns the most places that the runtime passes to a kernel in one call, for the limit of what a
/// schedule may store.
int64_t most_places(ir::StageKind kind) {
    const bool volume = kind == ir::StageKind::kVolume || kind == ir::StageKind::kVolumeDemand;
    return volume ? kMostBlocks : kMostLanes;
}

struct Lowered {
    ScheduledKernel kernel;
    Halide::Module module;
};

Fault schedule_fault(ScheduleFault what) {
    Fault fault;
    fault.schedule = std::move(what);
    return fault;
}

/// Halide's warnings are of a schedule that is refused, in words that are not ours.
class SilentReporter : public Halide::CompileTimeErrorReporter {
  public:
    void warning(const char*) override {}
    void error(const char* message) override { throw Halide::CompileError(message); }
};

/// Schedules a kernel and lowers it. A user's schedule is checked again where only the lowered code
/// shows what it does.
std::variant<Lowered, Fault> lower_kernel(const KernelRequest& request) {
    const Schedule& schedule = schedule_of(request);
    const bool checked = request.schedule != nullptr;
    std::optional<ScheduledKernel> scheduled;
    static SilentReporter reporter;
    static std::once_flag once;
    std::call_once(once, [] { Halide::set_custom_compile_time_error_reporter(&reporter); });
    try {
        const Kernel kernel = make_kernel(*request.stage, request.isa);
        std::variant<ScheduledKernel, ScheduleFault> applied = apply_schedule(schedule, kernel);
        if (auto* fault = std::get_if<ScheduleFault>(&applied)) return schedule_fault(*fault);
        scheduled = std::get<ScheduledKernel>(std::move(applied));
        Halide::Module module = Halide::Pipeline(kernel.output)
                                    .compile_to_module(kernel.arguments, request.function,
                                                       target_of(request.isa, checked),
                                                       Halide::LinkageType::ExternalPlusArgv);
        if (checked) {
            std::optional<ScheduleFault> fault =
                check_lowered(schedule, *scheduled, module, most_places(request.stage->kind));
            if (fault) return schedule_fault(std::move(*fault));
        }
        return Lowered{std::move(*scheduled), std::move(module)};
    } catch (const Halide::Error& error) {
        if (checked && scheduled)
            return schedule_fault(fault_of_lowering(schedule, *scheduled, error.what()));
        return internal_fault(fmt::format("{}: {}", request.function, error.what()));
    }
}

std::variant<Halide::Module, Fault> module_of(const KernelRequest& request) {
    std::variant<Lowered, Fault> lowered = lower_kernel(request);
    if (auto* fault = std::get_if<Fault>(&lowered)) return std::move(*fault);
    return std::move(std::get<Lowered>(lowered).module);
}

std::optional<Fault> write_module(const KernelRequest& request, Halide::OutputFileType type,
                                  const std::string& path) {
    auto made = module_of(request);
    if (auto* fault = std::get_if<Fault>(&made)) return *fault;
    try {
        std::get<Halide::Module>(made).compile({{type, path}});
    } catch (const Halide::Error& error) {
        return internal_fault(fmt::format("{}: {}", request.function, error.what()));
    }
    return std::nullopt;
}

/// The symbols of the runtime that kernels call; in a print program they are linked in.
const Halide::Internal::JITModule& runtime_symbols() {
    static const Halide::Internal::JITModule symbols = [] {
        using Halide::Internal::JITModule;
        JITModule out;
        const auto add = [&](const char* name, auto* function) {
            out.add_symbol_for_export(name, JITModule::Symbol(reinterpret_cast<void*>(function)));
        };
        add("openfab_sample_sse41", openfab_sample_sse41);
        add("openfab_sample_avx2", openfab_sample_avx2);
        return out;
    }();
    return symbols;
}

/// Code in memory calls a Halide runtime of its own, which asks these.
void use_process_hooks() {
    Halide::JITHandlers handlers;
    handlers.custom_error = [](Halide::JITUserContext* context, const char* message) {
        abi::keep_kernel_error(context, message);
    };
    handlers.custom_do_par_for = [](Halide::JITUserContext* context,
                                    int (*task)(Halide::JITUserContext*, int, uint8_t*), int min,
                                    int size, uint8_t* closure) {
        return abi::run_kernel_loop(context, reinterpret_cast<abi::KernelTask>(task), min, size,
                                    closure);
    };
    Halide::Internal::JITSharedRuntime::set_default_handlers(handlers);
}

std::string list_funcs(const KernelRequest& request) {
    const Kernel kernel = make_kernel(*request.stage, request.isa);
    const Schedule& schedule = schedule_of(request);
    std::ostringstream out;
    out << fmt::format("kernel {} for {}\n", kernel_name(request.stage->kind),
                       isa_name(request.isa));
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
    out << fmt::format("schedule {}\n{}", schedule.path, schedule_text(schedule));
    return out.str();
}

/// The schedule in force as a file that gives the same again.
std::string show_schedule(const KernelRequest& request) {
    const Schedule& schedule = schedule_of(request);
    std::string out = fmt::format("# {}, bound to {}\npipeline {}\n", schedule.path,
                                  isa_name(request.isa), kernel_name(request.stage->kind));
    for (const ScheduleParam& param : schedule.params)
        out += fmt::format("# {} = {} in {}\n", param.name.text, param.value, param.set());
    return out + schedule_text(schedule);
}

}  // namespace

const char* isa_name(openfab_isa isa) {
    return isa == OPENFAB_ISA_AVX2 ? "avx2" : "sse41";
}

const char* schedule_name(ir::StageKind kind) {
    return kernel_name(kind);
}

const std::vector<std::string>& pipeline_names() {
    using Kind = ir::StageKind;
    static const std::vector<std::string> names = [] {
        std::vector<std::string> out;
        for (const Kind kind :
             {Kind::kSurface, Kind::kSurfaceBounds, Kind::kVolume, Kind::kVolumeBounds,
              Kind::kSurfaceSegment, Kind::kVolumeSegment, Kind::kDerived, Kind::kVolumeDemand})
            out.emplace_back(kernel_name(kind));
        return out;
    }();
    return names;
}

std::optional<Fault> compile_object(const KernelRequest& request, const std::string& path) {
    return write_module(request, Halide::OutputFileType::object, path);
}

std::variant<LoadedKernel, Fault> compile_in_memory(const KernelRequest& request) {
    auto made = module_of(request);
    if (auto* fault = std::get_if<Fault>(&made)) return *fault;
    const auto& module = std::get<Halide::Module>(made);
    try {
        static std::once_flag once;
        std::call_once(once, use_process_hooks);
        auto code = std::make_shared<Halide::Internal::JITModule>(
            module, module.get_function_by_name(request.function),
            std::vector<Halide::Internal::JITModule>{runtime_symbols()});
        // The argument array is Halide's to read: its type says const, ours is that of linked code.
        const auto function = reinterpret_cast<openfab_kernel_fn>(code->argv_function());
        return LoadedKernel{std::move(code), function};
    } catch (const Halide::Error& error) {
        return internal_fault(fmt::format("{}: {}", request.function, error.what()));
    }
}

std::variant<std::string, Fault> emit_text(const KernelRequest& request, TextForm form) {
    if (form == TextForm::kHalide) {
        try {
            return list_funcs(request);
        } catch (const Halide::Error& error) {
            return internal_fault(error.what());
        }
    }
    if (form == TextForm::kSchedule) return show_schedule(request);
    if (form == TextForm::kLoops) {
        std::variant<Lowered, Fault> lowered = lower_kernel(request);
        if (auto* fault = std::get_if<Fault>(&lowered)) return std::move(*fault);
        const auto& [kernel, module] = std::get<Lowered>(lowered);
        return print_loops(kernel, list_storage(kernel, module, most_places(request.stage->kind)));
    }
    const Halide::OutputFileType type = form == TextForm::kStmt ? Halide::OutputFileType::stmt
                                        : form == TextForm::kLlvm
                                            ? Halide::OutputFileType::llvm_assembly
                                            : Halide::OutputFileType::assembly;
    // Halide writes to files only; the suffix is the one it insists on.
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return internal_fault(folder.error().message);
    const std::string name = ((*folder)->path() / "text").string();
    std::optional<Fault> fault = write_module(request, type, name);
    std::ifstream file(name, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (fault) return *fault;
    return text;
}

}  // namespace openfab::lower
