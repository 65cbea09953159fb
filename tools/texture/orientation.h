// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a stored picture is turned for people: EXIF's orientations, 1 to 8.

namespace openfab::tools {

/// What puts it upright: axes are exchanged first, then the upright picture is mirrored.
struct Orientation {
    bool swap = false, mirror_x = false, mirror_y = false;

    /// Numbers that EXIF does not have are upright.
    explicit Orientation(int number)
        : swap(number >= 5 && number <= 8),
          mirror_x(number == 2 || number == 3 || number == 6 || number == 7),
          mirror_y(number == 3 || number == 4 || number == 7 || number == 8) {}
};

}  // namespace openfab::tools
