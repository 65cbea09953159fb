// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/compile.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <system_error>

#include "base/own_folder.h"
#include "compiler/lower/apply_schedule.h"
#include "compiler/lower/kernel.h"

namespace openfab::lower {

namespace {

using Halide::Target;

/// `checked`: the code checks the shapes of its buffers. The built-in schedules read and write
/// exactly what compiler/lower/kernel.h says, and the checks are half of the compile time; user
/// schedules keep them.
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

/// Halide's message starts with the name of a Func that cannot be placed as the schedule says:
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

/// Halide reports some errors only when it lowers everything: the shortest failing prefix ends with
/// the faulty line. A prefix can take minutes, since what it does not schedule is inlined.
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

std::string code_source(const KernelRequest& request) {
    return fmt::format("{} {}\n{}\n{}{}", isa_name(request.isa),
                       request.schedule != nullptr ? "checked" : "unchecked",
                       schedule_of(request).text, ir::dump(*request.stage),
                       request.demand != nullptr ? ir::dump(*request.demand) : "");
}

std::variant<std::string, Fault> compile_object(const KernelRequest& request) {
    // Halide writes to files only. This one is in memory, so that nothing is left of it.
    const int file = ::memfd_create("openfab kernel", MFD_CLOEXEC);
    const auto trouble = [&] {
        return internal_fault(
            fmt::format("{}: {}", request.function, std::generic_category().message(errno)));
    };
    if (file < 0) return trouble();
    std::optional<Fault> fault = write_module(request, Halide::OutputFileType::object,
                                              fmt::format("/proc/self/fd/{}", file));
    std::variant<std::string, Fault> out;
    if (fault) {
        out = std::move(*fault);
    } else if (std::optional<std::string> bytes = read_all(file)) {
        out = std::move(*bytes);
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
            return internal_fault(error.what());
        }
    }
    const Halide::OutputFileType type = form == TextForm::kStmt ? Halide::OutputFileType::stmt
                                        : form == TextForm::kLlvm
                                            ? Halide::OutputFileType::llvm_assembly
                                            : Halide::OutputFileType::assembly;
    // Halide writes to files only, and requires this suffix.
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
