// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What people and programs are told of printer profiles: which there are, and one with the documents
// that its figures are taken from.

#include <string>
#include <vector>

#include "world/printer.h"

namespace openfab::world {

/// Returns the text of a profile, by its name or path, as load_printer reads it.
Result<std::string> printer_text(const std::string& name_or_path);

/// Returns a table with one line for each printer.
std::string printer_table(const std::vector<Printer>& printers);

/// Returns all that a profile says, for its reader.
std::string printer_sheet(const Printer& printer);

/// Returns an array of objects, with null for what is not known.
std::string printers_json(const std::vector<Printer>& printers);

}  // namespace openfab::world
