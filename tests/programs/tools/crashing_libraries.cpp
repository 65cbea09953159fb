// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Readers of files, of the libraries that programs link, which crash in their place: preloaded by converters_test.

#include <cstdlib>

// What a library exports is called by these names, whatever it takes.
extern "C" {

/// HarfBuzz: fonts.
void* hb_blob_create_from_file_or_fail() {
    std::abort();
}

/// Little CMS: profiles.
void* cmsOpenProfileFromMemTHR() {
    std::abort();
}

/// OpenCASCADE: STEPCAFControl_Reader::ReadFile.
int step_read_file() __asm__("_ZN21STEPCAFControl_Reader8ReadFileEPKc");
int step_read_file() {
    std::abort();
}

/// Coin: SoDB::readAll.
void* vrml_read_all() __asm__("_ZN4SoDB7readAllEP7SoInput");
void* vrml_read_all() {
    std::abort();
}
}
