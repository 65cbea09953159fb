// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes 3MF packages of a model and of stacks of images that it names.

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "backends/common/package.h"
#include "backends/common/part_file.h"
#include "base/result.h"

namespace openfab::tools {

/// The file appears when it is complete.
class FieldPackage {
  public:
    Result<void> begin(const std::string& output);
    /// Adds an image by the name that the model has for it.
    Result<void> add_sheet(const std::string& name, const std::vector<uint8_t>& png);
    Result<void> end(const std::string& model);

  private:
    std::unique_ptr<backends::PartFile> file_;
    std::unique_ptr<backends::Package> package_;  ///< declared after file_, so destroyed before it
    std::vector<std::pair<std::string, std::string>> sheets_;
};

}  // namespace openfab::tools
