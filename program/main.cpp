// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/run_main.h"
#include "program/print_main.h"

int main(int argc, char** argv) {
    return openfab::run_main(
        [](int count, char** arguments) {
            return openfab::program::print_main(count, arguments, openfab_fablets);
        },
        argc, argv);
}
