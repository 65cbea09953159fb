// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// STEP files that OpenCASCADE writes, read as triangles: volumes and areas against closed forms, names, colours and
// places of an assembly.

#include "tools/step/step_solids.h"

#include <gmock/gmock.h>

#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <TDF_Label.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS_Shape.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <gp_Ax1.hxx>
#include <gp_Trsf.hxx>
#include <map>

namespace openfab::tools {
namespace {

constexpr double kPi = M_PI;

std::filesystem::path in_folder(const std::string& name) {
    return std::filesystem::path(::testing::TempDir()) / name;
}

/// A document of one part after another, each of a name and a colour, or of an assembly of them.
class Document {
  public:
    Document() : document_(new TDocStd_Document("XmlXCAF")) {
        Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
        shapes_ = XCAFDoc_DocumentTool::ShapeTool(document_->Main());
        colors_ = XCAFDoc_DocumentTool::ColorTool(document_->Main());
    }
    TDF_Label part(const TopoDS_Shape& shape, const std::string& name,
                   const std::array<double, 3>& color) {
        const TDF_Label label = shapes_->AddShape(shape, Standard_False);
        TDataStd_Name::Set(label, name.c_str());
        colors_->SetColor(label, Quantity_Color(color[0], color[1], color[2], Quantity_TOC_RGB),
                          XCAFDoc_ColorGen);
        return label;
    }
    TDF_Label assembly(const std::string& name) {
        const TDF_Label label = shapes_->NewShape();
        TDataStd_Name::Set(label, name.c_str());
        return label;
    }
    void place(const TDF_Label& holder, const TDF_Label& part, const gp_Trsf& at) {
        shapes_->AddComponent(holder, part, TopLoc_Location(at));
    }
    std::filesystem::path write(const std::string& file) {
        shapes_->UpdateAssemblies();
        STEPCAFControl_Writer writer;
        writer.SetColorMode(Standard_True);
        writer.SetNameMode(Standard_True);
        EXPECT_TRUE(writer.Transfer(document_));
        std::filesystem::path path = in_folder(file);
        EXPECT_EQ(writer.Write(path.c_str()), IFSelect_RetDone);
        return path;
    }

  private:
    Handle(TDocStd_Document) document_;
    Handle(XCAFDoc_ShapeTool) shapes_;
    Handle(XCAFDoc_ColorTool) colors_;
};

struct Measured {
    double volume = 0, area = 0;
    Vec3d middle;  ///< of the volume
    bool closed = true;
};

Measured measured(const StepSolid& solid) {
    Measured out;
    std::map<std::pair<int32_t, int32_t>, int> edges;
    for (const auto& t : solid.triangles) {
        const Vec3d a = solid.vertices[static_cast<size_t>(t[0])],
                    b = solid.vertices[static_cast<size_t>(t[1])],
                    c = solid.vertices[static_cast<size_t>(t[2])];
        const double v = dot(a, cross(b, c)) / 6;
        out.volume += v;
        out.middle = out.middle + (a + b + c) * (v / 4);
        out.area += length(cross(b - a, c - a)) / 2;
        for (size_t k = 0; k < 3; ++k) {
            ++edges[{t[k], t[(k + 1) % 3]}];
            --edges[{t[(k + 1) % 3], t[k]}];
        }
    }
    out.middle = out.middle * (1 / out.volume);
    for (const auto& [edge, count] : edges)
        out.closed = out.closed && count == 0;
    return out;
}

struct Solid {
    const char* name;
    TopoDS_Shape shape;
    double volume, area;
    bool flat = false;  ///< all of its faces
};

std::vector<Solid> primitives() {
    const double slant = std::sqrt(4.0 * 4 + 9 * 9);
    return {
        {"box", BRepPrimAPI_MakeBox(10, 20, 5).Shape(), 1000, 2 * (200 + 100 + 50), true},
        {"cylinder", BRepPrimAPI_MakeCylinder(4, 12).Shape(), kPi * 16 * 12,
         2 * kPi * 16 + 2 * kPi * 4 * 12},
        {"cone", BRepPrimAPI_MakeCone(5, 1, 9).Shape(), kPi * 9 / 3 * (25 + 5 + 1),
         kPi * (25 + 1) + kPi * (5 + 1) * slant},
        {"sphere", BRepPrimAPI_MakeSphere(6).Shape(), 4.0 / 3 * kPi * 216, 4 * kPi * 36},
        {"torus", BRepPrimAPI_MakeTorus(8, 3).Shape(), 2 * kPi * kPi * 8 * 9, 4 * kPi * kPi * 24},
    };
}

// Triangles are so close to the surface that no more than a coat of the tolerance is missing; the slack of two is
// for the library, which divides by what it finds between the ends of an edge.
TEST(Step, PrimitivesHaveTheirVolumesAndAreas) {
    for (const Solid& solid : primitives()) {
        Document document;
        document.part(solid.shape, solid.name, {1, 0, 0});
        const auto file = document.write(std::string(solid.name) + ".step");
        double before = INFINITY;
        for (const double tolerance : {0.1, 0.01, 0.001}) {
            SCOPED_TRACE(std::string(solid.name) + " at " + std::to_string(tolerance));
            const Result<StepFile> read = read_step(file, tolerance);
            ASSERT_TRUE(read) << read.error().text();
            ASSERT_EQ(read->solids.size(), 1u);
            const Measured got = measured(read->solids[0]);
            EXPECT_TRUE(got.closed);
            const double off = std::fabs(got.volume - solid.volume);
            EXPECT_LE(off, solid.flat ? 1e-9 * solid.volume : 2 * tolerance * solid.area);
            EXPECT_LE(std::fabs(got.area - solid.area),
                      solid.flat ? 1e-9 * solid.area : 0.05 * std::sqrt(tolerance) * solid.area);
            EXPECT_LE(off, before + 1e-9);
            before = off;
        }
        // A thousandth of a millimetre: the closed form to three digits and more.
        EXPECT_LE(before, 2e-3 * solid.volume);
    }
}

TEST(Step, AnAssemblyKeepsNamesColoursAndPlaces) {
    Document document;
    const std::vector<Solid> shapes = primitives();
    const TDF_Label machine = document.assembly("machine");
    struct Part {
        std::string name;
        std::array<double, 3> color;
        double volume;
        gp_Trsf at;
    };
    std::vector<Part> wanted;
    // Nine parts in the assembly, and three in an assembly within it, which is turned.
    const TDF_Label inner = document.assembly("inner");
    gp_Trsf turn;
    turn.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(0, 0, 1)), kPi / 2);
    for (int i = 0; i < 12; ++i) {
        // A shape of its own, or the document would have one part twice.
        const Solid solid = primitives()[static_cast<size_t>(i) % shapes.size()];
        const std::string name = solid.name + std::string(" no. ") + std::to_string(i);
        const std::array<double, 3> color{i / 16.0, 1 - i / 16.0, 0.25};
        gp_Trsf at;
        at.SetTranslation(gp_Vec(30.0 * i, 5.0 * i, -3.0 * i));
        const bool is_inner = i >= 9;
        document.place(is_inner ? inner : machine, document.part(solid.shape, name, color), at);
        wanted.push_back({name, color, solid.volume, is_inner ? turn * at : at});
    }
    document.place(machine, inner, turn);
    const auto file = document.write("machine.step");
    const Result<StepFile> read = read_step(file, 0.005);
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->solids.size(), wanted.size());
    EXPECT_TRUE(read->notes.empty());
    for (const Part& part : wanted) {
        SCOPED_TRACE(part.name);
        const auto found = std::find_if(read->solids.begin(), read->solids.end(),
                                        [&](const StepSolid& s) { return s.name == part.name; });
        ASSERT_NE(found, read->solids.end());
        const Measured got = measured(*found);
        EXPECT_TRUE(got.closed);
        EXPECT_NEAR(got.volume / part.volume, 1, 5e-3);
        ASSERT_TRUE(found->color);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR((*found->color)[c], part.color[c], 1e-3);
        // Each primitive has its middle somewhere on its axis: that of what is read at its own place, moved.
        const Result<StepFile> alone = [&] {
            Document one;
            one.part(shapes[static_cast<size_t>(&part - wanted.data()) % shapes.size()].shape,
                     "one", {1, 1, 1});
            return read_step(one.write("one.step"), 0.005);
        }();
        ASSERT_TRUE(alone);
        const Vec3d middle = measured(alone->solids[0]).middle;
        const gp_Pnt moved = gp_Pnt(middle.x, middle.y, middle.z).Transformed(part.at);
        EXPECT_NEAR(got.middle.x, moved.X(), 1e-3);
        EXPECT_NEAR(got.middle.y, moved.Y(), 1e-3);
        EXPECT_NEAR(got.middle.z, moved.Z(), 1e-3);
    }
}

TEST(Step, WhatIsNoStepFileIsAnError) {
    const auto file = in_folder("none.step");
    std::ofstream(file) << "ISO-10303-21;\nHEADER;\nnonsense\n";
    const Result<StepFile> read = read_step(file, 0.01);
    ASSERT_FALSE(read);
    EXPECT_THAT(read.error().text(), ::testing::HasSubstr("none.step"));
    EXPECT_FALSE(read_step(in_folder("missing.step"), 0.01));
}

}  // namespace
}  // namespace openfab::tools
