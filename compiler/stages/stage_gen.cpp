// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Compiles one fixed-function stage to an object file; CMake runs it once per stage and instruction
// set, side by side.
//   stage_gen normalise sse41|avx2 OUT.o
//   stage_gen pack4|pack8 sse41|avx2 OUT.o
//   stage_gen runtime sse41 OUT.o         the one Halide runtime of a print binary

#include <cstdio>
#include <optional>
#include <string>

#include "compiler/lower/code/base_target.h"
#include "compiler/lower/schedule/apply_schedule.h"
#include "compiler/schedule/schedule.h"
#include "compiler/stages/stages.h"

namespace {

using openfab::stages::Stage;

// No FMA, even where available: contraction would change bits. strict_float is a target feature, so
// that it holds for every expression. The runtime is a module of its own.
Halide::Target kernel_target(const std::string& isa) {
    using Halide::Target;
    Target target = openfab::lower::base_target({Target::StrictFloat});
    if (isa == "avx2") {
        target.set_feature(Target::AVX);
        target.set_feature(Target::AVX2);
    }
    return target;
}

std::optional<Stage> make_stage(const std::string& name) {
    if (name == "normalise") return openfab::stages::normalise();
    if (name == "pack4") return openfab::stages::pack(4);
    if (name == "pack8") return openfab::stages::pack(8);
    return std::nullopt;
}

int generate(const std::string& name, const std::string& isa, const std::string& path) {
    using Halide::OutputFileType;
    Halide::Target target = kernel_target(isa);
    if (name == "runtime") {
        Halide::compile_standalone_runtime({{OutputFileType::object, path}}, target);
        return 0;
    }
    std::optional<Stage> stage = make_stage(name);
    if (!stage) {
        std::fprintf(stderr, "stage_gen: no stage `%s`\n", name.c_str());
        return 2;
    }
    namespace schedule = openfab::schedule;
    const schedule::Schedule& chosen = schedule::default_schedule(stage->name, isa);
    const auto applied = openfab::lower::apply_schedule(chosen, stage->kernel, true);
    if (const auto* fault = std::get_if<schedule::Fault>(&applied)) {
        std::fprintf(stderr, "%s:%d:%d: error: %s\n", chosen.path.c_str(), fault->line,
                     fault->column, fault->message.c_str());
        return 1;
    }
    target.set_feature(Halide::Target::NoRuntime);
    target.set_feature(Halide::Target::NoBoundsQuery);
    const std::string symbol = "openfab_" + name + "_" + isa;
    Halide::Module module = stage->pipeline.compile_to_module(
        stage->kernel.arguments, symbol, target, Halide::LinkageType::ExternalPlusArgv);
    module.compile({{OutputFileType::object, path}});
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: stage_gen STAGE ISA OUT.o\n");
        return 2;
    }
    try {
        return generate(argv[1], argv[2], argv[3]);
    } catch (const Halide::Error& error) {
        std::fprintf(stderr, "stage_gen: %s\n", error.what());
        return 4;
    }
}
