// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Compiles one fixed-function stage to an object file; CMake runs it once per stage, number of
// materials and instruction set, side by side.
//   stage_gen normalise MATERIALS sse41|avx2 OUT.o
//   stage_gen pack BITS sse41|avx2 OUT.o
//   stage_gen runtime 0 sse41 OUT.o         the one Halide runtime of a print binary

#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "compiler/lower/apply_schedule.h"
#include "compiler/lower/schedule.h"
#include "compiler/stages/stages.h"

namespace {

using openfab::stages::Stage;

// No FMA, whatever the machine has: contraction would change bits. strict_float is a target
// feature, so that it holds for every expression. The runtime is a module of its own.
Halide::Target kernel_target(const std::string& isa) {
    using Halide::Target;
    Target target(Target::Linux, Target::X86, 64, {Target::SSE41, Target::StrictFloat});
    if (isa == "avx2") {
        target.set_feature(Target::AVX);
        target.set_feature(Target::AVX2);
    }
    return target;
}

std::optional<Stage> make_stage(const std::string& name, int materials) {
    if (name == "normalise") return openfab::stages::normalise(materials);
    if (name == "pack") return openfab::stages::pack(materials);
    return std::nullopt;
}

int generate(const std::string& name, int materials, const std::string& isa,
             const std::string& path) {
    using Halide::OutputFileType;
    Halide::Target target = kernel_target(isa);
    if (name == "runtime") {
        Halide::compile_standalone_runtime({{OutputFileType::object, path}}, target);
        return 0;
    }
    std::optional<Stage> stage = make_stage(name, materials);
    if (!stage) {
        std::fprintf(stderr, "stage_gen: no stage `%s`\n", name.c_str());
        return 2;
    }
    const openfab::lower::Schedule& schedule = openfab::lower::default_schedule(name, isa);
    const auto applied = openfab::lower::apply_schedule(schedule, stage->kernel);
    if (const auto* fault = std::get_if<openfab::lower::ScheduleFault>(&applied)) {
        std::fprintf(stderr, "%s:%d:%d: error: %s\n", schedule.path.c_str(), fault->line,
                     fault->column, fault->message.c_str());
        return 1;
    }
    target.set_feature(Halide::Target::NoRuntime);
    target.set_feature(Halide::Target::NoBoundsQuery);
    const std::string symbol = "openfab_" + name + "_" + std::to_string(materials) + "_" + isa;
    Halide::Module module = stage->pipeline.compile_to_module(
        stage->kernel.arguments, symbol, target, Halide::LinkageType::ExternalPlusArgv);
    module.compile({{OutputFileType::object, path}});
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 5) {
        std::fprintf(stderr, "usage: stage_gen STAGE MATERIALS ISA OUT.o\n");
        return 2;
    }
    try {
        return generate(argv[1], std::atoi(argv[2]), argv[3], argv[4]);
    } catch (const Halide::Error& error) {
        std::fprintf(stderr, "stage_gen: %s\n", error.what());
        return 4;
    }
}
