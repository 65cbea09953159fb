// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/readers/readers.h"

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "backends/common/tee_sink.h"
#include "backends/ofr/format.h"
#include "backends/ofr/slice_codec.h"
#include "backends/stream/message.h"
#include "base/json.h"
#include "base/result.h"
#include "base/text.h"
#include "compiler/schedule/schedule.h"
#include "mechanics/model/voxels.h"
#include "mechanics/part/load_case.h"
#include "mesh/check/mesh_check.h"
#include "mesh/load/load_mesh.h"
#include "mesh/load/pictures.h"
#include "mesh/read/gltf.h"
#include "mesh/read/obj.h"
#include "mesh/read/threemf.h"
#include "runtime/process/kinds/kinds.h"
#include "tests/fuzz/readers/geometry_readers.h"
#include "tests/fuzz/readers/print_readers.h"
#include "tests/fuzz/readers/seal.h"
#include "texture/pyramid.h"
#include "tools/color/profile.h"
#include "tools/color/samples.h"
#include "tools/texture/convert.h"
#include "tools/texture/convert_volume.h"
#include "tools/texture/embedded_profile.h"
#include "tools/viewer/http_message.h"
#include "world/printer.h"
#include "world/transforms_file.h"
#include "world/world.h"

namespace openfab::testing {
namespace {

bool read_mesh(std::string_view bytes, const char* file) {
    mesh::MeshOptions options;
    options.name = "part";
    options.repair = bytes.size() % 2 == 0;
    options.memory_bytes = kReaderBytes;
    const Result<mesh::LoadedMesh> loaded = mesh::parse_mesh(bytes, file, options);
    if (!answered(loaded)) return false;
    if (!mesh::count_edges(loaded->mesh).fine()) std::abort();
    for (const mesh::MeshAttribute& a : loaded->mesh.attributes) {
        const auto values = static_cast<int32_t>(a.values.size()) / a.components;
        for (const auto& corners : a.corners) {
            for (const int32_t corner : corners) {
                if (corner < 0 || corner >= values) std::abort();
            }
        }
    }
    return true;
}

template <const char* file>
bool mesh(std::string_view bytes) {
    return read_mesh(bytes, file);
}

/// What its looks name is there, and its pictures, as `openfab import` fetches them.
template <auto parse, const char* name>
bool model(std::string_view bytes) {
    const Result<mesh::MeshSource> source = parse(bytes, name, kReaderBytes);
    if (!answered(source)) return read_mesh(bytes, name);
    for (const mesh::FaceGroup& group : source->groups) {
        const bool has_look = group.look < static_cast<int32_t>(source->looks.size());
        if (!has_look || group.body >= static_cast<int32_t>(source->bodies.size())) std::abort();
    }
    std::vector<std::string> pictures;
    for (const mesh::Look& look : source->looks) {
        if (look.picture) pictures.push_back(look.picture->source);
    }
    if (!pictures.empty()) {
        (void)answered(mesh::read_pictures(
            written(name, bytes), pictures, kReaderBytes,
            [](size_t, const Result<std::string>& picture) { (void)answered(picture); }));
    }
    return read_mesh(bytes, name);
}

/// As a printer's profile, with what it says of some colours, and as one that a picture carries.
bool icc(std::string_view bytes) {
    const std::vector<uint8_t> copy(bytes.begin(), bytes.end());
    const tools::EmbeddedProfile::Found found = tools::EmbeddedProfile::find(copy);
    (void)tools::EmbeddedProfile::find(copy, 1);
    const Result<color::PrinterProfile> profile = color::PrinterProfile::parse(copy);
    if (!answered(profile)) return found.is_srgb || found.other != nullptr;
    (void)profile->description();
    const std::vector<color::Rgb> colours = {{0, 0, 0}, {1, 1, 1}, {0.2, 0.9, 0.4}};
    bool whole = answered(profile->to_lab({{0.1, 0.2, 0.3, 0.4}, {}}, true));
    for (const color::Intent intent : {color::Intent::kPerceptual, color::Intent::kRelative}) {
        const Result<std::vector<color::Inks>> inks = profile->to_inks(colours, intent, true);
        whole = answered(inks) && whole;
        if (!inks) continue;
        for (const color::Inks& mixture : *inks) {
            for (const double ink : mixture) {
                if (!(ink >= 0 && ink <= 1)) std::abort();
            }
        }
    }
    return whole;
}

bool cgats(std::string_view bytes) {
    const Result<color::SampleTable> table = color::parse_samples(bytes);
    if (!answered(table)) return false;
    return answered(color::parse_samples(color::format_samples(*table, "again")));
}

/// The materials of a mesh that names this library.
bool mtl(std::string_view bytes) {
    written("a.mtl", bytes);
    const auto read = mesh::parse_obj(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl white\nf 1/1 2/1 3/1\n"
        "usemtl painted\nf 1/1 3/1 2/1\n",
        (folder() / "a.obj").string(), kReaderBytes);
    return answered(read) && read->looks[0].color;
}

bool oftx(std::string_view bytes) {
    return open_pyramid(written("a.oftx", bytes));
}

/// Converted by `make`, whose pyramids are sound.
template <const char* file, typename Options, auto make>
bool converted(std::string_view bytes) {
    const std::filesystem::path out = folder() / "out.oftx";
    texture::ReadLimits limits;
    limits.memory_bytes = kReaderBytes;
    if (!answered(make(written(file, bytes), out, Options{}, limits))) return false;
    if (!open_pyramid(out)) std::abort();
    return true;
}

template <const char* file>
constexpr auto picture = converted<file, texture::ImageOptions, tools::make_pyramid_file>;
template <const char* file>
constexpr auto volume = converted<file, texture::VolumeOptions, tools::make_volume_file>;

// What is bound is written and read again, as the same.
bool schedule(std::string_view bytes) {
    const auto open = [](const std::string& name, const schedule::Source& from) {
        auto opened = schedule::open_built_in(name, from);
        if (auto* source = std::get_if<schedule::Source>(&opened)) source->file = 1;
        return opened;
    };
    const auto refused = [&](const schedule::Fault& fault) {
        if (fault.message.empty() || (fault.file == 0 && fault.offset > bytes.size())) std::abort();
        return false;
    };
    const auto file = schedule::parse({"a.sched", std::string(bytes)}, open);
    if (const auto* fault = std::get_if<schedule::Fault>(&file)) return refused(*fault);
    for (const std::string& target : schedule::targets()) {
        const auto bound = schedule::bind(std::get<schedule::File>(file), {.target = target});
        if (const auto* fault = std::get_if<schedule::Fault>(&bound)) return refused(*fault);
        const std::string text = schedule::text_of(std::get<schedule::Schedule>(bound));
        const auto again = schedule::read({"b.sched", text});
        const auto* same = std::get_if<schedule::Schedule>(&again);
        if (same == nullptr || schedule::text_of(*same) != text) std::abort();
    }
    return true;
}

bool json(std::string_view bytes) {
    return answered(parse_json(bytes, "a.json", kReaderBytes));
}

bool world(std::string_view bytes) {
    return answered(world::load_world(written("a.fab.json", bytes), {{}, kReaderBytes}));
}

bool printer(std::string_view bytes) {
    const Result<world::Printer> read = world::load_printer(written("a.printer.json", bytes));
    return read ? answered(process::read_effects(read->process)) : answered(read);
}

bool transforms(std::string_view bytes) {
    return answered(world::parse_transforms(bytes, "a.txt", 100'000));
}

/// What both ends of a line make of messages: a receiver of a print, and a sender that hears its
/// answers.
class Listener {
  public:
    /// Returns whether the message makes sense; sets how long the next one may be.
    bool take(const stream::Message& message, stream::Line* line) {
        switch (message.kind) {
            case stream::Kind::kOpen:
                return open(message.bytes, line);
            case stream::Kind::kReady:
                return answered(stream::read_ready(message.bytes));
            case stream::Kind::kAcknowledge:
                return answered(stream::read_acknowledge(message.bytes));
            case stream::Kind::kSlice:
            case stream::Kind::kBack:
                return slice(message.bytes);
            case stream::Kind::kDone:
                return message.bytes.empty() || answered(ofr::read_index(message.bytes));
            case stream::Kind::kStop: {
                const std::string text = stream::read_stop(message.bytes).text;
                if (text != printable(text)) std::abort();
                return true;
            }
            case stream::Kind::kAlive:
                return true;
        }
        return false;
    }

  private:
    bool open(const std::vector<uint8_t>& bytes, stream::Line* line) {
        const Result<stream::Open> open = stream::read_open(bytes);
        if (!answered(open)) return false;
        const Result<pipeline::PrintInfo> info = ofr::read_header(open->header);
        if (!answered(info)) return false;
        const auto slice = static_cast<uint64_t>(info->size.y) *
                           backends::packed_row_bytes(info->size.x, info->bits);
        if (2 * slice > static_cast<uint64_t>(kReaderBytes)) return false;
        rows_.resize(slice);
        line->allow(ofr::kSliceHeadBytes + ofr::most_frame_bytes(slice));
        return true;
    }

    bool slice(std::span<const uint8_t> bytes) {
        if (bytes.size() < ofr::kSliceHeadBytes) return false;
        const auto head = ofr::read_slice_head(bytes.first(ofr::kSliceHeadBytes));
        return answered(head) && head->frame_bytes == bytes.size() - ofr::kSliceHeadBytes &&
               answered(ofr::decode_frame(*head, bytes.subspan(ofr::kSliceHeadBytes), rows_));
    }

    std::vector<uint8_t> rows_;
};

/// Messages as they come over a line, in pieces.
bool messages(std::string_view bytes) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0)
        std::abort();
    stream::Line line{stream::Socket(ends[0])}, sender{stream::Socket(ends[1])};
    Listener listener;
    stream::Message message;
    size_t taken = 0;
    bool all_make_sense = true;
    for (size_t sent = 0; sent < bytes.size();) {
        const size_t piece = std::min<size_t>(bytes.size() - sent, 1 + sent % 5000);
        const int64_t n =
            sender.send_some({reinterpret_cast<const uint8_t*>(bytes.data()) + sent, piece});
        if (n <= 0 || !line.receive()) std::abort();
        sent += static_cast<size_t>(n);
        for (;;) {
            const Result<bool> got = line.next(&message);
            if (!answered(got)) return false;
            if (!*got) break;
            taken += stream::kHeadBytes + message.bytes.size();
            all_make_sense = listener.take(message, &line) && all_make_sense;
        }
    }
    return all_make_sense && taken > 0 && taken == bytes.size();
}

constexpr char kObj[] = "a.obj", kStl[] = "a.stl", kPly[] = "a.ply", kAmf[] = "a.amf",
               kOff[] = "a.off", kGltf[] = "a.gltf", kGlb[] = "a.glb", kThreemf[] = "a.3mf",
               kPng[] = "a.png", kJpg[] = "a.jpg", kBmp[] = "a.bmp", kTga[] = "a.tga",
               kGif[] = "a.gif", kWebp[] = "a.webp", kTif[] = "a.tif", kExr[] = "a.exr",
               kHdr[] = "a.hdr", kPpm[] = "a.ppm", kNpy[] = "a.npy", kNrrd[] = "a.nrrd",
               kCube[] = "a.cube", kVti[] = "a.vti", kVtr[] = "a.vtr", kVts[] = "a.vts",
               kVtu[] = "a.vtu", kVtk[] = "a.vtk", kNii[] = "a.nii", kMrc[] = "a.mrc",
               kMha[] = "a.mha", kXdmf[] = "a.xdmf";

bool http(std::string_view bytes) {
    const viewer::HeadRead read = viewer::read_head(bytes);
    if (read.status != 0 && (read.bytes != 0 || read.why.empty())) std::abort();
    if (read.bytes > bytes.size()) std::abort();
    return read.bytes > 0;
}

bool materials(std::string_view bytes) {
    return answered(mechanics::read_properties(written("mechanics.json", bytes)));
}

bool cases(std::string_view bytes) {
    return answered(mechanics::parse_load_case(std::string(bytes), "a.fab.json", ""));
}

/// Mixtures of two materials, as a print writes them.
bool elements(std::string_view bytes) {
    const std::string file = written("elements.npy", bytes);
    written(
        "elements.npy.json",
        R"({"pitch_mm": [1, 1, 1], "origin_mm": [0, 0, 0], "materials": ["a", {"name": "b"}]})");
    const Result<mechanics::VoxelFile> opened = mechanics::open_voxels(file);
    if (!answered(opened)) return false;
    mechanics::Material a, b;
    a.young_MPa = 1;
    b.young_MPa = 2000;
    const mechanics::Mixture mixture({a, b}, mechanics::Properties());
    const Result<mechanics::Voxels> read = mechanics::read_voxels(*opened, mixture);
    if (!answered(read)) return false;
    for (const float mu : read->mu)
        if (!(mu >= 0)) std::abort();
    return true;
}

constexpr Reader kReaders[] = {
    {"obj", true, mesh<kObj>},
    {"mtl", true, mtl},
    {"stl", false, mesh<kStl>},
    {"ply", true, mesh<kPly>},
    {"amf", true, mesh<kAmf>},
    {"off", true, mesh<kOff>},
    {"gltf", true, model<mesh::parse_gltf, kGltf>},
    {"glb", false, model<mesh::parse_gltf, kGlb>},
    {"3mf", false, model<mesh::parse_threemf, kThreemf>},
    {"beams", true, beams},
    {"npz", false, beams_npz},
    {"lattice3mf", false, lattices},
    {"fields3mf", false, fields},
    {"answer", true, answer},
    {"json", true, json},
    {"world", true, world},
    {"printer", true, printer},
    {"transforms", true, transforms},
    {"ofr", false, ofr, seal_print},
    {"gcvf", false, gcvf},
    {"slices", true, slices},
    {"zarr", true, zarr_store, seal_store},
    {"zarray", true, zarr_array},
    {"oftx", false, oftx, seal_pyramid},
    {"stream", false, messages, seal_messages},
    {"png", false, picture<kPng>},
    {"jpg", false, picture<kJpg>},
    {"tif", false, picture<kTif>},
    {"exr", false, picture<kExr>},
    {"hdr", false, picture<kHdr>},
    {"ppm", true, picture<kPpm>},
    {"bmp", false, picture<kBmp>},
    {"tga", false, picture<kTga>},
    {"gif", false, picture<kGif>},
    {"webp", false, picture<kWebp>},
    {"npy", false, volume<kNpy>},
    {"nrrd", true, volume<kNrrd>},
    {"nii", false, volume<kNii>},
    {"mrc", false, volume<kMrc>},
    {"tifs", false, volume<kTif>},
    {"mha", true, volume<kMha>},
    {"cube", true, volume<kCube>},
    {"vti", true, volume<kVti>},
    {"vtr", true, volume<kVtr>},
    {"vts", true, volume<kVts>},
    {"vtu", true, volume<kVtu>},
    {"vtk", true, volume<kVtk>},
    {"xdmf", true, volume<kXdmf>},
    {"sched", true, schedule},
    {"icc", false, icc},
    {"cgats", true, cgats},
    {"http", true, http},
    {"materials", true, materials},
    {"cases", true, cases},
    {"elements", false, elements},
};

}  // namespace

std::span<const Reader> readers() {
    return kReaders;
}

const Reader* find_reader(std::string_view name) {
    for (const Reader& reader : kReaders) {
        if (reader.name == name) return &reader;
    }
    return nullptr;
}

}  // namespace openfab::testing
