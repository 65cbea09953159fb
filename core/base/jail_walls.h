// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the kernel keeps a reader from (jail.h): system calls by seccomp, files by Landlock. Both last until the process
// ends.

#include "base/jail.h"

namespace openfab {

/// Denies all system calls but those of a program that computes, reads files and, if it `converts`, writes them. A denied
/// call fails with EPERM. False where the kernel, or this kind of processor, has no such filter.
bool deny_system_calls(bool converts);

/// Denies files that the limits do not name. False where the kernel has no Landlock.
bool deny_files(const JailLimits& limits);

/// Whether the kernel has them.
bool has_system_call_filters();
bool has_landlock();

}  // namespace openfab
