// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// openfab._core: the compiler and the runtime as Python sees them. Nothing here waits with the
// interpreter's lock held. What is wrong with an input is returned as data; the package makes
// exceptions of it.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "base/caret.h"
#include "base/talking_program.h"
#include "mesh/load/load_mesh.h"
#include "python/src/bindings.h"
#include "python/src/print.h"
#include "python/src/program.h"
#include "python/src/share.h"
#include "runtime/process/kinds/kinds.h"
#include "texture/cache.h"
#include "world/edit/world_edit.h"
#include "world/printer_list.h"
#include "world/world_keys.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace openfab::python {

namespace {

Result<std::pair<std::string, std::vector<std::string>>> absolute_paths(std::string text,
                                                                        const std::string& folder) {
    Result<world::WorldEdit> world = world::WorldEdit::of_text(std::move(text), "world.fab.json");
    if (!world) return world.error();
    if (const Result<void> done = world->make_absolute(folder); !done) return done.error();
    std::vector<std::string> paths;
    for (const std::filesystem::path& path : world->paths())
        paths.push_back(path.string());
    return std::pair(world->text(), std::move(paths));
}

/// The sides of a mesh file's box in mm. Holes do not matter to it.
Result<std::array<double, 3>> mesh_size(const std::filesystem::path& file,
                                        std::optional<double> unit_mm, bool y_up,
                                        const std::string& body) {
    mesh::MeshOptions options;
    options.name = file.stem().string();
    options.unit_mm = unit_mm;
    options.y_up = y_up && !mesh::format_says_up(file);
    options.body = body;
    options.repair = true;
    const Result<mesh::LoadedMesh> loaded = mesh::load_mesh(file, options);
    if (!loaded) return loaded.error();
    Box3d box;
    for (const Vec3d& p : loaded->mesh.positions)
        box.add(p);
    const Vec3d size = box.size();
    return std::array<double, 3>{size.x, size.y, size.z};
}

using Codes = nb::ndarray<nb::numpy, const uint8_t, nb::ndim<2>>;
using Fractions = nb::ndarray<nb::numpy, const float, nb::ndim<3>>;
using Rates = nb::ndarray<nb::numpy, const float, nb::ndim<4>>;
using Rgba = nb::ndarray<nb::numpy, const uint8_t, nb::ndim<3>>;

/// z, codes, fractions, derivatives (y, x, column, material).
using SliceTuple = std::tuple<int32_t, Codes, std::optional<Fractions>, std::optional<Rates>>;

std::optional<SliceTuple> next_slice(Print& print, double seconds) {
    std::optional<Slice> slice;
    {
        const nb::gil_scoped_release released;
        slice = print.next(seconds);
    }
    if (!slice) return std::nullopt;
    const auto width = static_cast<size_t>(print.info().size.x);
    const auto height = static_cast<size_t>(print.info().size.y);
    std::optional<Fractions> fractions;
    if (print.wants_fractions()) {
        fractions =
            array_of<Fractions>(std::move(slice->fractions),
                                {height, width, static_cast<size_t>(print.fraction_materials())});
    }
    std::optional<Rates> rates;
    if (!slice->rates.empty()) {
        rates = array_of<Rates>(std::move(slice->rates),
                                {height, width, static_cast<size_t>(print.rate_count()),
                                 static_cast<size_t>(print.fraction_materials())});
    }
    return SliceTuple{slice->z, array_of<Codes>(std::move(slice->codes), {height, width}),
                      std::move(fractions), std::move(rates)};
}

std::vector<Rgba> pictures_of(const Print& print) {
    std::vector<Rgba> out;
    for (const Picture8& picture : print.pictures()) {
        out.push_back(array_of<Rgba>(picture.rgba, {static_cast<size_t>(picture.height),
                                                    static_cast<size_t>(picture.width), 4}));
    }
    return out;
}

using Bytes = nb::ndarray<const uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

nb::bytes bytes_of(const std::vector<uint8_t>& bytes) {
    return nb::bytes(bytes.data(), bytes.size());
}

using Compiled = std::tuple<std::shared_ptr<const Program>, Diagnostics>;

/// The file and the name of a dither rule.
using Rule = std::pair<std::string, std::string>;

Compiled compile_files(const std::vector<std::string>& files, bool enable_printf,
                       const std::optional<Rule>& rule,
                       const std::vector<std::string>& derivatives) {
    const nb::gil_scoped_release released;
    Diagnostics said;
    std::optional<frontend::DitherRule> dither;
    if (rule) dither = {rule->first, rule->second};
    auto made = compile(files, enable_printf, dither, derivatives, &said);
    if (auto* failed = std::get_if<Diagnostics>(&made)) return {nullptr, std::move(*failed)};
    return {std::get<std::shared_ptr<const Program>>(std::move(made)), std::move(said)};
}

void bind_shares(nb::module_& m) {
    using Totals = pipeline::PrintTotals;
    nb::class_<Totals>(m, "Totals", "The totals of some slices.")
        .def("__getstate__",
             [](const Totals& t) {
                 const Vec3i &lo = t.tight.lo, &hi = t.tight.hi;
                 return std::tuple(t.voxels_solid, t.voxels_by_code, t.hash,
                                   std::array{lo.x, lo.y, lo.z, hi.x, hi.y, hi.z});
             })
        .def("__setstate__",
             [](Totals& t, const std::tuple<int64_t, std::vector<int64_t>, uint64_t,
                                            std::array<int32_t, 6>>& state) {
                 const auto& [x0, y0, z0, x1, y1, z1] = std::get<3>(state);
                 new (&t) Totals{false, std::get<0>(state), std::get<1>(state), std::get<2>(state),
                                 Box3i{{x0, y0, z0}, {x1, y1, z1}}};
             })
        .def_ro("hash", &Totals::hash);
    nb::class_<Share>(m, "Share", "Neighbouring slabs, printed.")
        .def(
            "take_bytes",
            [](Share& s) {
                const size_t size = s.bytes.size();
                return array_of<nb::ndarray<nb::numpy, const uint8_t, nb::ndim<1>>>(
                    std::exchange(s.bytes, {}), {size});
            },
            "Gives away the encoded slices, one after the other.")
        .def_ro("lengths", &Share::lengths)
        .def_ro("totals", &Share::totals)
        .def_ro("seconds", &Share::seconds)
        .def_ro("processor_seconds", &Share::processor_seconds)
        .def_ro("statistics", &Share::statistics);
    nb::class_<SharePrinter>(m, "SharePrinter", "A print that is set up once, for shares of it.")
        .def_prop_ro("info",
                     [](const SharePrinter& p) { return info_of(p.info(), p.memory_bytes()); })
        .def_prop_ro("header", [](const SharePrinter& p) { return bytes_of(header_of(p.info())); })
        .def_prop_ro("slabs",
                     [](const SharePrinter& p) { return std::pair(p.slabs().x, p.slabs().y); })
        .def_prop_ro("warnings", &SharePrinter::warnings)
        .def_prop_ro("part_sizes", &SharePrinter::part_sizes)
        .def(
            "print",
            [](SharePrinter& p, int32_t first, int32_t end) { return either(p.print(first, end)); },
            "first"_a, "end"_a, nb::call_guard<nb::gil_scoped_release>());
    m.def(
        "set_up_shares",
        [](std::shared_ptr<const Program> program, const program::Options& options,
           const std::string& format) {
            return either(SharePrinter::create(std::move(program), options, format));
        },
        "program"_a, "options"_a, "format"_a, nb::call_guard<nb::gil_scoped_release>());
    nb::class_<ShareWriter>(m, "ShareWriter", "Writes shares to the output of a print.")
        .def_prop_ro("info", [](const ShareWriter& w) { return info_of(w.info(), 0); })
        .def_prop_ro("next_slice", &ShareWriter::next_slice)
        .def_prop_ro("statistics", &ShareWriter::statistics)
        .def(
            "write",
            [](ShareWriter& w, const Bytes& bytes, const std::vector<int64_t>& lengths,
               const Totals& totals) {
                const nb::gil_scoped_release released;
                return either(w.write({bytes.data(), bytes.size()}, lengths, totals));
            },
            "bytes"_a, "lengths"_a, "totals"_a)
        .def(
            "finish", [](ShareWriter& w) { return either(w.finish()); },
            nb::call_guard<nb::gil_scoped_release>());
    m.def(
        "open_writer",
        [](const program::Options& options, std::string output, std::string printer,
           const nb::bytes& header, int32_t support_code,
           std::vector<std::filesystem::path> inputs) {
            const auto* data = static_cast<const uint8_t*>(header.data());
            ShareWriter::Settings settings{
                options,      std::move(output), std::move(printer), {data, data + header.size()},
                support_code, std::move(inputs)};
            const nb::gil_scoped_release released;
            return either(ShareWriter::create(settings));
        },
        "options"_a, "output"_a, "printer"_a, "header"_a, "support_code"_a, "inputs"_a);
    m.def(
        "output_format",
        [](const program::Options& options, const std::string& printer) {
            return either(output_format(options, printer));
        },
        "options"_a, "printer"_a);
    m.def(
        "world_files", [](const program::Options& options) { return either(world_files(options)); },
        "options"_a, nb::call_guard<nb::gil_scoped_release>());
    m.def(
        "set_line_opener",
        [](nb::callable open) {
            // Never destroyed: a print may ask while the interpreter ends.
            auto* kept = new nb::callable(std::move(open));
            set_line_opener([kept](const std::string& token) {
                const nb::gil_scoped_acquire held;
                try {
                    return nb::cast<int>((*kept)(token));
                } catch (const std::exception&) {
                    return -1;
                }
            });
        },
        "open"_a);
    m.def(
        "world_dither",
        [](const program::Options& options) { return either(world_dither(options)); }, "options"_a,
        nb::call_guard<nb::gil_scoped_release>());
}

}  // namespace

nb::dict info_of(const pipeline::PrintInfo& info, int64_t memory_bytes) {
    nb::dict out;
    out["size"] = nb::make_tuple(info.size.x, info.size.y, info.size.z);
    out["pitch_mm"] = nb::make_tuple(info.pitch_mm.x, info.pitch_mm.y, info.pitch_mm.z);
    out["origin_mm"] = nb::make_tuple(info.origin_mm.x, info.origin_mm.y, info.origin_mm.z);
    out["slices"] = nb::make_tuple(info.slice_begin, info.slice_end);
    out["support_code"] = info.support_code;
    out["printer"] = info.printer;
    out["title"] = info.title;
    out["memory_bytes"] = memory_bytes;
    nb::list materials;
    for (const pipeline::SliceMaterial& material : info.materials) {
        nb::dict one;
        one["name"] = material.name;
        const auto& [kr, kg, kb, ka] = material.key;
        one["key"] = nb::make_tuple(kr, kg, kb, ka);
        const auto& [pr, pg, pb, pa] = material.preview;
        one["preview"] = nb::make_tuple(pr, pg, pb, pa);
        one["density_g_cm3"] = material.density_g_cm3;
        one["channel"] = material.channel;
        materials.append(one);
    }
    out["materials"] = materials;
    return out;
}

NB_MODULE(_core, m) {
    // Prints and programs that live as long as the interpreter are no leaks.
    nb::set_leak_warnings(false);
    m.doc() = "The compiler and the runtime of OpenFab; the package `openfab` is made of it.";

    nb::class_<Diagnostics>(m, "Diagnostics", "What the compiler has to say of a text.")
        .def_ro("code", &Diagnostics::code, "The exit code of openflc; 0: it compiles.")
        .def_ro("rendered", &Diagnostics::rendered)
        .def_ro("json", &Diagnostics::json)
        .def_ro("fault", &Diagnostics::fault);
    nb::class_<Interface>(m, "Interface", "The interface of a text's fablets.")
        .def_ro("diagnostics", &Interface::diagnostics)
        .def_ro("json", &Interface::json)
        .def_ro("files", &Interface::files);
    nb::class_<Program>(m, "Program", "The kernels of some fablets in this process.")
        .def_prop_ro("files", &Program::files)
        .def_prop_ro("compiled", &Program::compiled, "The number of kernels that no cache had.")
        .def("main", &Program::main, "words"_a, nb::call_guard<nb::gil_scoped_release>(),
             "Prints as a print binary does, in a process that does nothing else; returns its exit "
             "code.");
    m.def(
        "read_file_interface",
        [](const std::filesystem::path& file) { return read_interface(file); }, "file"_a,
        nb::call_guard<nb::gil_scoped_release>());
    m.def(
        "read_text_interface",
        [](const std::string& name, std::string text) {
            return read_interface(name, std::move(text));
        },
        "name"_a, "text"_a, nb::call_guard<nb::gil_scoped_release>());
    m.def("compile", &compile_files, "files"_a, "enable_printf"_a = false,
          "rule"_a = std::optional<Rule>(), "derivatives"_a = std::vector<std::string>());
    m.def(
        "world_keys",
        [](const std::string& kind) {
            const world::KeySet& set = world::world_keys(kind);
            return std::vector<std::string>(set.keys.begin(), set.keys.end());
        },
        "kind"_a, "The keys that a `.fab.json` may have for a kind of thing.");
    m.def(
        "effect_options",
        [] {
            std::vector<std::string> names;
            for (const process::Kind* kind : process::kinds()) {
                if (!kind->option.name.empty()) names.emplace_back(kind->option.name);
            }
            return names;
        },
        "The options of prints that effects of machines have.");
    m.def(
        "absolute_paths",
        [](std::string world, const std::string& folder) {
            return either(absolute_paths(std::move(world), folder));
        },
        "world"_a, "folder"_a,
        "The JSON of a world, whose paths count from a folder, with absolute paths, and these "
        "paths.");
    m.def(
        "mesh_size",
        [](const std::filesystem::path& file, std::optional<double> unit_mm, bool y_up,
           const std::string& body) { return either(mesh_size(file, unit_mm, y_up, body)); },
        "file"_a, "unit_mm"_a, "y_up"_a, "body"_a, nb::call_guard<nb::gil_scoped_release>(),
        "The sides of a mesh file's box in mm.");
    m.def(
        "printers",
        [] {
            std::vector<world::Printer> printers;
            for (const std::string& name : world::printer_names()) {
                if (Result<world::Printer> printer = world::load_printer(name); printer)
                    printers.push_back(std::move(*printer));
            }
            return world::printers_json(printers);
        },
        "The printers that are known, as JSON.");
    m.def("set_converter", &texture::set_converter, "program"_a);

    nb::class_<Error>(m, "Error", "What is wrong with an input, or went wrong.")
        .def_prop_ro(
            "code", [](const Error& e) { return exit_code(e.code); },
            "The exit code of a program: 1 input, 2 usage, 3 outside, 4 bug, 130 "
            "interrupted.")
        .def_ro("message", &Error::message)
        .def_ro("help", &Error::help)
        .def_prop_ro("file", [](const Error& e) { return e.location.file; })
        .def_prop_ro("line", [](const Error& e) { return e.location.line; })
        .def_prop_ro("column", [](const Error& e) { return e.location.column; })
        .def_prop_ro("rendered", [](const Error& e) { return render_error(e); });

    bind_options(m);
    nb::enum_<Target>(m, "Target", "What becomes of a print's slices.")
        .value("SLICES", Target::kSlices, "They are handed out.")
        .value("OUTPUT", Target::kOutput, "They go where the options say.")
        .value("PICTURES", Target::kPictures, "They are drawn.")
        .value("NOTHING", Target::kNothing, "Set-up alone.")
        .value("ESTIMATE", Target::kEstimate, "What the print will take.");
    nb::enum_<Print::State>(m, "State")
        .value("SETTING_UP", Print::State::kSettingUp)
        .value("PRINTING", Print::State::kPrinting)
        .value("ENDED", Print::State::kEnded);
    nb::class_<Print>(m, "Print", "A print in threads of its own.")
        .def(
            "__init__",
            [](Print* self, std::shared_ptr<const Program> program, program::Options options,
               Target target, bool fractions, std::string output,
               std::optional<std::array<double, 6>> window_mm,
               std::vector<std::string> derivatives) {
                std::optional<Box3d> window;
                if (window_mm) {
                    const auto& [x0, y0, z0, x1, y1, z1] = *window_mm;
                    window = Box3d{{x0, y0, z0}, {x1, y1, z1}};
                }
                new (self) Print(std::move(program), std::move(options), target, fractions,
                                 std::move(output), window, std::move(derivatives));
            },
            "program"_a, "options"_a, "target"_a, "fractions"_a = false, "output"_a = "",
            "window_mm"_a = nb::none(), "derivatives"_a = std::vector<std::string>())
        .def_prop_ro("state", &Print::state)
        .def("wait_while", &Print::wait_while, "state"_a, "seconds"_a,
             nb::call_guard<nb::gil_scoped_release>(),
             "Waits for another state, at most so long; returns the state.")
        .def("next", &next_slice, "seconds"_a,
             "Returns z, codes, fractions and derivatives of the next slice, as read-only arrays "
             "that own "
             "their memory; None where there is none yet, or no more.")
        .def("cancel", &Print::cancel)
        .def(
            "abandon", [](nb::handle self) { self.inc_ref(); },
            "Keeps it for ever: after a fork its destructor would wait for threads that the child "
            "lacks.")
        .def("join", &Print::join, nb::call_guard<nb::gil_scoped_release>())
        .def_prop_ro("info",
                     [](const Print& p) { return info_of(p.info(), p.estimate().memory_bytes); })
        .def_prop_ro("error", [](const Print& p) { return p.error(); })
        .def_prop_ro("statistics", &Print::statistics)
        .def_prop_ro("pictures", &pictures_of, nb::rv_policy::move)
        .def_prop_ro("progress",
                     [](const Print& p) {
                         const pipeline::ProgressEvent event = p.progress();
                         return std::pair(event.slices_done, event.slices_total);
                     })
        .def_prop_ro(
            "rate_columns",
            [](const Print& p) {
                std::vector<std::tuple<std::string, int32_t, int32_t, int32_t, std::string>> out;
                for (const program::RateColumns& c : p.rate_columns())
                    out.emplace_back(c.name, c.first, c.components, c.array_length, c.type_name);
                return out;
            },
            "Of each uniform with derivatives its name, first column, components, array length and "
            "type.")
        .def("take_notes", &Print::take_notes)
        .def("take_warnings", &Print::take_warnings)
        .def("take_lines", &Print::take_lines);

    bind_shares(m);
    bind_print_file(m);
    bind_texels(m);
}

}  // namespace openfab::python
