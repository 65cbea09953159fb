// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace openfab::abi {

/// The outcome of a generated kernel, or of a chain of calls, which stops at the first failure.
/// Generated code itself returns an int (abi/fablet_table.h), which is converted where it is
/// called.
class [[nodiscard]] KernelStatus {
  public:
    /// Success.
    constexpr KernelStatus() = default;
    /// The value that generated code returned: 0, or a Halide error code.
    static constexpr KernelStatus of_code(int code) {
        return {code == 0 ? Kind::kOk : Kind::kFailed, code};
    }
    /// Cancelled: nothing failed, but the print was told to end early.
    static constexpr KernelStatus stopped() { return {Kind::kStopped, 0}; }

    constexpr bool ok() const { return kind_ == Kind::kOk; }
    constexpr bool is_stopped() const { return kind_ == Kind::kStopped; }
    /// The error code of a failure, else 0.
    constexpr int code() const { return code_; }

  private:
    enum class Kind { kOk, kStopped, kFailed };
    constexpr KernelStatus(Kind kind, int code) : kind_(kind), code_(code) {}

    Kind kind_ = Kind::kOk;
    int code_ = 0;
};

}  // namespace openfab::abi
