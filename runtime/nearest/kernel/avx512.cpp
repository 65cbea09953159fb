// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#define OPENFAB_NEAREST_ISA avx512
#include "runtime/nearest/kernel/kernel.inl"
