// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

/// A row of a folder's messages.h: a text as a constant; `fmt::format(messages::kName, …)` checks what it takes.
#define OPENFAB_MESSAGE(name, text) inline constexpr char name[] = text;
