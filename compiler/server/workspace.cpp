// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/server/workspace.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/input_file.h"

namespace openfab::server {

namespace {

constexpr std::string_view kFile = "file://";
constexpr std::string_view kLibrary = "openfl:/";

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    const char low = static_cast<char>(c | 0x20);
    return low >= 'a' && low <= 'f' ? low - 'a' + 10 : -1;
}

}  // namespace

std::filesystem::path path_of_uri(std::string_view uri) {
    if (!uri.starts_with(kFile)) return {};
    uri.remove_prefix(kFile.size());
    // The authority, `localhost` or none.
    uri.remove_prefix(std::min(uri.find('/'), uri.size()));
    std::string out;
    for (size_t i = 0; i < uri.size(); ++i) {
        const int high = i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
        const int low = i + 2 < uri.size() ? hex_digit(uri[i + 2]) : -1;
        if (uri[i] == '%' && high >= 0 && low >= 0) {
            out += static_cast<char>(high * 16 + low);
            i += 2;
        } else {
            out += uri[i];
        }
    }
    // No file has such a name.
    return out.find('\0') == std::string::npos ? std::filesystem::path(out)
                                               : std::filesystem::path();
}

std::string uri_of_path(const std::filesystem::path& path) {
    std::string out(kFile);
    for (const char c : path.string()) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                           (c >= '0' && c <= '9') ||
                           std::string_view("/-._~").find(c) != std::string_view::npos;
        out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return out;
}

Document& Workspace::open(const std::string& uri, int64_t version, std::string text) {
    Document& document = documents_[uri];
    document.uri = uri;
    document.path = path_of_uri(uri);
    document.version = version;
    document.text.set(std::move(text));
    return document;
}

void Workspace::close(const std::string& uri) {
    documents_.erase(uri);
}

Document* Workspace::find(std::string_view uri) {
    const auto found = documents_.find(uri);
    return found == documents_.end() ? nullptr : &found->second;
}

OpenFiles Workspace::open_files() const {
    OpenFiles out;
    for (const auto& [uri, document] : documents_) {
        if (!document.path.empty()) out[document.path] = document.text.text();
    }
    return out;
}

const Analysis& Workspace::analysis(Document* document) {
    if (document->analysis == nullptr)
        document->analysis = analyse(*document, document->text.text());
    return *document->analysis;
}

std::unique_ptr<Analysis> Workspace::analyse(const Document& document,
                                             const std::string& text) const {
    return std::make_unique<Analysis>(document.path, text, open_files());
}

std::vector<std::string> Workspace::changed(const Document& document) {
    std::vector<std::string> out{document.uri};
    const std::filesystem::path path = without_links(document.path);
    for (auto& [uri, other] : documents_) {
        if (other.analysis == nullptr) continue;
        bool imports = false;
        if (uri != document.uri && !document.path.empty()) {
            for (const check::Unit& unit : other.analysis->units())
                imports =
                    imports || without_links(other.analysis->path_of(unit.file->end.file)) == path;
        }
        if (imports) out.push_back(uri);
        if (imports || uri == document.uri) other.analysis = nullptr;
    }
    return out;
}

std::string Workspace::library_text(std::string_view uri) {
    constexpr std::string_view kFolder = "openfl:/stdlib/";
    if (!uri.starts_with(kFolder) || !uri.ends_with(".fl")) return {};
    uri.remove_prefix(kFolder.size());
    return frontend::library_text(uri.substr(0, uri.size() - 3));
}

void Workspace::write(JsonText* out, const Position& position) const {
    out->begin_object()
        .member("line", position.line)
        .member("character", position.character)
        .end_object();
}

void Workspace::write(JsonText* out, const Range& range) const {
    out->begin_object().key("start");
    write(out, range.start);
    out->key("end");
    write(out, range.end);
    out->end_object();
}

void Workspace::write_span(JsonText* out, const source::SourceManager& sources,
                           const source::Span& span) const {
    const TextDocument text{std::string(sources.text(span.file))};
    write(out, text.range(span.begin, span.end, encoding));
}

void Workspace::write_location(JsonText* out, const Document& document,
                               const source::SourceManager& sources,
                               const source::Span& span) const {
    // Both managers of an analysis read the same files, but not in the same order.
    std::string uri = document.uri;
    if (span.file != Analysis::kDocument) {
        const std::filesystem::path folder = sources.folder(span.file);
        const std::filesystem::path name(std::string(sources.name(span.file)));
        uri = folder.empty() ? std::string(kLibrary) + name.string()
                             : uri_of_path(folder / name.filename());
    }
    out->begin_object().member("uri", uri).key("range");
    write_span(out, sources, span);
    out->end_object();
}

}  // namespace openfab::server
