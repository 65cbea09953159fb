// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/property/pipeline/reference_check.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>

#include "compiler/diag/render.h"
#include "compiler/driver/frontend.h"
#include "runtime/slab/print.h"
#include "tests/support/reference/pipeline.h"
#include "tests/support/slab/box_print.h"

namespace openfab::testing {

size_t Compiled::find(const std::string& name) const {
    for (size_t k = 0; k < module.fablets.size(); ++k) {
        if (module.fablets[k].name == name) return k;
    }
    ADD_FAILURE() << "no fablet " << name;
    return 0;
}

Compiled compile(const std::filesystem::path& file) {
    Compiled compiled;
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    std::optional<ir::Module> module = driver::compile_to_ir(sources, file, sink, &fault);
    if (!module) {
        ADD_FAILURE() << file << " does not compile: " << fault;
        return compiled;
    }
    compiled.module = std::move(*module);
    auto loaded = lower::load_module(compiled.module);
    if (std::holds_alternative<lower::Fault>(loaded)) {
        ADD_FAILURE() << std::get<lower::Fault>(loaded).internal;
        return compiled;
    }
    compiled.program = std::move(std::get<0>(loaded));
    return compiled;
}

void expect_reference(const std::vector<scene::Part>& parts,
                      const std::vector<const ir::Fablet*>& sources, const Vec3d& pitch_mm,
                      uint64_t seed) {
    slab::PrintInput input;
    input.parts = parts;
    for (int k = 0; k < 4; ++k)
        input.materials.push_back({fmt::format("m{}", k), {}, {}, 1, ""});
    input.pitch_mm = pitch_mm;

    slab::PrintOptions options;
    options.seed = seed;
    options.threads = 2;
    options.memory_bytes += tests::kSanitizerBytes;
    auto print = slab::Print::create(std::move(input), options);
    ASSERT_TRUE(print) << print.error().message;
    tests::MemorySink sink;
    slab::PrintStatistics statistics;
    const std::atomic<bool> interrupt{false};
    const Result<void> ran = (*print)->run(sink, nullptr, interrupt, &statistics);
    ASSERT_TRUE(ran) << ran.error().message;

    const scene::Grid grid{sink.info.origin_mm, sink.info.pitch_mm, sink.info.size};
    std::vector<reference::ReferencePart> references;
    for (size_t k = 0; k < parts.size(); ++k)
        references.push_back({&parts[k], sources[k]});
    const std::vector<uint8_t> expected = reference::print(references, grid, 4, seed);
    const std::vector<uint8_t> codes = sink.codes();
    ASSERT_EQ(codes.size(), expected.size());
    int64_t different = 0, solid = 0;
    std::string first;
    for (size_t v = 0; v < codes.size(); ++v) {
        solid += expected[v] != 0 ? 1 : 0;
        if (codes[v] == expected[v]) continue;
        if (different++ == 0) {
            const auto w = static_cast<size_t>(grid.size.x), h = static_cast<size_t>(grid.size.y);
            first = fmt::format("voxel ({}, {}, {}): printed {}, asked {}", v % w, v / w % h,
                                v / (w * h), codes[v], expected[v]);
        }
    }
    EXPECT_EQ(different, 0) << first << " of " << codes.size();
    EXPECT_GT(solid, static_cast<int64_t>(codes.size()) / 20);
    printf("%zu voxels, %ld solid, blocks %ld filled, %ld evaluated\n", codes.size(),
           static_cast<long>(solid), static_cast<long>(statistics.blocks_filled),
           static_cast<long>(statistics.blocks_evaluated));
}

}  // namespace openfab::testing
