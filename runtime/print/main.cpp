// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/print/print_main.h"

int main(int argc, char** argv) {
    return openfab::print::print_main(argc, argv, openfab_fablets);
}
