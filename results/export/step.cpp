#include "results/export/step.hpp"

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <GeomFill.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <STEPControl_Writer.hxx>
#include <ShapeUpgrade_UnifySameDomain.hxx>
#include <Standard_Failure.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <XSControl_WorkSession.hxx>
#include <gp_Ax2.hxx>
#include <gp_Circ.hxx>
#include <sstream>
#include <stdexcept>

#include "results/export/parts.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

constexpr double sewing = 1e-5;  ///< faces are one where they are closer [mm]

gp_Pnt point_mm(const Vector3d& p) { return {1e3 * p[0], 1e3 * p[1], 1e3 * p[2]}; }
gp_Dir direction(const Vector3d& v) { return {v[0], v[1], v[2]}; }

/// What a grid of points lies on: knots along come from the places, so that all rows share them.
using Row = std::vector<gp_Pnt>;

Handle(Geom_BSplineCurve) through(const Row& points, const std::vector<double>& places) {
  const int n = static_cast<int>(points.size());
  Handle(TColgp_HArray1OfPnt) array = new TColgp_HArray1OfPnt(1, n);
  Handle(TColStd_HArray1OfReal) at = new TColStd_HArray1OfReal(1, n);
  for (int k = 0; k < n; ++k) {
    array->SetValue(k + 1, points[static_cast<std::size_t>(k)]);
    at->SetValue(k + 1, places[static_cast<std::size_t>(k)]);
  }
  GeomAPI_Interpolate spline(array, at, Standard_False, 1e-12);
  spline.Perform();
  if (!spline.IsDone()) throw std::runtime_error("no spline through the points of a leaf");
  return spline.Curve();
}

Row poles_of(const Handle(Geom_BSplineCurve) & curve) {
  Row poles;
  for (int k = 1; k <= curve->NbPoles(); ++k) poles.push_back(curve->Pole(k));
  return poles;
}

/// rows[j][i]: splines along through all rows, then across through their poles.
Handle(Geom_BSplineSurface)
    surface_through(const std::vector<Row>& rows, const std::vector<double>& along) {
  std::vector<double> across;
  for (std::size_t j = 0; j < rows.size(); ++j) across.push_back(static_cast<double>(j));
  std::vector<Row> poles;
  Handle(Geom_BSplineCurve) u, v;
  for (const Row& row : rows) {
    u = through(row, along);
    poles.push_back(poles_of(u));
  }
  const int count = u->NbPoles();
  std::vector<Row> columns;
  for (int i = 0; i < count; ++i) {
    Row column;
    for (const Row& row : poles) column.push_back(row[static_cast<std::size_t>(i)]);
    v = through(column, across);
    columns.push_back(poles_of(v));
  }
  TColgp_Array2OfPnt net(1, count, 1, v->NbPoles());
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < v->NbPoles(); ++j)
      net.SetValue(i + 1, j + 1, columns[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]);
  return new Geom_BSplineSurface(net, u->Knots(), v->Knots(), u->Multiplicities(),
                                 v->Multiplicities(), u->Degree(), v->Degree());
}

TopoDS_Shape solid_of(BRepBuilderAPI_Sewing& faces, const std::string& name) {
  faces.Perform();
  TopExp_Explorer shells(faces.SewedShape(), TopAbs_SHELL);
  if (!shells.More()) throw std::runtime_error("the faces of " + name + " make no solid");
  TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(TopoDS::Shell(shells.Current())).Solid();
  if (!BRepLib::OrientClosedSolid(solid))
    throw std::runtime_error("the faces of " + name + " are not closed");
  return solid;
}

/// Both faces of a sheet, its rims and its ends; a fold ends one surface and begins the next.
TopoDS_Shape sheet(const LeafSurface& surface, const std::string& name) {
  BRepBuilderAPI_Sewing faces(sewing);
  const auto add = [&](const Handle(Geom_Surface) & face) {
    faces.Add(BRepBuilderAPI_MakeFace(face, 1e-9).Face());
  };
  std::vector<int> ends{0};
  ends.insert(ends.end(), surface.folds.begin(), surface.folds.end());
  ends.push_back(surface.along - 1);
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    const auto face = [&](double sign) {
      std::vector<Row> rows;
      for (int j = 0; j < surface.across; ++j) {
        rows.emplace_back();
        for (int i = ends[piece]; i <= ends[piece + 1]; ++i)
          rows.back().push_back(
              point_mm(surface.middle[surface.at(i, j)] + sign * surface.half[surface.at(i, j)]));
      }
      return surface_through(rows, {surface.places.begin() + ends[piece],
                                    surface.places.begin() + ends[piece + 1] + 1});
    };
    const Handle(Geom_BSplineSurface) top = face(1), bottom = face(-1);
    add(top);
    add(bottom);
    double u0 = 0, u1 = 0, v0 = 0, v1 = 0;
    top->Bounds(u0, u1, v0, v1);
    for (const double v : {v0, v1}) add(GeomFill::Surface(top->VIso(v), bottom->VIso(v)));
    if (piece == 0) add(GeomFill::Surface(top->UIso(u0), bottom->UIso(u0)));
    if (piece + 2 == ends.size()) add(GeomFill::Surface(top->UIso(u1), bottom->UIso(u1)));
  }
  return solid_of(faces, name);
}

TopoDS_Shape wire(const LeafSurface& surface, bool straight) {
  const auto at = [](const std::vector<Vector3d>& list, int k) {
    return list[static_cast<std::size_t>(k)];
  };
  const int last = surface.along - 1;
  if (straight) {
    const Vector3d way = at(surface.middle, last) - at(surface.middle, 0);
    return BRepPrimAPI_MakeCylinder(
               gp_Ax2(point_mm(at(surface.middle, 0)), direction(way.normalized())),
               1e3 * at(surface.half, 0).norm(), 1e3 * way.norm())
        .Shape();
  }
  BRepOffsetAPI_ThruSections loft(Standard_True, Standard_False, 1e-6);
  for (int i = 0; i <= last; ++i) {
    const Vector3d side = at(surface.side, i), along = side.cross(at(surface.half, i));
    const gp_Circ circle(gp_Ax2(point_mm(at(surface.middle, i)), direction(along.normalized()),
                                direction(side.normalized())),
                         1e3 * side.norm());
    loft.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire());
  }
  loft.Build();
  return loft.Shape();
}

bool is_plain(const LeafSpring& leaf) { return !leaf.curve && !leaf.fold && !leaf.has_profile(); }

/// The section of a flat leaf along it, extruded over its width; at clamped ends it widens by
/// quarter circles.
TopoDS_Shape prism(const LeafSpring& leaf, double radius) {
  const Vector3d corner = leaf.origin - 0.5 * leaf.width * leaf.axes.col(1);
  const double h = 0.5 * leaf.thickness, L = leaf.length;
  const auto at = [&](double x, double y) {
    return point_mm(corner + x * leaf.axes.col(0) + y * leaf.axes.col(2));
  };
  const double base = radius, tip = leaf.tip == free_edge ? 0 : radius;
  BRepBuilderAPI_MakeWire outline;
  const auto line = [&](const gp_Pnt& p, const gp_Pnt& q) {
    outline.Add(BRepBuilderAPI_MakeEdge(p, q).Edge());
  };
  const auto arc = [&](double x0, double y0, double x1, double y1, double x2, double y2) {
    outline.Add(
        BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(at(x0, y0), at(x1, y1), at(x2, y2)).Value())
            .Edge());
  };
  const double part = 1 - std::sqrt(0.5);  // of the radius: the middle of a quarter circle
  line(at(base, -h), at(L - tip, -h));
  if (tip > 0) arc(L - tip, -h, L - part * tip, -h - part * tip, L, -h - tip);
  line(at(L, -h - tip), at(L, h + tip));
  if (tip > 0) arc(L, h + tip, L - part * tip, h + part * tip, L - tip, h);
  line(at(L - tip, h), at(base, h));
  if (base > 0) arc(base, h, part * base, h + part * base, 0, h + base);
  line(at(0, h + base), at(0, -h - base));
  if (base > 0) arc(0, -h - base, part * base, -h - part * base, base, -h);
  const Vector3d over = 1e3 * leaf.width * leaf.axes.col(1);
  return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(outline.Wire()).Face(),
                               gp_Vec(over[0], over[1], over[2]))
      .Shape();
}

TopoDS_Shape polyhedron(const TriangleMesh& mesh) {
  BRepBuilderAPI_Sewing faces(sewing);
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto at = [&](int k) { return point_mm(mesh.points[static_cast<std::size_t>(k)]); };
    faces.Add(BRepBuilderAPI_MakeFace(
                  BRepBuilderAPI_MakePolygon(at(a), at(b), at(c), Standard_True).Wire())
                  .Face());
  }
  ShapeUpgrade_UnifySameDomain unify(solid_of(faces, mesh.name));
  unify.Build();
  return unify.Shape();
}

/// Every other point of what was made fine enough for triangles.
LeafSurface leaf_surface(const Mechanism& mechanism, const PathPoint* point, std::size_t i) {
  if (!point) return undeflected_surface(mechanism.leaves[i]);
  const LeafShape& shape = point->shapes[i];
  return surface_of_shape(mechanism.leaves[i], shape, shape.deflected, 2);
}

TopoDS_Shape leaf_solid(const Exported& exported, const PathPoint* point, std::size_t i,
                        std::vector<std::string>& without_fillets) {
  const LeafSpring& leaf = exported.mechanism.leaves[i];
  const bool round = leaf.section == Section::circular;
  double radius = exported.request.stress.fillet.value_or(0);
  const bool carries = !point && !round && is_plain(leaf) && 2 * radius < leaf.length;
  if (radius > 0 && !carries) {
    without_fillets.push_back(leaf.name);
    radius = 0;
  }
  if (!point && !round && is_plain(leaf)) return prism(leaf, radius);
  const LeafSurface surface = leaf_surface(exported.mechanism, point, i);
  return round ? wire(surface, !point && is_plain(leaf)) : sheet(surface, leaf.name);
}

class Document {
 public:
  Document() {
    Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
    Interface_Static::SetCVal("write.step.schema", "AP214IS");
    Interface_Static::SetCVal("write.step.unit", "MM");
  }

  void add(const TopoDS_Shape& shape, const std::string& name) {
    Interface_Static::SetCVal("write.step.product.name", name.c_str());
    if (writer_.Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone)
      throw std::runtime_error("Open CASCADE does not write " + name);
  }

  /// Without the time of writing: the same job has the same file.
  std::string text(const std::string& name) {
    APIHeaderSection_MakeHeader header(writer_.Model());
    const auto word = [](const std::string& text) {
      return new TCollection_HAsciiString(text.c_str());
    };
    header.SetName(word(name));
    header.SetTimeStamp(word("1970-01-01T00:00:00"));
    header.SetOriginatingSystem(word("flexopt " + std::string(version())));
    StepData_StepWriter writer(writer_.Model());
    writer.SendModel(Handle(StepData_Protocol)::DownCast(writer_.WS()->Protocol()));
    std::ostringstream stream;
    if (!writer.Print(stream)) throw std::runtime_error("Open CASCADE does not write the file");
    return stream.str();
  }

 private:
  STEPControl_Writer writer_;
};

}  // namespace

StepFile step_file(const Exported& exported, const PathPoint* point) try {
  const Mechanism& mechanism = exported.mechanism;
  StepFile file;
  Document document;
  std::vector<std::string> without_fillets;
  for (std::size_t i = 0; i < mechanism.leaves.size(); ++i)
    document.add(leaf_solid(exported, point, i, without_fillets), mechanism.leaves[i].name);
  for (std::size_t b = 0; b < mechanism.bodies.size(); ++b) {
    TriangleMesh mesh = body_solid(mechanism, static_cast<int>(b));
    if (mesh.triangles.empty()) continue;
    const BodyPose pose = body_pose(mechanism, point, static_cast<int>(b));
    for (Vector3d& p : mesh.points) p = pose(p);
    document.add(polyhedron(mesh), mesh.name);
  }
  for (const std::string& name : without_fillets)
    file.notes.push_back("step: leaf " + name +
                         " has no fillets: only flat undeflected ones have them");
  file.content = document.text(exported.name);
  return file;
} catch (const Standard_Failure& failure) {
  throw std::runtime_error(std::string("Open CASCADE: ") + failure.GetMessageString());
}

}  // namespace flexopt

#ifdef __SANITIZE_ADDRESS__
/// Open CASCADE keeps what it has made for its readers and writers to the end: no leaks of ours.
extern "C" const char* __lsan_default_suppressions() { return "leak:libTK"; }
#endif
