// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The browser of whoever has started the viewer.

#include <string>

namespace openfab::viewer {

/// Opens an address in the browser of the desktop, where somebody sits at a terminal of one; else says what to do with it.
/// Nothing happens where a program reads the address.
void open_in_browser(const std::string& url);

}  // namespace openfab::viewer
