// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/print_main.h"

int main(int argc, char** argv) {
    return openfab::program::print_main(argc, argv, openfab_fablets);
}
