// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Profiles that tests make by Little CMS.

#include <gtest/gtest.h>
#include <lcms2.h>

#include <cstdint>
#include <vector>

namespace openfab::testing {

/// Returns the bytes of a profile, and closes it.
inline std::vector<uint8_t> saved(cmsHPROFILE profile) {
    cmsUInt32Number size = 0;
    EXPECT_TRUE(cmsSaveProfileToMem(profile, nullptr, &size));
    std::vector<uint8_t> bytes(size);
    EXPECT_TRUE(cmsSaveProfileToMem(profile, bytes.data(), &size));
    cmsCloseProfile(profile);
    return bytes;
}

}  // namespace openfab::testing
