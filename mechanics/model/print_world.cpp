// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/model/print_world.h"

#include <fmt/format.h>

#include <array>
#include <memory>

#include "backends/common/output_file.h"
#include "base/check.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "base/talking_program.h"
#include "client/child.h"
#include "client/fablet_compiler.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

Result<void> run(const std::vector<std::string>& argv, const fs::path& folder) {
    return client::run(argv, folder / "print.out", folder / "print.err");
}

std::string numbers_text(const std::array<double, 3>& v) {
    return fmt::format("{:.17g},{:.17g},{:.17g}", v[0], v[1], v[2]);
}

/// The command line of a print, but for its outputs.
std::vector<std::string> print_words(const PrintRequest& request) {
    std::vector<std::string> out{(request.programs / "openfab").string(),
                                 "print",
                                 as_argument(request.world),
                                 "--support",
                                 "off",
                                 "--as-built"};
    const auto& pitch = request.pitch_mm;
    if (pitch[0] > 0) out.push_back("--pitch=" + numbers_text(pitch));
    if (request.lattice_mm[0] > 0) out.push_back("--lattice=" + numbers_text(request.lattice_mm));
    for (const std::string& one : request.allow)
        out.push_back(allow_argument(one));
    for (const std::string& one : request.settings)
        out.insert(out.end(), {"--set", one});
    if (request.field) {
        const FieldTexture& f = *request.field;
        out.push_back("--field=" + f.name + "=" + f.file.string());
        out.push_back("--field-origin=" + numbers_text(f.origin_mm));
        out.push_back("--field-spacing=" + numbers_text(f.spacing_mm));
    }
    return out;
}

/// Prints with these words besides; returns the array.
Result<fs::path> print_array(const PrintRequest& request, const fs::path& folder,
                             const std::string& name, const std::vector<std::string>& more) {
    const fs::path file = folder / (name + ".npy");
    std::vector<std::string> argv = print_words(request);
    argv.insert(argv.end(), {"--memory", fmt::format("{}B", request.memory_bytes), "--threads",
                             std::to_string(request.threads), "--progress", "none"});
    argv.insert(argv.end(), more.begin(), more.end());
    if (request.codes) {
        argv.insert(argv.end(), {"-o", file.string()});
        if (!request.dither.empty()) argv.insert(argv.end(), {"--dither", request.dither});
    } else {
        argv.insert(argv.end(), {"--fractions", file.string()});
        if (request.supersample > 0)
            argv.insert(argv.end(),
                        {"--fractions-supersample", std::to_string(request.supersample)});
    }
    if (Result<void> done = run(argv, folder); !done) return done.error();
    return file;
}

std::array<double, 3> three_of(const JsonValue& json, const char* key) {
    const JsonMember* m = json.find(key);
    OPENFAB_CHECK(m && m->value.items.size() == 3);  // the print wrote it
    return {m->value.items[0].number, m->value.items[1].number, m->value.items[2].number};
}

/// A world of a fablet alone, which has a material for each that it takes.
Result<CellWorld> of_fablet(const fs::path& input, const fs::path& programs,
                            const fs::path& scratch) {
    const client::FabletCompiler compiler(programs, scratch);
    const Result<std::vector<client::Diagnostic>> checked = compiler.check(input);
    if (!checked) return checked.error();
    for (const client::Diagnostic& one : *checked)
        if (one.severity == "error")
            return error_at({one.file.string(), one.line, one.column}, one.message);
    const auto described = compiler.describe(input);
    if (!described) return described.error();
    if (described->empty()) return user_error(fmt::format(messages::kNoFablet, input.string()));
    const auto& [name, fablet] = *described->begin();
    JsonText uniforms, materials;
    uniforms.begin_object();
    materials.begin_object();
    int number = 0;
    if (const JsonValue* list = member_of(fablet, "uniforms"))
        for (const JsonValue& one : list->items) {
            const JsonValue* kind = member_of(one, "kind");
            const JsonValue* uniform = member_of(one, "name");
            if (!kind || !uniform || kind->text != "material") continue;
            uniforms.member(uniform->text, uniform->text);
            materials.key(uniform->text).begin_object();
            materials.member("key", fmt::format("#{:06x}", 0x303030 + 0x2a1 * ++number));
            materials.end_object();
        }
    uniforms.end_object();
    materials.end_object();
    if (number == 0)
        return user_error(fmt::format(messages::kNoMaterialUniform, input.string(), name),
                          messages::kNoMaterialUniformHelp);
    JsonText source;
    source.value(fs::absolute(input).string());
    const fs::path file = scratch / "cell.fab.json";
    const std::string text = fmt::format(
        "{{\"openfab\": 1, \"printer\": \"generic\", \"fablets\": {{\"cell\": {{\"source\": {}, "
        "\"fablet\": \"{}\"}}}}, \"materials\": {}, \"meshes\": {{\"cell\": {{\"box\": [1, 1, "
        "1]}}}}, "
        "\"objects\": {{\"cell\": {{\"mesh\": \"cell\", \"fablet\": \"cell\", \"uniforms\": "
        "{}}}}}, "
        "\"build\": [{{\"object\": \"cell\"}}]}}",
        source.take(), name, materials.take(), uniforms.take());
    if (Result<void> done = backends::write_whole_file(file, text); !done) return done.error();
    return CellWorld{file, "cell", false, {fs::absolute(input).parent_path()}};
}

}  // namespace

Result<fs::path> print_voxels(const PrintRequest& request, const fs::path& folder,
                              const std::string& name) {
    // Codes are what is sent to the machine: a voxel that others have run into is of no material alone.
    return print_array(
        request, folder, name,
        request.codes ? std::vector<std::string>{"--bleed", "undo"} : std::vector<std::string>());
}

Result<fs::path> print_lowest(const PrintRequest& request, int slices, const fs::path& folder) {
    PrintRequest lowest = request;
    lowest.codes = true;
    lowest.dither = "majority";
    std::vector<std::string> more{"--bleed", "undo"};
    if (slices > 0) more.insert(more.end(), {"--slices", fmt::format("0:{}", slices)});
    return print_array(lowest, folder, "lowest", more);
}

Result<fs::path> print_object(const PrintRequest& request, const std::string& object, int around,
                              const fs::path& folder) {
    PrintRequest solid = request;
    solid.codes = true;
    solid.dither.clear();
    return print_array(solid, folder, "object",
                       {"--only-object=" + object, "--solid", "--around", std::to_string(around)});
}

Result<fs::path> print_cell(const PrintRequest& request, const CellBox& box,
                            const fs::path& folder) {
    // What lies around a cell is the same again, which no print of it knows.
    return print_array(request, folder, "cell",
                       {"--only-object=" + box.object, "--cell=" + numbers_text(box.size_mm),
                        "--cell-at=" + numbers_text(box.at_mm), "--bleed", "off"});
}

Result<BuildSize> build_size(const PrintRequest& request, const fs::path& folder) {
    const fs::path file = folder / "estimate.json";
    PrintRequest coarse = request;
    coarse.pitch_mm = {BuildSize::kPitch_mm, BuildSize::kPitch_mm, BuildSize::kPitch_mm};
    std::vector<std::string> argv = print_words(coarse);
    argv.insert(argv.end(), {"--dry-run", "--stats", file.string()});
    if (Result<void> done = run(argv, folder); !done) return done.error();
    const Result<std::string> text = read_text_file(file, kMostWorldBytes);
    if (!text) return text.error();
    const Result<JsonValue> estimate = parse_json(*text, file.string());
    if (!estimate) return estimate.error();
    const auto size = three_of(*estimate, "size_voxels"), pitch = three_of(*estimate, "pitch_mm");
    BuildSize out;
    for (size_t a = 0; a < 3; ++a)
        out.mm[a] = size[a] * pitch[a];
    out.printer_pitch_mm = three_of(*estimate, "printer_pitch_mm");
    return out;
}

Result<CellWorld> cell_world(const fs::path& input, const std::string& object,
                             const fs::path& programs, const fs::path& scratch) {
    if (input.extension() == ".fl") return of_fablet(input, programs, scratch);
    const Result<std::string> text = read_text_file(input, kMostWorldBytes);
    if (!text) return text.error();
    const Result<JsonValue> world = parse_json(*text, input.string());
    if (!world) return world.error();
    const JsonMember* objects = world->find("objects");
    if (!objects || objects->value.members.empty())
        return user_error(fmt::format(messages::kNoObjectsIn, input.string()));
    const JsonMember* taken =
        object.empty() ? objects->value.members.data() : objects->value.find(object);
    if (!taken) return user_error(fmt::format(messages::kNoObjectIn, input.string(), object));
    return CellWorld{input, taken->key, world->find("printer") != nullptr, {}};
}

}  // namespace openfab::mechanics
