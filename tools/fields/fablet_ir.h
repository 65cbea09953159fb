// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A fablet as `openflc emit --as ir` writes it, one instruction a line: what of a compiled fablet
// other programs may be told, as the compiler itself is not in this one.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "compiler/ir/ops.h"

namespace openfab::tools {

/// An instruction; its value has its index in the stage. Floats and what is neither are 32 bits.
struct IrLine {
    ir::Op op = ir::Op::kConst;
    ir::Type type = ir::Type::kFloat;
    uint32_t bits = 0;             ///< of a constant
    std::string input;             ///< of an input: `uniform`, `shape_point`, …
    std::vector<int32_t> numbers;  ///< of an input or a function: which one
    std::vector<uint32_t> args;
};

struct IrOutput {
    std::string name, kind;  ///< `weight`, `shape_value`, …
    int32_t index = 0;       ///< of a weight: its slot
    uint32_t value = 0;
};

struct IrStage {
    std::vector<IrLine> lines;
    std::vector<IrOutput> outputs;
    bool empty() const { return outputs.empty(); }
};

struct IrUniform {
    std::string name;
    std::string type_name;  ///< with the names of its values, as in abi/fablet_table.h
    std::string kind;
    ir::Type type = ir::Type::kFloat;
    int32_t components = 1, array_length = 1, first_index = 0;
    std::vector<uint32_t> default_bits;
};

struct FabletIr {
    std::string name;
    int32_t value_count = 0, texture_count = 0, object_count = 0, slot_count = 0, void_slot = -1;
    bool shape_is_distance = false, grows = false, has_surface = false, has_dither = false;
    std::vector<IrUniform> uniforms;
    IrStage shape, volume;
};

/// Reads the text of one fablet; fails where this is no such text.
Result<FabletIr> read_fablet_ir(std::string_view text);

}  // namespace openfab::tools
