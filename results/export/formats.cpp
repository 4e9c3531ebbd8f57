#include "results/export/formats.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/spec/spec_error.hpp"
#include "results/export/parts.hpp"
#include "results/export/writers.hpp"
#include "results/files/folder.hpp"
#include "results/report/report.hpp"

namespace flexopt {

namespace {

/// A file before it is written.
struct ExportedFile {
  std::string name, content;
};

/// `notes`: receives what was left out of the files.
using MakeFiles = std::vector<ExportedFile> (*)(const Exported&, const ExportOptions&,
                                                std::vector<std::string>& notes);
using Notes = std::vector<std::string>;

struct Maker {
  ExportFormat format;
  MakeFiles make;
};

/// The equilibrium at the strokes; nothing where the mechanism is undeflected.
std::optional<PathPoint> point_of(const Exported& exported) {
  if (exported.undeflected) return std::nullopt;
  return exported.equilibria({exported.strokes}).front();
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

std::vector<ExportedFile> dxf_files(const Exported& e, const ExportOptions& o, Notes&) {
  std::vector<ExportedFile> files;
  if (auto leaves = dxf_leaves(e.mechanism))
    files.push_back({o.stem + "_leaves.dxf", std::move(*leaves)});
  const std::optional<PathPoint> point = point_of(e);
  if (auto contour = dxf_contour(e.mechanism, point ? &*point : nullptr))
    files.push_back({o.stem + "_contour.dxf", std::move(*contour)});
  if (files.empty())
    throw SpecError("--format", "dxf", "wires have no outline: expected a leaf with a width");
  return files;
}

std::vector<ExportedFile> step_files(const Exported& e, const ExportOptions& o, Notes& notes) {
  const std::optional<PathPoint> point = point_of(e);
  StepFile file = step_file(e, point ? &*point : nullptr);
  notes.insert(notes.end(), file.notes.begin(), file.notes.end());
  return {{o.stem + ".step", std::move(file.content)}};
}

/// Decks go as far as the job does unless a stroke is given.
VectorXd strokes_of_deck(const Exported& exported) {
  return exported.undeflected ? exported.largest_strokes() : exported.strokes;
}

const std::vector<Maker>& makers() {
  static const std::vector<Maker> all{
      {{"step", "solids of leaves and bodies for CAD, in mm"}, step_files},
      {{"stl", "triangles of leaves and bodies, each a closed solid, in mm"},
       [](const Exported& e, const ExportOptions& o, Notes&) -> std::vector<ExportedFile> {
         const std::optional<PathPoint> point = point_of(e);
         return {{o.stem + ".stl", stl_text(drawn_parts(e.mechanism, point ? &*point : nullptr))}};
       }},
      {{"gltf", "leaves and bodies that move through the stroke, in m"},
       [](const Exported& e, const ExportOptions& o, Notes&) -> std::vector<ExportedFile> {
         const std::optional<PathPoint> point = point_of(e);
         return {{o.stem + ".glb",
                  glb(e.mechanism, point ? &*point : nullptr, e.equilibria(frames_of(e)))}};
       }},
      {{"dxf", "outlines of the leaves, and of planar mechanisms the contour, in mm"}, dxf_files},
      {{"ccx", "a deck of CalculiX in solid elements, driven to the stroke"},
       [](const Exported& e, const ExportOptions& o, Notes&) -> std::vector<ExportedFile> {
         return {{o.stem + ".inp", ccx_deck(e, strokes_of_deck(e), o.solid)},
                 {"compare_ccx.py", std::string(embedded_file("compare_ccx.py"))}};
       }},
      {{"spacar", "a script for SPACAR Light with beams, driven to the stroke"},
       [](const Exported& e, const ExportOptions& o, Notes&) -> std::vector<ExportedFile> {
         return {{o.stem + "_spacar.m", spacar_script(e, strokes_of_deck(e))}};
       }},
      {{"vtu", "displacement, stress and modes on the leaves, for ParaView"},
       [](const Exported& e, const ExportOptions& o, Notes&) -> std::vector<ExportedFile> {
         Outputs modes;
         if (e.request.frequencies > 0)
           modes.add({Output::frequencies_locked, Output::frequencies_free});
         return {{o.stem + ".vtu", point_vtu(e.mechanism, e.standing(modes))}};
       }},
  };
  return all;
}

}  // namespace

const std::vector<ExportFormat>& export_formats() {
  static const std::vector<ExportFormat> formats = [] {
    std::vector<ExportFormat> list;
    for (const Maker& maker : makers()) list.push_back(maker.format);
    return list;
  }();
  return formats;
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
  WrittenExports written;
  std::vector<ExportedFile> files;
  for (const std::string& format : options.formats) {
    const auto maker =
        std::ranges::find(makers(), format, [](const Maker& m) { return m.format.name; });
    for (ExportedFile& file : maker->make(exported, options, written.notes))
      files.push_back(std::move(file));
  }
  for (const ExportedFile& file : files) {
    write_file(folder / file.name, file.content);
    written.names.push_back(file.name);
  }
  return written;
}

}  // namespace flexopt
