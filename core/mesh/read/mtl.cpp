// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/mtl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/color.h"
#include "base/input_file.h"
#include "base/plain_text.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/read/beside_files.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kLargestLibrary = 64'000'000;
constexpr size_t kMostLibraries = 100;
constexpr std::string_view kBlanks = " \t\r";

using Rgb = std::array<double, 3>;

bool is_blank(char c) {
    return kBlanks.find(c) != std::string_view::npos;
}

/// Removes and returns the first word of a line.
std::string_view take_first(std::string_view* line) {
    *line = without_blanks(*line);
    const std::string_view word = line->substr(0, line->find_first_of(kBlanks));
    *line = without_blanks(line->substr(word.size()));
    return word;
}

std::string_view without_quotes(std::string_view name) {
    const bool quoted = name.size() > 1 && name.front() == '"' && name.back() == '"';
    return quoted ? name.substr(1, name.size() - 2) : name;
}

/// A picture as a statement names it.
struct MapStatement {
    std::string_view name;
    std::array<double, 2> scale{1, 1}, offset{0, 0};
    bool clamp = false;
    PictureUse::Space space = PictureUse::Space::kOwn;
    std::vector<std::string_view> changes;  ///< options that change how it looks
};

/// Removes and returns up to three numbers; `missing` stands for those that are not there.
Rgb take_numbers(std::string_view* line, double missing) {
    Rgb numbers{missing, missing, missing};
    for (double& number : numbers) {
        std::string_view rest = *line;
        if (!scan_number(take_first(&rest), &number).empty()) {
            number = missing;
            break;
        }
        *line = rest;
    }
    return numbers;
}

MapStatement read_map(std::string_view line) {
    MapStatement out;
    while (line.starts_with('-')) {
        std::string_view rest = line;
        const std::string option = lower_ascii(std::string(take_first(&rest)));
        const std::string_view shown = line.substr(0, option.size());
        if (option == "-clamp") {
            out.clamp = lower_ascii(std::string(take_first(&rest))) == "on";
        } else if (option == "-colorspace") {  // of tinyobjloader, and of tools/usd
            const std::string value = lower_ascii(std::string(take_first(&rest)));
            if (value == "srgb") out.space = PictureUse::Space::kSrgb;
            if (value == "linear") out.space = PictureUse::Space::kLinear;
        } else if (option == "-o") {
            const Rgb n = take_numbers(&rest, 0);
            out.offset = {n[0], n[1]};
        } else if (option == "-s") {
            const Rgb n = take_numbers(&rest, 1);
            out.scale = {n[0], n[1]};
        } else if (option == "-t") {
            if (take_numbers(&rest, 0) != Rgb{}) out.changes.push_back(shown);
        } else if (option == "-mm") {
            double base = 0, gain = 1;
            const bool numbers = scan_number(take_first(&rest), &base).empty() &&
                                 scan_number(take_first(&rest), &gain).empty();
            if (!numbers || base != 0 || gain != 1) out.changes.push_back(shown);
        } else if (option == "-cc" || option == "-imfchan") {
            const std::string value = lower_ascii(std::string(take_first(&rest)));
            if (value != "off" && value != "m") out.changes.push_back(shown);
        } else if (option == "-bm" || option == "-boost" || option == "-texres" ||
                   option == "-type" || option == "-blendu" || option == "-blendv") {
            take_first(&rest);  // how it is filtered, or of other maps
        } else {
            break;  // a file may have such a name
        }
        line = rest;
    }
    out.name = without_quotes(without_comment(line));
    return out;
}

/// Reads the materials of one library.
class LibraryReader {
  public:
    /// `folder` is the library's, relative to the mesh's.
    LibraryReader(const fs::path& mesh, const fs::path& library, fs::path folder)
        : mesh_(mesh), library_(library), folder_(std::move(folder)) {}

    /// Takes the line behind its number; returns the material that it ends.
    std::optional<MtlMaterial> take(std::string_view line, int32_t number) {
        line = without_blanks(line);
        // Blender writes linear light without a conversion, and reads it so.
        if (number == 1 && line.starts_with("# Blender")) linear_ = true;
        // Of a file whose format says where alpha counts (tools/usd).
        if (number == 1 && line.starts_with("# OpenFab: opaque pictures")) opaque_ = true;
        if (line.empty() || line.starts_with('#')) return {};
        line_ = number;
        const std::string word = lower_ascii(std::string(take_first(&line)));
        if (word == "newmtl") {
            std::optional<MtlMaterial> ended = finish();
            begin(line);
            return ended;
        }
        if (open_) statement(word, line);
        return {};
    }

    std::optional<MtlMaterial> finish() {
        if (!open_) return {};
        open_ = false;
        Look& look = now_.look;
        const bool dark = !look.color || *look.color == Rgb{};
        if (dark && !look.picture && glow_map_) picture(read_map(*glow_map_));
        if (dark && !look.picture && glow_ && *glow_ != Rgb{}) look.color = glow_;
        if (!look.picture && ambient_map_) {
            tell(messages::kAmbientPicture, messages::kAmbientPictureHelp);
        }
        if (transparency_ && !opacity_) {
            // Some programs write 1 for what is opaque.
            look.alpha = *transparency_ >= 1 ? 1 : 1 - *transparency_;
            if (*transparency_ >= 1) tell(messages::kTransparencyTrOne, "write `d`");
        }
        if (opacity_) look.alpha = *opacity_;
        if (opacity_map_ && (!look.picture || *opacity_map_ != color_map_)) {
            tell(messages::kPictureOfOpacity, messages::kPictureOfOpacityHelp);
        }
        return std::move(now_);
    }

  private:
    void begin(std::string_view name) {
        now_ = {};
        now_.look.name = utf8_or_latin1(without_comment(name));
        glow_.reset();
        glow_map_.reset();
        transparency_.reset();
        opacity_.reset();
        opacity_map_.reset();
        ambient_map_ = false;
        color_map_.clear();
        open_ = true;
    }

    std::string place() const { return SourceLocation{library_.string(), line_, 1}.str(); }
    void tell(const std::string& what, const std::string& remedy) {
        for (LeftOut& known : now_.left_out) {
            if (known.what == what) return;
        }
        // Unknown words may all be different.
        constexpr size_t kMost = 40;
        if (now_.left_out.size() < kMost) now_.left_out.push_back({what, place(), remedy, 1});
    }

    /// Reads a colour, in sRGB unless Blender wrote it; none if it is given in another way.
    std::optional<Rgb> color(std::string_view line, const std::string& word) {
        std::string_view rest = line;
        const std::string first = lower_ascii(std::string(take_first(&rest)));
        if (first == "spectral" || first == "xyz") {
            tell(fmt::format(messages::kColourAs, word, first), messages::kColourAsHelp);
            return {};
        }
        Rgb rgb{};
        double given = 0;
        if (!scan_number(first, &rgb[0]).empty()) {
            tell(fmt::format(messages::kColourNoNumber, word), messages::kColourNoNumberHelp);
            return {};
        }
        // One number is grey.
        rgb[1] = rgb[2] = rgb[0];
        if (scan_number(take_first(&rest), &given).empty()) {
            rgb[1] = given;
            rgb[2] = 0;
            if (scan_number(take_first(&rest), &given).empty()) rgb[2] = given;
        }
        const double largest = *std::max_element(rgb.begin(), rgb.end());
        const bool bytes = largest > 1 && largest <= 255 &&
                           std::all_of(rgb.begin(), rgb.end(),
                                       [](double c) { return c >= 0 && c == std::floor(c); });
        if (bytes) tell(messages::kRangeOfColour, messages::kRangeOfColourHelp);
        for (double& channel : rgb) {
            channel = std::clamp(bytes ? channel / 255 : channel, 0.0, 1.0);
            if (!linear_) channel = srgb_to_linear(channel);
        }
        return rgb;
    }

    static std::optional<double> fraction(std::string_view line) {
        double value = 0;
        std::string_view word = take_first(&line);
        if (word == "-halo") word = take_first(&line);
        if (!scan_number(word, &value).empty()) return {};
        return std::clamp(value, 0.0, 1.0);
    }

    void statement(const std::string& word, std::string_view line) {
        Look& look = now_.look;
        if (word == "kd") {
            if (const std::optional<Rgb> rgb = color(line, "Kd")) look.color = rgb;
        } else if (word == "ke") {
            glow_ = color(line, "Ke");
        } else if (word == "d") {
            if (line.starts_with("-halo"))
                tell(messages::kOpacityOfDirection, messages::kOpacityOfDirectionHelp);
            opacity_ = fraction(line);
        } else if (word == "tr") {
            transparency_ = fraction(line);
        } else if (word == "map_kd") {
            color_map_ = line;
            picture(read_map(line));
        } else if (word == "map_ke") {
            glow_map_ = std::string(line);
        } else if (word == "map_ka") {
            ambient_map_ = true;
        } else if (word == "map_d" || word == "map_tr" || word == "map_opacity") {
            opacity_map_ = std::string(line);
        } else if (word == "map_bump" || word == "bump" || word == "norm" || word == "map_norm" ||
                   word == "map_kn") {
            tell(fmt::format(messages::kBumpMap, word), messages::kBumpMapHelp);
        } else if (word == "disp" || word == "map_disp") {
            tell(messages::kDisplacementMap, messages::kDisplacementMapHelp);
        } else if (word == "decal") {
            tell("a `decal`", messages::kPaintIntoMapKd);
        } else if (word == "tf") {
            const std::optional<Rgb> filter = color(line, "Tf");
            if (filter && *filter != Rgb{1, 1, 1})
                tell(messages::kColourThatShinesThrough, messages::kColourThatShinesThroughHelp);
        } else if (word.starts_with("map_") || word == "refl") {
            if (word != "map_aat")
                tell(fmt::format(messages::kPictureOfGloss, word), messages::kPictureOfGlossHelp);
        } else if (!is_silent(word)) {
            tell(fmt::format(messages::kStatementOfMaterial, printable(word.substr(0, 40))),
                 messages::kStatementOfMaterialHelp);
        }
    }

    /// Gloss and how a renderer treats it: numbers that most programs write for each material.
    static bool is_silent(const std::string& word) {
        static constexpr std::string_view kWords[] = {
            "ka", "ks", "ns",  "ni",    "illum",  "sharpness", "pr", "pm",
            "ps", "pc", "pcr", "aniso", "anisor", "km",        "tf", "bump_gain"};
        return std::find(std::begin(kWords), std::end(kWords), word) != std::end(kWords);
    }

    void picture(const MapStatement& map) {
        if (map.name.empty()) return;
        std::string_view name = map.name;
        const fs::path folder = folder_of(mesh_) / folder_;
        if (const std::string_view cut = before_last_mark(name);
            !cut.empty() && !find_beside(mesh_, folder, name) && find_beside(mesh_, folder, cut))
            name = cut;
        PictureUse use;
        const fs::path named = with_slashes(name);
        use.source = (folder_.empty() ? named : folder_ / named).string();
        use.name = utf8_or_latin1(named.filename().string());
        if (opaque_) use.alpha = PictureUse::Alpha::kOpaque;
        use.space = map.space;
        if (map.clamp) use.wrap = {PictureWrap::kClamp, PictureWrap::kClamp};
        now_.look.picture = std::move(use);
        now_.scale = map.scale;
        now_.offset = map.offset;
        for (const std::string_view option : map.changes)
            tell(fmt::format(messages::kOptionOfPicture, option), messages::kOptionOfPictureHelp);
    }

    const fs::path& mesh_;
    const fs::path& library_;
    fs::path folder_;
    int32_t line_ = 0;
    bool open_ = false;
    bool linear_ = false;  ///< colours are linear light
    bool opaque_ = false;  ///< the alpha of pictures does not count
    MtlMaterial now_;
    std::optional<Rgb> glow_;
    std::optional<double> transparency_, opacity_;
    std::optional<std::string> glow_map_, opacity_map_;
    std::string color_map_;
    bool ambient_map_ = false;
};

int64_t bytes_of(const MtlMaterial& material) {
    // The list doubles and is copied then; the map holds the name again.
    constexpr size_t kNode = 96;
    const Look& look = material.look;
    size_t bytes = 3 * sizeof material + kNode + 2 * look.name.size();
    if (look.picture) bytes += look.picture->source.size() + look.picture->name.size();
    for (const LeftOut& left : material.left_out)
        bytes += 2 * sizeof left + left.what.size() + left.place.size() + left.remedy.size();
    return static_cast<int64_t>(bytes);
}

}  // namespace

std::string_view without_blanks(std::string_view text) {
    const size_t start = text.find_first_not_of(kBlanks);
    if (start == std::string_view::npos) return {};
    return text.substr(start, text.find_last_not_of(kBlanks) - start + 1);
}

std::string_view without_comment(std::string_view text) {
    for (size_t at = text.find('#'); at != std::string_view::npos; at = text.find('#', at + 1)) {
        const bool alone = (at == 0 || is_blank(text[at - 1])) &&
                           (at + 1 == text.size() || is_blank(text[at + 1]));
        if (alone) return without_blanks(text.substr(0, at));
    }
    return without_blanks(text);
}

std::string_view before_last_mark(std::string_view text) {
    for (size_t at = text.rfind('#'); at != std::string_view::npos && at > 0;
         at = text.rfind('#', at - 1)) {
        if (is_blank(text[at - 1])) return without_blanks(text.substr(0, at));
    }
    return {};
}

Result<void> MtlLibraries::add(std::string_view names, const std::string& place) {
    names = without_blanks(names);
    if (names.empty() || known_.size() > kMostLibraries) return Ok{};
    if (!known_.insert(std::string(names)).second) return Ok{};
    if (known_.size() > kMostLibraries)
        return user_error(fmt::format(messages::kTooManyLibraries, mesh_.string(), kMostLibraries));
    const auto find = [&](std::string_view name) {
        return find_beside(mesh_, folder_of(mesh_), without_quotes(name));
    };
    // A name may have blanks, and the statement several names.
    std::vector<std::string_view> candidates = {names};
    if (const std::string_view cut = without_comment(names); cut != names)
        candidates.push_back(cut);
    if (const std::string_view cut = before_last_mark(names); !cut.empty())
        candidates.push_back(cut);
    for (const std::string_view whole : candidates) {
        if (const Result<fs::path> path = find(whole)) return read(*path);
    }
    std::string_view rest = candidates.back();
    // Each start of the statement may be a name: not of very long ones.
    constexpr int64_t kMostBlanks = 32;
    const auto blanks = std::count_if(rest.begin(), rest.end(), is_blank);
    const bool several = blanks > 0 && blanks < kMostBlanks;
    std::vector<std::string_view> missing;
    size_t found = 0;
    while (several && !rest.empty()) {
        // The longest name that is there begins with the first word.
        bool is_there = false;
        for (std::string_view name = rest; !name.empty() && !is_there;) {
            if (const Result<fs::path> path = find(name)) {
                if (Result<void> done = read(*path); !done) return done;
                rest = without_blanks(rest.substr(name.size()));
                is_there = true;
                ++found;
                continue;
            }
            const size_t blank = name.find_last_of(kBlanks);
            name = blank == std::string_view::npos ? std::string_view()
                                                   : without_blanks(name.substr(0, blank));
        }
        if (!is_there) missing.push_back(take_first(&rest));
    }
    if (found == 0) missing = {candidates.back()};
    for (const std::string_view name : missing) {
        missing_.insert(std::string(name));
        const Result<fs::path> path = find(name);
        out_.leave_out(fmt::format(messages::kMaterialLibrary, printable(name.substr(0, 200)),
                                   path ? messages::kLibraryNotRead : path.error().message),
                       place, path ? "" : path.error().help);
    }
    return Ok{};
}

Result<void> MtlLibraries::read(const fs::path& library) {
    if (!read_.insert(library).second) return Ok{};
    const auto too_much = [&] {
        return user_error(fmt::format(messages::kMaterialsTakeTooMuch, library.string()));
    };
    const int64_t left = memory_bytes_ - bytes_;
    if (left <= 0) return too_much();
    const fs::path root = without_links(folder_of(mesh_));
    const Result<InputFile> file = InputFile::open(library, {root});
    const Result<std::string> bytes =
        file ? file->read_all(std::min(left / 2, kLargestLibrary)) : file.error();
    const Complaint wide = bytes ? not_utf8(*bytes) : Complaint();
    if (!bytes || !wide.empty()) {
        missing_.insert(library.string());
        out_.leave_out(fmt::format(messages::kMaterialLibrary, library.string(),
                                   bytes ? wide.what : bytes.error().text()),
                       library.string(), bytes ? wide.help : "");
        return Ok{};
    }
    out_.files.push_back(library);
    const fs::path folder = library.parent_path().lexically_relative(folder_of(mesh_));
    LibraryReader reader(mesh_, library, folder == "." ? fs::path() : folder);
    const PlainText plain(*bytes);
    const int64_t texts = static_cast<int64_t>(bytes->size()) + plain.copied_bytes();
    const auto keep = [&](std::optional<MtlMaterial> material) {
        if (!material) return;
        bytes_ += bytes_of(*material);
        const auto [at, fresh] = by_name_.emplace(material->look.name, materials_.size());
        if (fresh) {
            if (const std::string_view start = before_last_mark(at->first); !start.empty())
                by_start_.emplace(start, materials_.size());
            materials_.push_back(std::move(*material));
        } else {
            // The first one counts, as in other programs.
            out_.leave_out(messages::kSecondMaterialOfName, library.string(),
                           messages::kSecondMaterialOfNameHelp);
        }
    };
    std::string_view text = plain.text();
    for (int32_t number = 1; !text.empty(); ++number) {
        const std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(line.size() + 1, text.size()));
        keep(reader.take(line, number));
        if (bytes_ + texts > memory_bytes_) return too_much();
    }
    keep(reader.finish());
    if (bytes_ + texts > memory_bytes_) return too_much();
    return Ok{};
}

const MtlMaterial* MtlLibraries::find(std::string_view name) const {
    for (std::string_view tried = name; !tried.empty(); tried = before_last_mark(tried)) {
        if (const auto at = by_name_.find(tried); at != by_name_.end())
            return &materials_[at->second];
    }
    // `newmtl red #old`, and `usemtl red`
    const auto at = by_start_.find(name);
    return at != by_start_.end() ? &materials_[at->second] : nullptr;
}

}  // namespace openfab::mesh
