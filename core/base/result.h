// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Result<T>: a value or an Error. It mirrors std::expected, which C++20 does not have. Our code
// throws nothing; set-up code returns Result, and the caller adds context on the way up.

#include <string>
#include <utility>
#include <variant>

#include "base/check.h"
#include "base/source_location.h"

namespace openfab {

/// The kind of trouble; the exit code of a program follows from it (exit_code below).
enum class ErrorCode {
    kUserInput,    ///< a file, option or value that the user gave is wrong
    kUsage,        ///< the command line is wrong
    kOutside,      ///< the outside world failed: disk, pipe, network, missing permission
    kInternal,     ///< a bug of ours
    kInterrupted,  ///< Ctrl-C
};

/// Tells a person what went wrong. All parts are lower case and without a final stop.
struct Error {
    ErrorCode code = ErrorCode::kInternal;
    std::string message;      ///< what was found
    std::string help;         ///< what would be right, or a way out; may be empty
    SourceLocation location;  ///< in a text file; empty where it is in none

    /// Formats all of it in one line: `path:line:column: message; help`.
    std::string text() const;
};

/// Describes what is wrong with part of a file whose location is not known yet; empty if nothing
/// is.
struct Complaint {
    std::string what;
    std::string help;

    Complaint() = default;
    Complaint(std::string what, std::string help = {})
        : what(std::move(what)), help(std::move(help)) {}
    Complaint(const char* what) : what(what) {}
    bool empty() const { return what.empty(); }
    /// Returns it as a user error at a location.
    Error at(SourceLocation location) const;
};

/// Returns the exit code of a program that ends with this error: 1 user input, 2 usage, 3 outside
/// world, 4 bug, 130 interrupted.
constexpr int exit_code(ErrorCode code) {
    switch (code) {
        case ErrorCode::kUserInput:
            return 1;
        case ErrorCode::kUsage:
            return 2;
        case ErrorCode::kOutside:
            return 3;
        case ErrorCode::kInternal:
            return 4;
        case ErrorCode::kInterrupted:
            return 130;
    }
    return 4;
}

inline Error user_error(std::string message, std::string help = {}) {
    return {ErrorCode::kUserInput, std::move(message), std::move(help), {}};
}
inline Error usage_error(std::string message) {
    return {ErrorCode::kUsage, std::move(message), {}, {}};
}
inline Error outside_error(std::string message) {
    return {ErrorCode::kOutside, std::move(message), {}, {}};
}
inline Error internal_error(std::string message) {
    return {ErrorCode::kInternal, std::move(message), {}, {}};
}

/// Makes a user error at a location in a file.
Error error_at(SourceLocation location, std::string what, std::string help = {});

/// Returns the error with a prefix before its message, such as `cannot read x.png: `; its location,
/// if it has one, goes into the message.
Error with_context(const Error& error, const std::string& before);

template <typename T>
class [[nodiscard]] Result {
  public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    bool has_value() const { return state_.index() == 0; }
    explicit operator bool() const { return has_value(); }

    /// Returns the value; aborts the process if there is none, so check first.
    T& value() {
        OPENFAB_CHECK(has_value());
        return *std::get_if<0>(&state_);
    }
    const T& value() const {
        OPENFAB_CHECK(has_value());
        return *std::get_if<0>(&state_);
    }
    T& operator*() { return value(); }
    const T& operator*() const { return value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    const Error& error() const {
        OPENFAB_CHECK(!has_value());
        return *std::get_if<1>(&state_);
    }

  private:
    std::variant<T, Error> state_;
};

struct Ok {};

template <>
class [[nodiscard]] Result<void> {
  public:
    Result() = default;
    Result(Ok) {}
    Result(Error error) : failed_(true), error_(std::move(error)) {}

    bool has_value() const { return !failed_; }
    explicit operator bool() const { return !failed_; }
    const Error& error() const {
        OPENFAB_CHECK(failed_);
        return error_;
    }

  private:
    bool failed_ = false;
    Error error_;
};

}  // namespace openfab
