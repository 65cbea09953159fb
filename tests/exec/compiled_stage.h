// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs one stage both ways: compiled for an instruction set, and in the interpreter. Tests give the
// inputs as bit patterns. A volume stage is compiled as segments that write its amounts to states,
// where they can be seen; expect_equal_slab compares what its slab kernel makes of them.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "compiler/ir/ir.h"
#include "compiler/lower/code/jit.h"
#include "compiler/schedule/schedule.h"
#include "tests/support/tested_isas.h"

namespace openfab::testing {

/// Level arrays of a texture, as texture/pyramid.h.
struct TestTexture {
    std::vector<float> texels;
    std::vector<int32_t> info;
    std::vector<float> minmax;
};

/// A box-filtered pyramid of texels in [0, 1]: noise blended with a ramp along u of weight `ramp`.
TestTexture make_texture(int32_t width, int32_t height, int32_t channels, int32_t wrap,
                         int32_t filter, uint32_t seed, float ramp = 0.0f);

/// Makes a surface stage that displaces along x by a lookup in texture 0, whose `args` arguments
/// after the guard are the components of surface input 0.
ir::Stage make_displacing_stage(int32_t args);

/// Bits of every input: one value per element, or one for scalars (kinds of the frame, uniforms,
/// …). Blocks are (3, n).
struct StageInputs {
    using Key = std::array<int32_t, 3>;  ///< kind, a, b
    std::map<Key, std::vector<uint32_t>> values;
    std::vector<TestTexture> textures;
    int32_t elements = 0;  ///< n of the kernel: blocks of 512 voxels in a volume stage
    size_t only = 0;       ///< interpret at most this many; 0: all

    void set(int32_t kind, int32_t a, int32_t b, std::vector<uint32_t> bits) {
        values[{kind, a, b}] = std::move(bits);
    }
};

using StageResults = std::vector<std::vector<uint32_t>>;  ///< [output][element]

class CompiledStage {
  public:
    /// Fails the test and returns null where the stage does not compile.
    static std::unique_ptr<CompiledStage> make(const ir::Stage& stage,
                                               const lower::ProgramOptions& options = {
                                                   .isas = tested_isas()});
    const std::vector<openfab_isa>& isas() const { return isas_; }
    StageResults run(openfab_isa isa, const StageInputs& inputs) const;

  private:
    StageResults run_segments(const openfab_segments& segments, openfab_isa isa,
                              const StageInputs& inputs) const;

    ir::Stage stage_;
    std::vector<openfab_isa> isas_;
    std::unique_ptr<lower::LoadedProgram> program_;
};

/// Elements of a volume stage are voxels (z, x, y, n), z fastest.
StageResults interpret(const ir::Stage& stage, const StageInputs& inputs);

/// Same, through the kernels and steps of a segmented stage.
StageResults interpret_segments(const ir::Stage& stage, const passes::SegmentedStage& segmented,
                                const StageInputs& inputs);

/// Returns the stage of amounts whose slab kernel expect_equal_slab compiles.
ir::Stage slab_stage(const ir::Stage& stage);

/// Compares what the slab kernel of a volume stage makes of the inputs, after the stage's segments if
/// it has any, with what the twin of normalise makes of the amounts that are expected: outputs that
/// are no floats are left out. `demand`: the stage of demand that a kernel without segments has
/// inside; where it says no, inputs are noise.
void expect_equal_slab(const ir::Stage& stage, const StageResults& expected,
                       const StageInputs& inputs, const lower::ProgramOptions& options,
                       const ir::Stage* demand = nullptr);

/// The answers of queries in these tests, by position, and the same on every path.
uint32_t answer(int32_t kind, int32_t b, float x, float y, float z, float stop = 0,
                uint32_t seed = 0);

/// Compares results bit for bit, treating all NaNs as equal, and reports the first differences.
void expect_equal(const ir::Stage& stage, const StageResults& expected, const StageResults& got,
                  const std::string& what);

/// Same, for the results of `compiled` on `inputs` for each instruction set.
void expect_equal(const ir::Stage& stage, const StageResults& expected,
                  const CompiledStage& compiled, const StageInputs& inputs);

}  // namespace openfab::testing
