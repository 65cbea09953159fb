// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The record that a print keeps beside its output.

#include <memory>
#include <optional>

#include "backends/common/format.h"
#include "backends/job/record.h"
#include "program/job.h"
#include "program/options.h"

namespace openfab::program {

/// The environment variable in which `openfab print` tells with which options it compiled, as JSON.
constexpr const char* kCompilationVariable = "OPENFAB_COMPILATION";

/// Reads all inputs of a print and makes its record; null for an output that has none, and for hosts without a command
/// line.
std::unique_ptr<job::Record> make_record(const Options& options, const Job& job,
                                         const backends::Format* format);

}  // namespace openfab::program
