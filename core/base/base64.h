// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Base64 (RFC 4648), as glTF and VTK files embed bytes in text.

#include <cstdint>
#include <string>
#include <string_view>

namespace openfab {

/// Decodes text that comes in pieces. Padding ends a run of bytes; another may follow it, as behind the
/// header of compressed VTK data. Blanks and line ends are skipped.
class Base64Decoder {
  public:
    /// Appends the bytes of `text`. Returns false where a character is none of base64.
    bool add(std::string_view text, std::string* out);

  private:
    uint32_t bits_ = 0;
    int held_ = 0;  ///< bits
};

/// Returns the decoded bytes; empty if the text is not valid base64.
std::string decode_base64(std::string_view text);

}  // namespace openfab
