// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inputs of a shape that are distances to objects, for passes, which know the contract with the runtime
// from the IR alone.

#include "abi/shape_distance.h"
