// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// XML parsing by expat, element by element. The only file that uses the library.

#include <string>
#include <string_view>

#include "base/result.h"

namespace openfab {

/// The attributes of one element; names are without namespace prefix.
class XmlAttributes {
  public:
    explicit XmlAttributes(const char** pairs) : pairs_(pairs) {}
    /// Returns the value of an attribute, or nullptr.
    const char* find(std::string_view name) const;
    /// Same, for a name with the prefix that the file uses.
    const char* find_exact(std::string_view name) const;
    /// Calls visit(name, value) for each, in the order of the file.
    template <typename Visit>
    void each(const Visit& visit) const {
        for (const char** p = pairs_; *p != nullptr; p += 2) {
            const std::string_view name = p[0];
            visit(name.substr(name.rfind(':') + 1), p[1]);
        }
    }

  private:
    const char** pairs_;  ///< name, value, …, nullptr
};

/// Receives the elements.
class XmlHandler {
  public:
    virtual ~XmlHandler() = default;
    /// Begins an element; `name` is without namespace prefix. Returns an error text, empty if none.
    virtual Complaint start(std::string_view name, const XmlAttributes& attributes) = 0;
    virtual void end(std::string_view name) = 0;
    /// Text between tags, in pieces, where `wants_text` says so: it is asked before the first tag and after
    /// each.
    virtual bool wants_text() const { return false; }
    virtual void text(std::string_view) {}
    /// Whether the file may name a document type, as XDMF does. What that type is, is not read.
    virtual bool allows_document_type() const { return false; }
};

/// Parses `text`; errors are located in `file`. Document types are refused unless the handler allows their
/// name, and what they declare in any case: none of it is needed here, and entities can expand a small file
/// into a large one.
Result<void> parse_xml(std::string_view text, const std::string& file, XmlHandler* handler);

}  // namespace openfab
