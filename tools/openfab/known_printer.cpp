// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/known_printer.h"

namespace openfab::tools {

world::Printer printer_of(const pipeline::PrintInfo& info) {
    // A name alone: who sends a print does not name files here.
    if (info.printer.find_first_of("/.") == std::string::npos) {
        if (Result<world::Printer> printer = world::load_printer(info.printer); printer)
            return *printer;
    }
    world::Printer unknown;
    unknown.name = info.printer;
    return unknown;
}

}  // namespace openfab::tools
