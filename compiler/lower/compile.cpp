// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/compile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <sstream>

#include "abi/halide_hooks.h"
#include "abi/nearest_stage.h"
#include "base/own_folder.h"
#include "compiler/lower/apply_schedule.h"
#include "compiler/lower/kernel.h"
#include "texture/sample.h"

namespace openfab::lower {

namespace {

using Halide::Target;

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

/// A scheduled kernel as a Halide module.
std::variant<Halide::Module, ScheduleFault> make_module(const KernelRequest& request,
                                                        const Schedule& schedule,
                                                        size_t line_count) {
    Kernel kernel = make_kernel(*request.stage, request.demand, request.isa);
    if (std::optional<ScheduleFault> fault = apply_schedule(schedule, line_count, &kernel)) {
        return *fault;
    }
    return Halide::Pipeline(kernel.output)
        .compile_to_module(kernel.arguments, request.function,
                           target_of(request.isa, request.schedule != nullptr),
                           Halide::LinkageType::ExternalPlusArgv);
}

/// Halide's message starts with the name of a Func that cannot be where the schedule puts it:
/// returns a fault on the last line that places it.
std::optional<ScheduleFault> find_misplaced(const Schedule& schedule, const std::string& message) {
    const size_t quote = message.find('"');
    if (quote == std::string::npos || message.find("invalid location") == std::string::npos)
        return std::nullopt;
    // Halide numbers Funcs of one name.
    const std::string name =
        message.substr(quote + 1, message.find_first_of("\"$", quote + 1) - quote - 1);
    const auto sets_level = [](const Directive& d) {
        return d.name.text == "compute_at" || d.name.text == "store_at";
    };
    for (auto line = schedule.lines.rbegin(); line != schedule.lines.rend(); ++line) {
        if (names_func(*line, name) &&
            std::any_of(line->directives.begin(), line->directives.end(), sets_level))
            return fault_on_line(*line, message);
    }
    return std::nullopt;
}

/// Halide complains about some lines only when it lowers everything: the shortest prefix that fails
/// names the line. A prefix can take minutes, as what it does not schedule is inlined.
std::optional<ScheduleFault> find_guilty_line(const KernelRequest& request,
                                              const Schedule& schedule,
                                              const std::string& message) {
    if (std::optional<ScheduleFault> misplaced = find_misplaced(schedule, message))
        return misplaced;
    for (size_t count = 1; count <= schedule.lines.size(); ++count) {
        try {
            const auto made = make_module(request, schedule, count);
            if (const auto* fault = std::get_if<ScheduleFault>(&made)) return *fault;
        } catch (const Halide::Error& error) {
            return fault_on_line(schedule.lines[count - 1], error.what());
        }
    }
    return std::nullopt;
}

std::variant<Halide::Module, Fault> module_of(const KernelRequest& request) {
    const Schedule& schedule = schedule_of(request);
    std::string message;
    try {
        auto made = make_module(request, schedule, schedule.lines.size());
        if (auto* module = std::get_if<Halide::Module>(&made)) return *module;
        Fault fault;
        fault.schedule = std::get<ScheduleFault>(made);
        return fault;
    } catch (const Halide::Error& error) {
        message = error.what();
    }
    if (request.schedule != nullptr) {
        if (std::optional<ScheduleFault> guilty = find_guilty_line(request, schedule, message)) {
            Fault fault;
            fault.schedule = std::move(guilty);
            return fault;
        }
    }
    return internal_fault(fmt::format("{}: {}", request.function, message));
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
        add("openfab_nearest", openfab_nearest);
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
    const Kernel kernel = make_kernel(*request.stage, request.demand, request.isa);
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
    out << fmt::format("schedule {}\n{}", schedule.path, schedule.text);
    return out.str();
}

}  // namespace

const char* isa_name(openfab_isa isa) {
    return isa == OPENFAB_ISA_AVX2 ? "avx2" : "sse41";
}

const char* schedule_name(ir::StageKind kind) {
    return kernel_name(kind);
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
