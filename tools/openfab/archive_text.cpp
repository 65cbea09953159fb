// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// archive.json and record.html of an archive.

#include <fmt/format.h>

#include "backends/common/xml_text.h"
#include "base/json_text.h"
#include "base/sha256.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/openfab/archive.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

void write_files(const char* name, const std::vector<ArchivedFile>& files, JsonText* out) {
    out->key(name).begin_array();
    for (const ArchivedFile& file : files) {
        out->begin_object().member("entry", file.entry).member("path", file.path);
        out->member("bytes", file.bytes).member("sha256", file.sha256);
        out->member("executable", file.executable).end_object();
    }
    out->end_array();
}

/// Reads members of archive.json, and remembers what is wrong.
class Members {
  public:
    explicit Members(const JsonValue& object) : object_(object) {}
    const JsonValue* member(const char* name, JsonValue::Kind kind) {
        const JsonValue* value =
            object_.is(JsonValue::Kind::kObject) ? member_of(object_, name) : nullptr;
        if (value != nullptr && value->is(kind)) return value;
        wrong_ = wrong_.empty() ? name : wrong_;
        return nullptr;
    }
    std::string text(const char* name) {
        const JsonValue* value = member(name, JsonValue::Kind::kString);
        return value == nullptr ? std::string() : value->text;
    }
    bool truth(const char* name) {
        const JsonValue* value = member(name, JsonValue::Kind::kBool);
        return value != nullptr && value->boolean;
    }
    int64_t count(const char* name) {
        constexpr double kMost = 9e15;
        const JsonValue* value = member(name, JsonValue::Kind::kNumber);
        if (value != nullptr && value->number >= 0 && value->number < kMost)
            return static_cast<int64_t>(value->number);
        wrong_ = wrong_.empty() ? name : wrong_;
        return 0;
    }
    /// Reads a list of texts, or a list of lists of them.
    std::vector<std::string> texts(const JsonValue& list) {
        std::vector<std::string> out;
        for (const JsonValue& one : list.items) {
            if (!one.is(JsonValue::Kind::kString)) wrong_ = "a list of texts";
            out.push_back(one.text);
        }
        return out;
    }
    std::vector<std::vector<std::string>> lists(const char* name) {
        std::vector<std::vector<std::string>> out;
        const JsonValue* value = member(name, JsonValue::Kind::kArray);
        for (size_t i = 0; value != nullptr && i < value->items.size(); ++i)
            out.push_back(texts(value->items[i]));
        return out;
    }
    const std::string& wrong() const { return wrong_; }

  private:
    const JsonValue& object_;
    std::string wrong_;
};

/// A path that stays below the folder where it is unpacked, on any system.
bool is_inside(const std::string& path) {
    if (path.empty() || path.size() > 4000 || path.front() == '/' || path.back() == '/')
        return false;
    for (size_t at = 0; at <= path.size();) {
        const size_t end = std::min(path.find('/', at), path.size());
        const std::string_view name = std::string_view(path).substr(at, end - at);
        if (name.empty() || name == "." || name == ".." || name.size() > 255) return false;
        at = end + 1;
    }
    return path.find('\0') == std::string::npos && path.find('\\') == std::string::npos;
}

std::string read_files(const JsonValue& list, std::vector<ArchivedFile>* files) {
    for (const JsonValue& each : list.items) {
        Members in(each);
        ArchivedFile& file = files->emplace_back();
        file.entry = in.text("entry");
        file.path = in.text("path");
        file.bytes = in.count("bytes");
        file.sha256 = in.text("sha256");
        file.executable = in.truth("executable");
        if (!in.wrong().empty()) return in.wrong();
        if (!is_inside(file.path)) return "path";
    }
    return {};
}

std::string escaped(const std::string& text) {
    return backends::escape_xml(printable(text));
}

std::string row(const std::string& name, const std::string& value) {
    return fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(name), escaped(value));
}

std::string table_of(const std::vector<ArchivedFile>& files) {
    std::string out = "<table>\n<tr><th>file</th><th>bytes</th><th>SHA-256</th></tr>\n";
    for (const ArchivedFile& file : files) {
        out += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"d\">{}</td></tr>\n",
                           escaped(file.path), file.bytes, escaped(file.sha256));
    }
    return out + "</table>\n";
}

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<title>{0}</title>
<style>
body {{ font: 11pt/1.4 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #111; background: #fff }}
table {{ border-collapse: collapse; width: 100% }}
th, td {{ text-align: left; vertical-align: top; padding: 2px 10px 2px 0; border-bottom: 1px solid #ccc; overflow-wrap: anywhere }}
th {{ font-weight: 600; min-width: 9em }}
.d, code {{ font: 9pt monospace }}
.line {{ border-bottom: 1px solid #111; height: 3em }}
</style>
</head>
<body>
<h1>{0}</h1>
)";

}  // namespace

std::string archive_json(const Archive& archive) {
    JsonText out;
    out.begin_object().member("format", "openfab.archive").member("version", 1);
    out.member("title", archive.title).member("output_format", archive.format);
    out.member("hash", archive.hash).key("printer").begin_object();
    out.member("name", archive.printer).member("sha256", archive.printer_sha256).end_object();
    out.key("provenance").begin_array();
    for (const auto& [name, value] : archive.provenance)
        out.begin_array().value(name).value(value).end_array();
    out.end_array().member("folder", archive.folder).key("options").begin_array();
    for (const job::OptionWords& option : archive.options) {
        out.begin_array().value(option.name);
        for (const std::string& value : option.values)
            out.value(value);
        out.end_array();
    }
    out.end_array().key("programs").begin_array();
    for (const std::vector<std::string>& command : archive.programs) {
        out.begin_array();
        for (const std::string& word : command)
            out.value(word);
        out.end_array();
    }
    out.end_array().member("checked", archive.checked).member("operator", archive.person);
    out.member("page_sha256", archive.page_sha256);
    out.key("story").begin_array();
    for (const std::string& line : archive.story)
        out.value(line);
    out.end_array();
    write_files("files", archive.files, &out);
    write_files("attached", archive.attached, &out);
    return out.end_object().take() + "\n";
}

Result<Archive> parse_archive(const std::string& text, const std::string& name) {
    const auto wrong = [&](const std::string& what) {
        return user_error(fmt::format(messages::kArchiveWrong, name, what));
    };
    const Result<JsonValue> root = parse_json(text, name);
    if (!root) return root.error();
    Members in(*root);
    if (in.text("format") != "openfab.archive" || in.count("version") != 1) return wrong("format");
    Archive out;
    out.title = in.text("title");
    out.format = in.text("output_format");
    out.hash = in.text("hash");
    out.folder = in.text("folder");
    out.checked = in.truth("checked");
    out.person = in.text("operator");
    if (root->is(JsonValue::Kind::kObject) && member_of(*root, "page_sha256") != nullptr)
        out.page_sha256 = in.text("page_sha256");
    if (const JsonValue* printer = in.member("printer", JsonValue::Kind::kObject)) {
        Members of(*printer);
        out.printer = of.text("name");
        out.printer_sha256 = of.text("sha256");
        if (!of.wrong().empty()) return wrong("printer");
    }
    for (const std::vector<std::string>& pair : in.lists("provenance")) {
        if (pair.size() != 2) return wrong("provenance");
        out.provenance.emplace_back(pair[0], pair[1]);
    }
    for (std::vector<std::string>& words : in.lists("options")) {
        if (words.empty()) return wrong("options");
        out.options.push_back({words[0], {words.begin() + 1, words.end()}});
    }
    out.programs = in.lists("programs");
    for (const std::vector<std::string>& command : out.programs) {
        if (command.empty()) return wrong("programs");
    }
    for (const auto& [key, files] :
         {std::pair("files", &out.files), std::pair("attached", &out.attached)}) {
        const JsonValue* list = in.member(key, JsonValue::Kind::kArray);
        if (list == nullptr) continue;
        if (const std::string what = read_files(*list, files); !what.empty()) return wrong(what);
    }
    if (!in.wrong().empty()) return wrong(in.wrong());
    if (!out.folder.empty() && !is_inside(out.folder)) return wrong("folder");
    return out;
}

std::string archive_page(const Archive& archive, const std::string& json_sha256) {
    std::string out = fmt::format(fmt::runtime(kHead), escaped("Record of " + archive.title));
    out += "<h2>Print</h2>\n<table>\n";
    out += row("hash of the voxels", archive.hash) + row("format", archive.format);
    out += row("printer", archive.printer) + row("profile's SHA-256", archive.printer_sha256);
    for (const auto& [name, value] : archive.provenance)
        out += row(name, value);
    for (const job::OptionWords& option : archive.options) {
        std::string values;
        for (const std::string& value : option.values)
            values += (values.empty() ? "" : ", ") + value;
        out += row(option.name == "INPUT" ? "input" : option.name, values);
    }
    for (const std::vector<std::string>& command : archive.programs) {
        std::string words;
        for (const std::string& word : command)
            words += (words.empty() ? "" : " ") + shell_word(word);
        out += row("program", words);
    }
    out += "</table>\n<h2>Inputs</h2>\n" + table_of(archive.files);
    out += "<h2>Making</h2>\n<table>\n";
    for (const std::string& line : archive.story)
        out += row("event", line);
    out += row("slices", "every slice was read and has its checksum when this record was made");
    out += row("details that the machine will not print well",
               archive.checked ? "looked for before the print; none found"
                               : "not looked for before the print");
    out += "</table>\n<h2>Checks and mechanics</h2>\n";
    out +=
        archive.attached.empty() ? "<p>No reports are attached.</p>\n" : table_of(archive.attached);
    out += "<h2>Signature</h2>\n<table>\n";
    out += fmt::format(
        "<tr><th>archive.json, SHA-256</th><td class=\"d\">{}</td></tr>\n"
        "<tr><th>operator</th><td class=\"line\">{}</td></tr>\n"
        "<tr><th>date</th><td class=\"line\"></td></tr>\n"
        "<tr><th>signature</th><td class=\"line\"></td></tr>\n</table>\n</body>\n</html>\n",
        json_sha256, escaped(archive.person));
    return out;
}

bool is_page_of(const Archive& archive, const std::string& json, std::string page) {
    const std::string digest = hex_text(sha256(json));
    const size_t at = page.find(digest);
    if (at == std::string::npos) return false;
    page.erase(at, digest.size());
    return hex_text(sha256(page)) == archive.page_sha256;
}

}  // namespace openfab::tools
