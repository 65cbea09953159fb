// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/jit.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <fstream>

namespace openfab::lower {

namespace {

Fault internal_fault(std::string message) {
    Fault fault;
    fault.internal = std::move(message);
    return fault;
}

// Overrides the runtime's handler, which prints and aborts. The error code that the kernel returns
// says enough.
constexpr const char* kErrorHandler =
    "void halide_error(void* user_context, const char* message) {\n"
    "    (void)user_context;\n"
    "    (void)message;\n"
    "}\n";

}  // namespace

LoadedProgram::~LoadedProgram() {
    if (library_ != nullptr) dlclose(library_);
}

std::variant<std::unique_ptr<LoadedProgram>, Fault> load_program(
    const std::vector<FabletUnit>& fablets, const ProgramOptions& options) {
    const ScratchFolder folder;
    if (folder.path().empty()) return internal_fault("no temporary folder can be made");
    auto compiled = compile_program(fablets, options, folder.path());
    if (auto* fault = std::get_if<Fault>(&compiled)) return *fault;
    const std::string runtime = (folder.path() / "runtime.o").string();
    if (std::optional<Fault> fault = compile_runtime(runtime)) return *fault;

    const std::string handler = (folder.path() / "error.c").string();
    std::ofstream(handler) << kErrorHandler;
    const std::string library = (folder.path() / "fablets.so").string();
    // Symbolic: the library must call its own runtime, not one that the program around it has.
    std::vector<std::string> command = {
        options.compiler, "-shared", "-fPIC", "-Wl,-Bsymbolic", "-o", library, handler, runtime};
    for (const auto& object : std::get<ProgramObjects>(compiled).objects) {
        command.push_back(object.string());
    }
    command.insert(command.end(), {"-lm", "-lpthread", "-ldl"});
    const std::string trouble = run_tool(command);
    if (!trouble.empty()) return internal_fault(trouble);

    std::unique_ptr<LoadedProgram> out(new LoadedProgram);
    out->library_ = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (out->library_ == nullptr) return internal_fault(dlerror());
    out->list_ = static_cast<const openfab_fablet_list*>(dlsym(out->library_, "openfab_fablets"));
    if (out->list_ == nullptr) return internal_fault(dlerror());
    return out;
}

std::variant<std::unique_ptr<LoadedProgram>, Fault> load_module(
    const ir::Module& module, const ProgramOptions& options,
    const passes::PipelineOptions& pipeline) {
    std::vector<passes::PipelineResult> results;
    results.reserve(module.fablets.size());
    std::vector<FabletUnit> units;
    for (const ir::Fablet& fablet : module.fablets) {
        results.push_back(passes::run_pipeline(fablet, pipeline));
        if (!results.back().fault.empty()) return internal_fault(results.back().fault);
        units.push_back({&fablet, &results.back().stages, "", 0});
    }
    return load_program(units, options);
}

}  // namespace openfab::lower
