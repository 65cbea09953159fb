// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab printers [NAME]`: which printers are known, and what of each.

#include "base/say.h"
#include "tools/openfab/commands.h"
#include "world/printer_list.h"

namespace openfab::tools {

Result<void> list_printers(const std::string& name, bool json) {
    std::vector<world::Printer> printers;
    for (const std::string& known :
         name.empty() ? world::printer_names() : std::vector<std::string>{name}) {
        Result<world::Printer> printer = world::load_printer(known);
        if (!printer) return printer.error();
        printers.push_back(std::move(*printer));
    }
    if (json) {
        show(world::printers_json(printers));
    } else if (name.empty()) {
        show(world::printer_table(printers));
    } else {
        show(world::printer_sheet(printers.front()));
    }
    return {};
}

}  // namespace openfab::tools
