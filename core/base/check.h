// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Assertions of invariants that only a bug in OpenFab can violate. OPENFAB_CHECK and its
// comparisons hold in every build: they print their location, the condition and the values, and
// abort the process. OPENFAB_DCHECK is for paths that run for each voxel, and compiles to nothing
// where NDEBUG is set.

#include <string>
#include <type_traits>

namespace openfab {

/// Prints to standard error which check failed, and aborts. `values`: those compared, or empty.
[[noreturn]] void check_failed(const char* file, int line, const char* expression,
                               const std::string& values = {});

namespace check_detail {

std::string text_of(long long value);
std::string text_of(unsigned long long value);
std::string text_of(double value);
std::string text_of(const void* value);

template <typename T>
std::string value_text(const T& value) {
    if constexpr (std::is_floating_point_v<T>) {
        return text_of(static_cast<double>(value));
    } else if constexpr (std::is_unsigned_v<T>) {
        return text_of(static_cast<unsigned long long>(value));
    } else if constexpr (std::is_integral_v<T> || std::is_enum_v<T>) {
        return text_of(static_cast<long long>(value));
    } else {
        return text_of(static_cast<const void*>(value));
    }
}

template <typename A, typename B>
[[noreturn]] void comparison_failed(const char* file, int line, const char* expression, const A& a,
                                    const B& b) {
    check_failed(file, line, expression, value_text(a) + " and " + value_text(b));
}

}  // namespace check_detail
}  // namespace openfab

#define OPENFAB_CHECK(condition)                         \
    (static_cast<bool>(condition) ? static_cast<void>(0) \
                                  : ::openfab::check_failed(__FILE__, __LINE__, #condition))

#define OPENFAB_CHECK_OP(a, op, b)                                                            \
    do {                                                                                      \
        const auto& openfab_a = (a);                                                          \
        const auto& openfab_b = (b);                                                          \
        if (!(openfab_a op openfab_b))                                                        \
            ::openfab::check_detail::comparison_failed(__FILE__, __LINE__, #a " " #op " " #b, \
                                                       openfab_a, openfab_b);                 \
    } while (false)

#define OPENFAB_CHECK_EQ(a, b) OPENFAB_CHECK_OP(a, ==, b)
#define OPENFAB_CHECK_NE(a, b) OPENFAB_CHECK_OP(a, !=, b)
#define OPENFAB_CHECK_LT(a, b) OPENFAB_CHECK_OP(a, <, b)
#define OPENFAB_CHECK_LE(a, b) OPENFAB_CHECK_OP(a, <=, b)
#define OPENFAB_CHECK_GT(a, b) OPENFAB_CHECK_OP(a, >, b)
#define OPENFAB_CHECK_GE(a, b) OPENFAB_CHECK_OP(a, >=, b)

#ifdef NDEBUG
#define OPENFAB_DCHECK(condition) static_cast<void>(sizeof((condition) ? 1 : 0))
#else
#define OPENFAB_DCHECK(condition) OPENFAB_CHECK(condition)
#endif
