// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/machine_tray.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "base/units.h"
#include "program/messages.h"
#include "tools/openfab/messages.h"
#include "world/printer.h"

namespace openfab::tools {

Result<MachineTray> machine_tray(const std::string& fit) {
    if (fit.find('x') != std::string::npos && fit.ends_with("mm")) {
        MachineTray out;
        std::string_view rest(fit.data(), fit.size() - 2);
        for (int a = 0; a < 3; ++a) {
            const size_t end = std::min(rest.find('x'), rest.size());
            const Result<double> size = parse_length_mm(std::string(rest.substr(0, end)) + "mm");
            if (!size || !(*size > 0) || (a < 2) == (end == rest.size())) {
                return usage_error(fmt::format(messages::kFitIsNoPrinter, fit));
            }
            out.size_mm[a] = *size;
            rest.remove_prefix(std::min(end + 1, rest.size()));
        }
        return out;
    }
    const Result<world::Printer> printer = world::load_printer(fit);
    if (!printer) return printer.error();
    if (!printer->knows_build_volume()) {
        return user_error(fmt::format(messages::kFitTrayUnknown, fit),
                          messages::kFitTrayUnknownHelp);
    }
    MachineTray out{printer->build_volume_mm, {}, fit};
    const world::Process& process = printer->process;
    for (int a = 0; a < 3; ++a) {
        out.size_mm[a] /= process.scale[a];
        // Its corner is what the machine moves to 0; what is on the bed stays there.
        if (a < 2) out.low_mm[a] = process.about_mm[a] * (1 - 1 / process.scale[a]);
    }
    return out;
}

Result<double> length_option(const char* option, const std::string& text) {
    const Result<double> mm = parse_length_mm(text);
    if (!mm)
        return usage_error(fmt::format(program::messages::kOfOption, option, mm.error().text()));
    if (*mm >= 0) return *mm;
    return usage_error(fmt::format(messages::kGapNotALength, option, text));
}

}  // namespace openfab::tools
