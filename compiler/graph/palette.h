// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What can be added to a graph: functions of the standard library, built-in ones, those of the document, operators.

#include <string>
#include <string_view>
#include <vector>

#include "base/json_text.h"
#include "compiler/server/analysis.h"

namespace openfab::graph {

struct Parameter {
    std::string type;  ///< `float3`; of a built-in function also `floatN`, `T`
    std::string name;
    bool is_out = false;
    bool has_default = false;
    std::string sample;  ///< a value that shows something; empty: none is known
};

struct Entry {
    enum class Kind : uint8_t { kLibrary, kBuiltIn, kOwn, kOperator, kType, kMethod };
    Kind kind = Kind::kBuiltIn;
    std::string name;
    std::string module;     ///< of the library
    std::string signature;  ///< by which it is asked for
    std::string help;
    std::string result;
    std::vector<Parameter> parameters;
    std::string
        call;  ///< one that shows something, of `p`, `t`, `d` and `unit` (picture.cpp); empty: none is known
    double nanoseconds = -1;  ///< for a voxel; -1: not known
};

/// Returns all that can be added to a document, the document's own functions last.
std::vector<Entry> entries_of(const server::Analysis& analysis);

void write_entries(const std::vector<Entry>& entries, JsonText* out);

/// Returns a value of a type: `0`, `float3(0, 0, 0)`; empty if there is none that could be written.
std::string zero_of(std::string_view type);

}  // namespace openfab::graph
