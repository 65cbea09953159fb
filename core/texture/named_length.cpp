// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/named_length.h"

#include <map>

#include "base/text.h"

namespace openfab::texture {

std::optional<double> named_length_mm(const std::string& name) {
    // Signs of units are in the case that they have; of names any is meant.
    static const std::map<std::string, double> kSigns = {
        {"nm", 1e-6},       {"um", 1e-3}, {"\u00b5m", 1e-3}, {"\u03bcm", 1e-3},
        {"\\u00B5m", 1e-3}, {"mm", 1},    {"cm", 10},        {"dm", 100},
        {"m", 1000},        {"in", 25.4}, {"\"", 25.4}};
    static const std::map<std::string, double> kNames = {
        {"angstrom", 1e-7},   {"nanometer", 1e-6}, {"nanometre", 1e-6}, {"micrometer", 1e-3},
        {"micrometre", 1e-3}, {"micron", 1e-3},    {"millimeter", 1},   {"millimetre", 1},
        {"centimeter", 10},   {"centimetre", 10},  {"decimeter", 100},  {"decimetre", 100},
        {"meter", 1000},      {"metre", 1000},     {"inch", 25.4},      {"inche", 25.4}};
    if (const auto sign = kSigns.find(name); sign != kSigns.end()) return sign->second;
    std::string one = lower_ascii(name);
    if (one.ends_with('s')) one.pop_back();
    if (const auto known = kNames.find(one); known != kNames.end()) return known->second;
    return std::nullopt;
}

}  // namespace openfab::texture
