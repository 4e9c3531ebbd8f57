#include "results/export/step_writer.hpp"

#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRep_Builder.hxx>
#include <GC_MakeArcOfCircle.hxx>
#include <GProp_GProps.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <GeomFill.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_PrinterOStream.hxx>
#include <Quantity_Color.hxx>
#include <STEPConstruct.hxx>
#include <STEPConstruct_Styles.hxx>
#include <STEPControl_Writer.hxx>
#include <ShapeUpgrade_UnifySameDomain.hxx>
#include <Standard_Failure.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <StepRepr_RepresentationContext.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <StepVisual_Colour.hxx>
#include <StepVisual_MechanicalDesignGeometricPresentationRepresentation.hxx>
#include <StepVisual_PresentationStyleAssignment.hxx>
#include <StepVisual_StyledItem.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_ListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <Transfer_FinderProcess.hxx>
#include <XSControl_TransferWriter.hxx>
#include <XSControl_WorkSession.hxx>
#include <gp_Ax2.hxx>
#include <gp_Circ.hxx>
#include <numeric>
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

using Shapes = TopTools_ListOfShape;

double volume_of(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties);
  return properties.Mass();
}

Shapes solids_in(const TopoDS_Shape& shape) {
  Shapes solids;
  for (TopExp_Explorer found(shape, TopAbs_SOLID); found.More(); found.Next())
    solids.Append(found.Current());
  return solids;
}

/// A boolean operation of the first shapes with the others; faces in one plane become one.
template <class Operation>
TopoDS_Shape result_of(const Shapes& first, const Shapes& others, const std::string& name) {
  Operation operation;
  operation.SetArguments(first);
  operation.SetTools(others);
  operation.SetFuzzyValue(sewing);
  operation.Build();
  if (!operation.IsDone() || operation.HasErrors())
    throw std::runtime_error("the shapes of " + name + " cannot be joined");
  ShapeUpgrade_UnifySameDomain unify(operation.Shape());
  unify.Build();
  return unify.Shape();
}

TopoDS_Shape joined(Shapes all, const std::string& name) {
  if (all.Size() == 1) return all.First();
  Shapes first;
  first.Append(all.First());
  all.RemoveFirst();
  return result_of<BRepAlgoAPI_Fuse>(first, all, name);
}

/// The solids of a shape after a check of each: a solid by itself, several as a compound.
TopoDS_Shape checked(const TopoDS_Shape& shape, int expected, const std::string& name) {
  const Shapes solids = solids_in(shape);
  if (solids.IsEmpty() || (expected > 0 && solids.Size() != expected))
    throw std::runtime_error(name + " becomes " + std::to_string(solids.Size()) + " solids, not " +
                             (expected > 0 ? std::to_string(expected) : "one or more"));
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  for (const TopoDS_Shape& solid : solids) {
    if (!BRepCheck_Analyzer(solid).IsValid() || !(volume_of(solid) > 0))
      throw std::runtime_error("the solid of " + name + " is not closed or not valid");
    builder.Add(all, solid);
  }
  return solids.Size() == 1 ? solids.First() : TopoDS_Shape(all);
}

TopoDS_Shape made(const Product& product) {
  const auto shape_of = [&](const auto& of) { return made(of, product.name); };
  Shapes kept, cut, rooms;
  for (const Shape& shape : product.shapes) kept.Append(std::visit(shape_of, shape));
  for (const Shape& shape : product.cut) cut.Append(std::visit(shape_of, shape));
  for (const Polyhedron& room : product.rooms) rooms.Append(shape_of(room));
  if (!cut.IsEmpty() && !rooms.IsEmpty())
    cut = solids_in(result_of<BRepAlgoAPI_Cut>(cut, rooms, product.name));
  kept.Append(cut);
  const TopoDS_Shape shape = checked(joined(kept, product.name), product.solids, product.name);
  if (product.volume && std::abs(volume_of(shape) / *product.volume - 1) > 1e-3)
    throw std::runtime_error("the solid of " + product.name + " has " +
                             std::to_string(volume_of(shape)) + " mm³ instead of " +
                             std::to_string(*product.volume) + " mm³");
  return shape;
}

/// All in one solid. What bends is thin: less than 1 % of the volume may be in two of the products.
TopoDS_Shape one_solid(const std::vector<TopoDS_Shape>& products, const std::string& name) {
  Shapes all;
  double sum = 0;
  for (const TopoDS_Shape& product : products)
    for (const TopoDS_Shape& solid : solids_in(product)) {
      all.Append(solid);
      sum += volume_of(solid);
    }
  const TopoDS_Shape one = checked(joined(all, name), 1, name);
  if (std::abs(volume_of(one) / sum - 1) > 1e-2)
    throw std::runtime_error("the solid of " + name + " has not the volume of its parts");
  return one;
}

/// Solids and their colours go to a writer as products of their names.
class Products {
 public:
  explicit Products(STEPControl_Writer& writer) : writer_(&writer), styles_(writer.WS()) {}

  void add(const TopoDS_Shape& shape, const std::string& name,
           const std::array<double, 3>& colour) {
    Interface_Static::SetCVal("write.step.product.name", name.c_str());
    if (writer_->Transfer(shape, STEPControl_AsIs) != IFSelect_RetDone)
      throw std::runtime_error("Open CASCADE does not write " + name);
    const Handle(StepVisual_Colour) filled = STEPConstruct_Styles::EncodeColor(
        Quantity_Color(colour[0], colour[1], colour[2], Quantity_TOC_sRGB));
    for (const TopoDS_Shape& solid : solids_in(shape)) {
      const Handle(StepRepr_RepresentationItem) item =
          STEPConstruct::FindEntity(writer_->WS()->TransferWriter()->FinderProcess(), solid);
      if (item.IsNull()) throw std::runtime_error("Open CASCADE does not colour " + name);
      styles_.AddStyle(item, styles_.MakeColorPSA(item, filled, filled, filled, 0), {});
    }
    Handle(StepVisual_MechanicalDesignGeometricPresentationRepresentation) all;
    if (!styles_.CreateMDGPR(styles_.FindContext(shape), all))
      throw std::runtime_error("Open CASCADE does not colour " + name);
    writer_->Model()->AddWithRefs(all);
    styles_.ClearStyles();
  }

 private:
  STEPControl_Writer* writer_;
  STEPConstruct_Styles styles_;
};

}  // namespace
}  // namespace flexopt::step

void flexopt_write_step(const flexopt::step::Document& document, std::string& text) try {
  STEPControl_Writer writer;
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_PrinterOStream));
  Interface_Static::SetCVal("write.step.schema", "AP214IS");
  Interface_Static::SetCVal("write.step.unit", "MM");
  std::vector<TopoDS_Shape> shapes;
  for (const flexopt::step::Product& product : document.products)
    shapes.push_back(flexopt::step::made(product));
  flexopt::step::Products products(writer);
  if (document.monolithic)
    products.add(flexopt::step::one_solid(shapes, document.name), document.name,
                 document.products.front().colour);
  else
    for (std::size_t k = 0; k < shapes.size(); ++k)
      products.add(shapes[k], document.products[k].name, document.products[k].colour);
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
