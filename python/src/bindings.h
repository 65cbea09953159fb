// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What module.cpp binds besides prints: options, files of prints, and texels of arrays.

#include <nanobind/nanobind.h>

#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "base/result.h"
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

/// A result as Python has it: the value, or the error, or None for neither.
template <typename T>
std::variant<T, Error> either(Result<T> result) {
    if (!result) return result.error();
    return std::move(*result);
}
inline std::optional<Error> either(const Result<void>& result) {
    return result ? std::nullopt : std::optional(result.error());
}

void bind_options(nanobind::module_& m);
void bind_print_file(nanobind::module_& m);
void bind_texels(nanobind::module_& m);

}  // namespace openfab::python
