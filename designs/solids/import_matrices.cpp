#include "designs/solids/import_matrices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/math/nearest_rotation.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/spec/field_table.hpp"
#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/quantity.hpp"

namespace flexopt {
namespace {

using nlohmann::json;

Shape plain() { return shape::quantity("1"); }
Shape plain_vector() { return shape::list(plain(), 3, 3); }

Shape matrix_shape() {
  using namespace shape;
  return record({optional("lower", list(list(plain(), 1, 10000), 12, 10000),
                          "rows of the lower triangle, diagonal included"),
                 optional("file", text(), "instead of lower: beside this file"),
                 optional("format", choice({"matrix_market"}), "of the file")});
}

Shape elastic_body_shape() {
  using namespace shape;
  const Shape interface_shape = record(
      {required("name", text(200), "which edges, joints and bodies refer to"),
       required("at", plain_vector(), "its point, own axes of the body"),
       optional("axes", list(plain_vector(), 3, 3), "directions of its ux, uy, uz in the body"),
       optional("nodes", text(200), "of matrix_storage: set of nodes that it holds")});
  const Shape expected = record(
      {required("mass", quantity("1", 0, Shape::infinity, true), "of the body"),
       required("center_of_mass", plain_vector(), "own axes"),
       required("inertia", one_of({plain_vector(), list(plain_vector(), 3, 3)}),
                "about the centre of mass, own axes: moments, or all of it"),
       with_default("free_frequencies", list(quantity("1", 0, Shape::infinity, true), 0, 1000),
                    json::array(), "of the body that nothing holds, lowest first [Hz]")});
  return record(
      {required("flexopt_elastic", integer(1, 1), "version of the form"),
       optional("name", text(200), "of the body"),
       optional("source", text(2000), "program and deck, for the report"),
       required("units",
                record({required("length", text(50), "unit"), required("force", text(50), "unit"),
                        required("mass", text(50), "unit")}),
                "of all numbers; time is in s, turns are in rad"),
       required("interfaces", list(interface_shape, 2, 50), "rigid frames that hold the body"),
       with_default("modes", integer(0, 5000), 0, "fixed-interface modes behind the interfaces"),
       optional("order", list(text(200), 12, 10000), "of rows: \"leaf_1.ux\", ..., \"mode.1\""),
       optional("stiffness", matrix_shape(), "of the interfaces and modes"),
       optional("mass", matrix_shape(), "of the same; none: the body is massless"),
       optional("matrix_storage",
                record({required("files", text(), "name of .sti, .mas and .dof without ending"),
                        required("mesh", text(), "the deck, or another file of the mesh")}),
                "instead of stiffness and mass: whole matrices of CalculiX"),
       optional("expected", expected, "what the matrices must give"),
       with_default("patches", choice({"rigid"}), "rigid", "how interfaces hold their nodes")});
}

Vector3d vector_of(const json& read) {
  return Vector3d(read[0].get<double>(), read[1].get<double>(), read[2].get<double>());
}

/// Reads the document of a file, which has passed the shape.
class BodyFile {
 public:
  BodyFile(const json& read, std::filesystem::path folder)
      : read_(read), folder_(std::move(folder)), modes_(read["modes"]) {}

  ImportedBody body() {
    read_units();
    read_interfaces();
    const bool whole = read_.contains("matrix_storage");
    if (whole == read_.contains("stiffness") || (whole && read_.contains("mass")))
      throw SpecError("", "the file", "give stiffness and mass, or matrix_storage, one of the two");
    auto matrices = std::make_shared<ImportedMatrices>(whole ? condensed_whole() : reduced());
    ImportedBody body{.name = read_.value("name", ""),
                      .source = read_.value("source", ""),
                      .interfaces = interfaces_};
    const std::optional<ExpectedBody> expected = expected_body();
    std::vector<Fault> faults;
    for (const ImportFault& fault :
         check_imported(*matrices, interfaces_, expected ? &*expected : nullptr, body.figures)) {
      const bool of_matrix = fault.key == "stiffness" || fault.key == "mass";
      faults.push_back({.pointer = "/" + (whole && of_matrix ? "matrix_storage" : fault.key),
                        .value = (whole && of_matrix ? fault.key + " " : "") + fault.value,
                        .rule = fault.rule});
    }
    if (!faults.empty()) throw SpecError(std::move(faults));
    for (MatrixXd* matrix : {&matrices->stiffness, &matrices->mass})
      *matrix = (0.5 * (*matrix + matrix->transpose())).eval();
    body.matrices = std::move(matrices);
    return body;
  }

 private:
  void read_units() {
    const auto unit = [&](const char* key, const char* si) {
      return parse_quantity("1 " + read_["units"][key].get<std::string>(), si,
                            std::string("/units/") + key);
    };
    units_ = {
        .length = unit("length", "m"), .force = unit("force", "N"), .mass = unit("mass", "kg")};
    const double ratio = units_.force / (units_.mass * units_.length);
    if (std::abs(ratio - 1) > 1e-9)
      throw SpecError(
          "/units", shown(read_["units"]),
          fmt::format("force = mass length / s^2, as N, t and mm fit; this unit of force "
                      "is {:.6g} times that of mass and length",
                      ratio));
  }

  void read_interfaces() {
    for (std::size_t a = 0; a < read_["interfaces"].size(); ++a) {
      const json& item = read_["interfaces"][a];
      const JsonPointer at = JsonPointer("/interfaces") / a;
      ImportedInterface next{.name = item["name"], .place = units_.length * vector_of(item["at"])};
      if (std::ranges::find(interfaces_, next.name, &ImportedInterface::name) != interfaces_.end())
        throw SpecError(at / "name", next.name, "check 1: every interface has a name of its own");
      if (item.contains("axes")) {
        Matrix3d axes;
        for (int i = 0; i < 3; ++i) axes.row(i) = vector_of(item["axes"][i]).transpose();
        next.axes = nearest_rotation(axes);
        if (!((axes - next.axes).cwiseAbs().maxCoeff() <= 1e-6))
          throw SpecError(at / "axes", shown(item["axes"]),
                          "three unit vectors at right angles, right-handed, to 1e-6");
      }
      const bool whole = read_.contains("matrix_storage");
      if (whole != item.contains("nodes") || (whole && (item.contains("axes") || modes_ > 0)))
        throw SpecError(at, next.name,
                        "with matrix_storage an interface has nodes and no axes, and there are no "
                        "modes; else it has no nodes");
      if (whole) sets_.push_back(item["nodes"]);
      interfaces_.push_back(std::move(next));
    }
  }

  std::string beside(const json& file) const {
    return (folder_ / file.get<std::string>()).string();
  }

  ImportedMatrices condensed_whole() const {
    const json& storage = read_["matrix_storage"];
    return condensed_matrix_storage(beside(storage["files"]), beside(storage["mesh"]), units_,
                                    interfaces_, sets_);
  }

  std::vector<std::string> coordinate_names() const {
    std::vector<std::string> names;
    for (const ImportedInterface& a : interfaces_)
      for (const std::string_view direction : direction_names)
        names.push_back(fmt::format("{}.{}", a.name, direction));
    for (int k = 1; k <= modes_; ++k) names.push_back(fmt::format("mode.{}", k));
    return names;
  }

  /// For each row of the file its coordinate.
  std::vector<int> order() const {
    const std::vector<std::string> names = coordinate_names();
    std::vector<int> places;
    const std::vector<std::string> written = read_.value("order", names);
    if (written.size() != names.size())
      throw SpecError("/order", fmt::format("{} names", written.size()),
                      fmt::format("check 1: every coordinate once; there are {}", names.size()));
    for (std::size_t i = 0; i < written.size(); ++i) {
      const auto at = std::ranges::find(names, written[i]);
      if (at == names.end())
        throw SpecError(JsonPointer("/order") / i, written[i],
                        "no coordinate; " + known_names(written[i], names));
      places.push_back(static_cast<int>(at - names.begin()));
      if (std::ranges::count(places, places.back()) > 1)
        throw SpecError(JsonPointer("/order") / i, written[i], "check 1: every coordinate once");
    }
    return places;
  }

  /// The numbers of a matrix as they are written.
  MatrixXd written_matrix(const char* key, int n) const {
    const json& item = read_[key];
    if (item.contains("lower") == item.contains("file") ||
        item.contains("file") != item.contains("format"))
      throw SpecError(JsonPointer() / key, shown(item), "give lower, or file and format");
    if (item.contains("file")) return read_matrix_market(beside(item["file"]), n);
    const json& rows = item["lower"];
    MatrixXd matrix = MatrixXd::Zero(n, n);
    for (std::size_t i = 0; i < std::max<std::size_t>(rows.size(), n); ++i) {
      if (i >= rows.size() || static_cast<int>(i) >= n || rows[i].size() != i + 1)
        throw SpecError(
            JsonPointer() / key / "lower", fmt::format("{} rows", rows.size()),
            fmt::format("{} rows, for the coordinates of interfaces and modes, of 1, 2, "
                        "3 ... numbers",
                        n));
      for (std::size_t j = 0; j <= i; ++j) matrix(i, j) = matrix(j, i) = rows[i][j].get<double>();
    }
    return matrix;
  }

  // A coordinate of the file is a displacement in its unit of length, along an axis of the
  // interface, a turn, or the amplitude of a mode whose energy is ½ q̇² in the file's unit of it.
  ImportedMatrices reduced() const {
    const std::vector<int> places = order();
    const int n = static_cast<int>(places.size()), bodies = static_cast<int>(interfaces_.size());
    const double energy = units_.force * units_.length;
    MatrixXd toward = MatrixXd::Zero(n, n);
    for (int a = 0; a < bodies; ++a) {
      toward.block<3, 3>(6 * a, 6 * a) = interfaces_[a].axes / units_.length;
      toward.block<3, 3>(6 * a + 3, 6 * a + 3) = interfaces_[a].axes;
    }
    for (int k = 6 * bodies; k < n; ++k) toward(k, k) = 1 / std::sqrt(energy);
    const auto in_body = [&](const char* key) -> MatrixXd {
      if (!read_.contains(key)) return MatrixXd::Zero(n, n);
      const MatrixXd written = written_matrix(key, n);
      MatrixXd ordered(n, n);
      ordered(places, places) = written;
      return energy * (toward.transpose() * ordered * toward);
    };
    return {.stiffness = in_body("stiffness"), .mass = in_body("mass"), .modes = modes_};
  }

  std::optional<ExpectedBody> expected_body() const {
    if (!read_.contains("expected")) return std::nullopt;
    const json& item = read_["expected"];
    ExpectedBody expected{.mass = units_.mass * item["mass"].get<double>(),
                          .center_of_mass = units_.length * vector_of(item["center_of_mass"]),
                          .inertia = Matrix3d::Zero(),
                          .products = item["inertia"][0].is_array(),
                          .free_frequencies = item["free_frequencies"].get<std::vector<double>>()};
    for (int i = 0; i < 3; ++i)
      if (expected.products)
        expected.inertia.row(i) = vector_of(item["inertia"][i]).transpose();
      else
        expected.inertia(i, i) = item["inertia"][i];
    if (!(expected.inertia.diagonal().minCoeff() > 0))
      throw SpecError("/expected/inertia", shown(item["inertia"]), "moments are above 0");
    expected.inertia *= units_.mass * units_.length * units_.length;
    return expected;
  }

  const json& read_;
  std::filesystem::path folder_;
  int modes_;
  ImportUnits units_;
  std::vector<ImportedInterface> interfaces_;
  std::vector<std::string> sets_;
};

}  // namespace

ImportedBody read_elastic_body(const std::string& file) {
  const JsonText text = read_text(file);
  const json document = parse_json(text.text, text.origin);
  try {
    const json read = read_value(elastic_body_shape(), document);
    return BodyFile(read, std::filesystem::path(file).parent_path()).body();
  } catch (const SpecError& error) {
    std::vector<Fault> faults = error.faults();
    locate(faults, text, {});
    throw SpecError(std::move(faults));
  }
}

}  // namespace flexopt
