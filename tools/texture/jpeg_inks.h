// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A JPEG of inks, read by libjpeg: OpenImageIO makes colours of them, whatever its profile says.

#include <cstdint>
#include <functional>
#include <memory>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

class JpegInks {
  public:
    /// Opens a file of four components. Fails where it does not say how it counts inks: Adobe's programs store
    /// what is left white, and say so by a marker; without it programs differ.
    static Result<std::unique_ptr<JpegInks>> open(const InputFile& file, int64_t memory_bytes);
    ~JpegInks();
    JpegInks(const JpegInks&) = delete;
    JpegInks& operator=(const JpegInks&) = delete;

    /// Calls use(y, row) for each row from the top: cyan, magenta, yellow and black, 1 for all of it. Stops at
    /// the first error of `use`; fails where data is damaged or missing.
    Result<void> each_row(const std::function<Result<void>(int y, const float* row)>& use);

  private:
    struct Handle;
    JpegInks();

    std::unique_ptr<Handle> handle_;
};

}  // namespace openfab::tools
