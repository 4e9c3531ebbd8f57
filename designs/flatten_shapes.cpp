// Shapes of the elastic bodies of a design file, in axes of their own.
#include <fmt/format.h>

#include <Eigen/Dense>

#include "core/math/dual.hpp"
#include "designs/flattener.hpp"
#include "designs/solids/contour_curves.hpp"

namespace flexopt {

template <class S>
bool Flattener<S>::is_rigid(const ElasticItem& item) const {
  const auto chosen = input_.choices->find(elastic_bodies_option);
  return item.rigid ||
         (!item.is_hinge() && chosen != input_.choices->end() && chosen->second == "rigid");
}

template <class S>
void Flattener<S>::set_shape(const ElasticItem::Box& box, const BodyItem& item,
                             const Placement<S>& at, FlatElastic<S>& elastic) const {
  BoxShapeT<S> shape;
  for (std::size_t i = 0; i < 3; ++i)
    shape.lengths[i] =
        positive(box.lengths[i], item.pointer + "/elastic/box", "the lengths of a box");
  elastic.shape = shape;
  elastic.place = at.place(vector(item.at) + vector(box.center));
  elastic.axes = at.axes;
  if (at.mirrored) elastic.axes.col(2) = -elastic.axes.col(2);  // which makes the same shape
}

template <class S>
ContourT<S> Flattener<S>::contour_of(const ElasticItem::Contour& contour) const {
  const auto point = [&](const DesignPoint& p) {
    return std::array<S, 2>{number(p[0]), number(p[1])};
  };
  ContourT<S> result;
  for (const ElasticItem::Corner& corner : contour) {
    result.push_back({point(corner.at), corner.fillet ? number(*corner.fillet) : S(0), {}});
    if (corner.through) result.back().through = point(*corner.through);
  }
  if (result.size() > 2) return result;
  const auto a = result[0], b = result[1];
  return {a, {{b.at[0], a.at[1]}, b.fillet, {}}, b, {{a.at[0], b.at[1]}, a.fillet, {}}};
}

template <class S>
void Flattener<S>::set_shape(const ElasticItem::Plate& plate, const BodyItem& item,
                             const Placement<S>& at, FlatElastic<S>& elastic) const {
  const std::string pointer = item.pointer + "/elastic/plate";
  PlateShapeT<S> shape;
  shape.outline = contour_of(plate.outline);
  for (const ElasticItem::Contour& window : plate.windows)
    shape.windows.push_back(contour_of(window));
  for (std::size_t i = 0; i < plate.holes.size(); ++i)
    shape.holes.push_back(
        {{number(plate.holes[i].at[0]), number(plate.holes[i].at[1])},
         positive(plate.holes[i].radius, fmt::format("{}/holes/{}/radius", pointer, i),
                  "the radius of a hole")});
  shape.thickness = positive(plate.thickness, pointer + "/thickness", "a thickness");
  if constexpr (std::is_same_v<S, double>)
    if (const Check sound = check_contours(contours_of(shape), shape.windows.size()); !sound)
      throw SpecError(pointer, "its contours", sound.error());
  elastic.shape = std::move(shape);
  std::optional<Vector3<S>> along;
  if (plate.along) along = unit(vector(*plate.along), pointer + "/along");
  const Vector3<S> normal = unit(vector(plate.normal), pointer + "/normal");
  if (along && std::abs(value_of(along->dot(normal))) > 1 - 1e-9)
    throw SpecError(pointer + "/along", "the normal", "it lies in the plane of the plate");
  const auto [u, v] = in_plane(normal, along);
  elastic.place = at.place(vector(plate.at));
  elastic.axes.col(0) = at.direction(u);
  elastic.axes.col(1) = at.direction(v);
  elastic.axes.col(2) = Vector3<S>(elastic.axes.col(0)).cross(Vector3<S>(elastic.axes.col(1)));
}

template <class S>
void Flattener<S>::set_shape(const ElasticItem::Notch& notch, const BodyItem& item,
                             const Placement<S>& at, FlatElastic<S>& elastic) const {
  const std::string pointer = item.pointer + "/elastic/notch";
  const bool circular = notch.contour == NotchContour::circular;
  const auto size = [&](const DesignNumber& n, const char* key) {
    return positive(n, pointer + key, "a size of a notch");
  };
  NotchShapeT<S> shape;
  shape.contour = notch.contour;
  shape.half_length = size(notch.half_length, circular ? "/radius" : "/half_length");
  shape.depth = size(notch.depth, circular ? "/radius" : "/depth");
  shape.thickness = size(notch.thickness, "/thickness");
  shape.width = size(notch.width, "/width");
  not_negative(notch.ends, pointer + "/ends", "the length of an end");
  shape.end_length = number(notch.ends);
  shape.fillet = number(notch.fillet);
  shape.exponent = notch.exponent.constant;
  shape.two_axes = notch.two_axes;
  elastic.shape = shape;
  elastic.place = at.place(vector(item.at));
  set_axes(at.direction(vector(notch.axis)), at.direction(vector(notch.across)), pointer, elastic);
}

template <class S>
void Flattener<S>::set_shape(const ElasticItem::Imported& file, const BodyItem& item,
                             const Placement<S>& at, FlatElastic<S>& elastic) const {
  const std::string pointer = item.pointer + (file.mesh ? "/elastic/mesh" : "/elastic/import");
  elastic.file = item.elastic;
  elastic.mirrored = at.mirrored;
  elastic.shape = BoxShapeT<S>{};
  elastic.place = at.place(vector(item.at));
  set_axes(at.direction(vector(file.axis)), at.direction(vector(file.across)), pointer, elastic);
}

template <class S>
void Flattener<S>::set_axes(const Vector3<S>& x, Vector3<S> y, const std::string& pointer,
                            FlatElastic<S>& elastic) const {
  const Vector3<S> axis = unit(x, pointer + "/axis");
  y -= axis * axis.dot(y);
  elastic.axes.col(0) = axis;
  elastic.axes.col(1) = unit(y, pointer + "/across");
  elastic.axes.col(2) = axis.cross(Vector3<S>(elastic.axes.col(1)));
}

template <class S>
void Flattener<S>::add_elastic(const BodyItem& item, const Placement<S>& at, NamedBody& named) {
  const ElasticItem& from = *item.elastic;
  const std::string local = instance_name(item, item.name);
  FlatElastic<S> elastic;
  elastic.name = scope_.prefix + local;
  elastic.source = source_of(item);
  elastic.source.pointer += "/elastic";
  elastic.material = from.material;
  elastic.given_degree = from.degree;
  elastic.density = from.density;
  const auto finest = [&](const DesignNumber& n, const char* key) {
    not_negative(n, elastic.source.pointer + "/elements" + key, "the size of an element");
    return value_of(number(n));
  };
  elastic.density.size = finest(from.size, "/size");
  elastic.density.root = finest(from.root, "/root");
  elastic.frame = named.body;
  elastic.rigid = is_rigid(from);
  std::visit([&](const auto& shape) { set_shape(shape, item, at, elastic); }, from.shape);
  named.elastic = static_cast<int>(out_.elastic_bodies.size());
  out_.elastic_bodies.push_back(elastic);
  const auto add = [&](const ElasticItem::Interface& interface) {
    hold(named.elastic, local, interface_of(item, interface, at, elastic));
  };
  // the first one has the frame of the body's name
  for (const ElasticItem::Interface& interface : from.interfaces)
    if (!from.payload.empty() && interface.name == from.payload) add(interface);
  for (const ElasticItem::Interface& interface : from.interfaces)
    if (interface.body.empty() && (from.payload.empty() || interface.name != from.payload))
      add(interface);
}

template bool Flattener<double>::is_rigid(const ElasticItem&) const;
template bool Flattener<Dual1>::is_rigid(const ElasticItem&) const;
template void Flattener<double>::add_elastic(const BodyItem&, const Placement<double>&, NamedBody&);
template void Flattener<Dual1>::add_elastic(const BodyItem&, const Placement<Dual1>&, NamedBody&);

}  // namespace flexopt
