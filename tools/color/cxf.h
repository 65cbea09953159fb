// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// CxF 3, XML of colours (ISO 17972-1): objects with amounts of ink, and with spectra, Lab or XYZ. Programs
// write both into one object, or into objects of different types, which go together by their names or else
// by their order.

#include <string_view>

#include "base/result.h"
#include "tools/color/samples.h"

namespace openfab::color {

/// Whether a table is XML.
bool is_cxf(std::string_view text);

/// Parses the patches of a CxF; errors name the object but not the file.
Result<SampleTable> parse_cxf(std::string_view text, const Measure& measure);

}  // namespace openfab::color
