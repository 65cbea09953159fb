// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// XML by expat, element by element. The one place that knows the library.

#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab::scene {

/// Of one element; names without their namespace prefix.
class XmlAttributes {
  public:
    explicit XmlAttributes(const char** pairs) : pairs_(pairs) {}
    /// nullptr where there is none.
    const char* find(std::string_view name) const;
    /// The same, with the prefix as it stands in the file.
    const char* find_exact(std::string_view name) const;

  private:
    const char** pairs_;  ///< name, value, …, nullptr
};

class XmlHandler {
  public:
    virtual ~XmlHandler() = default;
    /// `name` without its namespace prefix. Returns what is wrong, empty where nothing is.
    virtual Complaint start(std::string_view name, const XmlAttributes& attributes) = 0;
    virtual void end(std::string_view name) = 0;
};

/// Errors have a place in `file`. Document types are refused: nothing here needs one, and
/// entities are how small files become large ones.
Result<void> parse_xml(std::string_view text, const std::string& file, XmlHandler* handler);

}  // namespace openfab::scene
