// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The documents that an editor has open, their analyses, and how places in sources are written as JSON.

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/json_text.h"
#include "compiler/server/analysis.h"
#include "compiler/server/text_document.h"

namespace openfab::server {

/// Returns the file of a `file:` URI; empty for others.
std::filesystem::path path_of_uri(std::string_view uri);
std::string uri_of_path(const std::filesystem::path& path);

struct Document {
    std::string uri;
    std::filesystem::path path;  ///< empty if it is not a file
    int64_t version = 0;
    TextDocument text;
    std::unique_ptr<Analysis> analysis;  ///< null until it is asked for
};

class Workspace {
  public:
    Encoding encoding = Encoding::kUtf16;

    Document& open(const std::string& uri, int64_t version, std::string text);
    void close(const std::string& uri);
    /// Returns null if it is not open.
    Document* find(std::string_view uri);
    std::map<std::string, Document, std::less<>>& documents() { return documents_; }
    const Analysis& analysis(Document* document);
    /// Forgets what is known of a document and of those that import it. Returns their URIs.
    std::vector<std::string> changed(const Document& document);
    /// Analyses what a document would be with another text.
    std::unique_ptr<Analysis> analyse(const Document& document, const std::string& text) const;

    /// Returns the text of `openfl:/stdlib/name.fl`, a module of the standard library; empty if there is none.
    static std::string library_text(std::string_view uri);

    void write(JsonText* out, const Position& position) const;
    void write(JsonText* out, const Range& range) const;
    /// Writes the range of a span.
    void write_span(JsonText* out, const source::SourceManager& sources,
                    const source::Span& span) const;
    /// Writes `{"uri", "range"}`.
    void write_location(JsonText* out, const Document& document,
                        const source::SourceManager& sources, const source::Span& span) const;

  private:
    OpenFiles open_files() const;

    std::map<std::string, Document, std::less<>> documents_;
};

}  // namespace openfab::server
