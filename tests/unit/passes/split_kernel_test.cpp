// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/split_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "compiler/interp/evaluate.h"

namespace openfab::passes {
namespace {

using ir::Op;
using ir::ValueId;

constexpr size_t kStates = 8;

/// The states of one lane, and what kernels write there.
class Place : public interp::Environment {
  public:
    explicit Place(size_t states) : bits(states) {
        for (size_t k = 0; k < states; ++k)
            bits[k] = static_cast<uint32_t>(3 * k + 1);
    }
    uint32_t input(int32_t kind, int32_t a, int32_t /*b*/) const override {
        return kind == OPENFAB_ARG_STATE ? bits.at(static_cast<size_t>(a)) : 17;
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }

    void run(const ir::Stage& kernel) {
        const std::vector<uint32_t> results = interp::evaluate(kernel, *this);
        for (size_t k = 0; k < results.size(); ++k) {
            const ir::Output& output = kernel.outputs[k];
            if (output.kind == OPENFAB_ARG_STATE_OUT) {
                bits.at(static_cast<size_t>(output.a)) = results[k];
            } else {
                EXPECT_TRUE(weights.emplace(output.a, results[k]).second) << "written twice";
            }
        }
    }

    std::map<int32_t, uint32_t> weights;
    std::vector<uint32_t> bits;
};

/// A kernel over uint states, of which the first four are written: two are swapped, one takes the
/// old value of another, one is computed, so that the order of reads and writes matters. A third of
/// the other outputs are a constant, a third one value.
ir::Stage long_kernel(int operations, int outputs) {
    ir::Stage stage;
    stage.kind = ir::StageKind::kVolumeSegment;
    ir::Builder b(&stage);
    std::vector<ValueId> values;
    for (size_t k = 0; k < kStates; ++k)
        values.push_back(b.input(ir::Type::kUint, OPENFAB_ARG_STATE, static_cast<int32_t>(k), 0));
    values.push_back(b.input(ir::Type::kUint, OPENFAB_ARG_UNIFORM, 0, 0));
    for (size_t k = 0; k < static_cast<size_t>(operations); ++k) {
        // Mostly of recent values, sometimes of much earlier ones.
        const size_t n = values.size();
        const ValueId first = values[n - 1 - k % std::min<size_t>(n, 5)];
        const ValueId second =
            values[k % 6 == 0 ? 7 * k % n : n - 1 - 3 * k % std::min<size_t>(n, 9)];
        constexpr std::array<Op, 4> kOps = {Op::kAdd, Op::kMul, Op::kBitXor, Op::kSub};
        values.push_back(b.emit(kOps[k % 4], {first, second}));
    }
    const size_t last = values.size() - 1;
    const auto write = [&](int32_t kind, int32_t a, ValueId value) {
        stage.outputs.push_back({"out", kind, a, 0, value});
    };
    write(OPENFAB_ARG_STATE_OUT, 0, values[1]);
    write(OPENFAB_ARG_STATE_OUT, 1, values[0]);
    write(OPENFAB_ARG_STATE_OUT, 2, values[3]);
    write(OPENFAB_ARG_STATE_OUT, 3, values[last]);
    const ValueId nothing = b.constant(0u);
    for (int32_t k = 0; k < outputs; ++k) {
        const ValueId some = values[static_cast<size_t>(k) * 11 % last];
        write(OPENFAB_ARG_WEIGHT, k, k % 3 == 0 ? nothing : k % 3 == 1 ? values[last / 2] : some);
    }
    return stage;
}

void expect_same(const ir::Stage& whole, size_t longest) {
    ASSERT_EQ(ir::verify(whole), "");
    std::vector<ir::Type> types(kStates, ir::Type::kUint);
    const std::vector<ir::Stage> pieces = split_kernel(whole, &types, longest);
    ASSERT_GT(pieces.size(), 1u);
    Place expected(types.size()), found(types.size());
    expected.run(whole);
    std::set<int32_t> written;
    for (const ir::Stage& piece : pieces) {
        ASSERT_EQ(ir::verify(piece), "") << ir::dump(piece);
        EXPECT_EQ(piece.kind, whole.kind);
        EXPECT_LE(kernel_operations(piece), 2 * longest / 5);
        for (const ir::Instr& instr : piece.instrs) {
            if (instr.op != Op::kInput || instr.kind != OPENFAB_ARG_STATE) continue;
            const auto state = static_cast<size_t>(instr.a);
            EXPECT_FALSE(state < kStates && written.count(instr.a) != 0) << "read once written";
            ASSERT_LT(state, types.size());
            EXPECT_EQ(instr.type, types[state]);
        }
        for (const ir::Output& output : piece.outputs) {
            if (output.kind == OPENFAB_ARG_STATE_OUT) written.insert(output.a);
        }
        found.run(piece);
    }
    EXPECT_EQ(found.weights, expected.weights);
    for (size_t k = 0; k < kStates; ++k)
        EXPECT_EQ(found.bits[k], expected.bits[k]) << "state " << k;
}

TEST(SplitKernel, PiecesComputeWhatTheWholeDoes) {
    for (const size_t longest : {size_t{10}, size_t{37}, size_t{200}, size_t{1000}}) {
        SCOPED_TRACE(longest);
        expect_same(long_kernel(3000, 20), longest);
    }
}

TEST(SplitKernel, ManyOutputsAreWrittenByMoreKernels) {
    const ir::Stage whole = long_kernel(700, 400);
    ASSERT_TRUE(needs_splitting(whole));
    std::vector<ir::Type> types(kStates, ir::Type::kUint);
    for (const ir::Stage& piece : split_kernel(whole, &types))
        EXPECT_LE(piece.outputs.size(), 64u);
    expect_same(whole, kMaxKernelOperations);
}

constexpr int kElements = 300;

/// A kernel that gets a bool, an int, and the elements of an array of ints.
struct ArrayKernel {
    ir::Stage stage;
    ir::Builder b{&stage};
    ValueId runs = ir::kNoValue, index = ir::kNoValue;
    std::vector<ValueId> elements;

    ArrayKernel() {
        stage.kind = ir::StageKind::kVolumeSegment;
        runs = b.input(ir::Type::kBool, OPENFAB_ARG_STATE, kElements, 0);
        index = b.input(ir::Type::kInt, OPENFAB_ARG_STATE, kElements + 1, 0);
        for (int32_t k = 0; k < kElements; ++k)
            elements.push_back(b.input(ir::Type::kInt, OPENFAB_ARG_STATE, k, 0));
    }

    size_t count_pieces() const {
        std::vector<ir::Type> types(kElements + 2, ir::Type::kInt);
        types[kElements] = ir::Type::kBool;
        return split_kernel(stage, &types).size();
    }

    void expect_narrow_pieces() const {
        ASSERT_EQ(ir::verify(stage), "");
        ASSERT_TRUE(needs_splitting(stage));
        std::vector<ir::Type> types(kElements + 2, ir::Type::kInt);
        types[kElements] = ir::Type::kBool;
        for (const ir::Stage& piece : split_kernel(stage, &types)) {
            ASSERT_EQ(ir::verify(piece), "");
            EXPECT_LE(piece.outputs.size(), 64u);
            EXPECT_LE(std::count_if(piece.instrs.begin(), piece.instrs.end(),
                                    [](const ir::Instr& i) { return i.op == Op::kInput; }),
                      64);
        }
    }
};

/// What a loop that fills an array makes of its trip: all elements are computed, then chosen.
TEST(SplitKernel, PiecesThatFillAnArrayReadAndWriteFewStates) {
    ArrayKernel kernel;
    ir::Builder& b = kernel.b;
    std::vector<ValueId> after;
    for (int32_t k = 0; k < kElements; ++k) {
        const ValueId here = b.emit(Op::kEq, {kernel.index, b.constant(k)});
        after.push_back(b.select(here, kernel.index, kernel.elements[static_cast<size_t>(k)]));
    }
    for (int32_t k = 0; k < kElements; ++k) {
        const auto e = static_cast<size_t>(k);
        const ValueId kept = b.select(kernel.runs, after[e], kernel.elements[e]);
        kernel.stage.outputs.push_back({"out", OPENFAB_ARG_STATE_OUT, k, 0, kept});
    }
    kernel.expect_narrow_pieces();
    // Each element is written by the kernel that reads it, not copied by another one.
    EXPECT_LE(kernel.count_pieces(), kElements / 30u);
}

/// What reads an element by a varying index: all tests, then all choices.
TEST(SplitKernel, PiecesThatReadAnArrayReadFewStates) {
    ArrayKernel kernel;
    ir::Builder& b = kernel.b;
    std::vector<ValueId> tests;
    for (int32_t k = 0; k < kElements; ++k)
        tests.push_back(b.emit(Op::kEq, {kernel.index, b.constant(k)}));
    ValueId chosen = kernel.elements[0];
    for (size_t e = kElements; e-- > 1;)
        chosen = b.select(tests[e], kernel.elements[e], chosen);
    kernel.stage.outputs.push_back({"out", OPENFAB_ARG_WEIGHT, 0, 0, chosen});
    kernel.expect_narrow_pieces();
}

TEST(SplitKernel, ShortKernelsStayWhole) {
    EXPECT_FALSE(needs_splitting(long_kernel(700, 20)));
    EXPECT_TRUE(needs_splitting(long_kernel(3600, 20)));
    EXPECT_TRUE(needs_splitting(long_kernel(10, 400)));
}

}  // namespace
}  // namespace openfab::passes
