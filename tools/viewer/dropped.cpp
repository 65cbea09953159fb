// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/dropped.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/replace_file.h"
#include "base/text.h"
#include "client/child.h"
#include "mesh/load/load_mesh.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/source_text.h"
#include "world/edit/world_edit.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr int64_t kLargestFile = int64_t{1} << 30;
constexpr int64_t kMostWords = 8 << 10;
constexpr std::array<std::string_view, 11> kPictures{
    ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".hdr", ".bmp", ".tga", ".gif", ".webp"};

/// A name of a file without folders, dots before it, and letters that cannot be printed.
bool is_plain(const std::string& name) {
    constexpr size_t kLongest = 120;
    return !name.empty() && name.size() <= kLongest && name[0] != '.' && name[0] != '-' &&
           std::none_of(name.begin(), name.end(), [](char c) {
               return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
           });
}

bool is_picture(const fs::path& file) {
    const std::string extension = lower_ascii(file.extension().string());
    return std::find(kPictures.begin(), kPictures.end(), extension) != kPictures.end();
}

/// Whether both hold the same bytes.
bool same_content(const fs::path& a, const fs::path& b) {
    std::error_code status;
    if (fs::file_size(a, status) != fs::file_size(b, status) || status) return false;
    std::ifstream first(a, std::ios::binary);
    std::ifstream second(b, std::ios::binary);
    constexpr size_t kBlock = 1 << 20;
    std::string one(kBlock, '\0');
    std::string two(kBlock, '\0');
    while (first && second) {
        first.read(one.data(), kBlock);
        second.read(two.data(), kBlock);
        if (first.gcount() != second.gcount() ||
            !std::equal(one.begin(), one.begin() + first.gcount(), two.begin()))
            return false;
    }
    return true;
}

/// Copies a file to a folder, where nothing of another content is replaced. Returns its name there.
Result<std::string> put_beside(const fs::path& file, const fs::path& folder) {
    constexpr int kMostTries = 1000;
    for (int i = 1; i < kMostTries; ++i) {
        const std::string name =
            i == 1 ? file.filename().string()
                   : fmt::format("{}-{}{}", file.stem().string(), i, file.extension().string());
        const fs::path to = folder / name;
        std::error_code status;
        if (fs::symlink_status(to, status).type() == fs::file_type::not_found) {
            if (Result<void> copied = copy_at_once(file, to); !copied) return copied.error();
            return name;
        }
        if (fs::is_regular_file(fs::symlink_status(to, status)) && same_content(file, to))
            return name;
    }
    return user_error(fmt::format(messages::kTooManyFilesLike, file.filename().string()));
}

/// What an import says, without where it put its own world.
std::string notes_of(const std::string& words) {
    std::string out;
    for (size_t from = 0; from < words.size();) {
        const size_t to = std::min(words.find('\n', from), words.size());
        const std::string_view line = std::string_view(words).substr(from, to - from);
        if (line.starts_with("note: ") || line.starts_with("warning: "))
            out += std::string(line) + '\n';
        from = to + 1;
    }
    return out;
}

/// A name that a section of the world does not have, or has for the same already.
std::string free_entry(const JsonValue& world, std::string_view section, const std::string& stem,
                       const std::string& value) {
    std::string compact;
    if (const Result<JsonValue> read = parse_json(value, stem); read) {
        JsonText as_text;
        as_text.value(*read);
        compact = as_text.take();
    }
    const JsonValue* there = member_of(world, section);
    for (int i = 1;; ++i) {
        std::string name = i == 1 ? stem : fmt::format("{}_{}", stem, i);
        const JsonValue* taken = there == nullptr ? nullptr : member_of(*there, name);
        if (taken == nullptr) return name;
        JsonText as_text;
        as_text.value(*taken);
        if (as_text.take() == compact) return name;
    }
}

}  // namespace

namespace {

std::string why_no_mesh(const fs::path& file) {
    const std::string name = file.filename().string();
    const std::string extension = lower_ascii(file.extension().string());
    if (extension == ".step" || extension == ".stp")
        return fmt::format(messages::kStepIsDropped, name);
    const std::string other = mesh::other_mesh_format(file);
    return other.empty() ? fmt::format(messages::kNeitherMeshNorPicture, name)
                         : fmt::format(messages::kOtherIsDropped, name, other);
}

/// A mesh that was repaired for an object alone, which has another one now, would be an error without its repair.
Result<void> forget_repaired(const JsonValue& before, const std::string& object,
                             const std::string& entry, bool repair, world::WorldEdit* edit) {
    const JsonValue* objects = member_of(before, "objects");
    const JsonValue* of = objects == nullptr ? nullptr : member_of(*objects, object);
    const JsonValue* mesh = of == nullptr ? nullptr : member_of(*of, "mesh");
    if (mesh == nullptr || mesh->text == entry || member_of(*of, "repair") == nullptr) return {};
    if (!repair) {
        const std::vector<std::string> path{"objects", object, "repair"};
        if (Result<void> done = edit->remove_at(path); !done) return done;
    }
    const auto uses = [&](const JsonMember& other) {
        const JsonValue* its = member_of(other.value, "mesh");
        return other.key != object && its != nullptr && its->text == mesh->text;
    };
    if (std::any_of(objects->members.begin(), objects->members.end(), uses)) return {};
    const std::vector<std::string> path{"meshes", mesh->text};
    return edit->remove_at(path);
}

}  // namespace

Result<void> Dropped::add(const std::string& name, int64_t at, const std::string& bytes) {
    if (!is_plain(name)) return user_error(messages::kNameCannotBeUsed);
    const std::lock_guard lock(mutex_);
    const fs::path file = scratch_ / name;
    std::error_code status;
    const auto there = at == 0 ? 0 : static_cast<int64_t>(fs::file_size(file, status));
    if (status || there != at) return user_error(messages::kPartMissing);
    if (at + static_cast<int64_t>(bytes.size()) > kLargestFile)
        return user_error(messages::kTooLargeToDrop);
    std::ofstream out(file, at == 0 ? std::ios::binary : std::ios::binary | std::ios::app);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) return outside_error(fmt::format(messages::kCannotWrite, file.string()));
    return {};
}

Result<Dropped::Made> Dropped::use_mesh(const fs::path& file, const std::string& object,
                                        const fs::path& world, const std::string& text,
                                        bool repair) const {
    if (!mesh::is_mesh_file(file.string())) return user_error(why_no_mesh(file));
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create(scratch_);
    if (!folder) return folder.error();
    const fs::path made = (*folder)->path() / "made";
    const fs::path err = (*folder)->path() / "import.err";
    std::vector<std::string> argv{(programs_ / "openfab").string(),
                                  "import",
                                  as_argument(file),
                                  "--fablet",
                                  "solid",
                                  "--one-material",
                                  "--output",
                                  made.string()};
    if (repair) argv.insert(argv.end(), {"--repair", "winding"});
    for (const std::string& word : client::memory_words())
        argv.push_back(word);
    Result<std::unique_ptr<client::Child>> child =
        client::Child::start(argv, (*folder)->path() / "import.out", err);
    if (!child) return child.error();
    const int code = (*child)->wait();
    const std::string words = client::end_of_file(err, kMostWords);
    if (code != 0) {
        const bool mendable = !repair && words.find("winding") != std::string::npos;
        const std::string said = words.substr(words.starts_with("error: ") ? 7 : 0);
        return user_error((said.empty() ? std::string(messages::kImportFailed) : said) +
                          (mendable ? messages::kCanBeRepaired : ""));
    }
    const Result<std::string> imported = read_source(made / (file.stem().string() + ".fab.json"));
    if (!imported) return imported.error();
    const Result<JsonValue> json = parse_json(*imported, "openfab import");
    const JsonValue* meshes = json ? member_of(*json, "meshes") : nullptr;
    const JsonValue* of_file = meshes == nullptr || meshes->members.empty()
                                   ? nullptr
                                   : member_of(meshes->members[0].value, "file");
    if (of_file == nullptr) return internal_error(messages::kImportMadeNoMesh);
    Made out{text, notes_of(words), {}, true};
    if (meshes->members.size() > 1)
        out.notes += fmt::format(messages::kFirstMeshShown, meshes->members.size());
    const Result<std::string> name = put_beside(made / of_file->text, world.parent_path());
    if (!name) return name.error();
    // Spaced as people write it.
    std::string value;
    for (const JsonMember& member : meshes->members[0].value.members) {
        JsonText of_member;
        member.key == "file" ? of_member.value(*name) : of_member.value(member.value);
        value += fmt::format("{}{}: {}", value.empty() ? "{" : ", ", json_string(member.key),
                             of_member.take());
    }
    value += "}";
    Result<world::WorldEdit> edit = world::WorldEdit::of_text(text, world.filename().string());
    if (!edit) return edit.error();
    const Result<JsonValue> before = parse_json(text, world.filename().string());
    if (!before) return before.error();
    out.entry = free_entry(edit->tree(), "meshes", file.stem().string(), value);
    Result<void> changed = edit->set_entry("meshes", out.entry, value);
    if (changed) changed = edit->set_of_object(object, "mesh", json_string(out.entry));
    if (changed && repair) changed = edit->set_of_object(object, "repair", json_string("winding"));
    if (changed) changed = forget_repaired(*before, object, out.entry, repair, &*edit);
    if (!changed) return changed.error();
    out.world = edit->text();
    return out;
}

Result<Dropped::Made> Dropped::use(const std::string& name, const std::string& object,
                                   const fs::path& world, const std::string& text, bool repair) {
    if (!is_plain(name)) return user_error(messages::kNameCannotBeUsed);
    const std::lock_guard lock(mutex_);
    const fs::path file = scratch_ / name;
    std::error_code status;
    if (!fs::is_regular_file(file, status))
        return user_error(fmt::format(messages::kHasNotCome, name));
    if (!is_picture(file)) return use_mesh(file, object, world, text, repair);
    Result<world::WorldEdit> edit = world::WorldEdit::of_text(text, world.filename().string());
    if (!edit) return edit.error();
    const Result<std::string> put = put_beside(file, world.parent_path());
    if (!put) return put.error();
    const std::string value = fmt::format("{{\"file\": {}}}", json_string(*put));
    Made out;
    out.entry = free_entry(edit->tree(), "textures", file.stem().string(), value);
    out.notes = fmt::format(messages::kTextureOfWorld, out.entry);
    if (Result<void> changed = edit->set_entry("textures", out.entry, value); !changed)
        return changed.error();
    out.world = edit->text();
    return out;
}

}  // namespace openfab::viewer
