// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Words and lines of VTK's older files.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

/// Reads words and lines of a file, and knows where it is.
class VtkWords {
  public:
    explicit VtkWords(const InputFile& file) : file_(file) {}

    int64_t at() const { return window_ + static_cast<int64_t>(next_); }
    int64_t left() const { return file_.bytes() - at(); }
    int line() const { return line_; }
    void go_to(int64_t offset) {
        window_ = offset;
        next_ = held_ = 0;
    }

    /// Returns the next word; empty at the end.
    Result<std::string> word();
    /// Returns the rest of the line, and passes its end.
    Result<std::string> rest_of_line();

  private:
    /// The next byte; below 0 at the end.
    Result<int> peek();
    void pass(int c) {
        line_ += c == '\n' ? 1 : 0;
        ++next_;
    }

    const InputFile& file_;
    std::vector<char> buffer_ = std::vector<char>(1 << 16);
    int64_t window_ = 0;
    size_t next_ = 0, held_ = 0;
    int line_ = 1;
};

/// A name as VTK writes it, with %20 for a blank.
std::string decoded_vtk_name(const std::string& name);

}  // namespace openfab::tools
