// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the library of HDF5 opened, closed when it is left. Files are opened so that nothing outside of them is
// read or loaded.

#include <hdf5.h>

#include <utility>

#include "base/input_file.h"

namespace openfab::tools {

/// Something of the library's that is closed.
class Hdf5Handle {
  public:
    Hdf5Handle() = default;
    Hdf5Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
    ~Hdf5Handle() {
        if (id_ >= 0) close_(id_);
    }
    Hdf5Handle(Hdf5Handle&& other) noexcept
        : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
        std::swap(id_, other.id_);
        std::swap(close_, other.close_);
        return *this;
    }
    Hdf5Handle(const Hdf5Handle&) = delete;
    Hdf5Handle& operator=(const Hdf5Handle&) = delete;
    bool ok() const { return id_ >= 0; }
    operator hid_t() const {
        return id_;
    }  // NOLINT(google-explicit-constructor): as the library takes it

  private:
    hid_t id_ = -1;
    herr_t (*close_)(hid_t) = nullptr;
};

/// Opens a file; no filter that it names is loaded as code.
Hdf5Handle open_hdf5(const InputFile& file);

/// Makes a list of how groups or data sets are opened, which refuses every link to another file.
Hdf5Handle within_file(hid_t kind);

}  // namespace openfab::tools
