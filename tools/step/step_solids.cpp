// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/step/step_solids.h"

#include <fmt/format.h>

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Poly_Triangulation.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TDF_ChildIterator.hxx>
#include <TDF_Label.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "base/at.h"
#include "base/input_file.h"
#include "base/text.h"
#include "tools/step/messages.h"

namespace openfab::tools {

namespace {

/// Assemblies in assemblies.
constexpr int kDeepest = 64;
constexpr size_t kMostSolids = 10'000;
constexpr double kMostTurn = 0.5;  // radians

std::string name_of(const TDF_Label& label) {
    Handle(TDataStd_Name) name;
    if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return {};
    const TCollection_ExtendedString& wide = name->Get();
    std::string out(static_cast<size_t>(wide.LengthOfCString()) + 1, '\0');
    Standard_PCharacter at = out.data();
    wide.ToUTF8CString(at);
    out.resize(out.find('\0'));
    return out;
}

class SolidReader {
  public:
    SolidReader(std::string file, double tolerance_mm)
        : file_(std::move(file)), tolerance_mm_(tolerance_mm) {}

    Result<StepFile> read() {
        Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
        Interface_Static::SetCVal("xstep.cascade.unit", "MM");
        STEPCAFControl_Reader reader;
        reader.SetColorMode(Standard_True);
        reader.SetNameMode(Standard_True);
        if (reader.ReadFile(file_.c_str()) != IFSelect_RetDone)
            return error(messages::kNotStep, messages::kNotStepHelp);
        Handle(TDocStd_Document) document = new TDocStd_Document("XmlXCAF");
        if (!reader.Transfer(document)) return error(messages::kShapesCannotBeRead);
        shapes_ = XCAFDoc_DocumentTool::ShapeTool(document->Main());
        colors_ = XCAFDoc_DocumentTool::ColorTool(document->Main());
        TDF_LabelSequence roots;
        shapes_->GetFreeShapes(roots);
        for (int i = 1; i <= roots.Length(); ++i) {
            const Result<void> done = visit(roots.Value(i), {}, "", {}, 0);
            if (!done) return done.error();
        }
        if (out_.solids.empty())
            return error(others_ > 0 ? messages::kOnlySurfaces : messages::kNoSolids,
                         messages::kNoSolidsHelp);
        if (others_ > 0)
            out_.notes.push_back(fmt::format(messages::kShapesLeftOut, file_, others_));
        return std::move(out_);
    }

  private:
    using Color = std::optional<std::array<double, 3>>;

    Error error(const std::string& what, const std::string& help = {}) const {
        return user_error(fmt::format("{}: {}", file_, what), help);
    }

    Color color_of(const TDF_Label& label) const {
        Quantity_Color color;
        for (const XCAFDoc_ColorType type :
             {XCAFDoc_ColorSurf, XCAFDoc_ColorGen, XCAFDoc_ColorCurv}) {
            if (colors_->GetColor(label, type, color))
                return std::array{color.Red(), color.Green(), color.Blue()};
        }
        return {};
    }

    Color color_of(const TopoDS_Shape& shape) const {
        Quantity_Color color;
        for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen}) {
            if (colors_->GetColor(shape, type, color))
                return std::array{color.Red(), color.Green(), color.Blue()};
        }
        return {};
    }

    /// A label of an assembly or a part; what it is called and coloured counts for what says nothing itself.
    Result<void> visit(const TDF_Label& label, const TopLoc_Location& place,
                       const std::string& holder, const Color& held_color, int depth) {
        if (depth > kDeepest) return error(messages::kAssembliesTooDeep);
        TDF_Label of = label;
        TopLoc_Location placed = place;
        std::string name = name_of(label);
        Color color = color_of(label);
        if (XCAFDoc_ShapeTool::IsReference(label)) {
            placed = place * XCAFDoc_ShapeTool::GetLocation(label);
            XCAFDoc_ShapeTool::GetReferredShape(label, of);
            // An occurrence is often called NAUO1 by the format itself.
            const std::string part = name_of(of);
            if (!part.empty() &&
                (name.empty() || name.starts_with("NAUO") || name.starts_with("=>")))
                name = part;
            if (!color) color = color_of(of);
        }
        if (name.empty()) name = holder;
        if (!color) color = held_color;
        if (XCAFDoc_ShapeTool::IsAssembly(of)) {
            TDF_LabelSequence parts;
            XCAFDoc_ShapeTool::GetComponents(of, parts);
            for (int i = 1; i <= parts.Length(); ++i) {
                Result<void> done = visit(parts.Value(i), placed, name, color, depth + 1);
                if (!done) return done;
            }
            return {};
        }
        const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(of);
        if (shape.IsNull()) return {};
        bool any = false;
        for (TopExp_Explorer each(shape, TopAbs_SOLID); each.More(); each.Next()) {
            any = true;
            if (out_.solids.size() == kMostSolids)
                return error(fmt::format(messages::kMoreThanSolids, kMostSolids));
            const Color own = color_of(each.Current());
            Result<void> done = add(each.Current(), placed, name, own ? own : color);
            if (!done) return done;
        }
        others_ += any ? 0 : 1;
        return {};
    }

    Result<void> add(const TopoDS_Shape& solid, const TopLoc_Location& place,
                     const std::string& name, Color color) {
        const TopoDS_Shape placed = solid.Moved(place);
        BRepMesh_IncrementalMesh(placed, tolerance_mm_, Standard_False, kMostTurn, Standard_False);
        StepSolid out;
        out.name = name;
        // Faces share the points of their edges, which are the same numbers on both sides.
        std::map<std::tuple<double, double, double>, int32_t> numbers;
        for (TopExp_Explorer each(placed, TopAbs_FACE); each.More(); each.Next()) {
            const TopoDS_Face& face = TopoDS::Face(each.Current());
            if (!color) color = color_of(face);
            TopLoc_Location of_face;
            const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, of_face);
            if (mesh.IsNull())
                return error(fmt::format(messages::kFaceNotDivided, printable(name)),
                             messages::kFaceNotDividedHelp);
            std::vector<int32_t> of_node(static_cast<size_t>(mesh->NbNodes()) + 1);
            for (int i = 1; i <= mesh->NbNodes(); ++i) {
                const gp_Pnt p = mesh->Node(i).Transformed(of_face.Transformation());
                const auto [known, fresh] = numbers.try_emplace(
                    {p.X(), p.Y(), p.Z()}, static_cast<int32_t>(out.vertices.size()));
                if (fresh) out.vertices.push_back({p.X(), p.Y(), p.Z()});
                at(of_node, i) = known->second;
            }
            const bool turned = face.Orientation() == TopAbs_REVERSED;
            for (int i = 1; i <= mesh->NbTriangles(); ++i) {
                int a = 0, b = 0, c = 0;
                mesh->Triangle(i).Get(a, b, c);
                if (turned) std::swap(b, c);
                const std::array<int32_t, 3> t{of_node[static_cast<size_t>(a)],
                                               of_node[static_cast<size_t>(b)],
                                               of_node[static_cast<size_t>(c)]};
                if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) out.triangles.push_back(t);
            }
        }
        out.color = color;
        if (!out.triangles.empty()) out_.solids.push_back(std::move(out));
        return {};
    }

    std::string file_;
    double tolerance_mm_;
    Handle(XCAFDoc_ShapeTool) shapes_;
    Handle(XCAFDoc_ColorTool) colors_;
    StepFile out_;
    int64_t others_ = 0;
};

}  // namespace

Result<StepFile> read_step(const std::filesystem::path& file, double tolerance_mm) {
    // It must be a regular file; the library opens it by its name.
    if (const Result<InputFile> opened = InputFile::open(file); !opened)
        return with_context(opened.error(), file.string() + ": ");
    try {
        return SolidReader(file.string(), tolerance_mm).read();
    } catch (const Standard_Failure& failure) {
        return user_error(fmt::format(messages::kOpenCascadeCannotRead, file.string(),
                                      printable(failure.GetMessageString())));
    } catch (const std::exception& failure) {
        return user_error(fmt::format(messages::kOpenCascadeCannotRead, file.string(),
                                      printable(failure.what())));
    }
}

}  // namespace openfab::tools
