// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/xml.h"

#include <expat.h>
#include <fmt/format.h>

#include <memory>
#include <type_traits>
#include <utility>

#include "base/messages.h"

namespace openfab {
namespace {

constexpr int kMaxDepth = 64;
/// Limit of a tag with its attributes, or of a comment. Expat buffers it whole and rescans it from
/// its start for each piece of input.
constexpr int64_t kLongestToken = 32'000'000;

// Expat 2.9 deprecates those whose names do not end in 64, which older ones have alone.
#if XML_MAJOR_VERSION > 2 || XML_MINOR_VERSION >= 9
#define OPENFAB_EXPAT(function) function##64
#else
#define OPENFAB_EXPAT(function) function
#endif

std::string_view without_prefix(std::string_view name) {
    const size_t colon = name.rfind(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

struct Parse {
    XML_Parser parser = nullptr;
    XmlHandler* handler = nullptr;
    int depth = 0;
    bool with_text = false;
    SourceLocation location;  ///< of the file; where parsing stopped, once it did
    Complaint wrong;

    void stop(Complaint why) {
        keep(std::move(why));
        XML_StopParser(parser, XML_FALSE);
    }
    /// The first error, at the parser's location.
    void keep(Complaint why) {
        if (!wrong.empty()) return;
        wrong = std::move(why);
        location.line = static_cast<int32_t>(OPENFAB_EXPAT(XML_GetCurrentLineNumber)(parser));
        location.column =
            static_cast<int32_t>(OPENFAB_EXPAT(XML_GetCurrentColumnNumber)(parser)) + 1;
    }
};

void on_text(void* data, const char* text, int bytes);

/// Text costs a call for the blanks between any two tags.
void ask_for_text(Parse* parse) {
    if (parse->handler->wants_text() == parse->with_text) return;
    parse->with_text = !parse->with_text;
    XML_SetCharacterDataHandler(parse->parser, parse->with_text ? on_text : nullptr);
}

void on_start(void* data, const char* name, const char** attributes) {
    auto* parse = static_cast<Parse*>(data);
    if (!parse->wrong.empty()) return;
    if (++parse->depth > kMaxDepth) return parse->stop(messages::kNestedElements);
    Complaint wrong = parse->handler->start(without_prefix(name), XmlAttributes(attributes));
    if (!wrong.empty()) return parse->stop(std::move(wrong));
    ask_for_text(parse);
}

void on_end(void* data, const char* name) {
    auto* parse = static_cast<Parse*>(data);
    if (!parse->wrong.empty()) return;
    --parse->depth;
    parse->handler->end(without_prefix(name));
    ask_for_text(parse);
}

void on_text(void* data, const char* text, int bytes) {
    auto* parse = static_cast<Parse*>(data);
    if (parse->wrong.empty()) parse->handler->text({text, static_cast<size_t>(bytes)});
}

void on_document_type(void* data, const char*, const char*, const char*, int) {
    static_cast<Parse*>(data)->stop(messages::kDocumentType);
}

void on_entity(void* data, const char*, int, const char*, int, const char*, const char*,
               const char*, const char*) {
    static_cast<Parse*>(data)->stop(messages::kEntityDeclaration);
}

void on_attributes(void* data, const char*, const char*, const char*, const char*, int) {
    static_cast<Parse*>(data)->stop(messages::kAttributeDeclaration);
}

void on_unknown_entity(void* data, const char* name, int) {
    static_cast<Parse*>(data)->stop(fmt::format(messages::kUnknownEntity, name));
}

}  // namespace

const char* XmlAttributes::find(std::string_view name) const {
    for (const char** p = pairs_; *p != nullptr; p += 2) {
        if (without_prefix(p[0]) == name) return p[1];
    }
    return nullptr;
}

const char* XmlAttributes::find_exact(std::string_view name) const {
    for (const char** p = pairs_; *p != nullptr; p += 2) {
        if (p[0] == name) return p[1];
    }
    return nullptr;
}

Result<void> parse_xml(std::string_view text, const std::string& file, XmlHandler* handler) {
    const std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser(
        XML_ParserCreate(nullptr), &XML_ParserFree);
    if (parser == nullptr) return outside_error(messages::kOutOfMemory);
    Parse parse{parser.get(), handler, 0, false, {file, 0, 0}, {}};
    XML_SetUserData(parser.get(), &parse);
    XML_SetElementHandler(parser.get(), on_start, on_end);
    ask_for_text(&parse);
    if (!handler->allows_document_type())
        XML_SetStartDoctypeDeclHandler(parser.get(), on_document_type);
    XML_SetEntityDeclHandler(parser.get(), on_entity);
    XML_SetAttlistDeclHandler(parser.get(), on_attributes);
    XML_SetSkippedEntityHandler(parser.get(), on_unknown_entity);
    // Parses in pieces, as expat's length is an int.
    constexpr size_t kPiece = 1 << 24;
    for (size_t at = 0;; at += kPiece) {
        const std::string_view piece = text.substr(at, kPiece);
        const bool last = at + kPiece >= text.size();
        const XML_Status status =
            XML_Parse(parser.get(), piece.data(), static_cast<int>(piece.size()), last);
        if (status != XML_STATUS_OK) {
            const XML_Error code = XML_GetErrorCode(parser.get());
            parse.keep(XML_ErrorString(code));
            return parse.wrong.at(parse.location);
        }
        if (last) return Ok{};
        const int64_t token = OPENFAB_EXPAT(XML_GetCurrentByteIndex)(parser.get());
        if (token >= 0 && static_cast<int64_t>(at + piece.size()) - token > kLongestToken) {
            parse.keep(fmt::format(messages::kLongToken, kLongestToken / 1'000'000));
            return parse.wrong.at(parse.location);
        }
    }
}

}  // namespace openfab
