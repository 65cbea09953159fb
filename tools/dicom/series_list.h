// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which slices of a folder belong together, and how people name them.

#include <string>
#include <vector>

#include "base/result.h"
#include "tools/dicom/dicom_slice.h"

namespace openfab::tools {

/// Returns the slices of the one series that there is, or of which `field` is the number, else the
/// identifier, else the description. Slices of a series that have another size, orientation or spacing
/// than the first, or are of another stack of their file, are a part of their own, `NUMBER/2`, as a scout
/// across the others is. Where it is not clear which one is wanted, the error lists them.
Result<std::vector<DicomSlice>> choose_series(std::vector<DicomSlice> slices,
                                              const std::string& field);

/// Whether a field is the number, identifier or description of one of the series, or names a part.
bool names_series(const std::vector<DicomSlice>& slices, const std::string& field);

/// Lists up to five names, and how many more there are.
std::string list_some(const std::vector<std::string>& names);

}  // namespace openfab::tools
