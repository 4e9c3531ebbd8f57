#include "results/export/exported.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "core/response/quantities.hpp"
#include "core/spec/quantity.hpp"
#include "core/spec/spec_error.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_parts.hpp"
#include "results/report/report.hpp"
#include "results/run/run.hpp"

namespace flexopt {

struct Making {
  const Exported& of;
  const ExportOptions& options;
  std::vector<std::string>& notes;            ///< receives what was left out of the files
  std::optional<PathPoint> equilibrium = {};  ///< at the strokes, once it was asked for

  /// The equilibrium at the strokes; null where the mechanism is undeflected.
  const PathPoint* point() {
    if (!of.undeflected && !equilibrium) equilibrium = of.equilibria({of.strokes}).front();
    return equilibrium ? &*equilibrium : nullptr;
  }
  /// Decks go as far as the job does unless a stroke is given.
  VectorXd strokes_of_deck() const { return of.undeflected ? of.largest_strokes() : of.strokes; }
  std::string name(const char* ending) const { return options.stem + ending; }
};

namespace {

using Files = std::vector<ExportedFile>;

/// Unit of the k-th number of a stroke.
std::string unit_of_stroke(const Exported& of, std::size_t k) {
  if (!of.request.loads.driven()) return "1";
  return is_rotation(of.mechanism.drives[k].direction) ? "rad" : "m";
}

/// Unit text of a stroke, such as " m"; empty for plain numbers.
std::string shown_unit(const Exported& of, std::size_t k) {
  return of.request.loads.driven() ? " " + unit_of_stroke(of, k) : "";
}

std::string name_of_stroke(const Exported& of, std::size_t k) {
  if (!of.request.loads.driven()) return "load factor";
  const Drive& drive = of.mechanism.drives[k];
  return drive.name.empty() ? std::string(direction_names[index(drive.direction)]) : drive.name;
}

/// A quantity with its unit, or a plain number in SI.
double stroke_value(const std::string& text, const std::string& unit) {
  double number = 0;
  const char* end = text.data() + text.size();
  if (const auto [last, error] = std::from_chars(text.data(), end, number);
      error == std::errc() && last == end && std::isfinite(number))
    return number;
  return parse_quantity(text, unit, "--at");
}

/// Checks that a stroke is within the strokes of the job, rest included.
void check_in_path(const Exported& of, std::size_t k, double value, const std::string& text) {
  double low = 0, high = 0;
  for (const VectorXd& strokes : of.path()) {
    low = std::min(low, strokes[k]);
    high = std::max(high, strokes[k]);
  }
  const double slack = 1e-9 * (high - low);  // rounding of unit conversions
  if (value < low - slack || value > high + slack)
    throw SpecError("--at", text,
                    fmt::format("expected {} on the path of the job: from {:.9g} to {:.9g}{}",
                                name_of_stroke(of, k), low, high, shown_unit(of, k)));
}

VectorXd read_strokes(const Exported& of, const std::vector<std::string>& texts) {
  const std::size_t count = static_cast<std::size_t>(of.strokes.size());
  VectorXd strokes = VectorXd::Zero(of.strokes.size());
  const bool named = of.request.loads.driven() && DriveList(of.mechanism).named();
  if (count == 0) throw SpecError("--at", texts.front(), "nothing is driven in this job");
  if (!named && texts.size() > 1)
    throw SpecError("--at", texts[1], "expected one stroke: there is one drive");
  std::vector<bool> given(count);
  std::vector<std::string> names;
  for (std::size_t k = 0; k < count; ++k) names.push_back(name_of_stroke(of, k));
  for (const std::string& text : texts) {
    std::size_t k = 0, begin = 0;
    if (named) {
      const std::size_t sign = text.find('=');
      while (k < count && names[k] != text.substr(0, sign)) ++k;
      if (sign == std::string::npos || k == count)
        throw SpecError(
            "--at", text,
            fmt::format("expected NAME=STROKE with one of the drives {}", fmt::join(names, ", ")));
      begin = sign + 1;
    }
    if (given[k]) throw SpecError("--at", text, "this stroke is given twice");
    given[k] = true;
    const double value = stroke_value(text.substr(begin), unit_of_stroke(of, k));
    check_in_path(of, k, value, text);
    strokes[k] = value;
  }
  return strokes;
}

StrokeRequest request_of(const Job& job, const std::string& name) {
  const std::vector<JobCase> cases = cases_of(job);
  if (name.empty()) return cases.front().request;
  std::vector<std::string> names;
  for (const JobCase& one : cases) {
    if (one.name == name) return one.request;
    if (!one.name.empty()) names.push_back(one.name);
  }
  throw SpecError("--case", name,
                  names.empty() ? "the job has one load case, without a name"
                                : fmt::format("expected one of {}", fmt::join(names, ", ")));
}

/// Points of the path that an animation goes through: all, or some of many.
std::vector<VectorXd> frames_of(const Exported& exported) {
  constexpr std::size_t most = 41;
  const std::vector<VectorXd> all = exported.path();
  if (all.size() <= most) return all;
  std::vector<VectorXd> some;
  for (std::size_t k = 0; k < most; ++k) some.push_back(all[k * (all.size() - 1) / (most - 1)]);
  return some;
}

/// What drawings of surfaces leave out.
void note_bodies_without_mesh(Making& making, const char* format) {
  for (const std::string& name : bodies_without_mesh(making.of.mechanism))
    making.notes.push_back(fmt::format(
        "{}: elastic body {} is left out: it is matrices of another program, which have no mesh",
        format, name));
}

Files dxf_files(Making& making) {
  Files files;
  if (auto leaves = dxf_leaves(making.of.mechanism))
    files.push_back({making.name("_leaves.dxf"), std::move(*leaves)});
  if (files.empty())
    throw SpecError("--format", "dxf", "wires have no outline: expected a leaf with a width");
  const double kerf = making.options.kerf;
  DxfContour contour = dxf_contour(making.of, making.point(), kerf);
  if (!contour.reason.empty() && kerf > 0)
    throw SpecError("--kerf", fmt::format("{:.9g} m", kerf), contour.reason);
  if (!contour.reason.empty())
    making.notes.push_back("dxf: no contour of the whole: " + contour.reason);
  if (contour.content) files.push_back({making.name("_contour.dxf"), std::move(*contour.content)});
  return files;
}

Files step_files(Making& making) {
  StepFile file = step_file(making.of, making.point(), making.options.monolithic);
  making.notes.insert(making.notes.end(), file.notes.begin(), file.notes.end());
  note_bodies_without_mesh(making, "step");
  return {{making.name(".step"), std::move(file.content)}};
}

Files stl_files(Making& making) {
  note_bodies_without_mesh(making, "stl");
  return {{making.name(".stl"), stl_text(drawn_parts(making.of.mechanism, making.point()))}};
}

Files gltf_files(Making& making) {
  note_bodies_without_mesh(making, "gltf");
  const PathPoint* point = making.point();
  return {{making.name(".glb"),
           glb(making.of.mechanism, point, making.of.equilibria(frames_of(making.of)))}};
}

Files ccx_files(Making& making) {
  const SolidMeshSize& size = making.options.solid;
  const double excess = solid_excess(making.of.mechanism, size);
  if (excess > 0.003)
    making.notes.push_back(fmt::format(
        "ccx: with {} x {} x {} solids leaves are up to {:.2g} % stiffer than in a finer mesh "
        "along them, not within 0.3 %",
        size.along, size.across, size.through, 100 * excess));
  return {
      {making.name(".inp"), ccx_deck(making.of, making.strokes_of_deck(), making.options.solid)},
      {"compare_ccx.py", std::string(embedded_file("compare_ccx.py"))}};
}

Files spacar_files(Making& making) {
  return {{making.name("_spacar.m"), spacar_script(making.of, making.strokes_of_deck())}};
}

Files vtu_files(Making& making) {
  Outputs modes;
  if (making.of.request.frequencies > 0)
    modes.add({Output::frequencies_locked, Output::frequencies_free});
  note_bodies_without_mesh(making, "vtu");
  return {{making.name(".vtu"), point_vtu(making.of.mechanism, making.of.standing(modes))}};
}

}  // namespace

std::vector<PathPoint> Exported::equilibria(const std::vector<VectorXd>& at, const ModelOptions& by,
                                            const Outputs& outputs) const {
  StrokeRequest asked = request;
  asked.points.clear();
  asked.strokes.clear();
  for (const VectorXd& point : at) {
    asked.points.push_back(point.size() > 0 ? point[0] : 0.0);
    if (!request.strokes.empty()) asked.strokes.push_back(point);
  }
  asked.outputs = {Output::equilibrium, Output::stress, Output::shapes};
  asked.outputs.add(outputs);
  if (!outputs.need_frequencies()) asked.frequencies = 0;
  asked.buckling_load.clear();
  StrokeResponse found = evaluate_stroke(mechanism, by, asked);
  for (std::size_t k = 0; k < found.path.size(); ++k)
    if (found.path[k].status != PointStatus::converged)
      throw NoEquilibrium(
          fmt::format("no equilibrium at {}: {}", stroke_text(at[k]),
                      found.path[k].message.empty() ? found.message : found.path[k].message));
  return std::move(found.path);
}

PathPoint Exported::standing(const Outputs& outputs) const {
  if (!undeflected) return equilibria({strokes}, model, outputs).front();
  Exported unloaded = *this;
  LoadCase& loads = unloaded.request.loads;
  loads.constant.clear();
  loads.assembly.clear();
  loads.temperature.clear();
  loads.body_expansion.clear();
  loads.gravity.setZero();
  loads.mounting.clear();
  loads.spring_steps.clear();
  loads.gravity_step = loads.temperature_step = 0;
  return unloaded.equilibria({strokes}, model, outputs).front();
}

std::vector<VectorXd> Exported::path() const {
  std::vector<VectorXd> points;
  for (std::size_t k = 0; k < request.points.size(); ++k)
    points.push_back(request.loads.driven() ? request.strokes_at(k, mechanism.drives.size())
                                            : VectorXd::Constant(1, request.points[k]));
  return points;
}

VectorXd Exported::largest_strokes() const {
  const std::vector<VectorXd> points = path();
  return *std::ranges::max_element(points, {}, [](const VectorXd& p) { return p.norm(); });
}

std::string Exported::stroke_text(const VectorXd& at) const {
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < static_cast<std::size_t>(at.size()); ++k)
    texts.push_back(
        fmt::format("{} = {:.9g}{}", name_of_stroke(*this, k), at[k], shown_unit(*this, k)));
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return text;
}

Exported make_exported(const Job& job, const ExportPlace& place) {
  demand_one_design(job, "a job of one design can be exported");
  Exported made;
  made.name = job.name;
  made.mechanism = make_mechanism(job, job.design.parameters);
  made.request = request_of(job, place.load_case);
  made.model = job.model;
  const bool driven = made.request.loads.driven();
  made.strokes =
      VectorXd::Zero(driven ? static_cast<Eigen::Index>(made.mechanism.drives.size()) : 1);
  if (!place.at.empty()) {
    made.strokes = read_strokes(made, place.at);
    made.undeflected = false;
  }
  return made;
}

const std::vector<ExportFormat>& export_formats() {
  static const std::vector<ExportFormat> all{
      {"step", "solids of leaves and bodies for CAD, in mm", step_files},
      {"stl", "triangles of leaves and bodies, each a closed solid, in mm", stl_files},
      {"gltf", "leaves and bodies that move through the stroke, in m", gltf_files},
      {"dxf", "outlines of the leaves, and of planar mechanisms the contour, in mm", dxf_files},
      {"ccx", "a deck of CalculiX in solid elements, driven to the stroke", ccx_files},
      {"spacar", "a script for SPACAR Light with beams, driven to the stroke", spacar_files},
      {"vtu", "displacement, stress and modes on the leaves, for ParaView", vtu_files}};
  return all;
}

std::vector<std::string> read_formats(const std::string& list) {
  std::vector<std::string> formats, known;
  for (const ExportFormat& format : export_formats()) known.push_back(format.name);
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string name = list.substr(begin, end - begin);
    begin = end + 1;
    if (std::ranges::find(known, name) == known.end())
      throw SpecError("--format", name.empty() ? "nothing" : name,
                      fmt::format("expected one of {}", fmt::join(known, ", ")));
    if (std::ranges::find(formats, name) != formats.end())
      throw SpecError("--format", name, "this format is named twice");
    formats.push_back(name);
  }
  return formats;
}

WrittenExports write_exports(const Exported& exported, const ExportOptions& options,
                             const std::filesystem::path& folder) {
  const auto made = [&](const char* format) {
    return std::ranges::find(options.formats, format) != options.formats.end();
  };
  if (options.monolithic && !made("step"))
    throw SpecError("--monolithic", "true", "it is for --format step");
  if (options.kerf != 0 && !made("dxf"))
    throw SpecError("--kerf", fmt::format("{:.9g} m", options.kerf), "it is for --format dxf");
  WrittenExports written;
  Making making{exported, options, written.notes};
  Files files;
  for (const std::string& format : options.formats) {
    const auto known = std::ranges::find(export_formats(), format, &ExportFormat::name);
    for (ExportedFile& file : known->make(making)) files.push_back(std::move(file));
  }
  for (const ExportedFile& file : files) {
    write_file(folder / file.name, file.content);
    written.names.push_back(file.name);
  }
  return written;
}

}  // namespace flexopt
