// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// A print binary whose fablets are written by hand, so that the program can be tested without the
// compiler.

#include "program/print_main.h"
#include "tests/support/prints/test_fablets.h"

int main(int argc, char** argv) {
    using namespace openfab::testing;
    // A mesh alone can only be printed by a binary with one fablet.
    const openfab_fablet* const fablets[] = {&skin_fablet(), &solid_fablet(), &tint_fablet(),
                                             &broken_fablet()};
    return openfab::program::print_main(argc, argv, {OPENFAB_TEST_FABLETS, fablets});
}
