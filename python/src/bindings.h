// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What module.cpp binds besides prints: files of prints, and texels of arrays.

#include <nanobind/nanobind.h>

#include <memory>
#include <utility>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::python {

/// An array that owns the elements of a vector, in place. Its type is an nb::ndarray.
template <typename Array, typename T>
Array array_of(std::vector<T> values, std::initializer_list<size_t> shape) {
    auto* kept = new std::vector<T>(std::move(values));
    nanobind::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return Array(kept->data(), shape, owner);
}

/// What is known of a print before its first slice, as a dict.
nanobind::dict info_of(const pipeline::PrintInfo& info, int64_t memory_bytes);

void bind_print_file(nanobind::module_& m);
void bind_texels(nanobind::module_& m);

}  // namespace openfab::python
