// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/hdf5/hdf5_handle.h"

namespace openfab::tools {

namespace {

herr_t refuse(const char*, const char*, const char*, const char*, unsigned*, hid_t, void*) {
    return -1;
}

}  // namespace

Hdf5Handle open_hdf5(const InputFile& file) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    H5PLset_loading_state(0);
    return {H5Fopen(file.name().c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
}

Hdf5Handle within_file(hid_t kind) {
    Hdf5Handle out(H5Pcreate(kind), H5Pclose);
    H5Pset_elink_cb(out, refuse, nullptr);
    return out;
}

}  // namespace openfab::tools
