#include "results/export/step_writer.hpp"

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

namespace flexopt::step {

namespace {

constexpr double sewing = 1e-5;  ///< faces are one where they are closer [mm]

gp_Pnt point(const Point& p) { return {p[0], p[1], p[2]}; }
gp_Dir direction(const Point& v) { return {v[0], v[1], v[2]}; }

/// What a grid of points lies on: knots along come from the places, so that all rows share them.
using Row = std::vector<gp_Pnt>;

Handle(Geom_BSplineCurve) through(const Row& points, const std::vector<double>& places) {
  const int n = static_cast<int>(points.size());
  Handle(TColgp_HArray1OfPnt) array = new TColgp_HArray1OfPnt(1, n);
  Handle(TColStd_HArray1OfReal) at = new TColStd_HArray1OfReal(1, n);
  for (int k = 0; k < n; ++k) {
    array->SetValue(k + 1, points[k]);
    at->SetValue(k + 1, places[k]);
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
    for (const Row& row : poles) column.push_back(row[i]);
    v = through(column, across);
    columns.push_back(poles_of(v));
  }
  TColgp_Array2OfPnt net(1, count, 1, v->NbPoles());
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < v->NbPoles(); ++j) net.SetValue(i + 1, j + 1, columns[i][j]);
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

/// Solid of a sheet: both faces, its rims and its ends. A fold ends one surface and begins the
/// next.
TopoDS_Shape made(const Sheet& sheet, const std::string& name) {
  BRepBuilderAPI_Sewing faces(sewing);
  const auto add = [&](const Handle(Geom_Surface) & face) {
    faces.Add(BRepBuilderAPI_MakeFace(face, 1e-9).Face());
  };
  std::vector<int> ends{0};
  ends.insert(ends.end(), sheet.folds.begin(), sheet.folds.end());
  ends.push_back(sheet.along - 1);
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    const auto face = [&](const std::vector<Point>& grid) {
      std::vector<Row> rows;
      for (int j = 0; j < sheet.across; ++j) {
        rows.emplace_back();
        for (int i = ends[piece]; i <= ends[piece + 1]; ++i)
          rows.back().push_back(point(grid[j * sheet.along + i]));
      }
      return surface_through(
          rows, {sheet.places.begin() + ends[piece], sheet.places.begin() + ends[piece + 1] + 1});
    };
    const Handle(Geom_BSplineSurface) top = face(sheet.top), bottom = face(sheet.bottom);
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

TopoDS_Shape made(const Cylinder& of, const std::string&) {
  return BRepPrimAPI_MakeCylinder(gp_Ax2(point(of.base), direction(of.direction)), of.radius,
                                  of.length)
      .Shape();
}

TopoDS_Shape made(const Pipe& pipe, const std::string&) {
  BRepOffsetAPI_ThruSections loft(Standard_True, Standard_False, 1e-6);
  for (const Pipe::Circle& c : pipe.circles) {
    const gp_Circ circle(gp_Ax2(point(c.centre), direction(c.normal), direction(c.side)), c.radius);
    loft.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire());
  }
  loft.Build();
  return loft.Shape();
}

TopoDS_Shape made(const Prism& prism, const std::string&) {
  BRepBuilderAPI_MakeWire outline;
  for (const Prism::Edge& e : prism.outline)
    outline.Add(e.by ? BRepBuilderAPI_MakeEdge(
                           GC_MakeArcOfCircle(point(e.from), point(*e.by), point(e.to)).Value())
                           .Edge()
                     : BRepBuilderAPI_MakeEdge(point(e.from), point(e.to)).Edge());
  return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(outline.Wire()).Face(),
                               gp_Vec(prism.over[0], prism.over[1], prism.over[2]))
      .Shape();
}

TopoDS_Shape made(const Polyhedron& of, const std::string& name) {
  BRepBuilderAPI_Sewing faces(sewing);
  for (const auto& [a, b, c] : of.triangles) {
    const auto at = [&](int k) { return point(of.points[k]); };
    faces.Add(BRepBuilderAPI_MakeFace(
                  BRepBuilderAPI_MakePolygon(at(a), at(b), at(c), Standard_True).Wire())
                  .Face());
  }
  ShapeUpgrade_UnifySameDomain unify(solid_of(faces, name));
  unify.Build();
  return unify.Shape();
}

}  // namespace
}  // namespace flexopt::step

void flexopt_write_step(const flexopt::step::Document& document, std::string& text) try {
  STEPControl_Writer writer;
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
  Interface_Static::SetCVal("write.step.schema", "AP214IS");
  Interface_Static::SetCVal("write.step.unit", "MM");
  for (const flexopt::step::Solid& solid : document.solids) {
    const TopoDS_Shape shape = std::visit(
        [&](const auto& of) { return flexopt::step::made(of, solid.name); }, solid.shape);
    Interface_Static::SetCVal("write.step.product.name", solid.name.c_str());
    if (writer.Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone)
      throw std::runtime_error("Open CASCADE does not write " + solid.name);
  }
  APIHeaderSection_MakeHeader header(writer.Model());
  const auto word = [](const std::string& of) { return new TCollection_HAsciiString(of.c_str()); };
  header.SetName(word(document.name));
  header.SetTimeStamp(word("1970-01-01T00:00:00"));  // so that equal jobs have equal files
  header.SetOriginatingSystem(word(document.origin));
  StepData_StepWriter printed(writer.Model());
  printed.SendModel(Handle(StepData_Protocol)::DownCast(writer.WS()->Protocol()));
  std::ostringstream stream;
  if (!printed.Print(stream)) throw std::runtime_error("Open CASCADE does not write the file");
  text = stream.str();
} catch (const Standard_Failure& failure) {
  throw std::runtime_error(std::string("Open CASCADE: ") + failure.GetMessageString());
}
